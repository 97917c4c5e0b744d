//! A file's tags: the nodes and elements that they number, each tag once.

use super::contents::Contents;
use super::problem::{Flaw, ImportProblem, Result};
use crate::mesh::MeshError;

/// Nodes by tag.
pub(super) struct Tags {
    /// Tag and place in the file's list, by tag.
    sorted: Vec<(u64, u32)>,
}

impl Tags {
    pub(super) fn new(contents: &Contents) -> Result<Self> {
        if u32::try_from(contents.nodes.len()).is_err() {
            return Err(MeshError::TooLarge { what: "nodes" }.into());
        }
        let mut sorted: Vec<_> =
            contents.nodes.iter().enumerate().map(|(place, node)| (node.tag, place as u32)).collect();
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let node = &contents.nodes[pair[1].1 as usize];
            return Err(Flaw::at(node.at, ImportProblem::Repeated { item: contents.node(node.tag) }));
        }
        Ok(Tags { sorted })
    }

    pub(super) fn find(&self, tag: u64) -> Option<usize> {
        let first = self.sorted.first()?.0;
        // Tags mostly have no gaps.
        let guess = usize::try_from(tag.checked_sub(first)?).ok().and_then(|place| self.sorted.get(place));
        let found = match guess {
            Some(entry) if entry.0 == tag => entry,
            _ => &self.sorted[self.sorted.binary_search_by_key(&tag, |entry| entry.0).ok()?],
        };
        Some(found.1 as usize)
    }
}

pub(super) fn check_element_tags(contents: &Contents) -> Result<()> {
    let mut sorted: Vec<_> = contents.elements.iter().map(|element| (element.tag, element.at)).collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(Flaw::at(pair[1].1, ImportProblem::Repeated { item: contents.element(pair[1].0) })),
        None => Ok(()),
    }
}

// For each entry of the elements' node lists, the place of the node in the file's list.
pub(super) fn element_places(contents: &Contents, tags: &Tags) -> Result<Vec<u32>> {
    let mut places = Vec::with_capacity(contents.element_nodes.len());
    for element in &contents.elements {
        let nodes = contents.nodes_of(element);
        for (position, &node) in nodes.iter().enumerate() {
            let Some(place) = tags.find(node) else {
                let problem = ImportProblem::MissingNode {
                    element: contents.element(element.tag),
                    node: contents.node(node),
                };
                return Err(Flaw::at(element.at, problem));
            };
            if nodes[..position].contains(&node) {
                let problem = ImportProblem::NodeTwice {
                    element: contents.element(element.tag),
                    node: contents.node(node),
                };
                return Err(Flaw::at(element.at, problem));
            }
            places.push(place as u32);
        }
    }
    Ok(places)
}
