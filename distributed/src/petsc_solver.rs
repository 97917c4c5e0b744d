//! PETSc's solvers behind the trait that Newton's method asks of a linear solver.

use std::ffi::CStr;
use std::ptr::{null, null_mut};
use std::time::Instant;

use forms_fem::linear_algebra::{CsrMatrix, LinearAlgebraError, ResidualHistory, check_residual};
use forms_fem::prelude::*;
use forms_fem::solve::linear_system::HOLDS;
use forms_fem::solve::{LinearSolution, SolverError, Transpose};

use crate::error::PetscError;
use crate::matrix::DistributedMatrix;
use crate::node_rows::NodeRows;
use crate::petsc::{self, DEFAULT, EUCLIDEAN, Index, Object, TRUE, UNPRECONDITIONED, call};
use crate::vector::DistributedVector;
use crate::world::World;

/// The relative residual that conjugate gradients reach where nothing else is asked for.
pub const TOLERANCE: f64 = 1e-10;

/// Methods of solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// LU by MUMPS, for any matrix.
    Direct,
    /// Conjugate gradients with smoothed aggregation (GAMG), told the rigid motions where the unknown is a displacement: for
    /// symmetric positive definite matrices.
    ConjugateGradients {
        /// Relative residual ‖b − A x‖₂ / ‖b‖₂ to reach.
        tolerance: f64,
        /// Most iterations.
        max_iterations: u16,
    },
}

impl Method {
    /// Conjugate gradients to a relative residual of [`TOLERANCE`], in at most 500 iterations.
    pub fn conjugate_gradients() -> Self {
        Method::ConjugateGradients { tolerance: TOLERANCE, max_iterations: 500 }
    }

    /// The method of a name: `direct` or `cg`.
    ///
    /// # Errors
    /// [`UnknownMethod`].
    pub fn named(name: &str) -> Result<Self, UnknownMethod> {
        match name {
            "direct" => Ok(Method::Direct),
            "cg" => Ok(Method::conjugate_gradients()),
            name => Err(UnknownMethod { name: name.to_owned() }),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Method::Direct => "MUMPS",
            Method::ConjugateGradients { .. } => "CG with GAMG",
        }
    }
}

/// There is no method of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no method is called \"{name}\": there are \"direct\" (MUMPS) and \"cg\" (conjugate gradients with GAMG)"
)]
pub struct UnknownMethod {
    /// The name that was asked for.
    pub name: String,
}

/// Counts of a solver so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PetscReport {
    /// Rows of the matrix on all processes.
    pub rows: usize,
    /// Matrices whose positions were declared again.
    pub patterns: usize,
    /// Iterations of each solve; 0 for direct solutions.
    pub iterations: Vec<usize>,
    /// Largest relative residual of a solve.
    pub largest_residual: f64,
    /// Seconds in sending and adding up matrices.
    pub assembly_seconds: f64,
    /// Seconds in setting up and solving.
    pub solve_seconds: f64,
}

/// Solves by PETSc on all processes together. Its matrices are local contributions, whose sum over the processes is the matrix; right-hand
/// sides and solutions are whole, and the same on all.
#[derive(Debug)]
pub struct PetscSolver<'w> {
    world: &'w World,
    method: Method,
    nodes: NodeRows,
    b: DistributedVector<'w>,
    x: DistributedVector<'w>,
    residual: DistributedVector<'w>,
    system: Option<System<'w>>,
    report: PetscReport,
}

#[derive(Debug)]
struct System<'w> {
    matrix: DistributedMatrix<'w>,
    solver: Object,
    /// This process's part, and the whole matrix's diagonal: by them each equation is judged.
    local: CsrMatrix,
    diagonal: Vec<f64>,
}

impl<'w> System<'w> {
    fn new(
        matrix: DistributedMatrix<'w>,
        local: &CsrMatrix,
        world: &World,
        method: Method,
    ) -> Result<Self, PetscError> {
        let mut system = System { matrix, solver: null_mut(), local: local.clone(), diagonal: vec![] };
        let mut preconditioner = null_mut();
        // SAFETY: PETSc writes the handles; the solver is this system's own, the preconditioner the solver's. Names end
        // with zero.
        unsafe {
            call!(KSPCreate(world.communicator(), &mut system.solver))?;
            call!(KSPGetPC(system.solver, &mut preconditioner))?;
            match method {
                Method::Direct => {
                    call!(KSPSetType(system.solver, c"preonly".as_ptr()))?;
                    call!(PCSetType(preconditioner, c"lu".as_ptr()))?;
                    call!(PCFactorSetMatSolverType(preconditioner, c"mumps".as_ptr()))?;
                }
                Method::ConjugateGradients { .. } => {
                    call!(KSPSetType(system.solver, c"cg".as_ptr()))?;
                    call!(KSPSetNormType(system.solver, UNPRECONDITIONED))?;
                    call!(KSPSetResidualHistory(system.solver, null_mut(), Index::from(u16::MAX), TRUE))?;
                    call!(PCSetType(preconditioner, c"gamg".as_ptr()))?;
                }
            }
        }
        Ok(system)
    }
}

impl Drop for System<'_> {
    fn drop(&mut self) {
        // SAFETY: a handle that this owns, or null, which PETSc leaves alone.
        unsafe { petsc::KSPDestroy(&mut self.solver) };
    }
}

impl<'w> PetscSolver<'w> {
    /// A solver for systems on the space of these constraints, which must be those of every system.
    ///
    /// # Errors
    /// PETSc's error.
    pub fn new<const D: usize>(
        world: &'w World,
        constraints: &Constraints<D>,
        method: Method,
    ) -> Result<Self, PetscError> {
        let nodes = NodeRows::new(world, constraints)?;
        let vector = || DistributedVector::new(world, nodes.rows.clone());
        let (b, x, residual) = (vector()?, vector()?, vector()?);
        let report = PetscReport { rows: nodes.rows.count, ..PetscReport::default() };
        Ok(PetscSolver { world, method, b, x, residual, nodes, system: None, report })
    }

    /// Counts so far.
    pub fn report(&self) -> &PetscReport {
        &self.report
    }

    fn check_size(&self, what: &'static str, found: usize) -> Result<(), LinearAlgebraError> {
        let expected = self.nodes.places.len();
        if expected == found {
            return Ok(());
        }
        Err(LinearAlgebraError::SizeMismatch { what, expected, found })
    }

    /// The error with PETSc's reason and the residuals.
    fn not_converged(&self, solver: Object) -> Result<SolverError, PetscError> {
        let (mut text, mut values, mut count, mut iterations) = (null(), null(), 0, 0);
        let mut history = ResidualHistory::default();
        // SAFETY: PETSc writes a string of its own, and lends the list of residuals with its length.
        let reason = unsafe {
            call!(KSPGetConvergedReasonString(solver, &mut text))?;
            call!(KSPGetIterationNumber(solver, &mut iterations))?;
            if self.method != Method::Direct {
                call!(KSPGetResidualHistory(solver, &mut values, &mut count))?;
            }
            if !values.is_null() {
                history.0.extend_from_slice(std::slice::from_raw_parts(values, count.max(0) as usize));
            }
            if text.is_null() { "for no known reason".into() } else { CStr::from_ptr(text).to_string_lossy() }
        };
        let why = format!("stopped after {iterations} iterations: {reason}");
        Ok(SolverError::Other { solver: self.method.name(), why, history })
    }
}

impl LinearSolver for PetscSolver<'_> {
    fn set_matrix(&mut self, local: CsrMatrix) -> Result<(), SolverError> {
        let start = Instant::now();
        let fit = self.check_size("the set of rows", local.rows());
        self.world.agree(fit.and_then(|()| local.check_finite()))?;
        // All processes tell their positions again if one has to.
        let is_new = !self.system.as_ref().is_some_and(|system| system.matrix.fits(&local));
        let mut system = match self.system.take() {
            Some(system) if self.world.sum(&[f64::from(u8::from(is_new))])?[0] == 0.0 => system,
            Some(_) => self.new_system(&local)?,
            None => self.new_system(&local)?,
        };
        system.matrix.assemble(&local)?;
        let matrix = system.matrix.handle();
        // SAFETY: handles of the system, which keeps both.
        unsafe { call!(KSPSetOperators(system.solver, matrix, matrix))? };
        system.diagonal = self.world.sum(&local.diagonal())?;
        system.local = local;
        self.system = Some(system);
        self.report.assembly_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Each equation of a solution that is handed out holds relative to the sizes of its own terms, whatever the norm says.
    fn judges_equations(&self) -> bool {
        true
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        absolute: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let right_hand_side = b;
        self.check_size("the right-hand side", b.len())?;
        let start = Instant::now();
        self.b.set(&self.nodes.spread(b))?;
        let system = self.system.as_ref().ok_or(SolverError::NoMatrix)?;
        let (solver, matrix) = (system.solver, system.matrix.handle());
        let (b, x, rest) = (self.b.handle(), self.x.handle(), self.residual.handle());
        let (mut reason, mut iterations) = (0, 0);
        let (mut size, mut norm) = (0.0, 0.0);
        // SAFETY: handles that this owns, of one size; PETSc writes the numbers.
        unsafe {
            if let Method::ConjugateGradients { tolerance, max_iterations } = self.method {
                let (absolute, most) = (absolute.max(f64::MIN_POSITIVE), Index::from(max_iterations));
                call!(KSPSetTolerances(solver, tolerance, absolute, DEFAULT, most))?;
            }
            if transpose == Transpose::Yes && self.method == Method::Direct {
                call!(KSPSolveTranspose(solver, b, x))?;
            } else {
                // Conjugate gradients take the matrix for its transpose.
                call!(KSPSolve(solver, b, x))?;
            }
            call!(KSPGetConvergedReason(solver, &mut reason))?;
            if reason < 0 {
                return Err(self.not_converged(solver)?);
            }
            call!(KSPGetIterationNumber(solver, &mut iterations))?;
            if transpose == Transpose::Yes {
                call!(MatMultTranspose(matrix, x, rest))?;
            } else {
                call!(MatMult(matrix, x, rest))?;
            }
            call!(VecAYPX(rest, -1.0, b))?;
            call!(VecNorm(b, EUCLIDEAN, &mut size))?;
            call!(VecNorm(rest, EUCLIDEAN, &mut norm))?;
        }
        let relative_residual = if size == 0.0 { 0.0 } else { norm / size };
        let iterations = if self.method == Method::Direct { 0 } else { iterations as usize };
        let solution = self.nodes.gather(&self.x.whole()?);
        if norm > absolute {
            let rest = self.nodes.gather(&self.residual.whole()?);
            let sizes =
                |y: &[f64]| Ok::<_, SolverError>(self.world.sum(&term_sizes(&system.local, y, transpose))?);
            check_residual(&rest, (&solution, right_hand_side), &system.diagonal, sizes, HOLDS)?;
        }
        self.report.iterations.push(iterations);
        self.report.largest_residual = self.report.largest_residual.max(relative_residual);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(LinearSolution { solution, relative_residual, iterations })
    }
}

impl<'w> PetscSolver<'w> {
    fn new_system(&mut self, local: &CsrMatrix) -> Result<System<'w>, PetscError> {
        self.report.patterns += 1;
        System::new(DistributedMatrix::new(self.world, &self.nodes, local)?, local, self.world, self.method)
    }
}

/// Σ_j |a_ij x_j| of each row of a matrix or its transposed.
fn term_sizes(matrix: &CsrMatrix, x: &[f64], transpose: Transpose) -> Vec<f64> {
    let mut sizes = vec![0.0; x.len()];
    for row in 0..matrix.rows() {
        let (columns, values) = matrix.row(row);
        for (column, value) in columns.iter().zip(values) {
            let (target, source) = match transpose {
                Transpose::No => (row, *column as usize),
                Transpose::Yes => (*column as usize, row),
            };
            sizes[target] += (value * x[source]).abs();
        }
    }
    sizes
}
