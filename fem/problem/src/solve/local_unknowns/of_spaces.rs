//! The unknowns of spaces that live in one cell or facet each.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::linear_algebra::Groups;
use crate::mesh::Facet;
use crate::solve::Elimination;
use crate::space::{Family, Space};

/// Where some nodes live. Facets give way to cells with which they are coupled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Home {
    Cell(u32),
    /// The first of its sides.
    Facet(Facet),
}

/// Calls `visit` with the nodes of a space that live in one cell or facet, for each of these; not at all for a space whose nodes are shared.
fn visit_local_nodes<const D: usize>(space: &Space<D>, mut visit: impl FnMut(Home, &[u32])) {
    let on_cells = matches!(space.family(), Family::Discontinuous);
    let on_facets = match space.family() {
        Family::DiscontinuousOnFacets(_) => true,
        Family::OnFacets(_) => space.degree() == 0,
        Family::Continuous | Family::Discontinuous => false,
    };
    if on_cells {
        for cell in 0..space.mesh().cell_count() {
            visit(Home::Cell(cell as u32), space.cell_nodes(cell));
        }
    }
    if on_facets {
        // The two sides of an interior facet share its nodes.
        let mut seen = vec![false; space.node_count()];
        for (facet, nodes) in &space.facets {
            if nodes.first().is_some_and(|node| !std::mem::replace(&mut seen[*node as usize], true)) {
                visit(Home::Facet(*facet), nodes);
            }
        }
    }
}

/// The groups of free unknowns of a problem on some spaces that live in one cell or facet each.
pub(in crate::solve) fn groups_of<const D: usize>(
    spaces: &[Arc<Space<D>>],
    elimination: &Elimination,
) -> Groups {
    let mut groups = Groups::default();
    let mut homes: BTreeMap<Home, Vec<u32>> = BTreeMap::new();
    let mut numbers = vec![];
    let mut offset = 0;
    for space in spaces {
        let components = space.components();
        visit_local_nodes(space, |home, nodes| {
            if numbers.is_empty() {
                numbers = numbers_of(elimination);
            }
            let unknowns = nodes.iter().flat_map(|node| {
                let first = offset + *node as usize * components;
                first..first + components
            });
            let free = unknowns.filter_map(|unknown| numbers[unknown]);
            homes.entry(home).or_default().extend(free);
        });
        offset += space.unknowns();
    }
    for (home, unknowns) in homes {
        groups.add(u8::from(matches!(home, Home::Facet(_))), unknowns);
    }
    groups
}

/// The number of each unknown among the free ones.
fn numbers_of(elimination: &Elimination) -> Vec<Option<u32>> {
    let mut numbers = vec![None; elimination.size()];
    (0..).zip(elimination.free()).for_each(|(number, unknown)| numbers[*unknown] = Some(number));
    numbers
}
