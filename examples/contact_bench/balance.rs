//! Balance of the forces of contact: those on both bodies add up to nothing, and so do their moments.

use crate::case::{Case, Contact};

/// Sums over the nodes of both bodies, relative to the sizes of what is summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// |ΣF| / Σ|F|.
    pub force: f64,
    /// |Σ x × F| / Σ |x| |F|.
    pub moment: f64,
}

/// The balance of two bodies; none where the obstacle is rigid, whose force is that of the body by definition.
pub fn balance(case: &Case, forces: &[f64]) -> Option<Balance> {
    if matches!(case.contact, Contact::Obstacle(_)) {
        return None;
    }
    let (mut sum, mut moment, mut size, mut arms) = ([0.0; 2], 0.0, 0.0, 0.0);
    for (x, force) in case.space.positions().iter().zip(forces.chunks_exact(2)) {
        let length = force[0].hypot(force[1]);
        sum = [sum[0] + force[0], sum[1] + force[1]];
        moment += x[0] * force[1] - x[1] * force[0];
        size += length;
        arms += length * x[0].hypot(x[1]);
    }
    let part = |whole: f64, of: f64| if of > 0.0 { whole.abs() / of } else { 0.0 };
    Some(Balance { force: part(sum[0].hypot(sum[1]), size), moment: part(moment, arms) })
}
