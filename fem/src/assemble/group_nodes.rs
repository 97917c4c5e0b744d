//! The nodes of a space on a group's entities, all of them or those whose functions are seen.

use super::partition::Partition;
use super::walk::{Group, GroupSide};
use crate::element::{CellShape, Lagrange};
use crate::space::Space;
use crate::threads::Threads;

/// The nodes of a space on a group's entities.
pub(super) struct GroupNodes<'a, const D: usize> {
    space: &'a Space<D>,
    pub cells: &'a [u32],
    pub shape: CellShape,
    facet: Option<u8>,
    /// Those that are seen, entity after entity, and how many an entity has; where all are, none are listed.
    seen: Option<(Vec<u32>, usize)>,
}

impl<'a, const D: usize> GroupNodes<'a, D> {
    pub fn new(space: &'a Space<D>, side: &'a GroupSide<D>) -> Self {
        let facet = side.facet.map(|(local, _)| local);
        GroupNodes { space, cells: &side.cells, shape: side.shape, facet, seen: None }
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

    fn space_nodes(&self, entity: usize) -> &'a [u32] {
        self.space.nodes_at(self.cells[entity], self.facet)
    }

    pub fn of(&self, entity: usize) -> &[u32] {
        match &self.seen {
            Some((nodes, count)) => &nodes[entity * count..][..*count],
            None => self.space_nodes(entity),
        }
    }

    /// The division of the group among threads.
    pub fn partition(&self, threads: Threads) -> Partition {
        let (count, rows) = (self.cells.len(), self.space.node_count());
        Partition::new(count, threads, rows, |entity| self.of(entity))
    }
}

/// The places, among a cell's nodes, of those whose functions do not vanish on the facets of contact pairs: what a kernel sees that
/// reads values alone. None where all count: on other entities, whose rows are known cell by cell, and on rigid surfaces, which lie
/// anywhere in a cell.
#[inline(never)]
pub(super) fn places_on_facets<const D: usize>(
    group: &Group<D>,
    side: usize,
    space: &Space<D>,
) -> Option<Vec<usize>> {
    let pairs = group.pairs.as_ref()?;
    let rigid = side == 1 && !pairs.group.rigid_normals.is_empty();
    let (shape, (local, _)) = (group.sides[side].shape, group.sides[side].facet?);
    if rigid || space.facet_region().is_some() || space.degree == 0 {
        return None;
    }
    Some(Lagrange { shape, degree: space.degree }.facet_nodes(usize::from(local)))
}
