//! Matrices whose rows are spread over the processes, as sums of what each of them assembled.

#![allow(unsafe_code)]

use std::ptr::null_mut;

use crate::error::PetscError;
use crate::local_matrix::{LocalMatrix, LocalPattern};
use crate::node_rows::{FieldRows, NodeRows};
use crate::object::Owned;
use crate::petsc::{self, FALSE, Index, Object, TRUE, call};
use crate::shared_rows::SharedRows;
use crate::vector::DistributedVector;
use crate::world::World;

/// A `MATAIJ`. Processes send what they have of each other's rows, so that each sets its own ones as sums, row by row: nothing but
/// the matrix itself has as many entries.
#[derive(Debug)]
pub(crate) struct DistributedMatrix<'w> {
    world: &'w World,
    matrix: Owned<'w>,
    pattern: LocalPattern,
    /// Of each row that this process keeps the one of the local matrix.
    local_rows: Vec<RowHere>,
    shared: SharedRows,
    /// Numbers of entries in own columns, and in those of others.
    entries: [usize; 2],
}

/// A row that a process keeps.
#[derive(Clone, Copy, Debug)]
enum RowHere {
    /// Of an unknown that is not free: 1 on the diagonal.
    Held,
    /// Of a free unknown.
    Free {
        /// Row of the local matrix; none where only other processes contribute.
        local: Option<u32>,
    },
}

impl<'w> DistributedMatrix<'w> {
    /// A matrix with the positions of all processes' local ones; values come with [`DistributedMatrix::assemble`].
    pub fn new(
        world: &'w World,
        nodes: &NodeRows,
        motions: &Motions<'w>,
        local: &LocalMatrix<'_>,
    ) -> Result<Self, PetscError> {
        let own = &nodes.rows.own;
        let mut local_rows = vec![RowHere::Free { local: None }; own.len()];
        let here = |place: &Index| own.contains(&(*place as usize)).then(|| *place as usize - own.start);
        for (row, place) in nodes.places.iter().enumerate() {
            if let Some(place) = here(place) {
                local_rows[place] = RowHere::Free { local: Some(row as u32) };
            }
        }
        nodes.held.iter().filter_map(here).for_each(|place| local_rows[place] = RowHere::Held);
        let shared = SharedRows::new(world, nodes, local)?;
        let (size, all) = (own.len() as Index, nodes.rows.count as Index);
        // SAFETY: PETSc writes the handle.
        let matrix = Owned::made(world, petsc::MatDestroy, |matrix| unsafe {
            call!(MatCreate(world.communicator(), matrix))
        })?;
        let pattern = local.pattern();
        let mut made = DistributedMatrix { world, matrix, pattern, local_rows, shared, entries: [0; 2] };
        let mut counts = [vec![0 as Index; own.len()], vec![0 as Index; own.len()]];
        made.visit_rows(nodes, local, |row, columns, _| {
            let inside = columns.iter().filter(|column| own.contains(&(**column as usize))).count();
            counts[0][row as usize - own.start] = inside as Index;
            counts[1][row as usize - own.start] = (columns.len() - inside) as Index;
            Ok(())
        })?;
        made.entries = counts.each_ref().map(|counts| counts.iter().map(|count| *count as usize).sum());
        let count = made.entries.iter().sum();
        if Index::try_from(count).is_err() {
            return Err(PetscError::TooMany { what: "entries", count });
        }
        let at = made.handle();
        // SAFETY: the matrix was just made; the name ends with zero; PETSc reads a number for each row of this process.
        unsafe {
            call!(MatSetSizes(at, size, size, all, all))?;
            call!(MatSetBlockSize(at, nodes.rows.block as Index))?;
            // On one process another kind of matrix, for which GAMG takes half of the memory. It heeds its own call only.
            call!(MatSetType(at, c"aij".as_ptr()))?;
            call!(MatSeqAIJSetPreallocation(at, 0, counts[0].as_ptr()))?;
            call!(MatMPIAIJSetPreallocation(at, 0, counts[0].as_ptr(), 0, counts[1].as_ptr()))?;
            call!(MatSetOption(at, petsc::NO_ENTRIES_OF_OTHERS, TRUE))?;
        }
        set_motions(at, motions)?;
        Ok(made)
    }

    /// Whether a local matrix has the positions of the one before.
    pub fn fits(&self, local: &LocalMatrix<'_>) -> bool {
        local.has(&self.pattern)
    }

    pub fn handle(&self) -> Object {
        self.matrix.handle()
    }

    /// Sets the matrix to the sum of the processes' parts.
    pub fn assemble(&mut self, nodes: &NodeRows, local: &LocalMatrix<'_>) -> Result<(), PetscError> {
        self.shared.exchange(self.world, local)?;
        let at = self.handle();
        self.visit_rows(nodes, local, |row, columns, values| {
            let count = columns.len() as Index;
            // SAFETY: one row with as many columns as values, which were all declared; PETSc copies them.
            unsafe {
                call!(MatSetValues(at, 1, &row, count, columns.as_ptr(), values.as_ptr(), petsc::INSERT))
            }
        })?;
        // SAFETY: the matrix lives.
        unsafe {
            call!(MatAssemblyBegin(at, petsc::FINAL))?;
            call!(MatAssemblyEnd(at, petsc::FINAL))
        }
    }

    /// A visit to each row that this process keeps: its columns, ascending, and the sums of the processes' values, added in the order of
    /// ranks.
    fn visit_rows(
        &self,
        nodes: &NodeRows,
        local: &LocalMatrix<'_>,
        mut visit: impl FnMut(Index, &[Index], &[f64]) -> Result<(), PetscError>,
    ) -> Result<(), PetscError> {
        let (mut entries, mut columns, mut values) = (vec![], vec![], vec![]);
        let rank = self.world.rank();
        for (row, here) in (nodes.rows.own.start as Index..).zip(&self.local_rows) {
            entries.clear();
            match here {
                RowHere::Held => entries.push((row, 1.0)),
                RowHere::Free { local: own } => {
                    self.shared.visit(row, |other| other < rank, &mut entries);
                    if let Some(own) = own {
                        let places = &nodes.places;
                        local.visit_row(*own as usize, |column, value| {
                            entries.push((places[column as usize], value));
                        });
                    }
                    self.shared.visit(row, |other| other > rank, &mut entries);
                    // Stable: equal columns stay in the order of ranks.
                    entries.sort_by_key(|(column, _)| *column);
                }
            }
            columns.clear();
            values.clear();
            for (column, value) in &entries {
                match values.last_mut() {
                    Some(sum) if columns.last() == Some(column) => *sum += value,
                    _ => {
                        columns.push(*column);
                        values.push(*value);
                    }
                }
            }
            visit(row, &columns, &values)?;
        }
        Ok(())
    }

    /// |A| x of own rows, or |A|ᵀ x.
    pub fn multiply_amounts(
        &self,
        x: &DistributedVector<'_>,
        product: &DistributedVector<'_>,
        transposed: bool,
    ) -> Result<(), PetscError> {
        let signs = self.with_values(|values| {
            let mut signs = vec![0_u64; values.len().div_ceil(64)];
            for (place, value) in values.iter_mut().enumerate() {
                signs[place / 64] |= u64::from(value.is_sign_negative()) << (place % 64);
                *value = value.abs();
            }
            signs
        })?;
        // SAFETY: objects of one size that live.
        let multiplied = unsafe {
            if transposed {
                call!(MatMultTranspose(self.handle(), x.handle(), product.handle()))
            } else {
                call!(MatMult(self.handle(), x.handle(), product.handle()))
            }
        };
        let mut signs = signs.into_iter();
        self.with_values(|values| {
            let signs = signs.next().unwrap_or_default();
            for (place, value) in values.iter_mut().enumerate() {
                if signs[place / 64] >> (place % 64) & 1 == 1 {
                    *value = -*value;
                }
            }
        })?;
        multiplied
    }

    /// The values of own rows in own columns, and those in others', lent to a function one after the other.
    fn with_values<T>(&self, mut each: impl FnMut(&mut [f64]) -> T) -> Result<Vec<T>, PetscError> {
        let (mut inside, mut outside, mut columns) = (self.handle(), null_mut(), std::ptr::null());
        let is_divided = self.world.size() > 1;
        if is_divided {
            // SAFETY: PETSc tells the two matrices of the process, which belong to this one.
            unsafe { call!(MatMPIAIJGetSeqAIJ(self.handle(), &mut inside, &mut outside, &mut columns))? };
        }
        let mut found = vec![];
        for (block, count) in
            [inside, outside].into_iter().zip(self.entries).take(1 + usize::from(is_divided))
        {
            let mut values = null_mut();
            // SAFETY: the array, which has at least as many values as were declared, is lent until it is given back.
            unsafe {
                call!(MatSeqAIJGetArray(block, &mut values))?;
                let none: &mut [f64] = &mut [];
                let all = if count == 0 { none } else { std::slice::from_raw_parts_mut(values, count) };
                found.push(each(all));
                call!(MatSeqAIJRestoreArray(block, &mut values))?;
            }
        }
        Ok(found)
    }

    /// The diagonal, into a vector.
    pub fn write_diagonal(&self, diagonal: &DistributedVector<'_>) -> Result<(), PetscError> {
        // SAFETY: both objects live, and have the same rows.
        unsafe { call!(MatGetDiagonal(self.handle(), diagonal.handle())) }
    }

    /// Its transposed, as a matrix of its own.
    pub fn transposed(&self, motions: &Motions<'w>) -> Result<Owned<'w>, PetscError> {
        // SAFETY: PETSc makes a matrix and writes its handle.
        let matrix = Owned::made(self.world, petsc::MatDestroy, |made| unsafe {
            call!(MatTranspose(self.handle(), petsc::INITIAL, made))
        })?;
        set_motions(matrix.handle(), motions)?;
        Ok(matrix)
    }
}

/// Tells GAMG the rigid motions of a matrix of one unknown.
fn set_motions(matrix: Object, motions: &Motions<'_>) -> Result<(), PetscError> {
    let [Some(space)] = motions else { return Ok(()) };
    // SAFETY: both objects live, and PETSc counts its own reference to the space.
    unsafe { call!(MatSetNearNullSpace(matrix, space.handle())) }
}

/// The rigid motions of each unknown as PETSc's near-null space, where it is a displacement.
pub(crate) type Motions<'w> = [Option<Owned<'w>>];

/// The rigid motions of an unknown, which PETSc takes over.
pub(crate) fn take_motions<'w>(
    world: &'w World,
    field: &mut FieldRows,
) -> Result<Option<Owned<'w>>, PetscError> {
    if field.motions.is_empty() {
        return Ok(None);
    }
    let mut vectors = Vec::new();
    for motion in std::mem::take(&mut field.motions) {
        let mut vector = DistributedVector::new(world, field.rows.clone())?;
        vector.set(&motion)?;
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
