//! From a grid to what every format's reader gives: cells of known kinds, in regions.

use super::VtkReader;
use super::error::VtkProblem;
use super::grid::Grid;
use super::kinds;
use super::regions::Regions;
use crate::mesh::imported::{Contents, Element, Item, Membership, Node, Note, Words};

const WORDS: Words = Words {
    node: "point",
    element: "cell",
    unnamed: |_, number| format!("number {number}"),
    part: |region| if region < 0 { "no region".to_owned() } else { format!("region {region}") },
    advice: kinds::advice,
    bent: " (a second-order cell may bend too much, or list its points in another order than VTK's)",
    omitted: "",
};

/// A point, for a message.
pub(super) fn point(place: usize) -> Item {
    Item { what: WORDS.node, tag: place as u64 }
}

/// The contents, and a note of facets that belong to no region.
pub(super) fn contents<const D: usize>(
    grid: &Grid,
    reader: &VtkReader,
) -> Result<(Contents, Option<Note>), VtkProblem> {
    let regions = Regions::find(grid, reader)?;
    let mut contents = Contents::new(&WORDS);
    let nodes = grid.points.iter().zip(0..);
    contents.nodes = nodes.map(|(&position, tag)| Node { tag, position, at: 0 }).collect();
    let mut facets = 0;
    for (cell, &code) in grid.types.iter().enumerate() {
        let points = grid.cell(cell)?;
        let Some((kind, order)) = kinds::resolve(code, points.len(), grid.before_9) else {
            return Err(VtkProblem::CellType { cell, code, points: points.len(), advice: kinds::KNOWN });
        };
        let start = contents.element_nodes.len();
        for place in 0..points.len() {
            let point = points[order.map_or(place, |order| usize::from(order[place]))];
            let tag = u64::try_from(point).ok().filter(|&tag| tag < grid.points.len() as u64);
            let Some(tag) = tag else {
                return Err(VtkProblem::PointRange { cell, point, count: grid.points.len() });
            };
            contents.element_nodes.push(tag);
        }
        let number = regions.as_ref().map_or(-1, |regions| regions.numbers[cell]);
        let mut membership = Membership { entity: number, ..Membership::default() };
        if number >= 0 {
            membership.groups.push(number);
        }
        facets += usize::from(kind.dimension + 1 == D);
        let membership = contents.membership_place(&membership);
        contents.elements.push(Element { tag: cell as u64, kind, start, membership, at: 0 });
    }
    if let Some(regions) = &regions {
        regions.name::<D>(reader, &mut contents)?;
    }
    let untold = regions.is_none() && facets > 0;
    Ok((contents, untold.then_some(Note::FacetsLeftOut { count: facets })))
}
