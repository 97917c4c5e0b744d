//! Minimisation of a reduced problem between bounds: projected L-BFGS.
//!
//! At an iterate the controls that stand at a bound and would leave it stay there; on the others Nocedal's two loops (1980) give a
//! direction from the last changes of controls and gradient, and Armijo's rule a point on the path that the bounds cut off
//! (Bertsekas 1982, Projected Newton methods, SIAM J. Control Optim. 20).

use std::collections::VecDeque;

use thiserror::Error;

use super::bounds::{Bounds, BoundsMismatch};
use super::reduced_problem::ReducedProblem;
use crate::linear_algebra::vector::{add_scaled, dot};

/// Options of the minimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimise {
    /// Most iterations.
    pub max_iterations: usize,
    /// Done where a gradient step of length one changes no control by more than this part of what it did at the start.
    pub tolerance: f64,
    /// Changes of controls and gradient that are remembered.
    pub memory: usize,
    /// The largest change of a control in the first trial step; later ones take the length that they come with.
    pub first_change: f64,
}

impl Default for Minimise {
    fn default() -> Self {
        Minimise { max_iterations: 200, tolerance: 1e-6, memory: 10, first_change: 0.1 }
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
pub enum Finish {
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
    /// Why it ended.
    pub finish: Finish,
}

/// A minimisation that could not go on.
#[derive(Debug, Error)]
pub enum MinimisationError<E: std::error::Error + 'static> {
    /// Bounds that do not fit.
    #[error(transparent)]
    Bounds(#[from] BoundsMismatch),
    /// A value that is not finite at the start.
    #[error("the criterion or its gradient is not finite at the start: J = {0}")]
    NotFinite(f64),
    /// The problem failed at the start, or at each trial of a step.
    #[error("iteration {iteration}: {why}")]
    Problem {
        /// The iteration.
        iteration: usize,
        /// The problem's error.
        #[source]
        why: E,
    },
}

/// Armijo's part of the expected decrease.
const DECREASE: f64 = 1e-4;
/// Trials of a step.
const TRIALS: usize = 30;
/// A change is remembered if s·y is above this part of |s| |y|.
const CURVED: f64 = 1e-12;

impl Minimise {
    /// Minimises from the problem's start, put between the bounds. `progress` is told of each iterate.
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
        bounds.check(&m)?;
        bounds.project(&mut m);
        let failed = |iteration| move |why| MinimisationError::Problem { iteration, why };
        let (mut value, mut gradient) = problem.value_and_gradient(&m).map_err(failed(0))?;
        if !all_finite(value, &gradient) {
            return Err(MinimisationError::NotFinite(value));
        }
        let mut changes = Changes::new(self.memory);
        let mut evaluations = 1;
        let mut history: Vec<MinimisationStep> = vec![];
        let finish = loop {
            let iteration = history.len();
            let criticality = bounds.criticality(&m, &gradient);
            let step = MinimisationStep { iteration, value, criticality, evaluations };
            progress(&step);
            history.push(step);
            if criticality <= self.tolerance * history[0].criticality {
                break Finish::Tolerance;
            }
            if iteration >= self.max_iterations {
                break Finish::Iterations;
            }
            let held: Vec<bool> =
                (0..m.len()).map(|place| bounds.hold(place, m[place], gradient[place])).collect();
            let found = loop {
                let (direction, first) = changes.direction(&gradient, &held, self.first_change);
                let found = self.search(
                    problem,
                    bounds,
                    (&m, value, &gradient),
                    (&direction, first),
                    &mut evaluations,
                );
                match found.map_err(failed(iteration + 1))? {
                    // Once more along the gradient: what is remembered may be of the other side of a kink.
                    None if !changes.is_empty() => changes.clear(),
                    found => break found,
                }
            };
            let Some((moved, moved_value, moved_gradient)) = found else { break Finish::NoDescent };
            changes.remember(&m, &moved, &gradient, &moved_gradient);
            (m, value, gradient) = (moved, moved_value, moved_gradient);
        };
        Ok(Minimum { controls: m, value, gradient, history, finish })
    }

    /// A point on the path along a direction with enough of a decrease; none if there is none.
    fn search<P: ReducedProblem + ?Sized>(
        &self,
        problem: &mut P,
        bounds: &Bounds,
        (m, value, gradient): (&[f64], f64, &[f64]),
        (direction, first): (&[f64], f64),
        evaluations: &mut usize,
    ) -> Result<Option<Point>, P::Error> {
        let mut length = first;
        for trial in 0..TRIALS {
            let mut moved = m.to_vec();
            add_scaled(&mut moved, length, direction);
            bounds.project(&mut moved);
            let change: Vec<f64> = moved.iter().zip(m).map(|(moved, m)| moved - m).collect();
            let expected = dot(gradient, &change);
            if change.iter().all(|change| *change == 0.0) || expected >= 0.0 {
                return Ok(None);
            }
            *evaluations += 1;
            let mut decrease = f64::NAN;
            match problem.value_and_gradient(&moved) {
                Ok((found, slope)) if all_finite(found, &slope) => {
                    if found <= value + DECREASE * expected {
                        return Ok(Some((moved, found, slope)));
                    }
                    decrease = found - value;
                }
                Ok(_) => {}
                Err(why) if trial + 1 == TRIALS => return Err(why),
                Err(_) => {}
            }
            // The minimum of the parabola through value, slope and trial, or where there is no value a tenth.
            let part = -expected / (2.0 * (decrease - expected));
            length *= if part.is_finite() { part.clamp(0.1, 0.5) } else { 0.1 };
        }
        Ok(None)
    }
}

/// Controls, value, gradient.
type Point = (Vec<f64>, f64, Vec<f64>);

fn all_finite(value: f64, gradient: &[f64]) -> bool {
    value.is_finite() && gradient.iter().all(|slope| slope.is_finite())
}

/// The last changes of controls and gradient, oldest first.
struct Changes {
    most: usize,
    pairs: VecDeque<[Vec<f64>; 2]>,
}

impl Changes {
    fn new(most: usize) -> Self {
        Changes { most, pairs: VecDeque::new() }
    }

    fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    fn clear(&mut self) {
        self.pairs.clear();
    }

    fn remember(&mut self, m: &[f64], moved: &[f64], gradient: &[f64], moved_gradient: &[f64]) {
        let difference = |new: &[f64], old: &[f64]| new.iter().zip(old).map(|(new, old)| new - old).collect();
        let (s, y): (Vec<f64>, Vec<f64>) = (difference(moved, m), difference(moved_gradient, gradient));
        if dot(&s, &y) > CURVED * (dot(&s, &s) * dot(&y, &y)).sqrt() {
            self.pairs.push_back([s, y]);
            if self.pairs.len() > self.most {
                self.pairs.pop_front();
            }
        }
    }

    /// A direction of descent, zero where controls are held, and the length to try first.
    fn direction(&self, gradient: &[f64], held: &[bool], first_change: f64) -> (Vec<f64>, f64) {
        let free = |vector: &[f64]| -> Vec<f64> {
            vector.iter().zip(held).map(|(value, held)| if *held { 0.0 } else { *value }).collect()
        };
        let slope = free(gradient);
        let pairs: Vec<[Vec<f64>; 2]> = self.pairs.iter().map(|[s, y]| [free(s), free(y)]).collect();
        let pairs: Vec<_> = pairs
            .iter()
            .filter_map(|[s, y]| {
                let curvature = dot(s, y);
                (curvature > CURVED * (dot(s, s) * dot(y, y)).sqrt()).then_some((s, y, curvature))
            })
            .collect();
        let steepest = || {
            let largest = slope.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
            let length = if largest > 0.0 { first_change / largest } else { 1.0 };
            (slope.iter().map(|slope| -slope).collect(), length)
        };
        let Some((_, y, curvature)) = pairs.last() else { return steepest() };
        let scale = curvature / dot(y, y);
        let mut direction = slope.clone();
        let mut factors = vec![];
        for (s, y, curvature) in pairs.iter().rev() {
            let factor = dot(s, &direction) / curvature;
            add_scaled(&mut direction, -factor, y);
            factors.push(factor);
        }
        direction.iter_mut().for_each(|value| *value *= scale);
        for ((s, y, curvature), factor) in pairs.iter().zip(factors.into_iter().rev()) {
            let other = dot(y, &direction) / curvature;
            add_scaled(&mut direction, factor - other, s);
        }
        direction.iter_mut().for_each(|value| *value = -*value);
        match dot(&direction, &slope) < 0.0 {
            true => (direction, 1.0),
            false => steepest(),
        }
    }
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
        assert_eq!(free.finish, Finish::Tolerance);
        assert!(free.controls.iter().all(|m| (m - 1.0).abs() < 1e-8), "{free:?}");
        assert!(free.history.len() < 80, "{}", free.history.len());
        // With x ≤ ½ the minimum is at (½, ¼), worth ¼ (Lagrange's conditions by hand).
        let bounds = Bounds::each(vec![-2.0; 10], [0.5, 2.0].repeat(5));
        let bounded = options.run(&mut Valley(start), &bounds, |_| ()).unwrap();
        assert_eq!(bounded.finish, Finish::Tolerance);
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
