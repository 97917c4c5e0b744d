//! Minimisation of a reduced problem under inequality constraints, between bounds: the method of moving asymptotes.
//!
//! At each iterate J and the constraints are replaced by convex separable functions with poles at two asymptotes per control, which move
//! apart where an iterate goes on and together where it swings (Svanberg 1987, Int. J. Numer. Methods Eng. 24; the constants are those
//! of his notes of 2007). The approximate problem is solved by its dual, which has one unknown per constraint.

mod approximation;

use thiserror::Error;

use self::approximation::{Approximation, Separable};
use super::bounds::{Bounds, BoundsMismatch};
use super::control_vectors::ControlVectors;
use super::minimise::StopReason;
use super::reduced_problem::ReducedProblem;
use crate::linear_algebra::vector::add_scaled;
use crate::solve::CommunicationError;

/// A constraint g(m) ≤ 0: its value and its gradient, an entry per control. Values of about one suit the method.
pub type Inequality<'c, E> = dyn FnMut(&[f64]) -> Result<(f64, Vec<f64>), E> + 'c;

/// Options of the method.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingAsymptotes {
    /// Most iterations.
    pub max_iterations: usize,
    /// Done where a step of length one along the gradient of the Lagrangian changes no control by more than this part of what one along
    /// the gradient of J did at the start, and no constraint is violated by more than this.
    pub tolerance: f64,
    /// Most part of the distance between its bounds by which a control changes in an iteration.
    pub move_limit: f64,
    /// The asymptotes' first distance from a control, relative to the distance between its bounds.
    pub first_distance: f64,
}

impl Default for MovingAsymptotes {
    fn default() -> Self {
        MovingAsymptotes { max_iterations: 200, tolerance: 1e-4, move_limit: 0.5, first_distance: 0.5 }
    }
}

/// An iterate.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstrainedStep {
    /// 0 for the start.
    pub iteration: usize,
    /// J.
    pub value: f64,
    /// g, one entry per constraint: not above zero where it holds.
    pub constraints: Vec<f64>,
    /// The largest change of a control in a step of length one along the gradient of the Lagrangian; of the start, of J.
    pub criticality: f64,
    /// The largest change of a control since the iterate before.
    pub change: f64,
}

/// A minimum under constraints, with the history of the iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstrainedMinimum {
    /// m.
    pub controls: Vec<f64>,
    /// J(m).
    pub value: f64,
    /// g(m).
    pub constraints: Vec<f64>,
    /// The multiplier of each constraint in the last approximate problem \[J\].
    pub multipliers: Vec<f64>,
    /// The start and each iterate.
    pub history: Vec<ConstrainedStep>,
    /// Reason of the end: [`StopReason::Tolerance`] or [`StopReason::Iterations`].
    pub finish: StopReason,
}

/// A minimisation that could not go on.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum ConstrainedError<E: std::error::Error + 'static> {
    /// Bounds that do not fit.
    #[error(transparent)]
    Bounds(#[from] BoundsMismatch),
    /// A failed exchange between processes that have parts of the controls.
    #[error(transparent)]
    Communication(#[from] CommunicationError),
    /// A control without bounds.
    #[error("control {0} has no finite bounds, between which the asymptotes would be placed")]
    Unbounded(usize),
    /// A gradient of another length than the controls.
    #[error("constraint {constraint} has a gradient of {found} entries for {controls} controls")]
    Length {
        /// The number of the constraint.
        constraint: usize,
        /// Entries of its gradient.
        found: usize,
        controls: usize,
    },
    /// A value or a gradient that is not finite.
    #[error("iteration {iteration}: {what} or its gradient is not finite")]
    NotFinite {
        iteration: usize,
        /// The criterion, or which constraint.
        what: String,
    },
    /// The problem or a constraint failed.
    #[error("iteration {iteration}: {why}")]
    Problem {
        iteration: usize,
        /// The problem's error.
        #[source]
        why: E,
    },
}

impl MovingAsymptotes {
    /// Minimisation from the problem's start, put between the bounds, which have to be finite. `progress` is called with each iterate.
    ///
    /// # Errors
    /// [`ConstrainedError`].
    pub fn run<P: ReducedProblem + ?Sized>(
        &self,
        problem: &mut P,
        bounds: &Bounds,
        constraints: &mut [Box<Inequality<'_, P::Error>>],
        mut progress: impl FnMut(&ConstrainedStep),
    ) -> Result<ConstrainedMinimum, ConstrainedError<P::Error>> {
        let mut m = problem.start();
        let vectors = problem.vectors().map_err(|why| ConstrainedError::Problem { iteration: 0, why })?;
        vectors.check_bounds(bounds, &m)?;
        let unbounded = bounds.first_infinite();
        if !vectors.all(unbounded.is_none()) {
            let elsewhere = ConstrainedError::Bounds(BoundsMismatch::Elsewhere);
            return Err(unbounded.map_or(elsewhere, ConstrainedError::Unbounded));
        }
        bounds.project(&mut m);
        let mut approximation = Approximation::new(&vectors, bounds, self.move_limit, self.first_distance);
        let mut multipliers = vec![0.0; constraints.len()];
        let mut history: Vec<ConstrainedStep> = vec![];
        let mut change = 0.0;
        loop {
            let iteration = history.len();
            let (of_value, of_constraints) = evaluate(problem, constraints, (&m, &vectors), iteration)?;
            let mut slope = of_value.gradient.clone();
            for (multiplier, constraint) in multipliers.iter().zip(&of_constraints) {
                add_scaled(&mut slope, *multiplier, &constraint.gradient);
            }
            let step = ConstrainedStep {
                iteration,
                value: of_value.value,
                constraints: of_constraints.iter().map(|constraint| constraint.value).collect(),
                criticality: vectors.largest(bounds.criticality(&m, &slope)),
                change,
            };
            progress(&step);
            history.push(step.clone());
            let small = step.criticality <= self.tolerance * history[0].criticality;
            let holds = step.constraints.iter().all(|value| *value <= self.tolerance);
            // The multipliers are known from the first approximate problem on.
            let done = small && holds && (iteration > 0 || constraints.is_empty());
            if done || iteration >= self.max_iterations {
                let finish = if done { StopReason::Tolerance } else { StopReason::Iterations };
                let ConstrainedStep { value, constraints, .. } = step;
                return Ok(ConstrainedMinimum {
                    controls: m,
                    value,
                    constraints,
                    multipliers,
                    history,
                    finish,
                });
            }
            let (moved, found) = approximation.minimum(&m, &of_value, &of_constraints);
            change =
                vectors.largest(moved.iter().zip(&m).map(|(new, old)| (new - old).abs()).fold(0.0, f64::max));
            vectors.check()?;
            (m, multipliers) = (moved, found);
        }
    }
}

/// J and the constraints with their gradients, finite all.
fn evaluate<P: ReducedProblem + ?Sized>(
    problem: &mut P,
    constraints: &mut [Box<Inequality<'_, P::Error>>],
    (m, vectors): (&[f64], &ControlVectors),
    iteration: usize,
) -> Result<(Separable, Vec<Separable>), ConstrainedError<P::Error>> {
    let failed = |why| ConstrainedError::Problem { iteration, why };
    let finite = |(value, gradient): (f64, Vec<f64>), what: &dyn Fn() -> String| {
        let own = value.is_finite() && gradient.iter().all(|slope| slope.is_finite());
        if vectors.all(own) {
            return Ok(Separable { value, gradient });
        }
        vectors.check()?;
        Err(ConstrainedError::<P::Error>::NotFinite { iteration, what: what() })
    };
    let value = finite(problem.value_and_gradient(m).map_err(failed)?, &|| "the criterion".to_owned())?;
    let mut found = vec![];
    for (number, constraint) in constraints.iter_mut().enumerate() {
        let (value, gradient) = constraint(m).map_err(failed)?;
        if gradient.len() != m.len() {
            let (found, controls) = (gradient.len(), m.len());
            return Err(ConstrainedError::Length { constraint: number, found, controls });
        }
        found.push(finite((value, gradient), &|| format!("constraint {number}"))?);
    }
    Ok((value, found))
}
