//! Measurements on one mesh, compared with Hertz's answer.

use std::fmt;
use std::time::Instant;

use clap::ValueEnum;
use forms_contact::ContactProblem;
use forms_contact::hertz::{CONTACT, Hertz, Measured};
use forms_examples::memory::peak_megabytes;
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
    /// Cells.
    pub cells: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// The force of the whole body.
    pub force: f64,
    /// Relative errors of a, and of p0 by the pressure within a/2.
    pub errors: [f64; 2],
    /// The relative error of p0 on the axis, where facets have a value there.
    pub axis: Option<f64>,
    /// The relative error of p0 by [`recovered_peak`], where there are points enough.
    pub recovered: Option<f64>,
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
    /// Largest memory of the program so far \[MB\], where the system reports it.
    pub memory: Option<f64>,
}

impl Row {
    /// The larger error of a and of p0 by the pressure within a/2.
    pub fn larger(&self) -> f64 {
        self.errors[0].abs().max(self.errors[1].abs())
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([a, middle], profile) = (self.errors.map(|error| 100.0 * error), 100.0 * self.profile);
        let Row { cells, unknowns, force, smallest, steps, seconds, .. } = self;
        let [axis, recovered] = [self.axis, self.recovered]
            .map(|error| error.map_or("–".to_owned(), |error| format!("{:+.2} %", 100.0 * error)));
        let iterations = self.iterations.map_or("–".to_owned(), |count| count.to_string());
        let memory = self.memory.map_or("–".to_owned(), |memory| format!("{memory:.0}"));
        write!(
            f,
            "{cells} | {unknowns} | {force:.4} | {a:+.2} % | {middle:+.2} % | {axis} | {recovered} | {profile:.2} % | {smallest:.4} | {steps} | {iterations} | {seconds:.2} | {memory}"
        )
    }
}

/// The least diameter of a cell \[mm\].
pub fn smallest<const D: usize>(mesh: &Mesh<D>) -> f64 {
    (0..mesh.cell_count()).map(|cell| mesh.diameter(cell)).fold(f64::INFINITY, f64::min)
}

/// The unknowns from which on a and p0 are within the tolerance.
pub fn settled(rows: &[Row]) -> Option<usize> {
    let off = rows.iter().rposition(|row| row.larger() > TOLERANCE);
    rows.get(off.map_or(0, |place| place + 1)).map(|row| row.unknowns)
}

/// The pressure on the axis \[MPa\] as a recovered value: the line through p² over r² within half of the reach, by least squares at the
/// points of quadrature. Near the axis any pressure that is smooth and the same in all directions has such a line up to r⁴, Hertz's has
/// it everywhere; its slope is free. None where too few points lie there.
fn recovered_peak<const D: usize>(
    problem: &ContactProblem<D>,
    u: &Field<D>,
    reach: f64,
) -> Outcome<Option<f64>>
where
    Dim: Dimension<D>,
{
    let pressure = problem.law.contact_pressure(u);
    let points = problem.assembler.at_quadrature_points(&pressure, Entity::Facets, CONTACT, 8)?;
    // Σ w, Σ w t, Σ w t², Σ w s, Σ w s t of t = r², s = p².
    let mut sums = [0.0; 5];
    for ((x, weight), value) in points.positions.iter().zip(&points.weights).zip(&points.values) {
        let (t, s) = (x[..D - 1].iter().map(|x| x * x).sum::<f64>(), value[0] * value[0]);
        if t < 0.25 * reach * reach {
            for (sum, term) in sums.iter_mut().zip([1.0, t, t * t, s, s * t]) {
                *sum += weight * term;
            }
        }
    }
    let [one, t, tt, s, st] = sums;
    let square = (tt * s - t * st) / (one * tt - t * t);
    Ok((square.is_finite() && square > 0.0).then(|| square.sqrt()))
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
    let recovered = recovered_peak(problem, &u, measured.reach)?.map(|peak| peak / hertz.peak - 1.0);
    let [reach, axis, middle] = measured.errors(&hertz);
    let row = Row {
        recovered,
        cells: mesh.cell_count(),
        unknowns: problem.space.unknowns(),
        force: measured.force,
        errors: [reach, middle],
        axis: Some(axis),
        profile: hertz.profile_error(problem, &u)?,
        steps,
        iterations,
        smallest: smallest(mesh),
        seconds,
        memory: peak_megabytes(),
    };
    tell(format!("{row}"));
    Ok((u, row))
}
