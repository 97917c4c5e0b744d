//! Vectors whose rows are spread over the processes.

use std::ptr::null_mut;

use crate::error::PetscError;
use crate::petsc::{self, ADD, FORWARD, INSERT, Index, Object, call};
use crate::rows::Rows;
use crate::world::World;

/// A vector; each process keeps its rows, and the way from there to a copy of all rows on every process.
#[derive(Debug)]
pub(crate) struct DistributedVector<'w> {
    _world: &'w World,
    rows: Rows,
    vector: Object,
    scatter: Object,
    /// All rows, on this process.
    copy: Object,
}

impl<'w> DistributedVector<'w> {
    pub fn new(world: &'w World, rows: Rows) -> Result<Self, PetscError> {
        let (vector, scatter, copy) = (null_mut(), null_mut(), null_mut());
        let mut made = DistributedVector { _world: world, rows, vector, scatter, copy };
        let (own, all) = (made.rows.own.len() as Index, made.rows.count as Index);
        // SAFETY: PETSc writes the handles, which this owns from here on; the sizes were checked when rows were made.
        unsafe {
            call!(VecCreateMPI(world.communicator(), own, all, &mut made.vector))?;
            call!(VecSetBlockSize(made.vector, made.rows.block as Index))?;
            call!(VecScatterCreateToAll(made.vector, &mut made.scatter, &mut made.copy))?;
        }
        Ok(made)
    }

    pub fn handle(&self) -> Object {
        self.vector
    }

    /// Sets the vector to the sum of the processes' parts, and returns it whole.
    pub fn sum(&mut self, local: &[f64]) -> Result<Vec<f64>, PetscError> {
        self.check_size(local)?;
        let mut rows: Vec<Index> = Vec::new();
        let mut values = Vec::new();
        for (row, value) in local.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            rows.push(row as Index);
            values.push(*value);
        }
        // SAFETY: as many rows as values, all of them less than the vector's size, which is that of the local vector.
        unsafe {
            call!(VecSet(self.vector, 0.0))?;
            call!(VecSetValues(self.vector, rows.len() as Index, rows.as_ptr(), values.as_ptr(), ADD))?;
            call!(VecAssemblyBegin(self.vector))?;
            call!(VecAssemblyEnd(self.vector))?;
        }
        self.whole()
    }

    /// Takes this process's rows out of a whole vector.
    pub fn set(&mut self, whole: &[f64]) -> Result<(), PetscError> {
        self.check_size(whole)?;
        let mut values = null_mut();
        // SAFETY: PETSc lends its array of as many values as there are rows of this process, until it is given back.
        unsafe {
            call!(VecGetArray(self.vector, &mut values))?;
            if !self.rows.own.is_empty() {
                let own = std::slice::from_raw_parts_mut(values, self.rows.own.len());
                own.copy_from_slice(&whole[self.rows.own.clone()]);
            }
            call!(VecRestoreArray(self.vector, &mut values))
        }
    }

    fn check_size(&self, vector: &[f64]) -> Result<(), PetscError> {
        let (expected, found) = (self.rows.count, vector.len());
        if expected == found { Ok(()) } else { Err(PetscError::Size { expected, found }) }
    }

    /// All rows, on every process.
    pub fn whole(&self) -> Result<Vec<f64>, PetscError> {
        let mut whole = vec![0.0; self.rows.count];
        let mut values = std::ptr::null();
        // SAFETY: the scatter was made for these two vectors; the copy has all rows, and its array is lent until it is
        // given back.
        unsafe {
            call!(VecScatterBegin(self.scatter, self.vector, self.copy, INSERT, FORWARD))?;
            call!(VecScatterEnd(self.scatter, self.vector, self.copy, INSERT, FORWARD))?;
            call!(VecGetArrayRead(self.copy, &mut values))?;
            if !whole.is_empty() {
                whole.copy_from_slice(std::slice::from_raw_parts(values, self.rows.count));
            }
            call!(VecRestoreArrayRead(self.copy, &mut values))?;
        }
        Ok(whole)
    }
}

impl Drop for DistributedVector<'_> {
    fn drop(&mut self) {
        // SAFETY: handles that this owns, or null, which PETSc leaves alone.
        unsafe {
            petsc::VecDestroy(&mut self.copy);
            petsc::VecScatterDestroy(&mut self.scatter);
            petsc::VecDestroy(&mut self.vector);
        }
    }
}
