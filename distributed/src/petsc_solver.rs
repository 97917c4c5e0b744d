//! PETSc's solvers behind the trait that Newton's method asks of a linear solver.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_int};
use std::ptr::null;
use std::time::Instant;

use forms_fem::linear_algebra::backward_error::check_rows;
use forms_fem::linear_algebra::{CsrMatrix, LinearAlgebraError, ResidualHistory};
use forms_fem::prelude::*;
use forms_fem::solve::communicator::Fingerprint;
use forms_fem::solve::linear_system::HOLDS;
use forms_fem::solve::{LinearSolution, SolverError, Transpose};

use crate::error::PetscError;
use crate::method::Method;
use crate::node_rows::NodeRows;
use crate::part::MeshPart;
use crate::petsc::{EUCLIDEAN, Index, call};
use crate::system::System;
use crate::vector::DistributedVector;
use crate::world::World;

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
///
/// A problem gives it such matrices after [`Problem::on`] the world, and whole ones without it, which are refused where there are several
/// processes. Those who set matrices themselves say first that they are parts, by [`LinearSolver::set_processes`].
#[derive(Debug)]
pub struct PetscSolver<'w> {
    world: &'w World,
    method: Method,
    /// Of the names of its options.
    prefix: CString,
    /// Number of processes whose matrices add up to the one that is meant; 1 for whole matrices.
    processes: usize,
    nodes: NodeRows,
    b: DistributedVector<'w>,
    x: DistributedVector<'w>,
    residual: DistributedVector<'w>,
    system: Option<System<'w>>,
    report: PetscReport,
}

impl<'w> PetscSolver<'w> {
    /// A solver for systems on the space of these constraints, which must be those of every system.
    ///
    /// # Errors
    /// [`PetscError::Different`] where the processes have different constraints or spaces; PETSc's error.
    pub fn new<const D: usize>(
        world: &'w World,
        constraints: &Constraints<D>,
        method: Method,
    ) -> Result<Self, PetscError> {
        Self::coupled(world, &[constraints], method)
    }

    /// A solver for systems of several unknowns, each with its constraints, in the order in which a problem has them. Conjugate gradients
    /// take the matrix of all of them for one of one unknown.
    ///
    /// # Errors
    /// As [`PetscSolver::new`].
    pub fn coupled<const D: usize>(
        world: &'w World,
        constraints: &[&Constraints<D>],
        method: Method,
    ) -> Result<Self, PetscError> {
        let nodes = world.agree(NodeRows::new(world, constraints))?;
        let fingerprint = nodes.fingerprint(constraints);
        world.check_same("unknowns for `PetscSolver`: other meshes, spaces or constraints", fingerprint)?;
        Self::on_rows(world, nodes, method)
    }

    /// A solver for systems on a part of a mesh, with the constraints of each unknown there. Nothing in it has the size of the whole problem:
    /// right-hand sides and solutions have the unknowns of this process's part.
    ///
    /// # Errors
    /// As [`PetscSolver::new`]; [`PetscError::Divided`].
    pub fn for_part<const D: usize>(
        part: &MeshPart<'w, D>,
        constraints: &[&Constraints<D>],
        method: Method,
    ) -> Result<Self, PetscError> {
        let nodes = part.node_rows(constraints)?;
        Self::on_rows(part.world(), nodes, method)
    }

    fn on_rows(world: &'w World, nodes: NodeRows, method: Method) -> Result<Self, PetscError> {
        world.destroy_dropped()?;
        let vector = || DistributedVector::new(world, nodes.rows.clone());
        let copied = || if nodes.divided.is_some() { vector() } else { vector()?.with_copy(world) };
        let vectors = || Ok((vector()?, copied()?, copied()?));
        let (b, x, residual) = world.agree_on_calls(vectors())?;
        let report = PetscReport { rows: nodes.rows.count, ..PetscReport::default() };
        let prefix = CString::default();
        Ok(PetscSolver { world, method, prefix, processes: 1, b, x, residual, nodes, system: None, report })
    }

    /// A prefix of the names of its options, to tell the solvers of a program apart: with `contact_`, `PETSC_OPTIONS` has
    /// `-contact_ksp_monitor` or `-contact_pc_type hypre`. Options come before the method; blocks of several unknowns are `fieldsplit_0_`
    /// and so on.
    ///
    /// # Errors
    /// [`PetscError::OptionsPrefix`] for a text that no option begins with.
    pub fn with_options_prefix(mut self, prefix: &str) -> Result<Self, PetscError> {
        let is_fit = prefix.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        let unfit = || PetscError::OptionsPrefix { prefix: prefix.to_owned() };
        self.prefix = if is_fit { CString::new(prefix).map_err(|_| unfit())? } else { return Err(unfit()) };
        Ok(self)
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

    fn check_matrix(&self, local: &CsrMatrix) -> Result<(), SolverError> {
        self.check_processes()?;
        self.check_size("the set of rows", local.rows())?;
        Ok(local.check_finite()?)
    }

    /// Whole matrices on each of several processes would add up to a multiple of the one that is meant.
    fn check_processes(&self) -> Result<(), SolverError> {
        match (self.processes, self.world.size()) {
            (problem, solver) if problem == solver => Ok(()),
            (problem, solver) => Err(SolverError::Processes { problem, solver }),
        }
    }

    /// The error with PETSc's reason and the residuals.
    fn not_converged(&self, found: &Found) -> Result<SolverError, SolverError> {
        let solver = self.system.as_ref().ok_or(SolverError::NoMatrix)?.last_solver();
        let (mut text, mut values, mut count) = (null(), null(), 0);
        let mut history = ResidualHistory::default();
        // SAFETY: PETSc writes a string of its own, and lends the list of residuals with its length.
        let reason = unsafe {
            call!(KSPGetConvergedReasonString(solver, &mut text))?;
            if self.method != Method::Direct {
                call!(KSPGetResidualHistory(solver, &mut values, &mut count))?;
            }
            if !values.is_null() {
                history.0.extend_from_slice(std::slice::from_raw_parts(values, count.max(0) as usize));
            }
            if text.is_null() { "for no known reason".into() } else { CStr::from_ptr(text).to_string_lossy() }
        };
        let why = format!("stopped after {} iterations: {reason}", found.iterations);
        Ok(SolverError::Other { solver: self.method.name(), why, history })
    }
}

impl LinearSolver for PetscSolver<'_> {
    fn set_processes(&mut self, count: usize) -> Result<(), SolverError> {
        self.processes = count;
        self.check_processes()
    }

    fn set_matrix(&mut self, local: CsrMatrix) -> Result<(), SolverError> {
        let start = Instant::now();
        self.world.agree(self.check_matrix(&local))?;
        // All processes tell their positions anew if one has to.
        let is_new = !self.system.as_ref().is_some_and(|system| system.fits(&local));
        if self.world.gather(u64::from(is_new))?.contains(&1) {
            self.system = None;
            self.world.destroy_dropped()?;
        }
        let assembled = self.assembled(&local);
        let mut system = self.world.agree_on_calls(assembled)?;
        system.diagonal = self.nodes.add_up(self.world, &local.diagonal())?;
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
        let fit = self.check_size("the right-hand side", b.len()).map_err(SolverError::from);
        let ready = if self.system.is_some() { Ok(()) } else { Err(SolverError::NoMatrix) };
        self.world.agree(fit.and(ready))?;
        if self.nodes.divided.is_none() {
            self.world.check_same("right-hand sides", Fingerprint::default().reals(b).finish())?;
        }
        let start = Instant::now();
        let solved = self.solve_by_calls(b, absolute, transpose);
        let solved = self.world.agree_on_calls(solved)?;
        if solved.reason < 0 {
            return Err(self.not_converged(&solved)?);
        }
        let relative_residual = if solved.size == 0.0 { 0.0 } else { solved.norm / solved.size };
        let iterations = if self.method == Method::Direct { 0 } else { solved.iterations as usize };
        let solution = self.nodes.unknowns_of(&solved.solution)?;
        if let Some(rest) = &solved.rest {
            let rest = self.nodes.unknowns_of(rest)?;
            let system = self.system.as_ref().ok_or(SolverError::NoMatrix)?;
            let sizes = |y: &[f64]| {
                let own = term_sizes(&system.local, y, transpose);
                Ok::<_, SolverError>(self.nodes.add_up(self.world, &own)?)
            };
            let of_all = |own: bool| Ok(!self.world.gather(u64::from(own))?.contains(&0));
            let checked = check_rows(&rest, (&solution, b), &system.diagonal, sizes, of_all, HOLDS);
            self.world.agree(checked)?;
        }
        self.report.iterations.push(iterations);
        self.report.largest_residual = self.report.largest_residual.max(relative_residual);
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(LinearSolution { solution, relative_residual, iterations })
    }
}

/// Report of PETSc's solver on a solution.
#[derive(Debug, Default)]
struct Found {
    /// Reason why it stopped: negative where it did not converge.
    reason: c_int,
    iterations: Index,
    /// Norms of the right-hand side and of the residual.
    size: f64,
    norm: f64,
    /// Its rows as far as they are known here.
    solution: Vec<f64>,
    /// Those of the residual, where it is above the tolerance that was asked for.
    rest: Option<Vec<f64>>,
}

impl<'w> PetscSolver<'w> {
    /// The system with this matrix: the known one where there is one, else a new one.
    fn assembled(&mut self, local: &CsrMatrix) -> Result<System<'w>, PetscError> {
        let mut system = match self.system.take() {
            Some(system) => system,
            None => {
                self.report.patterns += 1;
                System::new(self.world, &self.nodes, local, self.method, &self.prefix)?
            }
        };
        system.assemble(local)?;
        Ok(system)
    }

    fn solve_by_calls(
        &mut self,
        b: &[f64],
        absolute: f64,
        transpose: Transpose,
    ) -> Result<Found, PetscError> {
        let mut found = Found::default();
        let Some(system) = &mut self.system else { return Ok(found) };
        self.b.set(&self.nodes.own_of(b))?;
        let solver = system.solver_for(&self.nodes, transpose)?;
        let matrix = system.matrix();
        let (b, x, rest) = (self.b.handle(), self.x.handle(), self.residual.handle());
        // SAFETY: handles that this owns, of one size; PETSc writes the numbers.
        unsafe {
            if self.method != Method::Direct {
                let (mut relative, mut before, mut divergence, mut most) = (0.0, 0.0, 0.0, 0);
                call!(KSPGetTolerances(solver, &mut relative, &mut before, &mut divergence, &mut most))?;
                let absolute = absolute.max(f64::MIN_POSITIVE);
                call!(KSPSetTolerances(solver, relative, absolute, divergence, most))?;
            }
            if transpose == Transpose::Yes && self.method == Method::Direct {
                call!(KSPSolveTranspose(solver, b, x))?;
            } else {
                call!(KSPSolve(solver, b, x))?;
            }
            call!(KSPGetConvergedReason(solver, &mut found.reason))?;
            call!(KSPGetIterationNumber(solver, &mut found.iterations))?;
            if found.reason < 0 {
                return Ok(found);
            }
            if transpose == Transpose::Yes {
                call!(MatMultTranspose(matrix, x, rest))?;
            } else {
                call!(MatMult(matrix, x, rest))?;
            }
            call!(VecAYPX(rest, -1.0, b))?;
            call!(VecNorm(b, EUCLIDEAN, &mut found.size))?;
            call!(VecNorm(rest, EUCLIDEAN, &mut found.norm))?;
        }
        found.solution = self.x.values()?;
        if found.norm > absolute {
            found.rest = Some(self.residual.values()?);
        }
        Ok(found)
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
