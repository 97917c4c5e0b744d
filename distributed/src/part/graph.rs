//! Partition of the graph of a mesh's cells, which share facets, by the program that PETSc has for it: PT-Scotch or ParMETIS.

#![allow(unsafe_code)]

use std::ffi::CString;
use std::ptr::null_mut;

use forms_fem::mesh::Mesh;

use crate::error::PetscError;
use crate::mpi;
use crate::petsc::{self, Code, FALSE, Index, Object, call};

/// The program, by PETSc's name; empty where PETSc was built without one.
const PROGRAM: &str = env!("PETSC_PARTITIONER");

/// The process of each cell so that all processes have about the same weight and few facets are between processes; none without a program
/// for it, or where it would leave a process without cells. Computed by one process for all.
pub(super) fn owners<const D: usize>(
    mesh: &Mesh<D>,
    processes: usize,
    weights: &[u32],
) -> Result<Option<Vec<usize>>, PetscError> {
    if PROGRAM.is_empty() || processes == 1 {
        return Ok(None);
    }
    let (starts, neighbours) = neighbours(mesh);
    let [cells, links] = [mesh.cell_count(), neighbours.len()];
    if Index::try_from(cells.max(links)).is_err() {
        return Err(PetscError::TooMany { what: "facets between cells", count: links });
    }
    // Partitioners add weights up in the same numbers.
    let sum: u64 = weights.iter().map(|weight| u64::from(*weight)).sum();
    if sum > Index::MAX as u64 {
        return Err(PetscError::TooMany { what: "weights of cells, added up,", count: sum as usize });
    }
    let found = divided(&starts, &neighbours, processes, weights)?;
    let mut has_cells = vec![false; processes];
    found.iter().for_each(|rank| has_cells[*rank as usize] = true);
    let all = has_cells.into_iter().all(|has_cells| has_cells);
    Ok(all.then(|| found.into_iter().map(|rank| rank as usize).collect()))
}

/// The cells next to each cell: where its list starts in the second one.
fn neighbours<const D: usize>(mesh: &Mesh<D>) -> (Vec<Index>, Vec<Index>) {
    let mut starts = vec![0; mesh.cell_count() + 1];
    for facet in mesh.interior_facets().as_flattened() {
        starts[facet.cell as usize + 1] += 1;
    }
    for cell in 0..mesh.cell_count() {
        starts[cell + 1] += starts[cell];
    }
    let (mut next, mut all) = (starts.clone(), vec![0; mesh.interior_facets().len() * 2]);
    for [one, other] in mesh.interior_facets() {
        for (cell, neighbour) in [(one.cell, other.cell), (other.cell, one.cell)] {
            all[next[cell as usize] as usize] = neighbour as Index;
            next[cell as usize] += 1;
        }
    }
    for cell in 0..mesh.cell_count() {
        all[starts[cell] as usize..starts[cell + 1] as usize].sort_unstable();
    }
    (starts, all)
}

/// The part of each vertex of a graph.
fn divided(
    starts: &[Index],
    neighbours: &[Index],
    parts: usize,
    weights: &[u32],
) -> Result<Vec<Index>, PetscError> {
    let (communicator, count) = (mpi::this_process(), starts.len() as Index - 1);
    let weights: Vec<Index> = weights.iter().map(|weight| *weight as Index).collect();
    let name = CString::new(PROGRAM).unwrap_or_default();
    let graph = Made::by(petsc::MatDestroy, |graph| {
        let (starts, neighbours) = (given(starts)?, given(neighbours)?);
        // SAFETY: the lists are PETSc's memory, which the matrix takes over; their lengths are those that `starts` tells.
        unsafe { call!(MatCreateMPIAdj(communicator, count, count, starts, neighbours, null_mut(), graph)) }
    })?;
    // SAFETY: PETSc writes the handle.
    let partitioning = Made::by(petsc::MatPartitioningDestroy, |made| unsafe {
        call!(MatPartitioningCreate(communicator, made))
    })?;
    let weights = given(&weights)?;
    // SAFETY: both objects live, and PETSc counts its own reference to the graph. It takes over the weights, one for each vertex, and copies
    // the name.
    let parts = Made::by(petsc::ISDestroy, |parts_of| unsafe {
        call!(MatPartitioningSetAdjacency(partitioning.0, graph.0))?;
        call!(MatPartitioningSetType(partitioning.0, name.as_ptr()))?;
        call!(MatPartitioningSetVertexWeights(partitioning.0, weights))?;
        call!(MatPartitioningSetNParts(partitioning.0, parts as Index))?;
        call!(MatPartitioningSetFromOptions(partitioning.0))?;
        call!(MatPartitioningApply(partitioning.0, parts_of))
    })?;
    let mut list = std::ptr::null();
    // SAFETY: PETSc writes the address of as many numbers as there are vertices, which stays until it is given back.
    unsafe {
        call!(ISGetIndices(parts.0, &mut list))?;
        let found = std::slice::from_raw_parts(list, count as usize).to_vec();
        call!(ISRestoreIndices(parts.0, &mut list))?;
        Ok(found)
    }
}

/// An object of this process only, which nobody waits for when it is destroyed.
struct Made(Object, unsafe extern "C" fn(*mut Object) -> Code);

impl Made {
    fn by(
        destroy: unsafe extern "C" fn(*mut Object) -> Code,
        make: impl FnOnce(*mut Object) -> Result<(), PetscError>,
    ) -> Result<Self, PetscError> {
        let mut made = Made(null_mut(), destroy);
        make(&mut made.0)?;
        Ok(made)
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        if !self.0.is_null() {
            // SAFETY: the object was made by PETSc and is not used afterwards. An error would leave memory in use, and nothing else.
            let _ = unsafe { (self.1)(&mut self.0) };
        }
    }
}

/// A copy in memory of PETSc's, for objects that take it over.
fn given(list: &[Index]) -> Result<*mut Index, PetscError> {
    let (mut memory, place) = (null_mut(), c"part/graph.rs".as_ptr());
    // At least one number: PETSc gives no memory for none.
    let bytes = size_of::<Index>() * list.len().max(1);
    // SAFETY: PETSc writes the address of as many bytes, into which the numbers are copied.
    unsafe {
        call!(PetscMallocA(1, FALSE, 0, place, place, bytes, &mut memory))?;
        memory.cast::<Index>().copy_from_nonoverlapping(list.as_ptr(), list.len());
    }
    Ok(memory.cast())
}
