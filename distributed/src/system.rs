//! A system of equations in PETSc: a matrix with the solver for it, and with the one for its transposed where that is another one.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString};
use std::ptr::null_mut;

use forms_fem::solve::Transpose;

use crate::error::PetscError;
use crate::local_matrix::LocalMatrix;
use crate::matrix::{DistributedMatrix, Motions};
use crate::method::Method;
use crate::node_rows::{FieldRows, NodeRows};
use crate::object::Owned;
use crate::petsc::{self, DEFAULT, Index, Object, TRUE, UNPRECONDITIONED, call};
use crate::world::World;

/// A matrix and its solver.
#[derive(Debug)]
pub(crate) struct System<'w> {
    world: &'w World,
    method: Method,
    prefix: CString,
    matrix: DistributedMatrix<'w>,
    solver: Owned<'w>,
    /// The transposed matrix and its solver, once they were asked for.
    transposed: Option<[Owned<'w>; 2]>,
    /// Whether the last solution was one of the transposed matrix's own solver.
    was_transposed: bool,
}

impl<'w> System<'w> {
    pub fn new(
        world: &'w World,
        (nodes, motions): (&NodeRows, &Motions<'w>),
        local: &LocalMatrix<'_>,
        method: Method,
        prefix: &CStr,
    ) -> Result<Self, PetscError> {
        Ok(System {
            world,
            method,
            prefix: prefix.to_owned(),
            matrix: DistributedMatrix::new(world, nodes, motions, local)?,
            solver: krylov(world, (nodes, motions), method, prefix)?,
            transposed: None,
            was_transposed: false,
        })
    }

    pub fn fits(&self, local: &LocalMatrix<'_>) -> bool {
        self.matrix.fits(local)
    }

    pub fn matrix(&self) -> &DistributedMatrix<'w> {
        &self.matrix
    }

    /// Sets the matrix to the sum of the processes' parts.
    pub fn assemble(&mut self, nodes: &NodeRows, local: &LocalMatrix<'_>) -> Result<(), PetscError> {
        self.transposed = None;
        self.matrix.assemble(nodes, local)?;
        operators(&self.solver, self.matrix.handle())
    }

    /// The number of negative pivots of the factor of a symmetric matrix.
    pub fn negative_pivots(&self) -> Result<usize, PetscError> {
        let solver = self.solver.handle();
        let (mut preconditioner, mut factor, mut negative) = (null_mut(), null_mut(), 0);
        // SAFETY: the solver lives, and has the preconditioner with the factor. PETSc tells the numbers that are asked for.
        unsafe {
            call!(KSPSetUp(solver))?;
            call!(KSPGetPC(solver, &mut preconditioner))?;
            call!(PCFactorGetMatrix(preconditioner, &mut factor))?;
            call!(MatGetInertia(factor, &mut negative, null_mut(), null_mut()))?;
        }
        Ok(negative.max(0) as usize)
    }

    /// The solver of the last solution.
    pub fn last_solver(&self) -> Object {
        match &self.transposed {
            Some([_, solver]) if self.was_transposed => solver.handle(),
            _ => self.solver.handle(),
        }
    }

    /// The solver of equations with the matrix or its transposed. A factor serves both, and so does a symmetric matrix.
    pub fn solver_for(
        &mut self,
        (nodes, motions): (&NodeRows, &Motions<'w>),
        transpose: Transpose,
    ) -> Result<Object, PetscError> {
        self.was_transposed = transpose == Transpose::Yes && matches!(self.method, Method::Gmres { .. });
        if self.was_transposed && self.transposed.is_none() {
            // Not all preconditioners can be applied transposed.
            let matrix = self.matrix.transposed(motions)?;
            let solver = krylov(self.world, (nodes, motions), self.method, &self.prefix)?;
            operators(&solver, matrix.handle())?;
            self.transposed = Some([matrix, solver]);
        }
        Ok(self.last_solver())
    }
}

fn operators(solver: &Owned<'_>, matrix: Object) -> Result<(), PetscError> {
    // SAFETY: both objects live, and PETSc counts its own reference to the matrix.
    unsafe { call!(KSPSetOperators(solver.handle(), matrix, matrix)) }
}

/// Percent of memory that MUMPS takes beyond its estimate, in place of 20. With rows of contact surfaces its estimate was too low by more.
const MORE_MEMORY: &CStr = c"80";

/// The solver of a method, as the options change it.
fn krylov<'w>(
    world: &'w World,
    (nodes, motions): (&NodeRows, &Motions<'w>),
    method: Method,
    prefix: &CStr,
) -> Result<Owned<'w>, PetscError> {
    // SAFETY: PETSc writes the handle.
    let made = Owned::made(world, petsc::KSPDestroy, |solver| unsafe {
        call!(KSPCreate(world.communicator(), solver))
    })?;
    let (solver, several) = (made.handle(), nodes.fields.len() > 1);
    let mut preconditioner = null_mut();
    // SAFETY: PETSc writes the handle of the preconditioner, which is the solver's. Names end with zero, and are copied.
    unsafe {
        call!(KSPSetOptionsPrefix(solver, prefix.as_ptr()))?;
        call!(KSPGetPC(solver, &mut preconditioner))?;
        match method {
            Method::Direct | Method::Symmetric => {
                let is_symmetric = method == Method::Symmetric;
                let kind = if is_symmetric { c"cholesky" } else { c"lu" };
                call!(KSPSetType(solver, c"preonly".as_ptr()))?;
                call!(PCSetType(preconditioner, kind.as_ptr()))?;
                if is_symmetric {
                    // The last front on one process too: its pivots are counted only then.
                    default_option(prefix, "mat_mumps_icntl_13", c"1")?;
                }
                call!(PCFactorSetMatSolverType(preconditioner, c"mumps".as_ptr()))?;
                if nodes.divided.is_some() {
                    default_option(prefix, "mat_mumps_icntl_14", MORE_MEMORY)?;
                }
            }
            Method::ConjugateGradients { tolerance, max_iterations } => {
                iterations(solver, c"cg", tolerance, max_iterations)?;
                call!(PCSetType(preconditioner, c"gamg".as_ptr()))?;
            }
            Method::Gmres { tolerance, max_iterations } => {
                // Blocks may be solved by iterations of their own.
                iterations(solver, c"fgmres", tolerance, max_iterations)?;
                if several {
                    by_blocks(preconditioner, nodes, prefix)?;
                } else {
                    call!(PCSetType(preconditioner, c"gamg".as_ptr()))?;
                }
            }
        }
        call!(KSPSetFromOptions(solver))?;
    }
    if several {
        set_blocks(world, preconditioner, nodes, motions)?;
    }
    Ok(made)
}

/// Iterations to a relative residual, whose norms are kept.
fn iterations(solver: Object, name: &CStr, tolerance: f64, most: u16) -> Result<(), PetscError> {
    // SAFETY: the solver lives; the name ends with zero, and is copied; PETSc keeps the list of norms itself.
    unsafe {
        call!(KSPSetType(solver, name.as_ptr()))?;
        call!(KSPSetNormType(solver, UNPRECONDITIONED))?;
        call!(KSPSetTolerances(solver, tolerance, f64::MIN_POSITIVE, DEFAULT, Index::from(most)))?;
        call!(KSPSetResidualHistory(solver, null_mut(), Index::from(u16::MAX), TRUE))
    }
}

/// The unknowns of each block: one each, but those on facets together, whose equations couple them, as those of a pressure and of a mean gap.
fn blocks(nodes: &NodeRows) -> Vec<&[FieldRows]> {
    nodes.fields.chunk_by(|one, next| one.is_on_facets && next.is_on_facets).collect()
}

/// The preconditioner of several unknowns: by the Schur complement of two blocks, else one block after the other.
fn by_blocks(preconditioner: Object, nodes: &NodeRows, prefix: &CStr) -> Result<(), PetscError> {
    // SAFETY: the preconditioner lives; the name ends with zero, and is copied.
    unsafe { call!(PCSetType(preconditioner, c"fieldsplit".as_ptr()))? };
    if let [_, second] = blocks(nodes)[..] {
        // SAFETY: as above; no matrix of the caller's is named.
        unsafe {
            call!(PCFieldSplitSetType(preconditioner, petsc::SCHUR))?;
            call!(PCFieldSplitSetSchurFactType(preconditioner, petsc::FULL))?;
            call!(PCFieldSplitSetSchurPre(preconditioner, petsc::BY_DIAGONAL, null_mut()))?;
        }
        default_option(prefix, "fieldsplit_1_ksp_type", c"preonly")?;
        if second[0].is_on_facets {
            // Few unknowns, whose conditions are not symmetric.
            default_option(prefix, "fieldsplit_1_pc_type", c"lu")?;
            default_option(prefix, "fieldsplit_1_pc_factor_mat_solver_type", c"mumps")?;
        } else {
            default_option(prefix, "fieldsplit_1_pc_type", c"jacobi")?;
        }
    }
    default_option(prefix, "fieldsplit_0_ksp_type", c"preonly")?;
    default_option(prefix, "fieldsplit_0_pc_type", c"gamg")
}

/// An option that holds unless the environment has it.
fn default_option(prefix: &CStr, name: &str, value: &CStr) -> Result<(), PetscError> {
    let whole = format!("-{}{name}", prefix.to_string_lossy());
    let whole = CString::new(whole).map_err(|_| PetscError::OptionsPrefix { prefix: name.to_owned() })?;
    let mut is_set = 0;
    // SAFETY: texts that end with zero, and are copied; no prefix, and the options of the environment.
    unsafe {
        call!(PetscOptionsHasName(null_mut(), std::ptr::null(), whole.as_ptr(), &mut is_set))?;
        match is_set {
            0 => call!(PetscOptionsSetValue(null_mut(), whole.as_ptr(), value.as_ptr())),
            _ => Ok(()),
        }
    }
}

/// Tells a preconditioner by blocks which rows each unknown has. Other preconditioners take no notice.
fn set_blocks<'w>(
    world: &'w World,
    preconditioner: Object,
    nodes: &NodeRows,
    motions: &Motions<'w>,
) -> Result<(), PetscError> {
    let mut first_of_block = 0;
    for (number, fields) in blocks(nodes).into_iter().enumerate() {
        // A process has the rows of all unknowns one after the other.
        let field = &fields[0];
        let count = fields.iter().map(|field| field.rows.own.len()).sum::<usize>() as Index;
        let (first, size) = (field.start as Index, if fields.len() == 1 { field.rows.block } else { 1 });
        let motions = motions[first_of_block].as_ref().filter(|_| fields.len() == 1);
        first_of_block += fields.len();
        // SAFETY: PETSc writes the handle.
        let rows = Owned::made(world, petsc::ISDestroy, |rows| unsafe {
            call!(ISCreateStride(world.communicator(), count, first, 1, rows))
        })?;
        let name = CString::new(number.to_string()).unwrap_or_default();
        // SAFETY: all objects live, and PETSc counts its own references; the names end with zero, and are copied.
        unsafe {
            call!(ISSetBlockSize(rows.handle(), size as Index))?;
            if let Some(motions) = motions {
                call!(PetscObjectCompose(rows.handle(), c"nearnullspace".as_ptr(), motions.handle()))?;
            }
            call!(PCFieldSplitSetIS(preconditioner, name.as_ptr(), rows.handle()))?;
        }
    }
    Ok(())
}
