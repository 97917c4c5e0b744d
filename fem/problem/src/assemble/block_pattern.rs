//! Which matrix entries a form can touch: nodes that an integral couples, for each pair of test and trial
//! space; and where element matrices go.

pub(super) mod block_index;
mod cells;
pub(super) mod element_nodes;
mod on_threads;
mod rows;
pub(super) mod sparsity;
pub(super) mod touched;

use std::sync::Arc;

use forms_core::contract::{Role, Side};

use self::block_index::{Across, BlockIndex};
use self::cells::coupled_cells;
use self::element_nodes::ElementNodes;
use self::sparsity::couple;
use super::{Assembler, AssemblyError, Parts};
use crate::assemble::binding::entities::Entities;
use crate::assemble::binding::outline::{Coupling, Outline};
use crate::assemble::binding::owned_cells::OwnedCells;
use crate::assemble::groups::pair_groups::without_coefficients;
use crate::assemble::groups::pair_search::PairSearch;
use crate::assemble::scatter::group_nodes::{Reading, SeenAtFacets};
use crate::contract::{Form, Function};
use crate::field::FieldView;
use crate::instantiate::instantiate;
use crate::linear_algebra::large_pages::room;
use crate::linear_algebra::{BlockSparsity, LinearAlgebraError, NodeSet, SparsityPattern};
use crate::space::{Scope, Space};
use crate::threads::Threads;

/// The positions of a matrix over the unknowns of several spaces in a row, with what is needed to find the blocks
/// of an element matrix.
///
/// For each pair of test and trial space the places of the blocks are looked up once: one byte (two or four in long
/// rows) per cell that takes part, test node and trial node, about one thirtieth of the matrix for vectors in three
/// dimensions. The same of the pairs of nodes on the two sides of contact pairs. Couplings across interior facets and those of spaces on
/// facets are searched for as they come.
#[derive(Debug)]
pub struct BlockPattern<const D: usize> {
    pub(super) sparsity: Arc<BlockSparsity>,
    pub(super) tests: Vec<Arc<Space<D>>>,
    pub(super) trials: Vec<Arc<Space<D>>>,
    /// `maps[test][trial]`
    maps: Vec<Vec<Option<BlockIndex>>>,
    /// The cells whose couplings it holds, where they are not all.
    pub(super) owned: Option<Arc<OwnedCells>>,
    /// Source of the contact pairs.
    pub(super) search: PairSearch<D>,
}

/// The coupling of an integral for a pair of spaces.
#[derive(Clone, Default)]
struct Coupled<'a> {
    /// Cells whose nodes are coupled with each other.
    cells: Vec<bool>,
    /// Pairs of facets whose nodes on one side are coupled with those on the other, with these nodes, list after list.
    across: Vec<Across>,
    nodes_across: Vec<(&'a [u32], &'a [u32])>,
    /// Other sets of test and trial nodes.
    others: Vec<(&'a [u32], &'a [u32])>,
}

impl<'a> Coupled<'a> {
    fn add_cell(&mut self, cell: u32, count: usize) {
        self.cells.resize(count, false);
        self.cells[cell as usize] = true;
    }

    /// The nodes that an integral sees on the two sides of contact pairs.
    fn add_pairs(
        &mut self,
        coupling: &Coupling,
        entities: &Entities,
        [rows, columns]: &'a [SeenAtFacets; 2],
    ) {
        let key = |index| Across::key(&[entities.sides(index)[0], entities.sides(index)[1]]);
        let keys: Vec<u128> = (0..entities.count()).map(key).collect();
        let (sides, reading) = (coupling.sides, Reading::of_arguments(&coupling.requirements));
        let is_known =
            |known: &Across| known.sides == sides && known.reading == reading && known.keys == keys;
        if self.across.iter().any(is_known) {
            return;
        }
        let seen = || (0..entities.count()).map(|index| (rows.at(index), columns.at(index)));
        // Solvers count on a pattern that is symmetric, and an adjoint problem has the transposed one.
        self.others.extend(seen().map(|(rows, columns)| (columns, rows)));
        if keys.is_sorted() {
            self.nodes_across.extend(seen());
            self.across.push(Across { sides, reading, keys, starts: vec![] });
        } else {
            self.others.extend(seen());
        }
    }
}

impl<const D: usize> BlockPattern<D> {
    /// The pattern of a form's tangent: the nodes that its integrals couple, and nothing else. A pair of test
    /// and trial space that no integral couples has no entries; an integral over a facet region couples the
    /// nodes of the cells that own its facets, one over interior facets those of both cells, one over contact pairs those of
    /// the cells on which the points of the compiler's estimate of the degree lie. Made on the calling thread;
    /// [`Assembler::pattern`] has several.
    ///
    /// # Errors
    /// When the form has other test functions or unknowns than the spaces, a region does not exist, surfaces cannot be paired, the
    /// spaces are not on one mesh, or the matrix is too large to be numbered.
    pub fn for_form(
        form: &Form<D>,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<Self, AssemblyError> {
        let form = Outline::of(form, Parts::ALL);
        let search = PairSearch::default();
        Self::for_cells(&form, tests, &without_coefficients(trials), (None, search), Threads::ONE)
    }

    /// The pattern of the part of a form's tangent that an assembler assembles.
    ///
    /// # Errors
    /// Those of [`Self::at_iterate`].
    #[doc(hidden)]
    pub fn for_cells_of(
        form: &Outline<D>,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
        assembler: &Assembler<D>,
    ) -> Result<Self, AssemblyError> {
        Self::at_iterate(form, tests, &without_coefficients(trials), assembler)
    }

    /// The pattern with the pairs of displaced surfaces that there are at an iterate.
    ///
    /// # Errors
    /// Those of the regions and of the search for contact pairs.
    #[doc(hidden)]
    pub fn at_iterate(
        form: &Outline<D>,
        tests: &[&Arc<Space<D>>],
        unknowns: &[FieldView<D>],
        assembler: &Assembler<D>,
    ) -> Result<Self, AssemblyError> {
        let search = PairSearch::of(assembler);
        Self::for_cells(form, tests, unknowns, (assembler.owned.as_ref(), search), assembler.threads)
    }

    /// Whether everything that a form's pairs of displaced surfaces couple at an iterate has its place.
    ///
    /// # Errors
    /// Those of the search for contact pairs.
    #[doc(hidden)]
    pub fn covers(&self, form: &Outline<D>, unknowns: &[FieldView<D>]) -> Result<bool, AssemblyError> {
        let tests: Vec<&Arc<Space<D>>> = self.tests.iter().collect();
        self.search.covers(form, &tests, unknowns, &form.couplings)
    }

    #[inline(never)]
    fn for_cells(
        form: &Outline<D>,
        tests: &[&Arc<Space<D>>],
        unknowns: &[FieldView<D>],
        (owned, mut search): (Option<&Arc<OwnedCells>>, PairSearch<D>),
        threads: Threads,
    ) -> Result<Self, AssemblyError> {
        let trials: Vec<&Arc<Space<D>>> = unknowns.iter().map(|unknown| unknown.space).collect();
        let trials = &trials[..];
        let name = form.name();
        form.check().map_err(|source| AssemblyError::Combination { source })?;
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
            if !space.mesh.is_same(&first.mesh) {
                return Err(AssemblyError::OtherMesh { form: name, field: field.name });
            }
        }
        search.slide_to(form, tests, unknowns, &form.couplings)?;
        let mut found = Vec::new();
        for &coupling in &form.couplings {
            let entities = search.entities(form, tests, trials, &coupling)?;
            let entities = OwnedCells::among(owned.map(|owned| &**owned), entities);
            let seen = coupling.seen_on_pairs(form, tests, trials, &entities);
            let across = coupling.across_opposite_facets(tests, trials, &entities, seen.as_ref());
            found.push((coupling, entities, seen, across));
        }
        let mut coupled: Vec<Vec<Coupled>> = vec![vec![Coupled::default(); trials.len()]; tests.len()];
        for (coupling, entities, seen, across) in &found {
            let Coupling { test, trial, sides: [test_side, trial_side], .. } = *coupling;
            let (rows, columns) = (tests[test], trials[trial]);
            let target = &mut coupled[test][trial];
            for [rows, columns] in across {
                target.others.push((rows, columns));
                // As of pairs, the pattern is symmetric.
                target.others.extend(seen.is_some().then_some((&columns[..], &rows[..])));
            }
            let cells = rows.mesh.cell_count();
            let on_cells = rows.facet_region().is_none() && columns.facet_region().is_none();
            if let Entities::Cells(region) = entities {
                region.iter().filter(|_| on_cells).for_each(|cell| target.add_cell(*cell, cells));
                continue;
            }
            if let (Some(seen), false) = (seen, on_cells && test_side == trial_side) {
                target.add_pairs(coupling, entities, seen);
                continue;
            }
            for index in 0..entities.count() {
                let sides = entities.sides(index);
                let at = |side: Side| if side == Side::This { sides[0] } else { sides[sides.len() - 1] };
                let (test, trial) = (at(test_side), at(trial_side));
                if on_cells && test_side == trial_side {
                    target.add_cell(test.cell, cells);
                } else {
                    let row_nodes = rows.nodes_at(test.cell, Some(test.local));
                    target.others.push((row_nodes, columns.nodes_at(trial.cell, Some(trial.local))));
                }
            }
        }
        let pattern = Self::from_coupled(tests, trials, coupled, threads)
            .map_err(|source| AssemblyError::LinearAlgebra { form: name, source })?;
        Ok(BlockPattern { owned: owned.cloned(), search, ..pattern })
    }

    /// The pattern for test and trial spaces on one mesh in which all nodes of a cell are coupled, whatever
    /// the form; with a space on facets, all nodes at each of its facets. Made on the calling thread;
    /// [`Assembler::pattern_of_spaces`] has several.
    ///
    /// # Errors
    /// When the matrix is too large to be numbered.
    pub fn new(tests: &[&Arc<Space<D>>], trials: &[&Arc<Space<D>>]) -> Result<Self, LinearAlgebraError> {
        Self::for_spaces(tests, trials, Threads::ONE)
    }

    #[inline(never)]
    fn for_spaces(
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
        threads: Threads,
    ) -> Result<Self, LinearAlgebraError> {
        let of_pair = |test: &'_ Arc<Space<D>>, trial: &'_ Arc<Space<D>>| -> Vec<(u32, u8)> {
            let facets = if test.facet_region().is_some() { &test.facets } else { &trial.facets };
            facets.iter().map(|(facet, _)| (facet.cell, facet.local)).collect()
        };
        let mut coupled: Vec<Vec<Coupled>> = Vec::new();
        for test in tests {
            let mut row = Vec::new();
            for trial in trials {
                let mut pair = Coupled::default();
                if test.facet_region().is_none() && trial.facet_region().is_none() {
                    pair.cells = vec![true; test.mesh.cell_count()];
                } else {
                    let nodes =
                        |(cell, local)| (test.nodes_at(cell, Some(local)), trial.nodes_at(cell, Some(local)));
                    pair.others = of_pair(test, trial).into_iter().map(nodes).collect();
                }
                row.push(pair);
            }
            coupled.push(row);
        }
        Self::from_coupled(tests, trials, coupled, threads)
    }

    #[inline(never)]
    fn from_coupled(
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
        coupled: Vec<Vec<Coupled>>,
        threads: Threads,
    ) -> Result<Self, LinearAlgebraError> {
        let (mut pairs, mut maps) = (Vec::new(), Vec::new());
        let cells = coupled_cells(tests, trials, &coupled);
        for (test, coupled) in tests.iter().zip(coupled) {
            let (mut row_of_pairs, mut row_of_maps) = (Vec::new(), Vec::new());
            for (trial, Coupled { cells, mut across, nodes_across, others }) in trials.iter().zip(coupled) {
                let order = test.mesh.cell_order();
                let limited = [test, trial].map(|space| matches!(space.scope(), Scope::Within(..)));
                let has_nodes = |cell: usize| {
                    limited == [false; 2]
                        || !(test.cell_nodes(cell).is_empty() || trial.cell_nodes(cell).is_empty())
                };
                let takes_part = |cell: &&u32| {
                    cells.get(**cell as usize).is_some_and(|found| *found) && has_nodes(**cell as usize)
                };
                let walked: Vec<u32> = order.cells().iter().filter(takes_part).copied().collect();
                let parts = test.mesh.by_shape(walked);
                let (mut walk, mut starts, mut start) = (Vec::new(), Vec::new(), 0);
                for (shape, cells_of_shape) in parts.iter().filter(|(_, own)| !own.is_empty()) {
                    walk.resize(cells.len(), BlockIndex::ABSENT);
                    for (place, cell) in cells_of_shape.iter().enumerate() {
                        walk[*cell as usize] = place as u32;
                    }
                    starts.push((*shape, start));
                    let per_cell = test.element_of(*shape).nodes() * trial.element_of(*shape).nodes();
                    start += cells_of_shape.len() * per_cell;
                }
                let mut sizes = nodes_across.iter().map(|(rows, columns)| rows.len() * columns.len());
                for list in &mut across {
                    list.starts.push(start);
                    for size in sizes.by_ref().take(list.keys.len()) {
                        start += size;
                        list.starts.push(start);
                    }
                }
                let walked: Vec<u32> = parts.into_iter().flat_map(|(_, cells)| cells).collect();
                let nodes = |cell: &u32| (test.cell_nodes(*cell as usize), trial.cell_nodes(*cell as usize));
                let mapped = walked.len() + nodes_across.len();
                let count = mapped + others.len();
                let mut cliques = ElementNodes { rows: room(count), columns: room(count) };
                for (rows, columns) in walked.iter().map(nodes).chain(nodes_across).chain(others) {
                    cliques.rows.push(rows);
                    cliques.columns.push(columns);
                }
                let nodes = (test.node_count(), trial.node_count());
                let (blocks, places) = couple(&cliques, nodes, mapped, threads);
                row_of_pairs.push(blocks);
                row_of_maps.push((mapped > 0).then_some(BlockIndex { places, starts, walk, across }));
            }
            pairs.push(row_of_pairs);
            maps.push(row_of_maps);
        }
        let sets = |spaces: &[&Arc<Space<D>>]| {
            NodeSet::in_a_row(spaces.iter().map(|space| (space.node_count(), space.components())))
        };
        let sparsity = BlockSparsity::of_checked(sets(tests), sets(trials), pairs)?;
        let sparsity = match cells {
            Some(cells) => sparsity.with_cells_made_by(move || cells.make()),
            None => sparsity,
        };
        let sparsity = Arc::new(sparsity);
        let owned = |spaces: &[&Arc<Space<D>>]| spaces.iter().map(|space| Arc::clone(space)).collect();
        Ok(BlockPattern {
            sparsity,
            tests: owned(tests),
            trials: owned(trials),
            maps,
            owned: None,
            search: PairSearch::default(),
        })
    }

    /// The positions of the blocks, which matrices share.
    pub fn sparsity(&self) -> &Arc<BlockSparsity> {
        &self.sparsity
    }

    /// The positions of all entries in compressed rows; made at the first call.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        self.sparsity.pattern()
    }

    /// First unknown of a test space in a vector over all of them.
    pub fn row_offset(&self, test: usize) -> usize {
        self.sparsity.row_sets()[test].offset
    }

    /// First unknown of a trial space in a vector over all of them.
    pub fn column_offset(&self, trial: usize) -> usize {
        self.sparsity.column_sets()[trial].offset
    }

    /// Bytes of the maps from element matrices to the matrix, without the positions themselves
    /// ([`BlockSparsity::memory`]).
    pub fn map_memory(&self) -> usize {
        self.maps.iter().flatten().flatten().map(BlockIndex::memory).sum()
    }

    /// The places of the blocks of cells for a pair of spaces.
    pub(super) fn map(&self, test: usize, trial: usize) -> Option<&BlockIndex> {
        self.maps[test][trial].as_ref()
    }

    /// Checks that the pattern was made for these spaces, or for some that number their unknowns alike.
    #[inline(never)]
    pub(super) fn check(
        &self,
        form: &Function<D>,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<(), AssemblyError> {
        let what = "positions of the matrix";
        for (own, given, role) in
            [(&self.tests, tests, Role::Test as fn(usize) -> Role), (&self.trials, trials, Role::Unknown)]
        {
            if own.len() != given.len() {
                let (expected, found) = (given.len(), own.len());
                return Err(AssemblyError::Count { form: form.name(), what: "spaces", expected, found });
            }
            if let Some(number) = own.iter().zip(given).position(|(own, given)| !own.numbers_as(given)) {
                let field = form.name_of(role(number));
                return Err(AssemblyError::OtherSpace { form: form.name(), field, what });
            }
        }
        Ok(())
    }
}

instantiate!(
    block_pattern:
    BlockPattern::<D>::for_spaces,
    BlockPattern::<D>::for_cells,
    BlockPattern::<D>::check,
    PairSearch::<D>::covers
);
