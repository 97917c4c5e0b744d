//! Content of a file, before it is a mesh.

use std::collections::{BTreeMap, HashMap};

use super::kinds::Kind;
use super::problem::Item;

/// Words of a format.
pub(in crate::mesh) struct Words {
    /// "node" or "point".
    pub(in crate::mesh) node: &'static str,
    /// "element" or "cell".
    pub(in crate::mesh) element: &'static str,
    /// The name of a group without one, by dimension and tag.
    pub(in crate::mesh) unnamed: fn(usize, i64) -> String,
    /// Name of the entities that cells belong to.
    pub(in crate::mesh) part: fn(i64) -> String,
    /// Help where a type of cell is not supported.
    pub(in crate::mesh) advice: fn(&Kind) -> &'static str,
    /// Help where a second-order cell folds.
    pub(in crate::mesh) bent: &'static str,
    /// Help where a file has groups and no cells.
    pub(in crate::mesh) omitted: &'static str,
}

/// A file's nodes, elements and groups, under their tags.
pub(in crate::mesh) struct Contents {
    pub(in crate::mesh) words: &'static Words,
    /// Names of the groups, by dimension and tag.
    pub(in crate::mesh) names: BTreeMap<(usize, i64), String>,
    pub(in crate::mesh) nodes: Vec<Node>,
    pub(in crate::mesh) elements: Vec<Element>,
    /// Node tags, element after element.
    pub(in crate::mesh) element_nodes: Vec<u64>,
    /// Different memberships; elements name them by their place.
    memberships: Vec<Membership>,
    places: HashMap<Membership, u32>,
}

pub(in crate::mesh) struct Node {
    pub(in crate::mesh) tag: u64,
    pub(in crate::mesh) position: [f64; 3],
    /// Its place in the file \[bytes\].
    pub(in crate::mesh) at: usize,
}

pub(in crate::mesh) struct Element {
    pub(in crate::mesh) tag: u64,
    pub(in crate::mesh) kind: &'static Kind,
    /// The start of its nodes in [`Contents::element_nodes`].
    pub(in crate::mesh) start: usize,
    pub(in crate::mesh) membership: u32,
    /// Its place in the file \[bytes\].
    pub(in crate::mesh) at: usize,
}

/// The entity of an element.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(in crate::mesh) struct Membership {
    /// The geometric entity.
    pub(in crate::mesh) entity: i64,
    /// Tags of physical groups of the element's dimension.
    pub(in crate::mesh) groups: Vec<i64>,
    /// Partitions, from 1.
    pub(in crate::mesh) partitions: Vec<i64>,
}

impl Contents {
    pub(in crate::mesh) fn new(words: &'static Words) -> Self {
        Contents {
            words,
            names: BTreeMap::new(),
            nodes: Vec::new(),
            elements: Vec::new(),
            element_nodes: Vec::new(),
            memberships: Vec::new(),
            places: HashMap::new(),
        }
    }

    pub(in crate::mesh) fn membership_place(&mut self, membership: &Membership) -> u32 {
        if let Some(place) = self.places.get(membership) {
            return *place;
        }
        let place = self.memberships.len() as u32;
        self.memberships.push(membership.clone());
        self.places.insert(membership.clone(), place);
        place
    }

    pub(in crate::mesh) fn membership(&self, element: &Element) -> &Membership {
        &self.memberships[element.membership as usize]
    }

    pub(in crate::mesh) fn nodes_of(&self, element: &Element) -> &[u64] {
        &self.element_nodes[element.start..element.start + element.kind.nodes]
    }

    /// Help where elements of a dimension are missing: a format may write those of groups only.
    pub(super) fn omission(&self) -> &'static str {
        let has_groups = !self.names.is_empty() || self.memberships.iter().any(|one| !one.groups.is_empty());
        if has_groups { self.words.omitted } else { "" }
    }

    /// The name of a group, or the format's words for it if it has none.
    pub(in crate::mesh) fn group_name(&self, dimension: usize, tag: i64) -> String {
        let unnamed = || (self.words.unnamed)(dimension, tag);
        self.names.get(&(dimension, tag)).cloned().unwrap_or_else(unnamed)
    }

    pub(super) fn node(&self, tag: u64) -> Item {
        Item { what: self.words.node, tag }
    }

    pub(super) fn element(&self, tag: u64) -> Item {
        Item { what: self.words.element, tag }
    }
}
