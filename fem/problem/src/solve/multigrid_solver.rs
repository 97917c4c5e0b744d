//! Iterative solution with multigrid: conjugate gradients, or GMRES where the matrix is unsymmetric.

use std::sync::Arc;
use std::time::Instant;

use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use super::node_blocks::NodeBlocks;
use crate::constraints::Constraints;
use crate::linear_algebra::Transpose;
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::error::{check_finite, check_size};
use crate::linear_algebra::krylov::until_each_equation_holds;
use crate::linear_algebra::multigrid::LevelReport;
use crate::linear_algebra::vector::largest;
use crate::linear_algebra::{
    BlockMatrix, CsrMatrix, GmresError, GmresOptions, KrylovError, KrylovOptions, KrylovReport,
    LinearAlgebraError, Multigrid, MultigridOptions, OnThreads, Preconditioner, SharedWork, cg, gmres,
};
use crate::space::SpaceError;
use crate::threads::Threads;

/// A right-hand side smaller than this part of ‖A‖ ‖x‖ is rounding of A x.
const NOTHING: f64 = 1e-13;

/// Choices of a [`MultigridSolver`].
#[derive(Clone, Debug, PartialEq)]
pub struct MultigridSolverOptions {
    /// Relative residual to reach; each equation has to hold besides, up to a hundred times this part of its own terms.
    pub tolerance: f64,
    /// Most iterations of one solve.
    pub max_iterations: usize,
    /// A matrix whose [`CsrMatrix::asymmetry`] is at most this is solved by conjugate gradients.
    pub symmetry_tolerance: f64,
    /// The levels.
    pub multigrid: MultigridOptions,
    /// Threads of checks, iterations and vectors; solutions are the same for each number of them.
    pub threads: Threads,
}

impl Default for MultigridSolverOptions {
    fn default() -> Self {
        MultigridSolverOptions {
            tolerance: 1e-10,
            max_iterations: 200,
            symmetry_tolerance: 1e-12,
            multigrid: MultigridOptions::default(),
            threads: Threads::all(),
        }
    }
}

/// The work of a [`MultigridSolver`] since it was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MultigridSolverReport {
    /// Hierarchies that were set up.
    pub setups: usize,
    /// Systems solved.
    pub solves: usize,
    /// Iterations of each solve, in order.
    pub iterations: Vec<usize>,
    /// Levels of the last hierarchy, finest first.
    pub levels: Vec<LevelReport>,
    /// Counted work of the last hierarchy's set-up, without checks of the matrix and the ordering of the last level.
    pub setup_work: Option<SharedWork>,
    /// Counted work of one of its cycles.
    pub cycle_work: Option<SharedWork>,
    /// Seconds in set-up.
    pub setup_seconds: f64,
    /// Seconds in solves.
    pub solve_seconds: f64,
    /// Largest relative residual of a solve.
    pub largest_residual: f64,
    /// Relative residuals of the last solve, at the start and after each iteration.
    pub history: Vec<f64>,
}

/// A Krylov method preconditioned by multigrid on one space: from its degree down to degree 1 through the spaces on the
/// same mesh (Chebyshev smoothing), then by smoothed aggregation with rigid motions (elasticity) or constants as
/// near-null space, and a direct solution on the smallest level. For large systems in space that are symmetric and
/// positive definite, or nearly so.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = cuboid([0.0; 3], [1.0; 3], [4; 3], CellShape::Tetrahedron, 1)?;
/// let space = Space::scalar(&mesh, 2)?;
/// let poisson = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
/// let mut constraints = Constraints::new(&space);
/// constraints.fix("boundary", |_| 0.0)?;
/// let assembler = Assembler::new(&mesh);
/// let mut solver = MultigridSolver::new(&constraints, MultigridSolverOptions::default())?;
/// let u = Problem::new(&poisson, &space).assembler(&assembler).constrained(&constraints).solver(&mut solver).solve()?.into_field();
/// assert!((u.evaluate(&[0.5; 3])?[0] - 0.056).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MultigridSolver {
    options: MultigridSolverOptions,
    blocks: NodeBlocks,
    current: Option<Current>,
    report: MultigridSolverReport,
}

#[derive(Debug)]
struct Current {
    matrix: Arc<BlockMatrix>,
    /// Largest entry of the matrix.
    scale: f64,
    /// Empty for a symmetric matrix.
    transposed: Option<BlockMatrix>,
    multigrid: Multigrid,
}

impl Current {
    /// Whether b is rounding of A x in every equation.
    fn is_rounding(&self, b: &[f64], x: &[f64]) -> Result<bool, LinearAlgebraError> {
        let (_, sizes) = self.matrix.products(x)?;
        Ok(b.iter().zip(&sizes).all(|(b, size)| b.abs() <= NOTHING * size))
    }
}

impl MultigridSolver {
    /// A solver for systems on the space of these constraints, which must be those of every system.
    ///
    /// # Errors
    /// If there are no spaces of lower degree.
    pub fn new<const D: usize>(
        constraints: &Constraints<D>,
        options: MultigridSolverOptions,
    ) -> Result<Self, SpaceError> {
        let blocks = NodeBlocks::new(constraints)?;
        Ok(MultigridSolver { options, blocks, current: None, report: MultigridSolverReport::default() })
    }

    /// The work done so far.
    pub fn report(&self) -> &MultigridSolverReport {
        &self.report
    }
}

fn failed(error: KrylovError) -> SolverError {
    match error {
        KrylovError::BadArguments(error) => error.into(),
        error => SolverError::Krylov {
            method: "conjugate gradients",
            why: error.to_string(),
            report: error.report().cloned().unwrap_or_default(),
        },
    }
}

fn by_gmres(
    matrix: &BlockMatrix,
    multigrid: &mut Multigrid,
    b: &[f64],
    x: &mut [f64],
    options: &GmresOptions,
) -> Result<KrylovReport, SolverError> {
    let mut residual = vec![0.0; b.len()];
    let found = gmres(
        |v, w| matrix.multiply_on(options.threads, v, w).map_err(SolverError::from),
        |v| {
            residual.copy_from_slice(v);
            multigrid.precondition(&residual, v).map_err(|error| SolverError::Krylov {
                method: "multigrid",
                why: error.to_string(),
                report: KrylovReport::default(),
            })
        },
        b,
        x,
        options,
    );
    found.map(KrylovReport::from).map_err(|error| match error {
        GmresError::Operator(error) => error,
        GmresError::NotConverged(report) | GmresError::Stagnated(report) | GmresError::NotFinite(report) => {
            SolverError::NotConverged(report)
        }
        error @ GmresError::BadArguments { .. } => {
            SolverError::Krylov { method: "GMRES", why: error.to_string(), report: KrylovReport::default() }
        }
    })
}

impl LinearSolver for MultigridSolver {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        let (start, threads) = (Instant::now(), self.options.threads);
        matrix.check_finite_on(threads)?;
        if let Some(unknown) = matrix.diagonal().iter().position(|value| *value == 0.0) {
            return Err(LinearAlgebraError::Singular { unknown, ratio: 0.0 }.into());
        }
        let symmetric = matrix.is_symmetric_on(threads, self.options.symmetry_tolerance)?;
        let blocks = self.blocks.matrix(&matrix, threads)?;
        if self.current.as_ref().is_some_and(|current| *current.matrix == blocks) {
            return Ok(()); // an adjoint problem with the tangent that is known already
        }
        self.current = None;
        let blocks = Arc::new(blocks);
        let (levelled, transposed) = if symmetric {
            drop(matrix);
            (blocks.clone(), None)
        } else {
            let symmetric_part = Arc::new(self.blocks.matrix(&matrix.symmetric_part()?, threads)?);
            (symmetric_part, Some(self.blocks.matrix(&matrix.transpose(), threads)?))
        };
        let multigrid = Multigrid::new(
            levelled.clone(),
            self.blocks.transfers.clone(),
            self.blocks.near_null_space.clone(),
            &self.options.multigrid,
        )
        .map_err(|error| match self.blocks.singular(&levelled) {
            Some(error) => error.into(),
            None => SolverError::Krylov {
                method: "multigrid",
                why: format!("a level could not be made: {error}"),
                report: KrylovReport::default(),
            },
        })?;
        drop(levelled);
        self.report.setups += 1;
        self.report.setup_seconds += start.elapsed().as_secs_f64();
        self.report.levels = multigrid.levels().to_vec();
        self.report.setup_work = Some(multigrid.setup_work().clone());
        self.report.cycle_work = Some(multigrid.cycle_work().clone());
        let scale = largest(blocks.values());
        self.current = Some(Current { matrix: blocks, scale, transposed, multigrid });
        Ok(())
    }

    fn judges_equations(&self) -> bool {
        true
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        absolute: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let Some(current) = &mut self.current else { return Err(SolverError::NoMatrix) };
        check_size("the right-hand side", self.blocks.free_unknowns(), b.len())?;
        check_finite("the right-hand side", b)?;
        let start = Instant::now();
        let all = self.blocks.spread(b);
        let mut x = vec![0.0; all.len()];
        let threads = self.options.threads;
        let found = match &current.transposed {
            None => {
                let options = KrylovOptions {
                    tolerance: self.options.tolerance,
                    absolute_tolerance: absolute,
                    max_iterations: self.options.max_iterations,
                    threads,
                };
                let operator = OnThreads(&*current.matrix, threads);
                cg(&operator, &mut current.multigrid, &all, &mut x, &options).map_err(failed)
            }
            Some(other) => {
                let matrix = if transpose == Transpose::Yes { other } else { &*current.matrix };
                let options = GmresOptions {
                    tolerance: self.options.tolerance,
                    absolute_tolerance: absolute,
                    max_iterations: self.options.max_iterations,
                    threads,
                    ..GmresOptions::default()
                };
                let as_krylov = KrylovOptions {
                    tolerance: options.tolerance,
                    absolute_tolerance: absolute,
                    max_iterations: options.max_iterations,
                    threads,
                };
                let further = GmresOptions { absolute_tolerance: 0.0, ..options.clone() };
                by_gmres(matrix, &mut current.multigrid, &all, &mut x, &options).and_then(|report| {
                    let more = |b: &[f64], x: &mut [f64]| {
                        match by_gmres(matrix, &mut current.multigrid, b, x, &further) {
                            // A part of the residual is better than nothing.
                            Err(SolverError::NotConverged(report)) => Ok(report.into()),
                            found => found,
                        }
                    };
                    until_each_equation_holds(matrix, &all, &mut x, &as_krylov, report, more)
                })
            }
        };
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        let found = found.map_err(|error| {
            match &error {
                SolverError::Krylov { report, .. } => self.report.history.clone_from(&report.history),
                SolverError::NotConverged(report) => self.report.history.clone_from(&report.history),
                _ => {}
            }
            self.blocks
                .singular(&current.matrix)
                .map_or_else(|| self.blocks.reduced(error), SolverError::from)
        })?;
        // A motion that nothing resists is multiplied by rounding alone: the solution is then that motion, and huge.
        let resistance = largest(b) / (current.scale * largest(&x));
        // Of parts of different stiffness each counts in its own scale.
        if resistance < NOTHING && largest(b) > absolute && current.is_rounding(&all, &x)? {
            let solution = self.blocks.gather(&x);
            let moved = solution.iter().position(|value| value.abs() == largest(&solution)).unwrap_or(0);
            return Err(LinearAlgebraError::Singular { unknown: moved, ratio: resistance }.into());
        }
        self.report.solves += 1;
        self.report.iterations.push(found.iterations);
        self.report.largest_residual = self.report.largest_residual.max(found.relative_residual);
        self.report.history = found.history;
        Ok(LinearSolution {
            solution: self.blocks.gather(&x),
            relative_residual: found.relative_residual,
            iterations: found.iterations,
        })
    }
}

#[cfg(test)]
mod tests;
