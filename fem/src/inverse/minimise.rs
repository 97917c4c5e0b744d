//! Minimisation of a reduced problem between bounds: L-BFGS.
//!
//! At each iterate the quadratic model of the last changes of controls and gradient has a minimum between the bounds, as in L-BFGS-B
//! (Byrd, Lu, Nocedal & Zhu 1995, SIAM J. Sci. Comput. 16); towards it the step follows the weak conditions of Wolfe.

use thiserror::Error;

use super::bounds::{Bounds, BoundsMismatch};
use super::control_vectors::ControlVectors;
use super::quasi_newton::Model;
use super::reduced_problem::ReducedProblem;
use crate::linear_algebra::vector::add_scaled;
use crate::solve::CommunicationError;

/// Options of the minimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimise {
    /// Most iterations.
    pub max_iterations: usize,
    /// Done where a gradient step of length one changes no control by more than this part of what it did at the start.
    pub tolerance: f64,
    /// Changes of controls and gradient that are remembered.
    pub memory: usize,
    /// The largest change of a control in the first trial step.
    pub first_change: f64,
}

impl Default for Minimise {
    fn default() -> Self {
        Minimise { max_iterations: 200, tolerance: 1e-6, memory: 20, first_change: 0.1 }
    }
}

/// An iterate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinimisationStep {
    /// 0 for the start.
    pub iteration: usize,
    /// J.
    pub value: f64,
    /// The largest change of a control in a gradient step of length one.
    pub criticality: f64,
    /// Values and gradients computed so far.
    pub evaluations: usize,
}

/// The reason for which a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The criticality has fallen as asked for.
    Tolerance,
    /// The last iteration allowed.
    Iterations,
    /// No step along the gradient gave a smaller value: rounding, or a kink.
    NoDescent,
}

/// The best controls that were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// m.
    pub controls: Vec<f64>,
    /// J(m).
    pub value: f64,
    /// dJ/dm.
    pub gradient: Vec<f64>,
    /// The start and each iterate.
    pub history: Vec<MinimisationStep>,
    /// Reason of the end.
    pub finish: StopReason,
}

/// A minimisation that could not go on.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum MinimisationError<E: std::error::Error + 'static> {
    /// Bounds that do not fit.
    #[error(transparent)]
    Bounds(#[from] BoundsMismatch),
    /// A failed exchange between processes that have parts of the controls.
    #[error(transparent)]
    Communication(#[from] CommunicationError),
    /// A value that is not finite at the start.
    #[error("the criterion or its gradient is not finite at the start: J = {0}")]
    NotFinite(f64),
    /// The problem failed at the start, or at each trial of a step.
    #[error("iteration {iteration}: {why}")]
    Problem {
        iteration: usize,
        /// The problem's error.
        #[source]
        why: E,
    },
}

/// Armijo's part of the expected decrease.
const DECREASE: f64 = 1e-4;
/// The slope along a step has to fall to this part, unless the bounds end the step.
const FLATTER: f64 = 0.9;
/// Trials of a step.
const TRIALS: usize = 30;

impl Minimise {
    /// Minimisation from the problem's start, put between the bounds. `progress` is called with each iterate.
    ///
    /// # Errors
    /// [`MinimisationError`].
    pub fn run<P: ReducedProblem + ?Sized>(
        &self,
        problem: &mut P,
        bounds: &Bounds,
        mut progress: impl FnMut(&MinimisationStep),
    ) -> Result<Minimum, MinimisationError<P::Error>> {
        let mut m = problem.start();
        let failed = |iteration| move |why| MinimisationError::Problem { iteration, why };
        let vectors = problem.vectors().map_err(failed(0))?;
        vectors.check_bounds(bounds, &m)?;
        bounds.project(&mut m);
        let (mut value, mut gradient) = problem.value_and_gradient(&m).map_err(failed(0))?;
        if !all_finite(&vectors, value, &gradient) {
            vectors.check()?;
            return Err(MinimisationError::NotFinite(value));
        }
        let mut model = Model::new(&vectors, self.memory, self.first_scale(&vectors, &gradient));
        let mut evaluations = 1;
        let mut history: Vec<MinimisationStep> = vec![];
        let finish = loop {
            let iteration = history.len();
            let criticality = vectors.largest(bounds.criticality(&m, &gradient));
            let step = MinimisationStep { iteration, value, criticality, evaluations };
            progress(&step);
            history.push(step);
            if criticality <= self.tolerance * history[0].criticality {
                break StopReason::Tolerance;
            }
            if iteration >= self.max_iterations {
                break StopReason::Iterations;
            }
            let found = loop {
                let direction = model.minimum(&m, &gradient, bounds);
                let at = (&m[..], value, &gradient[..]);
                let found = self.search(problem, (bounds, &vectors), at, &direction, &mut evaluations);
                match found.map_err(failed(iteration + 1))? {
                    // Once more along the gradient: what is remembered may be of the other side of a kink.
                    None if !model.is_empty() => model.restart(self.first_scale(&vectors, &gradient)),
                    found => break found,
                }
            };
            vectors.check()?;
            let Some((moved, moved_value, moved_gradient)) = found else { break StopReason::NoDescent };
            model.remember(difference(&moved, &m), difference(&moved_gradient, &gradient));
            (m, value, gradient) = (moved, moved_value, moved_gradient);
        };
        Ok(Minimum { controls: m, value, gradient, history, finish })
    }

    /// θ with which the first step changes a control by as much as it may.
    fn first_scale(&self, vectors: &ControlVectors, gradient: &[f64]) -> f64 {
        let largest = gradient.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
        let largest = vectors.largest(largest);
        if largest > 0.0 { largest / self.first_change } else { 1.0 }
    }

    /// A point along a direction with enough of a decrease and a slope that has fallen; none if there is none.
    fn search<P: ReducedProblem + ?Sized>(
        &self,
        problem: &mut P,
        (bounds, vectors): (&Bounds, &ControlVectors),
        (m, value, gradient): (&[f64], f64, &[f64]),
        direction: &[f64],
        evaluations: &mut usize,
    ) -> Result<Option<Point>, P::Error> {
        let slope = vectors.dot(gradient, direction);
        if slope.is_nan() || slope >= 0.0 {
            return Ok(None);
        }
        let longest = -vectors.largest(-bounds.longest_step(m, direction).max(1.0));
        // What is too short, what is too long, and the best of what is too short.
        let (mut short, mut long, mut length) = (0.0, f64::INFINITY, 1.0);
        let mut best = None;
        for trial in 0..TRIALS {
            let mut moved = m.to_vec();
            add_scaled(&mut moved, length, direction);
            bounds.project(&mut moved);
            *evaluations += 1;
            match problem.value_and_gradient(&moved) {
                Ok((found, at))
                    if all_finite(vectors, found, &at) && found <= value + DECREASE * length * slope =>
                {
                    let flat = vectors.dot(&at, direction) >= FLATTER * slope;
                    best = Some((moved, found, at));
                    if flat || length >= longest {
                        break;
                    }
                    short = length;
                }
                // Too long a step may have no solution, or no number.
                Ok(_) => long = length,
                Err(why) if trial + 1 == TRIALS && best.is_none() => return Err(why),
                Err(_) => long = length,
            }
            length = if long.is_infinite() {
                (4.0 * short).min(longest)
            } else if short > 0.0 {
                0.5 * (short + long)
            } else {
                0.3 * long
            };
        }
        Ok(best)
    }
}

/// Controls, value, gradient.
type Point = (Vec<f64>, f64, Vec<f64>);

fn all_finite(vectors: &ControlVectors, value: f64, gradient: &[f64]) -> bool {
    vectors.all(value.is_finite() && gradient.iter().all(|slope| slope.is_finite()))
}

fn difference(new: &[f64], old: &[f64]) -> Vec<f64> {
    new.iter().zip(old).map(|(new, old)| new - old).collect()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::verification::Sample;

    /// Rosenbrock's function in pairs of controls.
    struct Valley(Vec<f64>);

    impl ReducedProblem for Valley {
        type Error = Infallible;

        fn start(&self) -> Vec<f64> {
            self.0.clone()
        }

        fn sample(&mut self, m: &[f64]) -> Result<Sample, Infallible> {
            Ok(self.value_and_gradient(m)?.0.into())
        }

        fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), Infallible> {
            let (mut value, mut gradient) = (0.0, vec![]);
            for pair in m.chunks(2) {
                let (x, y) = (pair[0], pair[1]);
                value += (1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2);
                gradient.extend([-2.0 * (1.0 - x) - 400.0 * x * (y - x * x), 200.0 * (y - x * x)]);
            }
            Ok((value, gradient))
        }
    }

    #[test]
    fn a_curved_valley_with_and_without_bounds() {
        let start = [-1.2, 1.0].repeat(5);
        let options = Minimise { tolerance: 1e-10, ..Minimise::default() };
        let free = options.run(&mut Valley(start.clone()), &Bounds::none(10), |_| ()).unwrap();
        assert_eq!(free.finish, StopReason::Tolerance);
        assert!(free.controls.iter().all(|m| (m - 1.0).abs() < 1e-8), "{free:?}");
        assert!(free.history.len() < 80, "{}", free.history.len());
        // With x ≤ ½ the minimum is at (½, ¼), worth ¼ (Lagrange's conditions by hand).
        let bounds = Bounds::each(vec![-2.0; 10], [0.5, 2.0].repeat(5));
        let bounded = options.run(&mut Valley(start), &bounds, |_| ()).unwrap();
        assert_eq!(bounded.finish, StopReason::Tolerance);
        for pair in bounded.controls.chunks(2) {
            assert!(pair[0] == 0.5 && (pair[1] - 0.25).abs() < 1e-8, "{pair:?}");
        }
        assert!((bounded.value - 5.0 * 0.25).abs() < 1e-12);
    }

    #[test]
    fn bounds_that_do_not_fit_are_named() {
        let run = |bounds: &Bounds| Minimise::default().run(&mut Valley(vec![0.0; 2]), bounds, |_| ());
        let few = run(&Bounds::none(3)).unwrap_err().to_string();
        assert!(few.contains("3 lower and 3 upper bounds were given for 2 controls"), "{few}");
        let crossed = run(&Bounds::each(vec![0.0, 2.0], vec![1.0, 1.0])).unwrap_err().to_string();
        assert!(crossed.contains("the lower bound 2 of control 1"), "{crossed}");
        let nan = run(&Bounds::between(2, f64::NAN, 1.0)).unwrap_err();
        assert!(matches!(nan, MinimisationError::Bounds(BoundsMismatch::Order { control: 0, .. })));
    }
}
