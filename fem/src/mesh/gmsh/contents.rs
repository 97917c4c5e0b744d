//! What a file says, before it is a mesh; the same for both versions.

use std::collections::{BTreeMap, HashMap};

use super::kinds::Kind;

/// A file's nodes, elements and groups, under their tags.
#[derive(Default)]
pub(super) struct Contents {
    /// Names of the groups, by dimension and tag.
    pub(super) names: BTreeMap<(usize, i64), String>,
    pub(super) nodes: Vec<Node>,
    pub(super) elements: Vec<Element>,
    /// Node tags, element after element.
    pub(super) element_nodes: Vec<u64>,
    /// Different memberships; elements name them by their place.
    memberships: Vec<Membership>,
    places: HashMap<Membership, u32>,
}

pub(super) struct Node {
    pub(super) tag: u64,
    pub(super) position: [f64; 3],
    /// Where the file lists it \[bytes\].
    pub(super) at: usize,
}

pub(super) struct Element {
    pub(super) tag: u64,
    pub(super) kind: &'static Kind,
    /// Where its nodes begin in [`Contents::element_nodes`].
    pub(super) start: usize,
    pub(super) membership: u32,
    /// Where the file lists it \[bytes\].
    pub(super) at: usize,
}

/// What an element belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Membership {
    /// The geometric entity.
    pub(super) entity: i64,
    /// Tags of physical groups of the element's dimension.
    pub(super) groups: Vec<i64>,
    /// Partitions, from 1.
    pub(super) partitions: Vec<i64>,
}

impl Contents {
    pub(super) fn membership_place(&mut self, membership: &Membership) -> u32 {
        if let Some(place) = self.places.get(membership) {
            return *place;
        }
        let place = self.memberships.len() as u32;
        self.memberships.push(membership.clone());
        self.places.insert(membership.clone(), place);
        place
    }

    pub(super) fn membership(&self, element: &Element) -> &Membership {
        &self.memberships[element.membership as usize]
    }

    pub(super) fn nodes_of(&self, element: &Element) -> &[u64] {
        &self.element_nodes[element.start..element.start + element.kind.nodes]
    }

    /// The name of a group, or Gmsh's words for it if it has none.
    pub(super) fn group_name(&self, dimension: usize, tag: i64) -> String {
        let unnamed = || format!("physical {} {tag}", super::error::entity(dimension));
        self.names.get(&(dimension, tag)).cloned().unwrap_or_else(unnamed)
    }
}
