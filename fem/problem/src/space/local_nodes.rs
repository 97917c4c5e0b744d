//! Nodes whose functions live on one cell or facet only: their unknowns can be eliminated group by group.

use super::numbering::UNNUMBERED;
use super::{Scope, Space};
use crate::mesh::Facet;

/// The cell or facet on which the functions of a group of nodes live.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Owner {
    /// A cell.
    Cell(u32),
    /// A facet of a space on facets; of an interior one its first side.
    Facet(Facet),
}

impl<const D: usize> Space<D> {
    /// Groups of nodes whose functions vanish outside of one cell, or that are the coefficients of one facet, in the order of
    /// cells or facets: all nodes where each cell or facet has coefficients of its own, and of continuous elements those inside the
    /// cells. Cells and facets without such nodes are left out.
    pub fn local_nodes(&self) -> Vec<(Owner, &[u32])> {
        let cells = || (0..self.mesh.cell_count()).map(|cell| (cell, self.cell_nodes(cell)));
        match self.scope.sharing() {
            Scope::Body => vec![],
            Scope::Nodes => {
                let inside = |(cell, nodes): (usize, &'_ [u32])| {
                    let count = self.cell_element(cell).of_entity()[D].min(nodes.len());
                    (cell, nodes.len() - count..nodes.len())
                };
                let own = cells().map(|(cell, nodes)| {
                    let (cell, inside) = inside((cell, nodes));
                    (Owner::Cell(cell as u32), &nodes[inside])
                });
                own.filter(|(_, nodes)| !nodes.is_empty()).collect()
            }
            Scope::Cell | Scope::Point | Scope::Within(..) => {
                let own = cells().map(|(cell, nodes)| (Owner::Cell(cell as u32), nodes));
                own.filter(|(_, nodes)| !nodes.is_empty()).collect()
            }
            Scope::Facets(_) if !self.is_constant() => vec![],
            Scope::Facets(_) | Scope::EachFacet(_) => {
                let mut owner = vec![UNNUMBERED; self.node_count()];
                let first = |(index, (facet, nodes)): (usize, &'_ (Facet, Vec<u32>))| {
                    let known = &mut owner[nodes[0] as usize];
                    let is_first = *known == UNNUMBERED;
                    *known = index as u32;
                    is_first.then_some((Owner::Facet(*facet), index))
                };
                let firsts: Vec<_> = self.facets.iter().enumerate().filter_map(first).collect();
                firsts.into_iter().map(|(owner, index)| (owner, &self.facets[index].1[..])).collect()
            }
        }
    }
}
