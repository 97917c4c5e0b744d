//! A row of the results: one formulation on one problem and mesh.

use std::time::Instant;

use forms_fem::output::Failure;
use serde::Serialize;

use crate::gradient::Gradient;
use crate::outcome::{Outcome, Pressures, Refusal};
use crate::problem::Quantity;

/// The outcome of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// A solution, measured.
    Solved(Measured),
    /// The formulation does not exist for the problem, and why.
    NotDefined(String),
    /// The formulation failed, and the solver's reason.
    Failed(String),
}

/// Numbers of a solution.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Measured {
    /// ‖p − p_known‖/‖p_known‖ in L² of the own surface, where the pressure is known.
    pub pressure_error: Option<f64>,
    /// All Newton steps.
    pub newton: usize,
    /// Most Newton steps of one solve.
    pub worst_newton: usize,
    /// Steps of an outer iteration.
    pub outer: Option<usize>,
    /// Seconds of the whole solution.
    pub seconds: f64,
    /// |ΣF| of both bodies, relative to Σ|F|.
    pub force_balance: Option<f64>,
    /// |ΣM| of both bodies, relative to Σ|x||F|.
    pub moment_balance: Option<f64>,
    /// The gradient by the way of the supports; on the coarsest mesh.
    pub gradient: Option<Gradient>,
    /// The reason for which there is no gradient.
    pub no_gradient: Option<String>,
    /// The worst penetration, relative to a typical change of the gap.
    pub penetration: f64,
    /// Numbers of the problem.
    pub quantities: Vec<Quantity>,
    /// Places along the contact with pressures, in order.
    pub pressures: Vec<[f64; 2]>,
    /// Places along the contact with known pressures.
    pub known: Vec<[f64; 2]>,
}

/// One formulation on one problem and mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The problem.
    pub problem: String,
    /// The formulation.
    pub formulation: String,
    /// Degree of the displacements.
    pub degree: usize,
    /// Level of the mesh.
    pub level: usize,
    /// Unknowns of the displacement.
    pub unknowns: usize,
    /// The outcome.
    pub answer: Answer,
}

impl Row {
    /// The numbers, if there is a solution.
    pub fn measured(&self) -> Option<&Measured> {
        match &self.answer {
            Answer::Solved(measured) => Some(measured),
            _ => None,
        }
    }
}

impl Answer {
    /// The answer of a formulation's solution, which is given its seconds, or of its refusal.
    ///
    /// # Errors
    /// Those of the measurement.
    pub fn timed<T>(
        solve: impl FnOnce() -> Result<T, Refusal>,
        measure: impl FnOnce(T, f64) -> Result<Measured, Failure>,
    ) -> Result<Answer, Failure> {
        let start = Instant::now();
        let found = solve();
        let seconds = start.elapsed().as_secs_f64();
        match found {
            Ok(found) => Ok(Answer::Solved(measure(found, seconds)?)),
            Err(why) => Ok(Answer::of(why)),
        }
    }

    /// The answer of a formulation without a solution.
    fn of(why: Refusal) -> Answer {
        match why {
            Refusal::NotDefined(why) => Answer::NotDefined(why),
            Refusal::Failed(why) => Answer::Failed(why),
        }
    }
}

impl Measured {
    /// The steps of a solution only.
    pub fn of(found: &Outcome) -> Measured {
        Measured { outer: found.outer, ..Measured::of_newton(found.newton.iter().copied()) }
    }

    /// The Newton steps of several solves.
    pub fn of_newton(steps: impl Iterator<Item = usize> + Clone) -> Measured {
        let worst_newton = steps.clone().max().unwrap_or(0);
        Measured { newton: steps.sum(), worst_newton, ..Measured::default() }
    }

    /// The Newton steps of loads, with the number of problems where a load is more than one.
    pub fn of_loads<'a>(loads: impl Iterator<Item = &'a [usize]> + Clone) -> Measured {
        let steps = loads.clone().flatten().copied();
        let (problems, loads) = (steps.clone().count(), loads.count());
        Measured { outer: (problems > loads).then_some(problems), ..Measured::of_newton(steps) }
    }

    /// With the pressures along the contact, compared with the known ones, where they are known at all points.
    pub fn compared(
        mut self,
        pressures: &Pressures,
        along: impl Fn([f64; 2]) -> f64,
        exact: impl Fn([f64; 2]) -> Option<f64>,
    ) -> Measured {
        let is_known = pressures.positions.iter().all(|x| exact(*x).is_some());
        let known = |x: [f64; 2]| exact(x).unwrap_or_default();
        self.pressure_error = is_known.then(|| {
            // A known pressure may be infinite at a node, where an edge ends.
            let finite = |x: [f64; 2], of: f64| if known(x).is_finite() { of * of } else { 0.0 };
            let square = pressures.integral(|x, p| finite(x, p - known(x)));
            (square / pressures.integral(|x, _| finite(x, known(x)))).sqrt()
        });
        let points = pressures.positions.iter().zip(&pressures.values);
        self.pressures = points.map(|(x, p)| [along(*x), *p]).collect();
        if is_known {
            let finite = pressures.positions.iter().filter(|x| known(**x).is_finite());
            self.known = finite.map(|x| [along(*x), known(*x)]).collect();
        }
        for list in [&mut self.pressures, &mut self.known] {
            list.sort_by(|a, b| a[0].total_cmp(&b[0]));
        }
        self
    }
}
