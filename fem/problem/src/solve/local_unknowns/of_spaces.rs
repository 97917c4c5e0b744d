//! The unknowns of spaces that live in one cell or facet each.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::element::Elements;
use crate::linear_algebra::{Groups, MultiplierNode};
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
    multiplier_nodes(spaces, elimination).into_iter().for_each(|node| groups.add_multipliers(node));
    groups
}

/// The free multipliers at each node of dual elements of degree 1, and the free displacements of degree 1 on which they act.
fn multiplier_nodes<const D: usize>(
    spaces: &[&Arc<Space<D>>],
    elimination: &Elimination,
) -> Vec<MultiplierNode> {
    let acts =
        |space: &&&Arc<Space<D>>| *space.elements() == Elements::Lagrange(1) && space.components() == D;
    let Some(place) = spaces.iter().position(|space| acts(&space) && space.displaces()) else {
        return vec![];
    };
    let first = |place: usize| spaces[..place].iter().map(|space| space.unknowns()).sum::<usize>();
    let displacements = spaces[place];
    let mut nodes: BTreeMap<(&str, u32), MultiplierNode> = BTreeMap::new();
    let mut numbers = vec![];
    for (number, space) in spaces.iter().enumerate() {
        let Some(region) = space.facet_region().filter(|_| *space.elements() == Elements::Dual) else {
            continue;
        };
        let Ok(facets) = space.mesh().facet_region(region) else { continue };
        if numbers.is_empty() {
            numbers = numbers_of(elimination);
        }
        let free = |first: usize, node: u32, components: usize| {
            let first = first + node as usize * components;
            (first..first + components).filter_map(|unknown| numbers[unknown]).collect::<Vec<u32>>()
        };
        let mut known = BTreeSet::new();
        for facet in facets {
            let cell = facet.cell as usize;
            let local = displacements.cell_element(cell).facet_nodes(usize::from(facet.local));
            for multiplier in space.nodes_at(facet.cell, Some(facet.local)) {
                if !known.insert(*multiplier) {
                    continue;
                }
                let of_node = nodes.entry((region, *multiplier)).or_default();
                of_node.unknowns.extend(free(first(number), *multiplier, space.components()));
                let at = space.positions()[*multiplier as usize];
                let apart = |node: &u32| {
                    let other = &displacements.positions()[*node as usize];
                    at.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
                };
                let there = local.iter().map(|node| displacements.cell_nodes(cell)[*node]);
                let nearest = there.min_by(|a, b| apart(a).total_cmp(&apart(b)));
                of_node.balances = nearest.map(|node| free(first(place), node, D)).unwrap_or_default();
            }
        }
    }
    nodes.into_values().filter(|node| !node.unknowns.is_empty() && !node.balances.is_empty()).collect()
}

/// The number of each unknown among the free ones.
fn numbers_of(elimination: &Elimination) -> Vec<Option<u32>> {
    let mut numbers = vec![None; elimination.size()];
    (0..).zip(elimination.free()).for_each(|(number, unknown)| numbers[*unknown] = Some(number));
    numbers
}
