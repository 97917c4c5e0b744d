//! The nodes of a space's cells and facets, which know no dimension: what adds to matrices is compiled once for all of them.

use super::numbering::UNNUMBERED;
use crate::mesh::{CellLists, Facet};

/// The nodes of a space's cells and facets.
#[derive(Clone, Copy)]
pub(crate) struct CellNodes<'a> {
    /// Cell after cell; none on facets.
    pub(super) nodes: &'a [u32],
    pub(super) lists: &'a CellLists,
    /// The nodes of the facets that a space on facets lives on, sorted by facet.
    pub(super) facets: Option<&'a [(Facet, Vec<u32>)]>,
    /// Whether some cells have no nodes.
    pub(super) on_some: bool,
    /// Number of nodes of the space.
    pub count: usize,
}

impl<'a> CellNodes<'a> {
    /// Nodes of a cell, in the order of the element's nodes; none for a space on facets, and outside the cells that a space is limited to.
    #[inline]
    pub fn of(self, cell: usize) -> &'a [u32] {
        if self.nodes.is_empty() {
            return &[];
        }
        let nodes = &self.nodes[self.lists.of(cell)];
        if self.on_some && nodes.first() == Some(&UNNUMBERED) { &[] } else { nodes }
    }

    /// Nodes whose basis functions live on a cell seen from one of its facets (or from inside): the cell's,
    /// or the facet's for a space on facets.
    #[inline]
    pub fn at(self, cell: u32, facet: Option<u8>) -> &'a [u32] {
        match (facet, self.facets) {
            (Some(local), Some(facets)) => {
                let facet = Facet { cell, local };
                let place = facets.binary_search_by_key(&facet, |(known, _)| *known);
                place.map_or(&[], |place| &facets[place].1)
            }
            _ => self.of(cell as usize),
        }
    }
}
