//! PETSc's solvers behind the trait that Newton's method asks of a linear solver.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_int};
use std::ptr::null;
use std::time::Instant;

use forms_fem::linear_algebra::backward_error::check_rows;
use forms_fem::linear_algebra::{BlockMatrix, CsrMatrix, LinearAlgebraError, ResidualHistory};
use forms_fem::prelude::*;
use forms_fem::solve::communicator::Fingerprint;
use forms_fem::solve::linear_system::HOLDS;
use forms_fem::solve::{Elimination, LinearSolution, SolverError, Transpose};

use crate::error::{DistributedError, PetscError};
use crate::local_matrix::LocalMatrix;
use crate::matrix::take_motions;
use crate::method::Method;
use crate::node_rows::NodeRows;
use crate::object::Owned;
use crate::part::MeshPart;
use crate::petsc::{EUCLIDEAN, Index, call};
use crate::system::System;
use crate::vector::DistributedVector;
use crate::world::World;

/// Statement of a process whose matrix is unfit.
const UNFIT: u64 = 2;

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
    /// Of each unknown.
    motions: Vec<Option<Owned<'w>>>,
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

    fn on_rows(world: &'w World, mut nodes: NodeRows, method: Method) -> Result<Self, PetscError> {
        world.destroy_dropped()?;
        let motions = nodes.fields.iter_mut().map(|field| take_motions(world, field)).collect();
        let motions: Vec<_> = world.agree_on_calls(motions)?;
        let vector = || DistributedVector::new(world, nodes.rows.clone());
        let copied = || if nodes.divided.is_some() { vector() } else { vector()?.with_copy(world) };
        let vectors = || Ok((vector()?, copied()?, copied()?));
        let (b, x, residual) = world.agree_on_calls(vectors())?;
        let report = PetscReport { rows: nodes.rows.count, ..PetscReport::default() };
        let prefix = CString::default();
        let (processes, system) = (1, None);
        Ok(PetscSolver { world, method, prefix, processes, nodes, motions, b, x, residual, system, report })
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

    fn check_matrix(&self, local: &LocalMatrix<'_>) -> Result<(), SolverError> {
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
            if !self.method.is_direct() {
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
        self.set_local(&LocalMatrix::Free(&local))
    }

    /// Without a copy of the process's part, where no unknown is given by others.
    fn set_reduced(
        &mut self,
        matrix: &BlockMatrix,
        elimination: &mut Elimination,
    ) -> Result<(), SolverError> {
        if elimination.only_prescribes() {
            return self.set_local(&LocalMatrix::of_all(matrix, elimination));
        }
        self.set_matrix(elimination.reduce_matrix(matrix)?)
    }

    /// By the signs of MUMPS's pivots.
    fn negative_eigenvalues(&mut self) -> Result<Option<usize>, SolverError> {
        if self.method != Method::Symmetric {
            return Ok(None);
        }
        let counted = self.system.as_ref().map(System::negative_pivots).transpose();
        Ok(Some(self.world.agree_on_calls(counted)?.ok_or(SolverError::NoMatrix)?))
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
        let iterations = if self.method.is_direct() { 0 } else { solved.iterations as usize };
        let solution = self.nodes.unknowns_of(&solved.solution)?;
        if let Some(rest) = &solved.rest {
            self.judge_rows(rest, (&solution, b), transpose)?;
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
    /// Takes the matrix to which this process contributes a part.
    fn set_local(&mut self, local: &LocalMatrix<'_>) -> Result<(), SolverError> {
        let (start, fit) = (Instant::now(), self.check_matrix(local));
        let is_new = !self.system.as_ref().is_some_and(|system| system.fits(local));
        let all = self.world.gather(if fit.is_err() { UNFIT } else { u64::from(is_new) })?;
        fit?;
        match all.iter().filter(|one| **one == UNFIT).count() {
            0 => {}
            count => return Err(DistributedError::<SolverError>::Elsewhere { count }.into()),
        }
        // All processes tell their positions anew if one has to.
        if all.contains(&1) {
            self.system = None;
            self.world.destroy_dropped()?;
        }
        let assembled = self.assembled(local);
        self.system = Some(self.world.agree_on_calls(assembled)?);
        self.report.assembly_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Whether each equation holds. Where processes have parts of vectors, each judges the rows that it keeps.
    fn judge_rows(
        &mut self,
        rest: &[f64],
        (solution, b): (&[f64], &[f64]),
        transpose: Transpose,
    ) -> Result<(), SolverError> {
        let PetscSolver { world, nodes, system, b: amounts, residual: product, .. } = self;
        let (system, product) = (system.as_ref().ok_or(SolverError::NoMatrix)?, &*product);
        let judged = nodes.judged();
        let known = |rows: &[f64]| judged.iter().map(|(_, row)| rows[*row]).collect::<Vec<_>>();
        let of = |reduced: &[f64]| judged.iter().map(|(free, _)| reduced[*free]).collect::<Vec<_>>();
        let sizes = |y: &[f64]| -> Result<Vec<f64>, SolverError> {
            let mut reduced = vec![0.0; nodes.places.len()];
            judged.iter().zip(y).for_each(|((free, _), value)| reduced[*free] = value.abs());
            let multiplied = amounts
                .set(&nodes.own_of(&reduced))
                .and_then(|()| {
                    system.matrix().multiply_amounts(amounts, product, transpose == Transpose::Yes)
                })
                .and_then(|()| product.values());
            Ok(known(&world.agree_on_calls(multiplied)?))
        };
        let diagonal = || -> Result<Vec<f64>, SolverError> {
            let written = system.matrix().write_diagonal(product).and_then(|()| product.values());
            Ok(known(&world.agree_on_calls(written)?))
        };
        let mut all_hold = false;
        let of_all = |own: bool| -> Result<bool, SolverError> {
            all_hold = !world.gather(u64::from(own))?.contains(&0);
            Ok(all_hold)
        };
        let mut checked = check_rows(&known(rest), (&of(solution), &of(b)), diagonal, sizes, of_all, HOLDS);
        if all_hold {
            return checked;
        }
        if let Err(SolverError::LinearAlgebra(LinearAlgebraError::Inaccurate { row, .. })) = &mut checked {
            *row = judged[*row].0;
        }
        Ok(world.agree(checked)?)
    }

    /// The system with this matrix: the known one where there is one, else a new one.
    fn assembled(&mut self, local: &LocalMatrix<'_>) -> Result<System<'w>, PetscError> {
        let mut system = match self.system.take() {
            Some(system) => system,
            None => {
                self.report.patterns += 1;
                System::new(self.world, (&self.nodes, &self.motions[..]), local, self.method, &self.prefix)?
            }
        };
        system.assemble(&self.nodes, local)?;
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
        let solver = system.solver_for((&self.nodes, &self.motions[..]), transpose)?;
        let matrix = system.matrix().handle();
        let (b, x, rest) = (self.b.handle(), self.x.handle(), self.residual.handle());
        // SAFETY: handles that this owns, of one size; PETSc writes the numbers.
        unsafe {
            if !self.method.is_direct() {
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
