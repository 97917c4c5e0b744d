//! Which matrix entries a form can touch: nodes that an integral couples, for each pair of test and trial
//! space.

use std::convert::Infallible;
use std::sync::Arc;

use forms_core::contract::{BilinearKernel, BilinearVisitor, Form, Integral, Role, Side};

use super::AssemblyError;
use super::binding::Entities;
use crate::linear_algebra::{LinearAlgebraError, SparsityPattern};
use crate::space::Space;

/// The sparsity pattern of a matrix over the unknowns of several spaces in a row, with what is needed to
/// find the entries of a node pair.
#[derive(Clone, Debug)]
pub struct BlockPattern {
    pattern: Arc<SparsityPattern>,
    /// First row of each test space.
    row_offsets: Vec<usize>,
    /// First column of each trial space.
    column_offsets: Vec<usize>,
    /// `adjacency[test][trial]`: the nodes of the trial space that are coupled with a node.
    adjacency: Vec<Vec<Adjacency>>,
    test_components: Vec<usize>,
    trial_components: Vec<usize>,
}

/// Test and trial nodes of a cell or facet, all coupled with each other.
type Clique<'a> = (&'a [u32], &'a [u32]);

/// Neighbours of each node, in compressed rows, sorted; without pointers where there are none at all.
#[derive(Clone, Debug, Default)]
struct Adjacency {
    pointers: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    fn new(test_nodes: usize, trial_nodes: usize, cliques: &[Clique]) -> Self {
        if cliques.is_empty() {
            return Adjacency::default();
        }
        // Cliques around each test node, then the union of their trial nodes.
        let mut counts = vec![0_usize; test_nodes + 1];
        for &node in cliques.iter().flat_map(|(nodes, _)| *nodes) {
            counts[node as usize + 1] += 1;
        }
        for node in 0..test_nodes {
            counts[node + 1] += counts[node];
        }
        let mut around = vec![0_u32; counts[test_nodes]];
        let mut next = counts.clone();
        for (index, (nodes, _)) in cliques.iter().enumerate() {
            for &node in *nodes {
                around[next[node as usize]] = index as u32;
                next[node as usize] += 1;
            }
        }
        let mut pointers = vec![0];
        let mut neighbours: Vec<u32> = Vec::new();
        let mut seen_by = vec![u32::MAX; trial_nodes];
        for node in 0..test_nodes {
            let start = neighbours.len();
            for &index in &around[counts[node]..counts[node + 1]] {
                for &other in cliques[index as usize].1 {
                    if seen_by[other as usize] != node as u32 {
                        seen_by[other as usize] = node as u32;
                        neighbours.push(other);
                    }
                }
            }
            neighbours[start..].sort_unstable();
            pointers.push(neighbours.len());
        }
        Adjacency { pointers, neighbours }
    }

    fn row(&self, node: usize) -> &[u32] {
        match self.pointers.get(node..node + 2) {
            Some(range) => &self.neighbours[range[0]..range[1]],
            None => &[],
        }
    }
}

/// One kind of tangent integral: test, trial, region and sides.
type Coupling = (usize, usize, usize, Side, Side);

struct CouplingVisitor {
    found: Vec<Coupling>,
}

impl<const D: usize> BilinearVisitor<D> for CouplingVisitor {
    type Error = Infallible;

    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, _: &K) -> Result<(), Infallible> {
        let Integral { test, trial, region, test_side, trial_side, .. } = *integral;
        let coupling = (test, trial, region, test_side, trial_side);
        if !self.found.contains(&coupling) {
            self.found.push(coupling);
        }
        Ok(())
    }
}

impl BlockPattern {
    /// The pattern of a form's tangent: the nodes that its integrals couple, and nothing else. A pair of test
    /// and trial space that no integral couples has no entries; an integral over a facet region couples the
    /// nodes of the cells that own its facets, one over interior facets those of both cells.
    ///
    /// # Errors
    /// When the form has other test functions or unknowns than the spaces, a region does not exist, the
    /// spaces are not on one mesh, or the matrix is too large to be numbered.
    pub fn for_form<F: Form<D>, const D: usize>(
        form: &F,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<Self, AssemblyError> {
        let name = form.name();
        let count = |is: fn(Role) -> bool| form.fields().iter().filter(|field| is(field.role)).count();
        for (what, expected, found) in [
            ("test functions", count(|role| matches!(role, Role::Test(_))), tests.len()),
            ("unknowns", count(|role| matches!(role, Role::Unknown(_))), trials.len()),
        ] {
            if expected != found {
                return Err(AssemblyError::Count { form: name, what, expected, found });
            }
        }
        for field in form.fields() {
            let (space, first) = match field.role {
                Role::Test(number) => (tests[number], tests[0]),
                Role::Unknown(number) => (trials[number], tests[0]),
                _ => continue,
            };
            if !Arc::ptr_eq(&space.mesh, &first.mesh) {
                return Err(AssemblyError::OtherMesh { form: name, field: field.name });
            }
        }
        let mut visitor = CouplingVisitor { found: vec![] };
        match form.tangent(&mut visitor) {
            Ok(()) => {}
            Err(never) => match never {},
        }
        let mut cliques: Vec<Vec<Vec<Clique>>> = vec![vec![vec![]; trials.len()]; tests.len()];
        for (test, trial, region, test_side, trial_side) in visitor.found {
            let (rows, columns) = (tests[test], trials[trial]);
            let target = &mut cliques[test][trial];
            match Entities::of(&rows.mesh, name, &form.inputs().regions[region])? {
                Entities::Cells(cells) => {
                    let clique = |cell: &u32| (rows.nodes_at(*cell, None), columns.nodes_at(*cell, None));
                    target.extend(cells.iter().map(clique));
                }
                Entities::Facets(facets) => target.extend(facets.iter().map(|facet| {
                    let (cell, local) = (facet.cell, Some(facet.local));
                    (rows.nodes_at(cell, local), columns.nodes_at(cell, local))
                })),
                Entities::InteriorFacets(facets) => target.extend(facets.iter().map(|sides| {
                    let at = |side: Side| if side == Side::This { sides[0] } else { sides[1] };
                    let (test, trial) = (at(test_side), at(trial_side));
                    let row_nodes = rows.nodes_at(test.cell, Some(test.local));
                    (row_nodes, columns.nodes_at(trial.cell, Some(trial.local)))
                })),
            }
        }
        Self::from_cliques(tests, trials, &cliques)
            .map_err(|source| AssemblyError::LinearAlgebra { form: name, source })
    }

    /// The pattern for test and trial spaces on one mesh in which all nodes of a cell are coupled, whatever
    /// the form; with a space on facets, all nodes at each of its facets.
    ///
    /// # Errors
    /// When the matrix is too large to be numbered.
    pub fn new<const D: usize>(
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<Self, LinearAlgebraError> {
        let all = |test: &Arc<Space<D>>, trial: &Arc<Space<D>>| -> Vec<(u32, Option<u8>)> {
            match (test.facet_region(), trial.facet_region()) {
                (None, None) => (0..test.mesh.cell_count() as u32).map(|cell| (cell, None)).collect(),
                (Some(_), _) => test.facets.iter().map(|(f, _)| (f.cell, Some(f.local))).collect(),
                (None, Some(_)) => trial.facets.iter().map(|(f, _)| (f.cell, Some(f.local))).collect(),
            }
        };
        let mut cliques: Vec<Vec<Vec<Clique>>> = Vec::new();
        for test in tests {
            let mut row = Vec::new();
            for trial in trials {
                let nodes = |(cell, facet)| (test.nodes_at(cell, facet), trial.nodes_at(cell, facet));
                row.push(all(test, trial).into_iter().map(nodes).collect());
            }
            cliques.push(row);
        }
        Self::from_cliques(tests, trials, &cliques)
    }

    fn from_cliques<const D: usize>(
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
        cliques: &[Vec<Vec<Clique>>],
    ) -> Result<Self, LinearAlgebraError> {
        let mut adjacency: Vec<Vec<Adjacency>> = Vec::new();
        for (test, cliques) in tests.iter().zip(cliques) {
            let block = |(trial, cliques): (&&Arc<Space<D>>, &Vec<Clique>)| {
                Adjacency::new(test.node_count(), trial.node_count(), cliques)
            };
            adjacency.push(trials.iter().zip(cliques).map(block).collect());
        }
        let offsets = |spaces: &[&Arc<Space<D>>]| {
            let mut offsets = vec![0];
            for space in spaces {
                offsets.push(offsets[offsets.len() - 1] + space.unknowns());
            }
            offsets
        };
        let components = |spaces: &[&Arc<Space<D>>]| spaces.iter().map(|space| space.components()).collect();
        let (row_offsets, column_offsets) = (offsets(tests), offsets(trials));
        let (test_components, trial_components): (Vec<usize>, Vec<usize>) =
            (components(tests), components(trials));
        let (rows, columns) = (row_offsets[tests.len()], column_offsets[trials.len()]);
        let mut row_pointers = vec![0];
        let mut column_indices: Vec<u32> = Vec::new();
        for (test, space) in tests.iter().enumerate() {
            for node in 0..space.node_count() {
                let start = column_indices.len();
                for (trial, count) in trial_components.iter().enumerate() {
                    for &neighbour in adjacency[test][trial].row(node) {
                        let first = column_offsets[trial] + neighbour as usize * count;
                        column_indices.extend((first..first + count).map(|column| column as u32));
                    }
                }
                let end = column_indices.len();
                row_pointers.push(end);
                for _ in 1..test_components[test] {
                    column_indices.extend_from_within(start..end);
                    row_pointers.push(column_indices.len());
                }
            }
        }
        let pattern = SparsityPattern::new(rows, columns, row_pointers, column_indices)?;
        Ok(BlockPattern {
            pattern: Arc::new(pattern),
            row_offsets,
            column_offsets,
            adjacency,
            test_components,
            trial_components,
        })
    }

    /// The pattern in compressed rows.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.pattern
    }

    /// First unknown of a test space in a vector over all of them.
    pub fn row_offset(&self, test: usize) -> usize {
        self.row_offsets[test]
    }

    /// First unknown of a trial space in a vector over all of them.
    pub fn column_offset(&self, trial: usize) -> usize {
        self.column_offsets[trial]
    }

    /// Adds the block of a node pair; entries row-major, test components × trial components. `None` if the
    /// pair is not in the pattern.
    pub(super) fn add(
        &self,
        values: &mut [f64],
        (test, i): (usize, usize),
        (trial, j): (usize, usize),
        block: impl Fn(usize) -> f64,
    ) -> Option<()> {
        let (rows, columns) = (self.test_components[test], self.trial_components[trial]);
        let place = self.adjacency[test][trial].row(i).binary_search(&(j as u32)).ok()?;
        let before: usize =
            (0..trial).map(|t| self.adjacency[test][t].row(i).len() * self.trial_components[t]).sum();
        for row in 0..rows {
            let start = self.pattern.row_pointers()[self.row_offsets[test] + i * rows + row];
            let start = start + before + place * columns;
            for column in 0..columns {
                values[start + column] += block(row * columns + column);
            }
        }
        Some(())
    }
}
