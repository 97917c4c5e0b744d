//! The sections of MSH 2.2: numbers of nodes and elements are written out in either case, elements carry their
//! tags themselves.

use super::error::{GmshError, GmshProblem};
use super::kinds;
use super::reader::{Encoding, Item, Reader};
use crate::mesh::imported::{Contents, Element, Kind, Membership, Node};

type Result<T> = std::result::Result<T, GmshError>;

// The count is written out; in binary files the data begin after its line.
fn count(reader: &mut Reader, what: &'static str, item: Item) -> Result<usize> {
    let at = reader.here();
    let count = reader.text(&format!("the number of {what}"))?;
    if reader.encoding != Encoding::Text {
        reader.line();
    }
    reader.check_count(at, what, count, item)
}

// Tags of nodes and elements are positive `int`s.
fn tag(reader: &mut Reader, expected: &str) -> Result<u64> {
    let at = reader.here();
    let value = reader.integer(expected)?;
    u64::try_from(value).map_err(|_| {
        let (expected, found) = (expected.to_owned(), value.to_string());
        reader.error_at(at, GmshProblem::Unexpected { expected, found })
    })
}

/// `$Nodes`.
pub(super) fn nodes(reader: &mut Reader, contents: &mut Contents) -> Result<()> {
    let count = count(reader, "nodes", Item { integers: 1, sizes: 0, reals: 3 })?;
    contents.nodes.reserve(count);
    for _ in 0..count {
        let at = reader.here();
        let tag = tag(reader, "a node's tag")?;
        let mut position = [0.0; 3];
        for x in &mut position {
            *x = reader.real("a coordinate")?;
        }
        contents.nodes.push(Node { tag, position, at });
    }
    Ok(())
}

/// `$Elements`.
pub(super) fn elements(reader: &mut Reader, contents: &mut Contents) -> Result<()> {
    let announced_at = reader.here();
    // A tag and a node at least; the type and the number of tags are given once per block in binary files.
    let announced = count(reader, "elements", Item { integers: 2, sizes: 0, reals: 0 })?;
    contents.elements.reserve(announced);
    while contents.elements.len() < announced {
        let at = reader.here();
        if reader.encoding == Encoding::Text {
            let tag = tag(reader, "an element's tag")?;
            let (kind, tags) = type_and_tags(reader)?;
            element(reader, contents, at, Some(tag), kind, tags)?;
            continue;
        }
        // A block: type, number of elements, number of tags of each.
        let code_at = reader.here();
        let code = reader.integer("an element type")?;
        let follow_at = reader.here();
        let follow = reader.integer("the number of elements of a block")?;
        let tags_at = reader.here();
        let tags = reader.integer("the number of tags")?;
        let kind = known(reader, code_at, code)?;
        let tags = number_of_tags(reader, tags_at, tags)?;
        let item = Item { integers: 1 + tags + kind.nodes, ..Item::default() };
        let follow = u64::try_from(follow).unwrap_or(u64::MAX);
        let follow = reader.check_count(follow_at, "elements", follow, item)?;
        let found = contents.elements.len() + follow;
        if found > announced || follow == 0 {
            let (announced, found) = (announced as u64, found as u64);
            let problem = GmshProblem::Sum { what: "elements", announced, found };
            return Err(reader.error_at(announced_at, problem));
        }
        for _ in 0..follow {
            let at = reader.here();
            element(reader, contents, at, None, kind, tags)?;
        }
    }
    Ok(())
}

fn known(reader: &Reader, at: usize, code: i64) -> Result<&'static Kind> {
    kinds::of(code).ok_or_else(|| reader.error_at(at, GmshProblem::ElementType { code }))
}

fn number_of_tags(reader: &Reader, at: usize, tags: i64) -> Result<usize> {
    let count = u64::try_from(tags).unwrap_or(u64::MAX);
    reader.check_count(at, "tags", count, Item { integers: 1, ..Item::default() })
}

fn type_and_tags(reader: &mut Reader) -> Result<(&'static Kind, usize)> {
    let at = reader.here();
    let code = reader.integer("an element type")?;
    let kind = known(reader, at, code)?;
    let at = reader.here();
    let tags = reader.integer("the number of tags")?;
    Ok((kind, number_of_tags(reader, at, tags)?))
}

// In binary files the tag has not been read yet.
fn element(
    reader: &mut Reader,
    contents: &mut Contents,
    at: usize,
    number: Option<u64>,
    kind: &'static Kind,
    tags: usize,
) -> Result<()> {
    let number = match number {
        Some(number) => number,
        None => tag(reader, "an element's tag")?,
    };
    let mut membership = Membership::default();
    let mut left = 0;
    for place in 0..tags {
        let value = reader.integer("a tag of an element")?;
        match place {
            // None is written as 0; the sign is that of an orientation.
            0 if value != 0 => membership.groups.push(value.saturating_abs()),
            0 => {}
            1 => membership.entity = value,
            2 => left = value,
            // Ghosts of other partitions have a minus sign.
            _ if left > 0 => {
                left -= 1;
                if value > 0 {
                    membership.partitions.push(value);
                }
            }
            _ => {}
        }
    }
    let membership = contents.membership_place(&membership);
    let start = contents.element_nodes.len();
    for _ in 0..kind.nodes {
        contents.element_nodes.push(tag(reader, "a node's tag")?);
    }
    contents.elements.push(Element { tag: number, kind, start, membership, at });
    Ok(())
}
