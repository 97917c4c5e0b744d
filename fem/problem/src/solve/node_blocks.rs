//! Properties of a space that multigrid needs: blocks by nodes, transfers to lower degrees, and the near-null space.

mod transfers;

use std::sync::Arc;

use super::linear_solver::SolverError;
use crate::constraints::Constraints;
use crate::element::Elements;
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::vector::largest;
use crate::linear_algebra::{
    BlockMatrix, BlockRows, BlockSparsity, CsrMatrix, LinearAlgebraError, NodeSet, rigid_motions,
};
use crate::space::{Scope, Space, SpaceError};
use transfers::{Given, coarse_level, transfer};

/// Forces of a motion, relative to the sizes of their terms, that are rounding.
const NOTHING: f64 = 1e-11;

/// Marks a node that is not kept.
const DROPPED: u32 = u32::MAX;

/// The nodes of a space that have free unknowns, and which of their components are free.
#[derive(Clone, Debug)]
struct FreeNodes {
    components: usize,
    /// Number of each node among those that are kept, or [`DROPPED`].
    number: Vec<u32>,
    kept: Vec<u32>,
    /// Per kept node and component.
    free: Vec<bool>,
}

impl FreeNodes {
    /// From whether each unknown is free.
    fn new(components: usize, is_free: &[bool]) -> Self {
        let mut result = FreeNodes { components, number: vec![], kept: vec![], free: vec![] };
        for (node, components) in is_free.chunks_exact(components).enumerate() {
            let kept = components.contains(&true);
            result.number.push(if kept { result.kept.len() as u32 } else { DROPPED });
            if kept {
                result.kept.push(node as u32);
                result.free.extend_from_slice(components);
            }
        }
        result
    }

    /// Whether a component of a node of the space is free.
    fn is_free(&self, node: usize, component: usize) -> bool {
        let number = self.number[node];
        number != DROPPED && self.free[number as usize * self.components + component]
    }
}

/// The way from reduced systems of a space to systems over nodes. Components that are prescribed, or given by free unknowns, at a node
/// with free ones get a row of their own with 1 on the diagonal; nodes without free components are left out.
#[derive(Debug)]
pub(super) struct NodeBlocks {
    nodes: FreeNodes,
    /// Unknown of the node system for each free unknown.
    places: Vec<u32>,
    pub(super) transfers: Vec<BlockMatrix>,
    pub(super) near_null_space: Vec<Vec<f64>>,
    /// The same on the given space: what a singular matrix is tried with.
    own_near_null_space: Vec<Vec<f64>>,
    sparsity: Option<Arc<BlockSparsity>>,
}

impl NodeBlocks {
    /// Prepares a space with its constraints.
    pub(super) fn new<const D: usize>(constraints: &Constraints<D>) -> Result<Self, SpaceError> {
        let mut space = constraints.space().clone();
        let components = space.components();
        let mut is_free = vec![true; space.unknowns()];
        for unknown in constraints.prescribed().keys().chain(constraints.relations().keys()) {
            is_free[*unknown] = false;
        }
        let fine = FreeNodes::new(components, &is_free);
        let unknowns = (0..fine.kept.len() * components).filter(|place| fine.free[*place]);
        let places = unknowns.map(|place| place as u32).collect();
        let own_near_null_space = near_null_space(&space, &fine);
        let relations = constraints.relations().iter();
        let mut given: Given =
            relations.map(|(unknown, relation)| (*unknown, relation.terms.clone())).collect();
        let mut nodes = fine.clone();
        let mut transfers = Vec::new();
        while space.is_continuous_lagrange() && space.degree() > 1 {
            let coarse = Elements::Lagrange(space.degree() / 2);
            let coarse = Space::of(space.mesh(), coarse, Scope::Nodes, space.shape())?;
            let embedding = space.embedding(&coarse)?;
            let (coarse_nodes, coarse_given) = coarse_level(&nodes, &given, &embedding);
            let transfer = transfer(&nodes, (&coarse_nodes, &coarse_given), &embedding);
            transfers.push(transfer.map_err(|_| SpaceError::TooLarge { unknowns: space.unknowns() })?);
            (space, nodes, given) = (coarse, coarse_nodes, coarse_given);
        }
        let near_null_space = near_null_space(&space, &nodes);
        Ok(NodeBlocks {
            nodes: fine,
            places,
            transfers,
            near_null_space,
            own_near_null_space,
            sparsity: None,
        })
    }

    /// Number of free unknowns.
    pub(super) fn free_unknowns(&self) -> usize {
        self.places.len()
    }

    /// The matrix over nodes of a matrix over free unknowns.
    pub(super) fn matrix(&mut self, reduced: &CsrMatrix) -> Result<BlockMatrix, LinearAlgebraError> {
        check_size("the set of rows", self.free_unknowns(), reduced.rows())?;
        check_size("the set of columns", self.free_unknowns(), reduced.columns())?;
        let (components, count) = (self.nodes.components, self.nodes.kept.len());
        let block = components * components;
        let mut pointers = vec![0_usize];
        let mut indices: Vec<u32> = Vec::with_capacity(reduced.values().len() / block);
        let mut values: Vec<f64> = Vec::with_capacity(reduced.values().len());
        let mut near: Vec<u32> = Vec::new();
        let mut row = 0;
        for node in 0..count {
            let free = &self.nodes.free[node * components..(node + 1) * components];
            let rows = row..row + free.iter().filter(|free| **free).count();
            row = rows.end;
            near.clear();
            near.push(node as u32);
            for row in rows.clone() {
                for &column in reduced.row(row).0 {
                    let other = self.places[column as usize] / components as u32;
                    // Components of a node follow each other.
                    if near.last() != Some(&other) {
                        near.push(other);
                    }
                }
            }
            near.sort_unstable();
            near.dedup();
            let first = values.len();
            values.resize(first + near.len() * block, 0.0);
            let own = near.partition_point(|other| (*other as usize) < node);
            let mut rows = rows;
            for (component, free) in free.iter().enumerate() {
                let Some(row) = rows.next_if(*free) else {
                    values[first + own * block + component * (components + 1)] = 1.0;
                    continue;
                };
                let mut place = 0;
                let (columns, entries) = reduced.row(row);
                for (&column, value) in columns.iter().zip(entries) {
                    let target = self.places[column as usize] as usize;
                    while (near[place] as usize) < target / components {
                        place += 1;
                    }
                    values[first + place * block + component * components + target % components] = *value;
                }
            }
            indices.extend_from_slice(&near);
            pointers.push(indices.len());
        }
        let rows = BlockRows::new(pointers, indices);
        let sets = NodeSet::in_a_row([(count, components)]);
        let sparsity = BlockSparsity::new(sets.clone(), sets, vec![vec![rows]])?;
        let sparsity = match self.sparsity.take().filter(|known| **known == sparsity) {
            Some(known) => known,
            None => Arc::new(sparsity),
        };
        self.sparsity = Some(sparsity.clone());
        BlockMatrix::from_values(&sparsity, values)
    }

    /// The error that names a free unknown of a motion (or constant) that the matrix does not resist, if there is one.
    /// Motions that prescribed unknowns stop are not among them, since they are cut off there.
    pub(super) fn singular(&self, matrix: &BlockMatrix) -> Option<LinearAlgebraError> {
        let mut least: Option<(usize, f64)> = None;
        for vector in &self.own_near_null_space {
            // Each row counts in its own scale.
            let (sums, sizes) = matrix.products(vector).ok()?;
            let of_row = |(sum, size): (&f64, &f64)| if *size > 0.0 { sum.abs() / size } else { 0.0 };
            let resistance = sums.iter().zip(&sizes).map(of_row).fold(0.0, f64::max);
            if resistance <= NOTHING && least.is_none_or(|(_, known)| resistance < known) {
                let moved = |place: &u32| vector[*place as usize].abs() == largest(vector);
                least = self.places.iter().position(moved).map(|unknown| (unknown, resistance));
            }
        }
        least.map(|(unknown, ratio)| LinearAlgebraError::Singular { unknown, ratio })
    }

    /// An error that names the equation of a free unknown, from one that names a row of the matrix over nodes.
    pub(super) fn reduced(&self, error: SolverError) -> SolverError {
        let SolverError::LinearAlgebra(LinearAlgebraError::Inaccurate { row, backward_error }) = error else {
            return error;
        };
        let row = self.places.iter().position(|place| *place as usize == row).unwrap_or(0);
        LinearAlgebraError::Inaccurate { row, backward_error }.into()
    }

    /// A vector over nodes from one over free unknowns.
    pub(super) fn spread(&self, reduced: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.nodes.free.len()];
        for (place, value) in self.places.iter().zip(reduced) {
            all[*place as usize] = *value;
        }
        all
    }

    /// The free unknowns of a vector over nodes.
    pub(super) fn gather(&self, all: &[f64]) -> Vec<f64> {
        self.places.iter().map(|place| all[*place as usize]).collect()
    }
}

/// Takes the next of a range if a condition holds.
trait NextIf: Iterator {
    fn next_if(&mut self, condition: bool) -> Option<Self::Item> {
        condition.then(|| self.next()).flatten()
    }
}

impl NextIf for std::ops::Range<usize> {}

/// Rigid motions where there are as many components as dimensions, otherwise one constant per component.
fn near_null_space<const D: usize>(space: &Space<D>, nodes: &FreeNodes) -> Vec<Vec<f64>> {
    let components = nodes.components;
    let positions: Vec<[f64; D]> = nodes.kept.iter().map(|node| space.positions()[*node as usize]).collect();
    let mut vectors = if components == D && D > 1 {
        rigid_motions(&positions)
    } else {
        let constant = |own: usize| {
            let value = move |unknown: usize| f64::from(u8::from(unknown % components == own));
            (0..positions.len() * components).map(value).collect()
        };
        (0..components).map(constant).collect()
    };
    for vector in &mut vectors {
        for (value, free) in vector.iter_mut().zip(&nodes.free) {
            if !free {
                *value = 0.0;
            }
        }
    }
    vectors
}
