//! Vectors whose rows are spread over the processes.

#![allow(unsafe_code)]

use std::ptr::null_mut;

use crate::error::PetscError;
use crate::object::Owned;
use crate::petsc::{self, FORWARD, INSERT, Index, Object, call};
use crate::rows::Rows;
use crate::world::World;

/// A vector whose rows are distributed.
#[derive(Debug)]
pub(crate) struct DistributedVector<'w> {
    rows: Rows,
    vector: Owned<'w>,
    /// The scatter that copies all rows to every process, and the copy here.
    all: Option<[Owned<'w>; 2]>,
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
        Ok(DistributedVector { rows, vector, all: None })
    }

    /// This vector with a way to copy all of its rows to every process.
    pub fn with_copy(mut self, world: &'w World) -> Result<Self, PetscError> {
        let mut copied = null_mut();
        // SAFETY: PETSc writes two handles.
        let scatter = Owned::made(world, petsc::VecScatterDestroy, |scatter| unsafe {
            call!(VecScatterCreateToAll(self.handle(), scatter, &mut copied))
        })?;
        let copy = Owned::made(world, petsc::VecDestroy, |copy| {
            // SAFETY: a place for a handle, which was made with the scatter.
            unsafe { copy.write(copied) };
            Ok(())
        })?;
        self.all = Some([scatter, copy]);
        Ok(self)
    }

    pub fn handle(&self) -> Object {
        self.vector.handle()
    }

    /// Sets this process's rows.
    pub fn set(&mut self, own: &[f64]) -> Result<(), PetscError> {
        let (expected, found) = (self.rows.own.len(), own.len());
        if expected != found {
            return Err(PetscError::Size { expected, found });
        }
        let mut values = null_mut();
        // SAFETY: PETSc lends its array of as many values as there are rows of this process, until it is given back.
        unsafe {
            call!(VecGetArray(self.handle(), &mut values))?;
            if !own.is_empty() {
                std::slice::from_raw_parts_mut(values, own.len()).copy_from_slice(own);
            }
            call!(VecRestoreArray(self.handle(), &mut values))
        }
    }

    /// This process's rows, or all rows where there is a copy of them.
    pub fn values(&self) -> Result<Vec<f64>, PetscError> {
        let (vector, mut values) = (self.handle(), std::ptr::null());
        let (from, count) = match &self.all {
            None => (vector, self.rows.own.len()),
            Some([scatter, copy]) => {
                let (scatter, copy) = (scatter.handle(), copy.handle());
                // SAFETY: the scatter was made for these two vectors.
                unsafe {
                    call!(VecScatterBegin(scatter, vector, copy, INSERT, FORWARD))?;
                    call!(VecScatterEnd(scatter, vector, copy, INSERT, FORWARD))?;
                }
                (copy, self.rows.count)
            }
        };
        let mut found = vec![0.0; count];
        // SAFETY: the array of as many values is lent until it is given back.
        unsafe {
            call!(VecGetArrayRead(from, &mut values))?;
            if count > 0 {
                found.copy_from_slice(std::slice::from_raw_parts(values, count));
            }
            call!(VecRestoreArrayRead(from, &mut values))?;
        }
        Ok(found)
    }
}
