//! Second derivatives of reduced problems: the Hessian along a direction, and Taylor tests of both orders.

use super::reduced_problem::ReducedProblem;
use super::sweep::Work;
use crate::verification::{TaylorReport, taylor};

/// J(m), dJ/dm and the Hessian along a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondOrder {
    /// J(m).
    pub value: f64,
    /// dJ/dm, an entry per control value.
    pub gradient: Vec<f64>,
    /// (d²J/dm²) d, an entry per control value.
    pub along: Vec<f64>,
}

/// J, its gradient, and the Hessian along a direction, with the cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Hessian {
    /// J(m).
    pub value: f64,
    /// dJ/dm.
    pub gradient: Vec<f64>,
    /// (d²J/dm²) d.
    pub along: Vec<f64>,
    /// Steps solved and stored.
    pub work: Work,
}

impl From<Hessian> for SecondOrder {
    fn from(found: Hessian) -> Self {
        SecondOrder { value: found.value, gradient: found.gradient, along: found.along }
    }
}

/// A reduced problem with a Hessian action.
pub trait TwiceDifferentiable: ReducedProblem {
    /// J(m), its gradient, and its Hessian applied to a direction of the controls.
    ///
    /// # Errors
    /// As [`ReducedProblem::sample`].
    fn second_order(&mut self, m: &[f64], direction: &[f64]) -> Result<SecondOrder, Self::Error>;
}

/// Taylor test of gradient and Hessian at m along a direction δ of the controls: |J(m + t δ) − J(m) − t dJ/dm·δ| has to fall with the second
/// order, and what is left of it after −½ t² δ·(d²J/dm²) δ with the third, from steps t = `first` on. The reports are of the gradient
/// and of the Hessian: `report.second_order()` and `report.third_order()` judge them.
///
/// # Errors
/// Those of the problem.
pub fn second_order_taylor_test<P: TwiceDifferentiable + ?Sized>(
    problem: &mut P,
    m: &[f64],
    direction: &[f64],
    first: f64,
) -> Result<[TaylorReport; 2], P::Error> {
    let found = problem.second_order(m, direction)?;
    let pairs = [(&found.gradient[..], direction), (&found.along, direction)];
    let products = problem.vectors()?.dots(&pairs);
    let (slope, curvature) = (products[0], products[1]);
    let mut moved = |step: f64| {
        let moved: Vec<f64> = m.iter().zip(direction).map(|(m, along)| m + step * along).collect();
        problem.sample(&moved)
    };
    let of_gradient = taylor(first, &[slope], &mut moved)?;
    let of_hessian = taylor(first, &[slope], |step| {
        let mut sample = moved(step)?;
        sample.value.iter_mut().for_each(|value| *value -= 0.5 * step * step * curvature);
        Ok(sample)
    })?;
    Ok([of_gradient, of_hessian])
}
