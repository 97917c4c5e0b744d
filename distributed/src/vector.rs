//! Vectors whose rows are spread over the processes.

#![allow(unsafe_code)]

use std::ptr::null_mut;

use crate::error::PetscError;
use crate::object::Owned;
use crate::petsc::{self, FORWARD, INSERT, Index, Object, call};
use crate::rows::Rows;
use crate::world::World;

/// A vector whose rows are distributed, and the scatter that copies all rows to every process.
#[derive(Debug)]
pub(crate) struct DistributedVector<'w> {
    rows: Rows,
    vector: Owned<'w>,
    scatter: Owned<'w>,
    /// All rows, on this process.
    copy: Owned<'w>,
}

impl<'w> DistributedVector<'w> {
    pub fn new(world: &'w World, rows: Rows) -> Result<Self, PetscError> {
        let (own, all) = (rows.own.len() as Index, rows.count as Index);
        // SAFETY: PETSc writes the handles; the sizes were checked when rows were made.
        let vector = Owned::made(world, petsc::VecDestroy, |vector| unsafe {
            call!(VecCreateMPI(world.communicator(), own, all, vector))
        })?;
        // SAFETY: a vector with rows of whole blocks.
        unsafe { call!(VecSetBlockSize(vector.handle(), rows.block as Index))? };
        let mut copied = null_mut();
        // SAFETY: PETSc writes two handles.
        let scatter = Owned::made(world, petsc::VecScatterDestroy, |scatter| unsafe {
            call!(VecScatterCreateToAll(vector.handle(), scatter, &mut copied))
        })?;
        let copy = Owned::made(world, petsc::VecDestroy, |copy| {
            // SAFETY: a place for a handle, which was made with the scatter.
            unsafe { copy.write(copied) };
            Ok(())
        })?;
        Ok(DistributedVector { rows, vector, scatter, copy })
    }

    pub fn handle(&self) -> Object {
        self.vector.handle()
    }

    /// Takes this process's rows out of a whole vector.
    pub fn set(&mut self, whole: &[f64]) -> Result<(), PetscError> {
        self.check_size(whole)?;
        let mut values = null_mut();
        // SAFETY: PETSc lends its array of as many values as there are rows of this process, until it is given back.
        unsafe {
            call!(VecGetArray(self.handle(), &mut values))?;
            if !self.rows.own.is_empty() {
                let own = std::slice::from_raw_parts_mut(values, self.rows.own.len());
                own.copy_from_slice(&whole[self.rows.own.clone()]);
            }
            call!(VecRestoreArray(self.handle(), &mut values))
        }
    }

    fn check_size(&self, vector: &[f64]) -> Result<(), PetscError> {
        let (expected, found) = (self.rows.count, vector.len());
        if expected == found { Ok(()) } else { Err(PetscError::Size { expected, found }) }
    }

    /// All rows, on every process.
    pub fn whole(&self) -> Result<Vec<f64>, PetscError> {
        let mut whole = vec![0.0; self.rows.count];
        let (scatter, vector, copy) = (self.scatter.handle(), self.handle(), self.copy.handle());
        let mut values = std::ptr::null();
        // SAFETY: the scatter was made for these two vectors; the copy has all rows, and its array is lent until it is
        // given back.
        unsafe {
            call!(VecScatterBegin(scatter, vector, copy, INSERT, FORWARD))?;
            call!(VecScatterEnd(scatter, vector, copy, INSERT, FORWARD))?;
            call!(VecGetArrayRead(copy, &mut values))?;
            if !whole.is_empty() {
                whole.copy_from_slice(std::slice::from_raw_parts(values, self.rows.count));
            }
            call!(VecRestoreArrayRead(copy, &mut values))?;
        }
        Ok(whole)
    }
}
