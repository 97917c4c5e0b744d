//! Proximal point iteration: inequality constraints by a sequence of smooth problems in a displacement u, further fields, if any, and a latent
//! variable ψ.
//!
//! Each problem minimises the energy plus 1/α_k times a distance from the last state. The constraint's slack is e^ψ, which is positive
//! (Keith and Surowiec 2024; Dokken, Farrell, Keith, Papadopoulos and Surowiec 2025). The multiplier is (ψ_{k−1} − ψ_k)/α_k.

use std::error::Error;
use std::fmt;

use forms_fem::prelude::*;
use thiserror::Error;

use crate::parameter_ranges::ParameterRanges;

/// The parameters of the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProximalOptions {
    /// α₀, the first step \[slack per unit of the multiplier\].
    pub first_step: f64,
    /// α_{k+1}/α_k, at least 1. Larger values take fewer iterations and more steps of Newton's method in each.
    pub growth: f64,
    /// The iteration ends where the H¹ norm of u's increment is below this part of u's. It does not depend on the mesh, as a norm over
    /// nodes would.
    pub tolerance: f64,
    /// Iterations at most.
    pub max_iterations: usize,
}

impl Default for ProximalOptions {
    fn default() -> Self {
        ProximalOptions { first_step: 1.0, growth: 2.0, tolerance: 1e-6, max_iterations: 100 }
    }
}

/// Numbers of one iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProximalStep {
    /// α_k.
    pub alpha: f64,
    /// H¹ norm of u's increment, as a part of that of u \[1\].
    pub change: f64,
    /// Steps of Newton's method.
    pub newton_steps: usize,
}

/// The iterations up to now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProximalHistory {
    /// One by one.
    pub steps: Vec<ProximalStep>,
}

impl ProximalHistory {
    /// All steps of Newton's method.
    pub fn newton_steps(&self) -> usize {
        self.steps.iter().map(|step| step.newton_steps).sum()
    }
}

impl fmt::Display for ProximalHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let last = self.steps.last().map_or(0.0, |step| step.change);
        let (count, newton_steps) = (self.steps.len(), self.newton_steps());
        write!(f, "{count} iterations with {newton_steps} Newton steps, last relative change {last:.1e}")
    }
}

/// A solution by the proximal point iteration.
#[derive(Clone, Debug)]
pub struct ProximalSolution<const D: usize, const N: usize = 2> {
    /// All fields, u in front and ψ at the end, with the history of the last of Newton's solves.
    pub solved: Solved<D, N>,
    /// (ψ_{k−1} − ψ_k)/α_k of the last iteration, in the space of ψ: the pressure or the force per area of the constraint.
    pub multiplier: Field<D>,
    /// The iterations.
    pub history: ProximalHistory,
}

/// Reasons for which the iteration ends without a solution.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum ProximalError {
    /// A problem of the sequence could not be solved.
    #[error(
        "proximal iteration {iteration} with α = {alpha:.3e} ({history}): {source}; try a smaller first step or growth"
    )]
    Problem {
        /// Number of the iteration, from 1.
        iteration: usize,
        alpha: f64,
        source: Box<dyn Error + Send + Sync>,
        history: ProximalHistory,
    },
    /// Parameters of the iteration that make no sense.
    #[error(
        "the proximal iteration needs a positive first step and a growth of at least 1; they are {first_step} and {growth}"
    )]
    Options { first_step: f64, growth: f64 },
    /// Norms of u.
    #[error("proximal iteration: {source}")]
    Assembly {
        #[from]
        source: AssemblyError,
    },
    /// The largest number of iterations was reached.
    #[error("the proximal iteration did not reach a change of {tolerance:.1e}: {history}")]
    NotConverged { tolerance: f64, history: ProximalHistory },
}

/// One problem of the sequence.
#[derive(Clone, Copy, Debug)]
pub struct Proximal<'a, const D: usize, const N: usize = 2> {
    /// α_k.
    pub alpha: f64,
    /// All fields of the last problem, u in front and ψ at the end, where Newton's method begins.
    pub before: &'a [Field<D>; N],
}

impl<'a, const D: usize, const N: usize> Proximal<'a, D, N> {
    /// ψ_k of the last problem.
    pub fn latent(&self) -> &'a Field<D> {
        &self.before[N - 1]
    }

    /// The problem of a law whose data have this α, on the spaces of all fields.
    ///
    /// # Errors
    /// A parameter of the law out of its range.
    pub fn problem(
        &self,
        law: &impl ParameterRanges,
        direct: &Form<D>,
        spaces: [&Arc<Space<D>>; N],
    ) -> Result<Problem<'a, D, N>, AssemblyError> {
        law.check(direct.name())?;
        Ok(Problem::new(direct, spaces).start(self.before))
    }
}

/// The proximal point iteration from u, further fields, if any, and ψ. `solve` solves one problem of it, that of a law of its kind, as
/// [`proximal_membrane`](mod@crate::laws::proximal_membrane) or [`proximal_obstacle`](mod@crate::laws::proximal_obstacle), at [`Proximal::alpha`] and
/// [`Proximal::latent`].
///
/// # Errors
/// [`ProximalError`].
pub fn solve_by_proximal_points<const D: usize, const N: usize, E: Into<Box<dyn Error + Send + Sync>>>(
    start: [Field<D>; N],
    options: ProximalOptions,
    mut solve: impl FnMut(Proximal<'_, D, N>) -> Result<Solved<D, N>, E>,
    mut progress: impl FnMut(&ProximalHistory),
) -> Result<ProximalSolution<D, N>, ProximalError>
where
    Dim: Dimension<D>,
{
    let ProximalOptions { first_step, growth, tolerance, max_iterations } = options;
    if !(first_step > 0.0 && first_step.is_finite() && growth >= 1.0 && growth.is_finite()) {
        return Err(ProximalError::Options { first_step, growth });
    }
    let assembler = Assembler::new(start[0].space().mesh());
    let (mut before, mut alpha) = (start, first_step);
    let mut history = ProximalHistory::default();
    loop {
        let iteration = history.steps.len() + 1;
        let solved = solve(Proximal { alpha, before: &before }).map_err(|source| ProximalError::Problem {
            iteration,
            alpha,
            source: source.into(),
            history: history.clone(),
        })?;
        let (u, latent) = (&solved.fields[0], &solved.fields[N - 1]);
        let moved = Field::combination(&[(1.0, u), (-1.0, &before[0])]).map_err(AssemblyError::other)?;
        let (moved, size) = (norms::norms(&assembler, &moved)?.h1, norms::norms(&assembler, u)?.h1);
        let change = if size > 0.0 { moved / size } else { moved };
        history.steps.push(ProximalStep { alpha, change, newton_steps: solved.iterations() });
        progress(&history);
        if change <= tolerance {
            let multiplier = Field::combination(&[(1.0 / alpha, &before[N - 1]), (-1.0 / alpha, latent)])
                .map_err(AssemblyError::other)?;
            return Ok(ProximalSolution { solved, multiplier, history });
        }
        if iteration >= max_iterations {
            return Err(ProximalError::NotConverged { tolerance, history });
        }
        before = solved.fields;
        alpha *= growth;
    }
}
