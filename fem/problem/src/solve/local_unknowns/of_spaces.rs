//! The unknowns of spaces that live in one cell or facet each.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::linear_algebra::Groups;
use crate::solve::Elimination;
use crate::space::{Owner, Scope, Space};

/// The nodes of a space that live in one cell or facet each. Nodes of continuous elements inside cells are not included, because their elimination
/// would gain little: they are about as many as the others, and a factorisation eliminates them cheaply.
fn local_nodes<const D: usize>(space: &Space<D>) -> Vec<(Owner, &[u32])> {
    match space.scope().sharing() {
        Scope::Nodes => vec![],
        _ => space.local_nodes(),
    }
}

/// The groups of free unknowns of a problem on some spaces that live in one cell or facet each.
pub fn groups_of<const D: usize>(spaces: &[&Arc<Space<D>>], elimination: &Elimination) -> Groups {
    let mut groups = Groups::default();
    let mut homes: BTreeMap<Owner, Vec<u32>> = BTreeMap::new();
    let mut numbers = vec![];
    let mut offset = 0;
    for space in spaces {
        let components = space.components();
        for (home, nodes) in local_nodes(space) {
            if numbers.is_empty() {
                numbers = numbers_of(elimination);
            }
            let unknowns = nodes.iter().flat_map(|node| {
                let first = offset + *node as usize * components;
                first..first + components
            });
            let free = unknowns.filter_map(|unknown| numbers[unknown]);
            homes.entry(home).or_default().extend(free);
        }
        offset += space.unknowns();
    }
    for (home, unknowns) in homes {
        groups.add(u8::from(matches!(home, Owner::Facet(_))), unknowns);
    }
    groups
}

/// The number of each unknown among the free ones.
fn numbers_of(elimination: &Elimination) -> Vec<Option<u32>> {
    let mut numbers = vec![None; elimination.size()];
    (0..).zip(elimination.free()).for_each(|(number, unknown)| numbers[*unknown] = Some(number));
    numbers
}
