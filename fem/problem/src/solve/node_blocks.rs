//! Properties of a space that multigrid needs: blocks by nodes, transfers to lower degrees, and the near-null space.

mod transfers;

use std::ops::Range;
use std::sync::Arc;

use super::linear_solver::SolverError;
use crate::constraints::Constraints;
use crate::element::Elements;
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::large_pages::zeros;
use crate::linear_algebra::vector::largest;
use crate::linear_algebra::{
    BlockMatrix, BlockRows, BlockSparsity, CsrMatrix, LinearAlgebraError, NodeSet, SparsityPattern,
    rigid_motions,
};
use crate::space::{Scope, Space, SpaceError};
use crate::threads::Threads;
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
    /// The free unknowns before each kept node, and their number.
    rows: Vec<u32>,
    /// The last pattern of a matrix over free unknowns, with that over nodes.
    known: Option<(Arc<SparsityPattern>, Arc<BlockSparsity>)>,
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
        let mut rows = vec![0];
        for components in fine.free.chunks_exact(components) {
            rows.push(rows[rows.len() - 1] + components.iter().filter(|free| **free).count() as u32);
        }
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
            rows,
            known: None,
        })
    }

    /// Number of free unknowns.
    pub(super) fn free_unknowns(&self) -> usize {
        self.places.len()
    }

    /// The matrix over nodes of a matrix over free unknowns, on some threads.
    pub(super) fn matrix(
        &mut self,
        reduced: &CsrMatrix,
        threads: Threads,
    ) -> Result<BlockMatrix, LinearAlgebraError> {
        check_size("the set of rows", self.free_unknowns(), reduced.rows())?;
        check_size("the set of columns", self.free_unknowns(), reduced.columns())?;
        let sparsity = self.sparsity_of(reduced.pattern(), threads)?;
        let block = self.nodes.components.pow(2);
        let rows = sparsity.pair(0, 0);
        let mut values = zeros(sparsity.entries());
        rows.on_threads(threads, (&mut values, block), |nodes, values| {
            let first = rows.range(nodes.start).start;
            for node in nodes {
                let range = rows.range(node);
                let values = &mut values[(range.start - first) * block..(range.end - first) * block];
                self.fill_row(node, rows.row(node), reduced, values);
            }
        });
        BlockMatrix::from_values(&sparsity, values)
    }

    /// The values of a node's blocks, which are zero before.
    fn fill_row(&self, node: usize, near: &[u32], reduced: &CsrMatrix, values: &mut [f64]) {
        let components = self.nodes.components;
        let block = components * components;
        let own = near.partition_point(|other| (*other as usize) < node);
        let mut rows = self.rows[node] as usize..self.rows[node + 1] as usize;
        for (component, free) in self.nodes.free[node * components..][..components].iter().enumerate() {
            let Some(row) = rows.next_if(*free) else {
                values[own * block + component * (components + 1)] = 1.0;
                continue;
            };
            let mut place = 0;
            let (columns, entries) = reduced.row(row);
            for (&column, value) in columns.iter().zip(entries) {
                let target = self.places[column as usize] as usize;
                while (near[place] as usize) < target / components {
                    place += 1;
                }
                values[place * block + component * components + target % components] = *value;
            }
        }
    }

    /// The blocks of a matrix over free unknowns: those of the last one where it has the same pattern.
    fn sparsity_of(
        &mut self,
        pattern: &Arc<SparsityPattern>,
        threads: Threads,
    ) -> Result<Arc<BlockSparsity>, LinearAlgebraError> {
        if let Some((known, sparsity)) = &self.known
            && Arc::ptr_eq(known, pattern)
        {
            return Ok(sparsity.clone());
        }
        let (components, count) = (self.nodes.components, self.nodes.kept.len());
        let length = count.div_ceil(threads.for_work(pattern.entries())).max(1);
        let ranges = (0..count).step_by(length).map(|first| first..(first + length).min(count)).collect();
        let found = threads.run(ranges, |nodes: Range<usize>| {
            let (mut ends, mut indices, mut near) = (Vec::with_capacity(nodes.len()), vec![], vec![]);
            for node in nodes {
                near.clear();
                near.push(node as u32);
                for row in self.rows[node]..self.rows[node + 1] {
                    for &column in pattern.row(row as usize) {
                        let other = self.places[column as usize] / components as u32;
                        // Components of a node follow each other.
                        if near.last() != Some(&other) {
                            near.push(other);
                        }
                    }
                }
                near.sort_unstable();
                near.dedup();
                indices.extend_from_slice(&near);
                ends.push(indices.len());
            }
            (ends, indices)
        });
        let (mut pointers, mut indices): (Vec<usize>, Vec<u32>) = (vec![0], vec![]);
        for (ends, of_part) in found {
            let first = indices.len();
            pointers.extend(ends.iter().map(|end| first + end));
            indices.extend(of_part);
        }
        let sets = NodeSet::in_a_row([(count, components)]);
        let sparsity = BlockSparsity::new(sets.clone(), sets, vec![vec![BlockRows::new(pointers, indices)]])?;
        let sparsity = match self.known.take() {
            Some((_, known)) if *known == sparsity => known,
            _ => Arc::new(sparsity),
        };
        self.known = Some((pattern.clone(), sparsity.clone()));
        Ok(sparsity)
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
