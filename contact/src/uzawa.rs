//! Uzawa's iteration for contact with friction: displacements for a given multiplier, then the multiplier by what they give.

use std::fmt;

use forms_fem::prelude::*;
use forms_fem::solve::SolveError;
use thiserror::Error;

use crate::contact_problem::ContactProblem;
use crate::laws::uzawa;

/// The ends of the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UzawaOptions {
    /// The largest change of the multiplier at a point, relative to the largest multiplier, at which it has converged.
    pub tolerance: f64,
    /// Iterations at most.
    pub max_iterations: usize,
}

impl Default for UzawaOptions {
    fn default() -> Self {
        UzawaOptions { tolerance: 1e-10, max_iterations: 200 }
    }
}

/// Numbers of one iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UzawaStep {
    /// The largest change |T − λ| of the multiplier at a point, relative to the largest |T| \[1\]; zero where nothing touches.
    pub change: f64,
    /// Steps of Newton's method for the displacements.
    pub newton_steps: usize,
}

/// The iterations up to now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UzawaHistory {
    /// One by one.
    pub steps: Vec<UzawaStep>,
}

impl UzawaHistory {
    /// The factor by which the last change is smaller than the one before: the rate of linear convergence. `None` before two
    /// changes are known, or where the earlier one is zero.
    pub fn rate(&self) -> Option<f64> {
        let [.., before, last] = &self.steps[..] else { return None };
        (before.change > 0.0).then(|| last.change / before.change)
    }

    /// Whether the last changes grew, one after the other.
    fn grows(&self) -> bool {
        let growing = self.steps.windows(2).rev().take_while(|pair| pair[1].change > pair[0].change);
        growing.count() >= GROWING
    }
}

/// Growing changes in a row after which the iteration counts as diverging.
const GROWING: usize = 10;

impl fmt::Display for UzawaHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let last = self.steps.last().map_or(0.0, |step| step.change);
        write!(f, "{} iterations, last relative change {last:.1e}", self.steps.len())?;
        match self.rate() {
            Some(rate) => write!(f, ", rate {rate:.3}"),
            None => Ok(()),
        }
    }
}

/// A solution by Uzawa's iteration.
#[derive(Clone, Debug)]
pub struct UzawaSolution<const D: usize> {
    /// The displacements, with the history of the last of Newton's solves.
    pub solved: Solved<D>,
    /// The iterations.
    pub history: UzawaHistory,
}

/// Reasons for which Uzawa's iteration ends without a solution.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum UzawaError {
    /// The displacements for a multiplier could not be found.
    #[error("Uzawa's iteration {iteration}: {source}")]
    Displacements {
        /// Number of the iteration, from 1.
        iteration: usize,
        source: Box<SolveError>,
    },
    /// Data that do not fit.
    #[error("Uzawa's iteration: {source}")]
    Assembly {
        #[from]
        source: AssemblyError,
    },
    /// The largest number of iterations was reached.
    #[error(
        "Uzawa's iteration did not reach a change of {tolerance:.1e}: {history}; a larger γ₀ makes it faster"
    )]
    NotConverged {
        /// The change asked for.
        tolerance: f64,
        history: UzawaHistory,
    },
    /// The changes grow.
    #[error("Uzawa's iteration diverges: {history}")]
    Diverging { history: UzawaHistory },
}

/// Solution of a contact problem by Uzawa's iteration, from a displacement and from the multiplier that the law's data hold:
/// u for λ by Newton's method, then λ ← T(λ, u), until λ changes no more. The multiplier of the last iteration stays in the data,
/// also after an error, and the next load step begins with it.
///
/// The error of λ falls by a constant factor: of a layer of height H, by M/(M + γ H) with its modulus M.
///
/// # Errors
/// [`UzawaError`].
pub fn solve_by_uzawa<const D: usize>(
    problem: &ContactProblem<D, uzawa::Model<D>>,
    start: &Field<D>,
    options: UzawaOptions,
    mut progress: impl FnMut(&UzawaHistory),
) -> Result<UzawaSolution<D>, UzawaError>
where
    Dim: Dimension<D>,
{
    let multiplier = &problem.law.data.multiplier;
    let mut history = UzawaHistory::default();
    let mut u = start.clone();
    loop {
        let iteration = history.steps.len() + 1;
        let solved = problem.direct()?.start(&u).solve();
        let solved =
            solved.map_err(|source| UzawaError::Displacements { iteration, source: Box::new(source) })?;
        u = solved.field().clone();
        let before = problem.assembler.history_values(multiplier)?;
        problem.assembler.update_history(&problem.law.obstacle_traction(&u), multiplier)?;
        multiplier.commit();
        let after = problem.assembler.history_values(multiplier)?;
        let change = relative_change(&before, &after);
        history.steps.push(UzawaStep { change, newton_steps: solved.iterations() });
        progress(&history);
        if change <= options.tolerance {
            return Ok(UzawaSolution { solved, history });
        }
        if history.grows() {
            return Err(UzawaError::Diverging { history });
        }
        if iteration >= options.max_iterations {
            return Err(UzawaError::NotConverged { tolerance: options.tolerance, history });
        }
    }
}

/// The largest difference of vectors relative to the largest vector of both; zero where all are.
fn relative_change(before: &[Vec<f64>], after: &[Vec<f64>]) -> f64 {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>().sqrt();
    let (mut change, mut size) = (0.0_f64, 0.0_f64);
    for (a, b) in before.iter().zip(after) {
        change = change.max(norm(&mut a.iter().zip(b).map(|(a, b)| a - b)));
        size = size.max(norm(&mut a.iter().copied())).max(norm(&mut b.iter().copied()));
    }
    if size > 0.0 { change / size } else { 0.0 }
}
