//! Reduced problems: a criterion as a function of the controls alone, the states being solved for on the way.

use super::control_vectors::ControlVectors;
use super::differentiable_map::Part;
use crate::verification::{Sample, TaylorReport, taylor};

/// J(m) with its gradient.
pub trait ReducedProblem {
    /// Error of a value or a gradient.
    type Error: std::error::Error + 'static;

    /// The controls m to begin with.
    fn start(&self) -> Vec<f64>;

    /// The names of the controls, each with its number of values: one name for all, unless the problem tells others.
    fn parts(&self) -> Vec<Part> {
        vec![Part::new("controls", self.start().len())]
    }

    /// Products of vectors of control values: where processes have parts of a mesh, those of all. Minimisation takes these.
    ///
    /// # Errors
    /// A failed exchange.
    fn vectors(&mut self) -> Result<ControlVectors, Self::Error> {
        Ok(ControlVectors::default())
    }

    /// J(m), with the switches that are on: where they change, J has a kink.
    ///
    /// # Errors
    /// Equations that were not solved; controls that do not fit.
    fn sample(&mut self, m: &[f64]) -> Result<Sample, Self::Error>;

    /// J(m).
    ///
    /// # Errors
    /// As [`ReducedProblem::sample`].
    fn value(&mut self, m: &[f64]) -> Result<f64, Self::Error> {
        Ok(self.sample(m)?.value.first().copied().unwrap_or(f64::NAN))
    }

    /// J(m) and dJ/dm, an entry per control value.
    ///
    /// # Errors
    /// As [`ReducedProblem::sample`].
    fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), Self::Error>;
}

/// Taylor test of the gradient at m along a direction of the controls: the remainder |J(m + t δ) − J(m) − t dJ/dm·δ| has to fall with the
/// second order, from steps t = `first` on. Steps across a kink are reported and do not count.
///
/// # Errors
/// Those of the problem.
pub fn taylor_test<P: ReducedProblem + ?Sized>(
    problem: &mut P,
    m: &[f64],
    direction: &[f64],
    first: f64,
) -> Result<TaylorReport, P::Error> {
    let (_, gradient) = problem.value_and_gradient(m)?;
    let slope = problem.vectors()?.dot(&gradient, direction);
    taylor(first, &[slope], |step| {
        let moved: Vec<f64> = m.iter().zip(direction).map(|(m, along)| m + step * along).collect();
        problem.sample(&moved)
    })
}
