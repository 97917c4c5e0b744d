//! References that an answer is compared with.

use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, LuSolver, NonlinearProblem};

/// The largest error of an answer, as a part of the variation of its component.
pub const TOLERANCE: f64 = 1e-6;
/// Unknowns are not known better than this part of themselves.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Whole Newton steps that a solution is looked for by.
const STEPS: usize = 80;

/// An outcome of a problem.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// The answer was right.
    Right,
    /// The answer was wrong by this part.
    Wrong { error: f64 },
    /// It was refused, and Newton's method with LU comes to no end either.
    Refused { why: String },
    /// It was refused, but LU solves it.
    WronglyRefused { why: String },
}

/// K⁻¹ R at u, on all unknowns.
fn newton_step(
    equations: &mut dyn NonlinearProblem,
    elimination: &mut Elimination,
    u: &[f64],
) -> Option<Vec<f64>> {
    let residual = equations.residual(u).ok()?;
    let load: Vec<f64> = elimination.reduce(&residual).ok()?.iter().map(|value| -value).collect();
    let matrix = elimination.reduce_matrix(&equations.tangent(u).ok()?.matrix).ok()?;
    let mut lu = LuSolver::default();
    lu.set_matrix(matrix).ok()?;
    let found = lu.solve(&load, 0.0).ok()?;
    let change = elimination.extend_by_zero(&found.solution).ok()?;
    change.iter().all(|value| value.is_finite()).then_some(change)
}

/// The largest difference of two vectors in some groups of unknowns, as a part of the largest value of the group, or of the variation
/// of all groups of the component where that is less.
pub fn difference(found: &[f64], exact: &[f64], groups: &[Group]) -> f64 {
    let range = |component: usize| {
        let own = groups.iter().filter(|group| group.component == component);
        let values = own.flat_map(|group| &group.unknowns).map(|unknown| exact[*unknown]);
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    let of_group = |group: &Group| {
        let most = group.unknowns.iter().map(|i| exact[*i].abs()).fold(0.0, f64::max);
        let off = group.unknowns.iter().map(|i| (found[*i] - exact[*i]).abs()).fold(0.0, f64::max);
        let range = range(group.component);
        // A component that is the same everywhere is its own scale.
        let scale = if range <= 1e-9 * most { most } else { most.min(range) };
        if off <= ROUNDING * most || off == 0.0 { 0.0 } else { off / scale.max(f64::MIN_POSITIVE) }
    };
    groups.iter().map(of_group).fold(0.0, f64::max)
}

/// Unknowns of one component in a part of the mesh.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// A number of the component among all.
    pub component: usize,
    /// The unknowns among all.
    pub unknowns: Vec<usize>,
}

/// Compares what a problem gave with a solution, or with further Newton steps.
pub fn judge(
    found: Result<Vec<f64>, String>,
    equations: &mut dyn NonlinearProblem,
    mut elimination: Elimination,
    (start, exact): (Vec<f64>, Option<Vec<f64>>),
    groups: &[Group],
) -> Outcome {
    let elimination = &mut elimination;
    match found {
        Ok(u) => {
            let reference = exact.unwrap_or_else(|| {
                // Quadratic convergence doubles digits: a few more steps are at rounding.
                let mut better = u.clone();
                for _ in 0..4 {
                    let Some(change) = newton_step(equations, elimination, &better) else { break };
                    better.iter_mut().zip(&change).for_each(|(u, change)| *u += change);
                }
                better
            });
            let error = difference(&u, &reference, groups);
            if error > TOLERANCE {
                println!("found {u:?}\nreference {reference:?}");
            }
            if error <= TOLERANCE { Outcome::Right } else { Outcome::Wrong { error } }
        }
        Err(why) => {
            let mut u = start;
            if elimination.impose(&mut u).is_err() {
                return Outcome::Refused { why };
            }
            let mut settled = 0;
            for _ in 0..STEPS {
                let Some(change) = newton_step(equations, elimination, &u) else {
                    return Outcome::Refused { why };
                };
                let next: Vec<f64> = u.iter().zip(&change).map(|(u, change)| u + change).collect();
                settled = if difference(&u, &next, groups) <= 1e-3 * TOLERANCE { settled + 1 } else { 0 };
                u = next;
                if settled == 2 {
                    return Outcome::WronglyRefused { why };
                }
            }
            Outcome::Refused { why }
        }
    }
}

/// The components of a space's unknowns in the left and in the right half of a mesh, from an offset on.
pub fn halves(space: &Space<2>, offset: usize) -> Vec<Group> {
    let components = space.components();
    let mut groups = vec![Group::default(); 2 * components];
    for (node, position) in space.positions().iter().enumerate() {
        for component in 0..components {
            let group = &mut groups[2 * component + usize::from(position[0] > 0.5)];
            group.component = offset + component;
            group.unknowns.push(offset + node * components + component);
        }
    }
    groups.retain(|group| !group.unknowns.is_empty());
    groups
}
