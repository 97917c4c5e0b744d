//! From a file's elements to the cells of a mesh and their regions.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};

use super::complete::{Completed, Completion};
use super::contents::{Contents, Element, Node};
use super::kinds::{Cell, Kind};
use super::plane::{check_plane, turn_clockwise_surfaces};
use super::problem::{Flaw, ImportProblem, Note, Result};
use super::tags::{Tags, check_element_tags, element_places};
use crate::element::Lagrange;
use crate::mesh::{Mesh, MeshError};

/// The mesh, and how its numbers belong to the file's tags.
pub(super) struct Cells<const D: usize> {
    pub(super) mesh: Mesh<D>,
    /// For each cell its place among the file's elements.
    pub(super) elements: Vec<usize>,
    /// For each element of dimension D its cell: several elements can be one cell, one per group (MSH 2.2).
    cell_of_element: Vec<(usize, u32)>,
    /// For each of the file's nodes its number in the mesh; `u32::MAX` where no cell uses it.
    numbers: Vec<u32>,
    /// Nodes of the mesh after the file's.
    pub(super) completed: Vec<Completed>,
    tags: Tags,
}

/// The elements that are cells, of one type or, in the plane, of two, with their places among the elements. Those of the
/// type that occurs first come first.
struct Chosen<'a> {
    kinds: Vec<(&'static Kind, &'static Cell)>,
    elements: Vec<(usize, &'a Element)>,
}

fn choose<'a>(contents: &'a Contents, dimension: usize) -> Result<Chosen<'a>> {
    let highest = contents.elements.iter().map(|element| element.kind.dimension).max().unwrap_or(0);
    if highest < 2 {
        return Err(ImportProblem::NoCells { advice: contents.omission() }.into());
    }
    let elements = contents.elements.iter().enumerate();
    let mut cells: Vec<_> = elements.filter(|(_, element)| element.kind.dimension == highest).collect();
    let first = cells[0].1;
    if highest != dimension {
        let (found, kind, element) = (highest, first.kind.name, contents.element(first.tag));
        let advice = if found < dimension { contents.omission() } else { "" };
        let problem = ImportProblem::Dimension { found, asked: dimension, element, kind, advice };
        return Err(Flaw::at(first.at, problem));
    }
    let mut kinds: Vec<(&'static Kind, &'static Cell)> = Vec::with_capacity(2);
    for (_, element) in &cells {
        let kind = element.kind;
        if kinds.iter().any(|(known, _)| known.code == kind.code) {
            continue;
        }
        // Triangles and quadrilaterals of one order make a mesh.
        let other = kinds.first().filter(|(_, known)| {
            dimension != 2
                || kind
                    .cell
                    .as_ref()
                    .is_some_and(|cell| cell.degree != known.degree || cell.shape == known.shape)
        });
        let problem = match (&kind.cell, other) {
            (Some(cell), None) => {
                kinds.push((kind, cell));
                continue;
            }
            (None, None) => {
                let (kind, advice) = (kind.name, (contents.words.advice)(kind));
                ImportProblem::Unsupported { element: contents.element(element.tag), kind, advice }
            }
            (_, Some(_)) => ImportProblem::Mixed {
                first: first.kind.name,
                first_element: contents.element(first.tag),
                second: kind.name,
                second_element: contents.element(element.tag),
            },
        };
        return Err(Flaw::at(element.at, problem));
    }
    // The order within a type stays.
    cells.sort_by_key(|(_, element)| kinds.iter().position(|(kind, _)| kind.code == element.kind.code));
    Ok(Chosen { kinds, elements: cells })
}

fn vertices(nodes: &[u32], kind: &Kind) -> [u32; 8] {
    let mut vertices = [u32::MAX; 8];
    vertices[..kind.vertices].copy_from_slice(&nodes[..kind.vertices]);
    vertices.sort_unstable();
    vertices
}

// MSH 2.2 lists a cell once for each of its groups; a cell that occurs twice otherwise is a mistake.
fn check_other_group(contents: &Contents, element: &Element, other: usize) -> Result<()> {
    let other = &contents.elements[other];
    let (groups, others) = (&contents.membership(element).groups, &contents.membership(other).groups);
    if groups.is_empty() || others.is_empty() || groups.iter().any(|group| others.contains(group)) {
        let problem = ImportProblem::SameCell {
            first: contents.element(other.tag),
            second: contents.element(element.tag),
        };
        return Err(Flaw::at(element.at, problem));
    }
    Ok(())
}

impl<const D: usize> Cells<D> {
    pub(super) fn new(contents: &Contents, notes: &mut Vec<Note>) -> Result<Self> {
        let tags = Tags::new(contents)?;
        check_element_tags(contents)?;
        let places = element_places(contents, &tags)?;
        let Chosen { kinds, elements } = choose(contents, D)?;
        let places_of = |element: &Element| &places[element.start..element.start + element.kind.nodes];

        // Elements with the same vertices are one cell.
        let mut cell_of_element = Vec::with_capacity(elements.len());
        let mut known: HashMap<[u32; 8], u32> = HashMap::with_capacity(elements.len());
        let mut again: HashMap<u32, Vec<usize>> = HashMap::new();
        let mut cells: Vec<usize> = Vec::with_capacity(elements.len());
        for &(index, element) in &elements {
            match known.entry(vertices(places_of(element), element.kind)) {
                Entry::Vacant(vacant) => {
                    vacant.insert(cells.len() as u32);
                    cell_of_element.push((index, cells.len() as u32));
                    cells.push(index);
                }
                Entry::Occupied(occupied) => {
                    let cell = *occupied.get();
                    let same = again.entry(cell).or_insert_with(|| vec![cells[cell as usize]]);
                    for &other in same.iter() {
                        check_other_group(contents, element, other)?;
                    }
                    same.push(index);
                    cell_of_element.push((index, cell));
                }
            }
        }
        drop(known);

        // Nodes that cells use, in the file's order.
        let mut numbers = vec![u32::MAX; contents.nodes.len()];
        for &cell in &cells {
            for &place in places_of(&contents.elements[cell]) {
                numbers[place as usize] = 0;
            }
        }
        let mut positions = Vec::with_capacity(numbers.len());
        let mut used = Vec::with_capacity(numbers.len());
        for (node, number) in contents.nodes.iter().zip(&mut numbers) {
            if *number == 0 {
                *number = positions.len() as u32;
                if node.position.iter().any(|x| !x.is_finite()) {
                    let problem =
                        ImportProblem::NotFinite { node: contents.node(node.tag), position: node.position };
                    return Err(Flaw::at(node.at, problem));
                }
                positions.push(std::array::from_fn(|k| node.position[k]));
                used.push(node);
            }
        }
        if D == 2 {
            check_plane(contents, &used)?;
        }
        let unused = contents.nodes.iter().zip(&numbers).filter(|(_, number)| **number == u32::MAX);
        if let Some((first, _)) = unused.clone().next() {
            notes.push(Note::UnusedNodes { count: unused.count(), first: contents.node(first.tag) });
        }

        let mut completion = Completion::default();
        let (mut blocks, mut entities) = (Vec::with_capacity(kinds.len()), Vec::with_capacity(cells.len()));
        for (kind, cell) in &kinds {
            let mut list = Vec::new();
            let elements = cells.iter().map(|&cell| &contents.elements[cell]);
            for element in elements.filter(|element| element.kind.code == kind.code) {
                let nodes = places_of(element);
                list.extend(cell.order.iter().map(|&k| numbers[nodes[usize::from(k)] as usize]));
                entities.push(contents.membership(element).entity);
            }
            if cell.order.len() < (Lagrange { shape: cell.shape, degree: cell.degree }).nodes() {
                list = completion.complete(cell.shape, &list, used.len());
            }
            blocks.push((cell.shape, list));
        }
        for added in &completion.added {
            let position = added.sum(positions.as_flattened(), D);
            positions.push(std::array::from_fn(|k| position[k]));
        }
        let degree = kinds[0].1.degree;
        if D == 2 {
            turn_clockwise_surfaces(contents, &positions, (degree, &mut blocks), &entities, notes);
        }
        let in_tags = |error| in_tags(contents, error, degree == 2, &cells, &used);
        let mesh = Mesh::of_sound_cells(degree, positions, blocks).map_err(in_tags)?;
        let touching = mesh.touching();
        touching.check_sides(&mesh).map_err(in_tags)?;
        let item = |cell: u32| contents.element(contents.elements[cells[cell as usize]].tag);
        if let Some(first) = touching.cracks.first() {
            let first = first.map(|facet| item(facet.cell));
            notes.push(Note::Cracks { count: touching.cracks.len(), first });
        }
        if let Some(first) = touching.hanging_nodes.first() {
            let (node, element) = (contents.node(used[first.node as usize].tag), item(first.facet.cell));
            notes.push(Note::HangingNodes { count: touching.hanging_nodes.len(), node, element });
        }
        Ok(Cells { mesh, elements: cells, cell_of_element, numbers, completed: completion.added, tags })
    }

    /// The number of a node in the mesh, if a cell uses it.
    pub(super) fn number(&self, tag: u64) -> Option<u32> {
        self.tags.find(tag).map(|place| self.numbers[place]).filter(|number| *number != u32::MAX)
    }

    /// For each of the mesh's nodes its place in the file's list.
    pub(super) fn nodes(&self) -> Vec<usize> {
        (0..self.numbers.len()).filter(|&place| self.numbers[place] != u32::MAX).collect()
    }

    /// Groups and partitions of cells become regions.
    pub(super) fn name_cells(&mut self, contents: &Contents) -> Result<()> {
        let mut regions: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for &(element, cell) in &self.cell_of_element {
            let membership = contents.membership(&contents.elements[element]);
            for &group in &membership.groups {
                regions.entry(contents.group_name(D, group)).or_default().push(cell);
            }
            for partition in &membership.partitions {
                regions.entry(format!("partition {partition}")).or_default().push(cell);
            }
        }
        for (name, mut cells) in regions {
            cells.sort_unstable();
            cells.dedup();
            // "all" may be named again.
            if self.mesh.cell_region(&name) != Ok(&cells) {
                self.mesh.name_listed_cells(&name, &cells)?;
            }
        }
        Ok(())
    }
}

// What a mesh says of its own numbers, said of the file's tags.
fn in_tags(contents: &Contents, error: MeshError, curved: bool, cells: &[usize], nodes: &[&Node]) -> Flaw {
    let element = |cell: usize| {
        let element = &contents.elements[cells[cell]];
        (contents.element(element.tag), element.at)
    };
    let both = |cells: [u32; 2]| {
        let [(first, _), (second, at)] = cells.map(|cell| element(cell as usize));
        ([first, second], at)
    };
    // A node that was added is in no file; those around it are named as well.
    let tag = |node: u32| nodes.get(node as usize).map_or(0, |node| node.tag);
    let tags = |vertices: Vec<u32>| -> Vec<_> {
        vertices.into_iter().map(|node| contents.node(tag(node))).collect()
    };
    match error {
        MeshError::Inverted { cell, determinant, position } => {
            let (element, at) = element(cell);
            let advice = if curved { contents.words.bent } else { "" };
            Flaw::at(at, ImportProblem::Inverted { element, determinant, position, advice })
        }
        MeshError::ShortEdge { cell, nodes: [a, b], length, longest } => {
            let (element, at) = element(cell);
            let nodes = [a, b].map(|node| contents.node(tag(node)));
            Flaw::at(at, ImportProblem::ShortEdge { element, nodes, length, longest })
        }
        MeshError::Undecided { cell, bound, position } => {
            let (element, at) = element(cell);
            Flaw::at(at, ImportProblem::Undecided { element, bound, position })
        }
        MeshError::SameSide { cells, vertices } => {
            let ([first, second], at) = both(cells);
            Flaw::at(at, ImportProblem::SameSide { first, second, nodes: tags(vertices) })
        }
        MeshError::Overlap { cells, position } => {
            let ([first, second], at) = both(cells);
            Flaw::at(at, ImportProblem::Overlap { first, second, position })
        }
        MeshError::MiddleNode { cells, nodes: [a, b], vertices } => {
            let (elements, at) = both(cells);
            let nodes = [a, b].map(|node| contents.node(tag(node)));
            Flaw::at(at, ImportProblem::MiddleNode { elements, nodes, vertices: tags(vertices) })
        }
        MeshError::SharedFacet { vertices, cells } => {
            let elements: Vec<_> = cells.into_iter().map(|cell| element(cell as usize)).collect();
            let at = elements.last().map_or(0, |(_, at)| *at);
            let elements = elements.into_iter().map(|(item, _)| item).collect();
            Flaw::at(at, ImportProblem::SharedFacet { nodes: tags(vertices), elements })
        }
        other => other.into(),
    }
}
