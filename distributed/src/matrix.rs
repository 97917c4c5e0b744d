//! Matrices whose rows are spread over the processes, as sums of what each of them assembled.

#![allow(unsafe_code)]

use std::sync::Arc;

use forms_fem::linear_algebra::{CsrMatrix, SparsityPattern};

use crate::error::PetscError;
use crate::node_rows::{FieldRows, NodeRows};
use crate::object::Owned;
use crate::petsc::{self, FALSE, Index, Object, call};
use crate::vector::DistributedVector;
use crate::world::World;

/// A `MATMPIAIJ`: PETSc sends each entry of a local matrix to the process that keeps its row, and adds up.
#[derive(Debug)]
pub(crate) struct DistributedMatrix<'w> {
    world: &'w World,
    matrix: Owned<'w>,
    pattern: Arc<SparsityPattern>,
    /// Number of this process's held rows: their ones come after the local matrix's values.
    held: usize,
    values: Vec<f64>,
}

impl<'w> DistributedMatrix<'w> {
    /// Tells PETSc the positions of a local matrix; values come with [`DistributedMatrix::assemble`].
    pub fn new(world: &'w World, nodes: &NodeRows, local: &CsrMatrix) -> Result<Self, PetscError> {
        let own = &nodes.rows.own;
        let count = local.values().len() + nodes.held.len();
        if Index::try_from(count).is_err() {
            return Err(PetscError::TooMany { what: "entries", count });
        }
        let (mut rows, mut columns) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (row, place) in nodes.places.iter().enumerate() {
            let found = local.row(row).0;
            rows.resize(rows.len() + found.len(), *place);
            columns.extend(found.iter().map(|column| nodes.places[*column as usize]));
        }
        let held: Vec<Index> =
            nodes.held.iter().copied().filter(|row| own.contains(&(*row as usize))).collect();
        rows.extend_from_slice(&held);
        columns.extend_from_slice(&held);
        let (pattern, held) = (local.pattern().clone(), held.len());
        let (size, all) = (own.len() as Index, nodes.rows.count as Index);
        // SAFETY: PETSc writes the handle.
        let matrix = Owned::made(world, petsc::MatDestroy, |matrix| unsafe {
            call!(MatCreate(world.communicator(), matrix))
        })?;
        let at = matrix.handle();
        // SAFETY: the matrix was just made; names end with zero; PETSc may change the two lists of positions, which are of one length,
        // and copies what it keeps of them.
        unsafe {
            call!(MatSetSizes(at, size, size, all, all))?;
            call!(MatSetBlockSize(at, nodes.rows.block as Index))?;
            call!(MatSetType(at, c"mpiaij".as_ptr()))?;
            let (rows_at, columns_at) = (rows.as_mut_ptr(), columns.as_mut_ptr());
            call!(MatSetPreallocationCOO(at, rows.len() as isize, rows_at, columns_at))?;
        }
        let made = DistributedMatrix { world, matrix, pattern, held, values: vec![] };
        set_motions(world, made.handle(), nodes)?;
        Ok(made)
    }

    /// Whether a local matrix has the positions of the one before.
    pub fn fits(&self, local: &CsrMatrix) -> bool {
        Arc::ptr_eq(&self.pattern, local.pattern()) || *self.pattern == **local.pattern()
    }

    pub fn handle(&self) -> Object {
        self.matrix.handle()
    }

    /// Sets the matrix to the sum of the processes' parts.
    pub fn assemble(&mut self, local: &CsrMatrix) -> Result<(), PetscError> {
        self.values.clear();
        self.values.extend_from_slice(local.values());
        self.values.resize(local.values().len() + self.held, 1.0);
        // SAFETY: as many values as positions were declared: the local matrix fits.
        unsafe { call!(MatSetValuesCOO(self.handle(), self.values.as_ptr(), petsc::INSERT)) }
    }

    /// Its transposed, as a matrix of its own.
    pub fn transposed(&self, nodes: &NodeRows) -> Result<Owned<'w>, PetscError> {
        // SAFETY: PETSc makes a matrix and writes its handle.
        let matrix = Owned::made(self.world, petsc::MatDestroy, |made| unsafe {
            call!(MatTranspose(self.handle(), petsc::INITIAL, made))
        })?;
        set_motions(self.world, matrix.handle(), nodes)?;
        Ok(matrix)
    }
}

/// Tells GAMG the rigid motions of a matrix of one unknown.
fn set_motions(world: &World, matrix: Object, nodes: &NodeRows) -> Result<(), PetscError> {
    let [field] = &nodes.fields[..] else { return Ok(()) };
    let Some(space) = motions_of(world, field)? else { return Ok(()) };
    // SAFETY: both objects live, and PETSc counts its own reference to the space.
    unsafe { call!(MatSetNearNullSpace(matrix, space.handle())) }
}

/// The rigid motions of an unknown as PETSc's near-null space, where it is a displacement.
pub(crate) fn motions_of<'w>(world: &'w World, field: &FieldRows) -> Result<Option<Owned<'w>>, PetscError> {
    if field.motions.is_empty() {
        return Ok(None);
    }
    let mut vectors = Vec::new();
    for motion in &field.motions {
        let mut vector = DistributedVector::new(world, field.rows.clone())?;
        vector.set(motion)?;
        vectors.push(vector);
    }
    let handles: Vec<Object> = vectors.iter().map(DistributedVector::handle).collect();
    let count = handles.len() as Index;
    // SAFETY: the vectors live until the end of this, and PETSc counts its own references to them.
    let space = Owned::made(world, petsc::MatNullSpaceDestroy, |space| unsafe {
        call!(MatNullSpaceCreate(world.communicator(), FALSE, count, handles.as_ptr(), space))
    })?;
    Ok(Some(space))
}
