//! Measurements on one mesh, beside Hertz's answer.

use std::fmt;
use std::time::Instant;

use clap::ValueEnum;
use forms_contact::ContactProblem;
use forms_contact::hertz::{Hertz, Measured};
use forms_fem::output::tell;
use forms_fem::prelude::*;

use crate::Outcome;

/// The part up to which a and p0 may be off.
pub const TOLERANCE: f64 = 0.005;

/// The method for Newton's linear systems.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum LinearMethod {
    /// A direct one, on the unknowns where contact may be
    Condensed,
    /// Multigrid as preconditioner of GMRES
    Multigrid,
}

/// Measurements on one mesh.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Unknowns.
    pub unknowns: usize,
    /// The force of the whole body.
    pub force: f64,
    /// Relative errors of a, of p0 on the axis, and of p0 by the pressure within a/2.
    pub errors: [f64; 3],
    /// The relative error of the pressure in L²(Γ_C).
    pub profile: f64,
    /// The least diameter of a cell \[mm\].
    pub smallest: f64,
    /// Steps of Newton's method.
    pub steps: usize,
    /// Most iterations of a linear system, where it is not solved directly.
    pub iterations: Option<usize>,
    /// Seconds by the clock to solve.
    pub seconds: f64,
}

impl Row {
    /// The larger error of a and of p0 by the pressure within a/2.
    pub fn larger(&self) -> f64 {
        self.errors[0].abs().max(self.errors[2].abs())
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([a, axis, middle], profile) = (self.errors.map(|error| 100.0 * error), 100.0 * self.profile);
        let Row { unknowns, force, smallest, steps, seconds, .. } = self;
        let iterations = self.iterations.map_or("–".to_owned(), |count| count.to_string());
        write!(
            f,
            "{unknowns} | {force:.4} | {a:+.2} % | {middle:+.2} % | {axis:+.2} % | {profile:.2} % | {smallest:.4} | {steps} | {iterations} | {seconds:.2}"
        )
    }
}

/// The unknowns from which on a and p0 are within the tolerance.
pub fn settled(rows: &[Row]) -> Option<usize> {
    let off = rows.iter().rposition(|row| row.larger() > TOLERANCE);
    rows.get(off.map_or(0, |place| place + 1)).map(|row| row.unknowns)
}

/// Solves on a mesh, from the solution on the one before.
pub fn solve<const D: usize>(
    problem: &ContactProblem<D>,
    before: Option<&Field<D>>,
    hertz: fn(f64) -> Hertz,
    method: LinearMethod,
) -> Outcome<(Field<D>, Row)>
where
    Dim: Dimension<D>,
{
    let start = Instant::now();
    let first = match before {
        Some(before) => before.onto(&problem.space).interpolated()?,
        None => Field::zero(&problem.space),
    };
    let (solved, iterations) = match method {
        LinearMethod::Condensed => {
            let mut solver = CondensedSolver::default();
            (problem.direct()?.start(&first).solver(&mut solver).solve()?, None)
        }
        LinearMethod::Multigrid => {
            let mut solver = MultigridSolver::new(&problem.constraints, MultigridSolverOptions::default())?;
            let solved = problem.direct()?.start(&first).solver(&mut solver).solve()?;
            (solved, solver.report().iterations.iter().copied().max())
        }
    };
    let (steps, u) = (solved.iterations(), solved.into_field());
    let seconds = start.elapsed().as_secs_f64();
    let (measured, mesh) = (Measured::of(problem, &u)?, problem.space.mesh());
    let hertz = hertz(measured.force);
    let row = Row {
        unknowns: problem.space.unknowns(),
        force: measured.force,
        errors: measured.errors(&hertz),
        profile: hertz.profile_error(problem, &u)?,
        steps,
        iterations,
        smallest: (0..mesh.cell_count()).map(|cell| mesh.diameter(cell)).fold(f64::INFINITY, f64::min),
        seconds,
    };
    tell(format!("{} cells: {row}", mesh.cell_count()));
    Ok((u, row))
}
