//! The sections of MSH 4.1: text and binary differ in the encoding of numbers only.

use std::collections::HashMap;

use super::error::{GmshError, GmshProblem};
use super::kinds;
use super::reader::{Item, Reader};
use crate::mesh::imported::{Contents, Element, Membership, Node};

type Result<T> = std::result::Result<T, GmshError>;

/// Groups and partitions of geometric entities, by dimension and tag.
#[derive(Default)]
pub(super) struct Entities {
    members: HashMap<(usize, i64), Membership>,
    /// A section with entities was there.
    pub(super) listed: bool,
}

/// An integer that can be a dimension.
fn dimension(reader: &mut Reader) -> Result<usize> {
    let at = reader.here();
    let value = reader.integer("a dimension")?;
    match usize::try_from(value) {
        Ok(dimension) if dimension <= 3 => Ok(dimension),
        _ => {
            let expected = "a dimension from 0 to 3".to_owned();
            Err(reader.error_at(at, GmshProblem::Unexpected { expected, found: value.to_string() }))
        }
    }
}

fn integers(reader: &mut Reader, what: &'static str) -> Result<Vec<i64>> {
    let count = reader.count(what, Item { integers: 1, ..Item::default() })?;
    (0..count).map(|_| reader.integer(what)).collect()
}

impl Entities {
    /// `$Entities`, or `$PartitionedEntities`, whose entities have parents and partitions.
    pub(super) fn read(&mut self, reader: &mut Reader, partitioned: bool) -> Result<()> {
        self.listed = true;
        if partitioned {
            reader.size("the number of partitions")?;
            let ghosts = reader.count("ghost entities", Item { integers: 2, ..Item::default() })?;
            for _ in 0..2 * ghosts {
                reader.integer("a ghost entity")?;
            }
        }
        let at = reader.here();
        let mut counts = [0; 4];
        for (count, what) in counts.iter_mut().zip(["points", "curves", "surfaces", "volumes"]) {
            *count = reader.size(&format!("the number of {what}"))?;
        }
        let mut found = HashMap::new();
        for (dimension, count) in counts.into_iter().enumerate() {
            let item = Item { integers: 1, sizes: 1, reals: 3 };
            let count = reader.check_count(at, "entities", count, item)?;
            for _ in 0..count {
                let at = reader.here();
                let (tag, membership) = self.entity(reader, dimension, partitioned)?;
                if found.insert((dimension, tag), membership).is_some() {
                    return Err(reader.error_at(at, GmshProblem::RepeatedEntity { dimension, tag }));
                }
            }
        }
        self.members.extend(found);
        Ok(())
    }

    fn entity(&self, reader: &mut Reader, dimension: usize, partitioned: bool) -> Result<(i64, Membership)> {
        let tag = reader.integer("an entity's tag")?;
        let mut membership = Membership { entity: tag, ..Membership::default() };
        if partitioned {
            let parent_dimension = reader.integer("the dimension of a parent entity")?;
            let parent = reader.integer("the tag of a parent entity")?;
            membership.partitions = integers(reader, "partitions")?;
            // The parts of a curve, surface or volume belong to its groups; so do partition boundaries not.
            if parent_dimension == dimension as i64
                && let Some(parent) = self.members.get(&(dimension, parent))
            {
                membership.groups.clone_from(&parent.groups);
            }
        }
        for _ in 0..if dimension == 0 { 3 } else { 6 } {
            reader.real("a coordinate")?;
        }
        // The sign is that of an orientation.
        membership.groups.extend(integers(reader, "physical groups")?.into_iter().map(i64::saturating_abs));
        membership.groups.sort_unstable();
        membership.groups.dedup();
        if dimension > 0 {
            integers(reader, "bounding entities")?;
        }
        Ok((tag, membership))
    }
}

/// `$Nodes`.
pub(super) fn nodes(reader: &mut Reader, contents: &mut Contents) -> Result<()> {
    let blocks = reader.count("blocks", Item { integers: 3, sizes: 1, reals: 0 })?;
    let announced_at = reader.here();
    let announced = reader.count("nodes", Item { integers: 0, sizes: 1, reals: 3 })?;
    for what in ["the smallest tag of a node", "the largest tag of a node"] {
        reader.size(what)?;
    }
    contents.nodes.reserve(announced);
    let mut tags = Vec::new();
    for _ in 0..blocks {
        let dimension = dimension(reader)?;
        reader.integer("an entity's tag")?;
        let parametric_at = reader.here();
        let parameters = match reader.integer("whether the nodes have parameters")? {
            0 => 0,
            1 => dimension,
            other => {
                let expected = "0 or 1 (whether the nodes have parameters)".to_owned();
                let problem = GmshProblem::Unexpected { expected, found: other.to_string() };
                return Err(reader.error_at(parametric_at, problem));
            }
        };
        let count = reader.count("nodes", Item { integers: 0, sizes: 1, reals: 3 + parameters })?;
        tags.clear();
        for _ in 0..count {
            tags.push(reader.size("a node's tag")?);
        }
        for &tag in &tags {
            let at = reader.here();
            let mut position = [0.0; 3];
            for x in &mut position {
                *x = reader.real("a coordinate")?;
            }
            for _ in 0..parameters {
                reader.real("a parameter of a node")?;
            }
            contents.nodes.push(Node { tag, position, at });
        }
    }
    check_sum(reader, announced_at, "nodes", announced, contents.nodes.len())
}

/// `$Elements`.
pub(super) fn elements(reader: &mut Reader, contents: &mut Contents, entities: &Entities) -> Result<()> {
    let blocks = reader.count("blocks", Item { integers: 3, sizes: 1, reals: 0 })?;
    let announced_at = reader.here();
    let announced = reader.count("elements", Item { integers: 0, sizes: 2, reals: 0 })?;
    for what in ["the smallest tag of an element", "the largest tag of an element"] {
        reader.size(what)?;
    }
    contents.elements.reserve(announced);
    for _ in 0..blocks {
        let at = reader.here();
        let dimension = dimension(reader)?;
        let tag = reader.integer("an entity's tag")?;
        let code_at = reader.here();
        let code = reader.integer("an element type")?;
        let kind =
            kinds::of(code).ok_or_else(|| reader.error_at(code_at, GmshProblem::ElementType { code }))?;
        if kind.dimension != dimension {
            let problem =
                GmshProblem::BlockDimension { dimension, tag, kind: kind.name, found: kind.dimension };
            return Err(reader.error_at(at, problem));
        }
        let unknown = Membership { entity: tag, ..Membership::default() };
        let membership = match entities.members.get(&(dimension, tag)) {
            Some(membership) => membership,
            None if entities.listed => {
                return Err(reader.error_at(at, GmshProblem::MissingEntity { dimension, tag }));
            }
            None => &unknown,
        };
        let membership = contents.membership_place(membership);
        let count = reader.count("elements", Item { integers: 0, sizes: 1 + kind.nodes, reals: 0 })?;
        for _ in 0..count {
            let at = reader.here();
            let tag = reader.size("an element's tag")?;
            let start = contents.element_nodes.len();
            for _ in 0..kind.nodes {
                contents.element_nodes.push(reader.size("a node's tag")?);
            }
            contents.elements.push(Element { tag, kind, start, membership, at });
        }
    }
    check_sum(reader, announced_at, "elements", announced, contents.elements.len())
}

fn check_sum(reader: &Reader, at: usize, what: &'static str, announced: usize, found: usize) -> Result<()> {
    if announced == found {
        return Ok(());
    }
    Err(reader.error_at(at, GmshProblem::Sum { what, announced: announced as u64, found: found as u64 }))
}
