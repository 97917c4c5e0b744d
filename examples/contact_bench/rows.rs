//! A row of the results: one formulation on one problem and mesh.

use forms_fem::output::Failure;
use serde::Serialize;

use crate::balance::balance;
use crate::case::Case;
use crate::gradient::Gradient;
use crate::outcome::{Outcome, Refusal};
use crate::problem::{Problem, Quantity};

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
#[derive(Clone, Debug, PartialEq, Serialize)]
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

/// A solution with its gradient, or the reason why there is none.
pub type WithGradient = (Outcome, Result<Gradient, Refusal>);

/// The answer to a formulation's outcome, and to the outcomes of further cases.
///
/// # Errors
/// Data that do not fit.
pub fn answer(
    problem: &dyn Problem,
    case: &Case,
    (outcome, others): (Result<WithGradient, Refusal>, &[Outcome]),
    seconds: f64,
) -> Result<Answer, Failure> {
    let (found, gradient) = match outcome {
        Ok(found) => found,
        Err(Refusal::NotDefined(why)) => return Ok(Answer::NotDefined(why)),
        Err(Refusal::Failed(why)) => return Ok(Answer::Failed(why)),
    };
    let pressures = &found.pressures;
    let force = pressures.force();
    let exact = |x: [f64; 2]| problem.exact_pressure(x, force);
    let is_known = pressures.positions.iter().all(|x| exact(*x).is_some());
    let known = |x: [f64; 2]| exact(x).unwrap_or_default();
    let pressure_error = is_known.then(|| {
        let square = pressures.integral(|x, p| (p - known(x)).powi(2));
        (square / pressures.integral(|x, _| known(x).powi(2))).sqrt()
    });
    let mut along: Vec<[f64; 2]> =
        pressures.positions.iter().zip(&pressures.values).map(|(x, p)| [problem.along(*x), *p]).collect();
    let mut known_along: Vec<[f64; 2]> = match is_known {
        true => pressures.positions.iter().map(|x| [problem.along(*x), known(*x)]).collect(),
        false => vec![],
    };
    for list in [&mut along, &mut known_along] {
        list.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    let sums = balance(case, &found.forces);
    let mut quantities = problem.quantities(case, &found)?;
    let all: Vec<Outcome> = std::iter::once(found.clone()).chain(others.iter().cloned()).collect();
    quantities.extend(problem.quantities_of_all(&all)?);
    Ok(Answer::Solved(Measured {
        pressure_error,
        newton: found.newton.iter().sum(),
        worst_newton: found.newton.iter().copied().max().unwrap_or(0),
        outer: found.outer,
        seconds,
        force_balance: sums.map(|sums| sums.force),
        moment_balance: sums.map(|sums| sums.moment),
        no_gradient: gradient.as_ref().err().map(|why| why.to_string()),
        gradient: gradient.ok(),
        penetration: case.penetration(&found.u)? / case.approach,
        quantities,
        pressures: along,
        known: known_along,
    }))
}
