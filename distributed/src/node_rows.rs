//! The rows of PETSc's matrices: whole nodes, as block methods want them, of those that have free unknowns.

use std::ops::Range;

use forms_fem::linear_algebra::rigid_motions;
use forms_fem::prelude::*;
use forms_fem::solve::communicator::Fingerprint;

use crate::error::PetscError;
use crate::part::DividedUnknowns;
use crate::petsc::Index;
use crate::rows::Rows;
use crate::world::World;

/// A motion whose part outside of the span of others is smaller than this, relative to its length, adds nothing to them.
const DEPENDENT: f64 = 1e-8;

/// The rows of the free unknowns of spaces with constraints: a component that is not free at a node with free ones gets a row with 1 on
/// the diagonal; nodes without free components have no rows. Each process has its part of the nodes of each unknown, one unknown after
/// the other.
#[derive(Clone, Debug)]
pub(crate) struct NodeRows {
    pub rows: Rows,
    /// Row of each free unknown.
    pub places: Vec<Index>,
    /// Rows of components that are not free.
    pub held: Vec<Index>,
    /// Of each unknown.
    pub fields: Vec<FieldRows>,
    /// The division of vectors over the unknowns, where processes have pieces of the mesh.
    pub divided: Option<DividedUnknowns>,
}

/// The rows of one unknown.
#[derive(Clone, Debug)]
pub(crate) struct FieldRows {
    /// Among the rows of the unknown.
    pub rows: Rows,
    /// The first of this process's ones among all rows.
    pub start: usize,
    /// This process's rows of an orthonormal basis of the rigid motions of a displacement, zero in the held rows; empty for other fields.
    pub motions: Vec<Vec<f64>>,
    /// Whether the unknown lives on facets only, as multipliers do.
    pub is_on_facets: bool,
}

/// The nodes of an unknown that have rows.
struct FreeNodes<const D: usize> {
    components: usize,
    is_on_facets: bool,
    /// Whether its components are free, node by node.
    is_free: Vec<bool>,
    positions: Vec<[f64; D]>,
}

impl<const D: usize> FreeNodes<D> {
    fn of(constraints: &Constraints<D>) -> Self {
        let space = constraints.space();
        let components = space.components();
        let mut all = vec![false; space.unknowns()];
        constraints.free().into_iter().for_each(|unknown| all[unknown] = true);
        let (mut is_free, mut positions) = (Vec::new(), Vec::new());
        for (free, position) in all.chunks_exact(components).zip(space.positions()) {
            if free.contains(&true) {
                is_free.extend_from_slice(free);
                positions.push(*position);
            }
        }
        FreeNodes { components, is_on_facets: space.facet_region().is_some(), is_free, positions }
    }

    /// The rows of a process's part of the nodes, among those of the unknown.
    fn rows_of(&self, world: &World, rank: usize) -> Range<usize> {
        let nodes = world.part_of(rank, self.positions.len());
        nodes.start * self.components..nodes.end * self.components
    }

    /// The rows with the rigid motions of a displacement.
    fn field_rows(&self, world: &World, start: usize) -> Result<FieldRows, PetscError> {
        let held = self.is_free.iter().enumerate().filter(|(_, is_free)| !**is_free);
        let held: Vec<usize> = held.map(|(row, _)| row).collect();
        let is_displacement = self.components == D && D > 1 && !self.is_on_facets;
        let motions = if is_displacement { rigid_motions(&self.positions) } else { vec![] };
        let rows = Rows::of_nodes(world, self.positions.len(), self.components)?;
        let products = |all: &[&[f64]], b: &[f64]| Ok(all.iter().map(|a| product(a, b)).collect());
        let mut motions = orthonormal(motions, &held, &products)?;
        motions.iter_mut().for_each(|motion| *motion = motion[rows.own.clone()].to_vec());
        Ok(FieldRows { rows, start, motions, is_on_facets: self.is_on_facets })
    }
}

impl NodeRows {
    pub fn new<const D: usize>(world: &World, constraints: &[&Constraints<D>]) -> Result<Self, PetscError> {
        let unknowns: Vec<FreeNodes<D>> = constraints.iter().map(|one| FreeNodes::of(one)).collect();
        let mut rows_of_unknowns: Vec<Vec<Index>> = unknowns.iter().map(|_| vec![]).collect();
        let count: usize = unknowns.iter().map(|one| one.is_free.len()).sum();
        if Index::try_from(count).is_err() {
            return Err(PetscError::TooMany { what: "rows", count });
        }
        let (mut next, mut own, mut fields) = (0, 0..0, vec![]);
        for rank in 0..world.size() {
            let start = next;
            for (unknown, rows) in unknowns.iter().zip(&mut rows_of_unknowns) {
                if rank == world.rank() {
                    fields.push(unknown.field_rows(world, next)?);
                }
                let of_rank = unknown.rows_of(world, rank);
                rows.extend((next..next + of_rank.len()).map(|row| row as Index));
                next += of_rank.len();
            }
            if rank == world.rank() {
                own = start..next;
            }
        }
        let (mut places, mut held) = (Vec::new(), Vec::new());
        for (unknown, rows) in unknowns.iter().zip(rows_of_unknowns) {
            for (is_free, row) in unknown.is_free.iter().zip(rows) {
                if *is_free { places.push(row) } else { held.push(row) }
            }
        }
        let block = if let [only] = &unknowns[..] { only.components } else { 1 };
        Ok(NodeRows { rows: Rows { count, block, own }, places, held, fields, divided: None })
    }

    /// A number that tells rows of other nodes, places or constraints apart.
    pub fn fingerprint<const D: usize>(&self, constraints: &[&Constraints<D>]) -> u64 {
        let places = self.places.iter().chain(&self.held).map(|place| *place as u64);
        let sizes = [self.rows.count, self.rows.block, self.places.len()].map(|size| size as u64);
        let positions = constraints.iter().flat_map(|one| one.space().positions());
        let coordinates = positions.flatten();
        Fingerprint::default().numbers(sizes).numbers(places).reals(coordinates).finish()
    }

    /// The free unknowns whose rows this process judges, with the places of these among the rows that it knows.
    pub fn judged(&self) -> Vec<(usize, usize)> {
        let rows = self.places.iter().map(|place| *place as usize).enumerate();
        match self.divided {
            None => rows.collect(),
            Some(_) => {
                let own = &self.rows.own;
                rows.filter(|(_, row)| own.contains(row)).map(|(free, row)| (free, row - own.start)).collect()
            }
        }
    }

    /// This process's rows of a vector over the free unknowns.
    pub fn own_of(&self, reduced: &[f64]) -> Vec<f64> {
        let mut own = vec![0.0; self.rows.own.len()];
        for (place, value) in self.places.iter().zip(reduced) {
            if let Some(row) = (*place as usize).checked_sub(self.rows.own.start)
                && row < own.len()
            {
                own[row] = *value;
            }
        }
        own
    }

    /// The free unknowns of a vector whose rows are all known here; on pieces of a mesh those of this process, and the others come from
    /// theirs.
    pub fn unknowns_of(&self, known: &[f64]) -> Result<Vec<f64>, PetscError> {
        let Some(divided) = &self.divided else {
            return Ok(self.places.iter().map(|place| known[*place as usize]).collect());
        };
        let own = |place: &Index| (*place as usize).checked_sub(self.rows.own.start);
        let found = self.places.iter().map(|place| own(place).and_then(|row| known.get(row)).copied());
        divided.spread(found.map(Option::unwrap_or_default))
    }
}

/// The part of a product of two vectors in some rows.
pub(crate) fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Products of some vectors with one. A process may have some of their rows only.
pub(crate) type Products<'a> = dyn Fn(&[&[f64]], &[f64]) -> Result<Vec<f64>, PetscError> + 'a;

/// Gram and Schmidt's basis of some vectors that are zero in the held rows.
pub(crate) fn orthonormal(
    vectors: Vec<Vec<f64>>,
    held: &[usize],
    products: &Products<'_>,
) -> Result<Vec<Vec<f64>>, PetscError> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut vector in vectors {
        held.iter().for_each(|row| vector[*row] = 0.0);
        let mut before = None;
        // Once more, for what rounding left.
        for _ in 0..2 {
            let asked: Vec<&[f64]> = basis.iter().chain([&vector]).map(|one| &one[..]).collect();
            let mut factors = products(&asked, &vector)?;
            let square = factors.pop().unwrap_or(f64::NAN);
            before = before.or(Some(square.sqrt()));
            for (known, factor) in basis.iter().zip(factors) {
                vector.iter_mut().zip(known).for_each(|(value, known)| *value -= factor * known);
            }
        }
        let before = before.unwrap_or(f64::NAN);
        let length = products(&[&vector], &vector)?[0].sqrt();
        if length > DEPENDENT * before {
            vector.iter_mut().for_each(|value| *value /= length);
            basis.push(vector);
        }
    }
    Ok(basis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_become_a_basis_that_leaves_held_rows_alone() {
        let vectors = vec![vec![1.0, 1.0, 0.0], vec![1.0, 1.0, 1.0], vec![2.0, 2.0, 5.0]];
        let products = |all: &[&[f64]], b: &[f64]| Ok(all.iter().map(|a| product(a, b)).collect());
        let basis = orthonormal(vectors, &[0], &products).unwrap();
        assert_eq!(basis, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }
}
