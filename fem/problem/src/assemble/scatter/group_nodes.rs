//! The nodes of a space on a group's entities, all of them or those whose functions are seen.

use std::collections::HashMap;

use forms_core::contract::Requirements;

use super::partition::Partition;
use crate::assemble::groups::{Group, GroupSide};
use crate::element::CellShape;
use crate::instantiate::instantiate;
use crate::mesh::Facet;
use crate::space::{CellNodes, Space};
use crate::threads::Threads;

/// The nodes of a space on a group's entities.
pub(in crate::assemble) struct GroupNodes<'a> {
    space: CellNodes<'a>,
    pub cells: &'a [u32],
    pub shape: CellShape,
    facet: Option<u8>,
    /// Those that are seen, entity after entity, and how many an entity has; where all are, none are listed.
    seen: Option<(Vec<u32>, usize)>,
}

impl<'a> GroupNodes<'a> {
    pub fn new<const D: usize>(space: &'a Space<D>, side: &'a GroupSide<D>) -> Self {
        let facet = side.facet.map(|(local, _)| local);
        GroupNodes { space: space.nodes_of_cells(), cells: &side.cells, shape: side.shape, facet, seen: None }
    }

    /// Only the nodes at some places among those of a cell; all where there is no list.
    pub fn at_places(mut self, places: Option<&[usize]>) -> Self {
        self.seen = places.map(|places| {
            let of_cell = |entity| {
                let nodes = self.space_nodes(entity);
                places.iter().map(move |place| nodes[*place])
            };
            ((0..self.cells.len()).flat_map(of_cell).collect(), places.len())
        });
        self
    }

    #[inline]
    fn space_nodes(&self, entity: usize) -> &'a [u32] {
        self.space.at(self.cells[entity], self.facet)
    }

    #[inline]
    pub fn of(&self, entity: usize) -> &[u32] {
        match &self.seen {
            Some((nodes, count)) => &nodes[entity * count..][..*count],
            None => self.space_nodes(entity),
        }
    }

    /// All nodes of an entity's cell; none if there is no such entity, or the space lives on facets.
    #[inline]
    pub fn of_later_cell(&self, entity: usize) -> &'a [u32] {
        self.cells.get(entity).map_or(&[], |cell| self.space.of(*cell as usize))
    }

    /// The division of the group among threads.
    pub fn partition(&self, threads: Threads) -> Partition {
        let (count, rows) = (self.cells.len(), self.space.count);
        Partition::new(count, threads, rows, |entity| self.of(entity))
    }
}

/// The part of a test or trial function that a kernel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::assemble) enum Reading {
    /// Values alone: functions that vanish on a facet are not seen there.
    Values,
    Derivatives,
}

impl Reading {
    /// The nodes of the test and of the trial functions.
    pub fn of_arguments(requirements: &Requirements) -> [Self; 2] {
        [requirements.test_derivatives, requirements.trial_derivatives]
            .map(|derivatives| if derivatives { Reading::Derivatives } else { Reading::Values })
    }
}

/// The places, among a cell's nodes, of those that a kernel sees on the facets of contact pairs. None where all count: also on other
/// entities, whose rows are known cell by cell, and on rigid surfaces, which lie anywhere in a cell.
#[inline(never)]
pub(in crate::assemble) fn seen_places<const D: usize>(
    group: &Group<D>,
    side: usize,
    space: &Space<D>,
    reading: Reading,
) -> Option<Vec<usize>> {
    group.pairs()?;
    places_on_facet(group, side, space, reading)
}

/// The places, among a cell's nodes, of those that a kernel sees on the facets of a group. None where all count.
pub(in crate::assemble) fn places_on_facet<const D: usize>(
    group: &Group<D>,
    side: usize,
    space: &Space<D>,
    reading: Reading,
) -> Option<Vec<usize>> {
    let (shape, (local, _)) = (group.sides[side].shape, group.sides[side].facet?);
    let rigid = side == 1 && group.pairs().is_some_and(|pairs| !pairs.group.rigid_normals.is_empty());
    if rigid || reading == Reading::Derivatives || space.facet_region().is_some() {
        return None;
    }
    let seen = space.element_of(shape).seen(usize::from(local));
    (seen.len() < space.element_of(shape).nodes()).then_some(seen)
}

/// The nodes of a space that a kernel sees at some facets of contact pairs, one list per facet.
pub(in crate::assemble) struct SeenAtFacets {
    starts: Vec<usize>,
    nodes: Vec<u32>,
}

impl SeenAtFacets {
    #[inline(never)]
    pub fn new<const D: usize>(
        space: &Space<D>,
        facets: &mut dyn Iterator<Item = Facet>,
        reading: Reading,
    ) -> Self {
        let mesh = &space.mesh;
        let whole = reading == Reading::Derivatives || space.facet_region().is_some();
        let mut known: HashMap<(CellShape, u8), Vec<usize>> = HashMap::new();
        let mut seen = SeenAtFacets { starts: vec![0], nodes: vec![] };
        for facet in facets {
            let nodes = space.nodes_at(facet.cell, Some(facet.local));
            if whole || nodes.is_empty() || mesh.carries(facet.cell) {
                seen.nodes.extend(nodes);
            } else {
                let shape = mesh.cell_shape(facet.cell as usize);
                let places = known
                    .entry((shape, facet.local))
                    .or_insert_with(|| space.element_of(shape).seen(usize::from(facet.local)));
                seen.nodes.extend(places.iter().map(|place| nodes[*place]));
            }
            seen.starts.push(seen.nodes.len());
        }
        seen
    }

    /// The nodes at a facet, by its place in the list.
    pub fn at(&self, index: usize) -> &[u32] {
        &self.nodes[self.starts[index]..self.starts[index + 1]]
    }
}

instantiate!(group_nodes: seen_places::<D>, SeenAtFacets::new::<D>);
