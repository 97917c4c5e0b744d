//! Numbers of the nodes of a space, and their positions.

use std::collections::HashMap;

use super::{Scope, orientation};
use crate::element::{CellShape, Element, PerShape};
use crate::mesh::small_matrices::inverse;
use crate::mesh::{CellLists, Facet, Mesh};

/// The number of a node that is in no cell of the space.
pub(super) const UNNUMBERED: u32 = u32::MAX;

/// Who shares the nodes of a cell.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Sharing {
    /// All cells have the same.
    Body,
    /// Cells share the nodes of the vertices, edges and faces that they share.
    Entities,
    /// No other cell.
    Nobody,
}

/// The numbers of the nodes of each cell that is `included`, in the order of first use along the mesh's cell order. An edge or face is
/// known by its sorted vertices; the nodes inside it are numbered together.
pub(super) fn cell_numbers<const D: usize>(
    mesh: &Mesh<D>,
    elements: &PerShape<Element>,
    sharing: Sharing,
    lists: &CellLists,
    included: &dyn Fn(u32) -> bool,
) -> Vec<u32> {
    let mut next = 0;
    let mut fresh = |count: usize| {
        next += count as u32;
        next - count as u32
    };
    let shared = sharing == Sharing::Entities;
    let mut of_vertex = if shared { vec![UNNUMBERED; mesh.node_count()] } else { vec![] };
    let mut of_entity = EntityNumbers::on_vertices(of_vertex.len());
    let mut cell_nodes = vec![UNNUMBERED; lists.length()];
    let of_shape = |shape: CellShape| (shape, elements[shape].of_entity());
    let counts: PerShape<[usize; 4]> = mesh.shapes().into_iter().map(of_shape).collect();
    for &cell in mesh.cell_order().cells().iter().filter(|cell| included(**cell)) {
        let own = &mut cell_nodes[lists.of(cell as usize)];
        if !shared {
            let first = if sharing == Sharing::Body { 0 } else { fresh(own.len()) };
            own.iter_mut().zip(first..).for_each(|(number, node)| *number = node);
            continue;
        }
        let shape = mesh.cell_shape(cell as usize);
        let [of_each_vertex, inside_edge, inside_face, _] = counts[shape];
        let vertices = &mesh.cell(cell as usize)[..shape.vertices()];
        let mut numbers = own.iter_mut();
        if of_each_vertex > 0 {
            for (&vertex, number) in vertices.iter().zip(&mut numbers) {
                let node = &mut of_vertex[vertex as usize];
                if *node == UNNUMBERED {
                    *node = fresh(1);
                }
                *number = *node;
            }
        }
        let mut share = |entity: &[usize], count: usize, places: &dyn Fn(&[u32; 4]) -> Vec<usize>| {
            let mut around = [u32::MAX; 4];
            for (entry, &vertex) in around.iter_mut().zip(entity) {
                *entry = vertices[vertex];
            }
            let mut key = around;
            key.sort_unstable();
            let first = of_entity.find_or_add(key, || fresh(count));
            if count == 1 {
                numbers.by_ref().take(1).for_each(|number| *number = first);
                return;
            }
            for (number, place) in numbers.by_ref().take(count).zip(places(&around)) {
                *number = first + place as u32;
            }
        };
        // Several nodes inside an edge or a face are those of the Lagrange element with one more step along edges.
        let degree = inside_edge + 1;
        if inside_edge > 0 {
            for edge in shape.edges() {
                share(edge, inside_edge, &|around| orientation::along_edge(degree, around));
            }
        }
        if shape.dimension() == 3 && inside_face > 0 {
            for local in 0..shape.facets() {
                share(shape.facet_vertices(local), inside_face, &|around| match shape.is_simplex() {
                    true => orientation::in_triangle(degree, around),
                    false => orientation::in_quadrilateral(degree, around),
                });
            }
        }
        for inside in numbers {
            *inside = fresh(1);
        }
    }
    cell_nodes
}

/// Numbers of edges and faces, each known by its sorted vertices: in a list for each vertex that is the first one of some.
struct EntityNumbers {
    /// The last entry of each vertex's list.
    lists: Vec<u32>,
    entries: Vec<EntityNumber>,
}

struct EntityNumber {
    other_vertices: [u32; 3],
    number: u32,
    /// The entry before it in its list, or [`UNNUMBERED`].
    before: u32,
}

impl EntityNumbers {
    fn on_vertices(count: usize) -> Self {
        EntityNumbers { lists: vec![UNNUMBERED; count], entries: vec![] }
    }

    /// The number of an entity. One that is met for the first time gets a new number.
    fn find_or_add(&mut self, [first, other_vertices @ ..]: [u32; 4], new: impl FnOnce() -> u32) -> u32 {
        let list = &mut self.lists[first as usize];
        let mut place = *list;
        while let Some(entry) = self.entries.get(place as usize) {
            if entry.other_vertices == other_vertices {
                return entry.number;
            }
            place = entry.before;
        }
        let number = new();
        let before = std::mem::replace(list, self.entries.len() as u32);
        self.entries.push(EntityNumber { other_vertices, number, before });
        number
    }
}

/// Positions of the nodes of cells.
pub(super) fn node_positions<const D: usize>(
    mesh: &Mesh<D>,
    elements: &PerShape<Element>,
    lists: &CellLists,
    cell_nodes: &[u32],
) -> Vec<[f64; D]> {
    let last = cell_nodes.iter().filter(|node| **node != UNNUMBERED).max();
    let count = last.map_or(0, |last| *last as usize + 1);
    let mut positions = vec![[0.0; D]; count];
    let mut placed = vec![false; count];
    for block in mesh.blocks() {
        let element = &elements[block.shape];
        let points = element.node_points::<D>();
        let tables = mesh.element_of(block.shape).tabulate(&points);
        for cell in block.cells.clone() {
            let geometry = mesh.cell(cell);
            for (q, &node) in cell_nodes[lists.of(cell)].iter().enumerate() {
                if node == UNNUMBERED || std::mem::replace(&mut placed[node as usize], true) {
                    continue;
                }
                let position = &mut positions[node as usize];
                if element.is_in_space() {
                    *position = CellInSpace::of(mesh, cell).position(&points[q]);
                    continue;
                }
                let phi = &tables.value[q * tables.nodes..(q + 1) * tables.nodes];
                for (phi, &corner) in phi.iter().zip(geometry) {
                    for (x, corner) in position.iter_mut().zip(mesh.nodes()[corner as usize]) {
                        *x += phi * corner;
                    }
                }
            }
        }
    }
    positions
}

/// A cell's map, linearised at the centre of the reference cell: functions of the position are functions of what it is the image of.
pub(crate) struct CellInSpace<const D: usize> {
    centre: [f64; D],
    image: [f64; D],
    jacobian: [[f64; D]; D],
    inverse: [[f64; D]; D],
}

impl<const D: usize> CellInSpace<D> {
    pub fn of(mesh: &Mesh<D>, cell: usize) -> Self {
        let centre = mesh.cell_shape(cell).centre::<D>();
        let (image, jacobian) = mesh.map(cell, &centre);
        // Meshes are sound: the Jacobian is positive there.
        let inverse = inverse(&jacobian).unwrap_or([[f64::NAN; D]; D]);
        CellInSpace { centre, image, jacobian, inverse }
    }

    /// The image of a reference point.
    pub fn position(&self, reference: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|i| {
            let along = |j: usize| self.jacobian[i][j] * (reference[j] - self.centre[j]);
            self.image[i] + (0..D).map(along).sum::<f64>()
        })
    }

    /// The reference point whose image is a position.
    pub fn reference(&self, position: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|i| {
            let along = |j: usize| self.inverse[i][j] * (position[j] - self.image[j]);
            self.centre[i] + (0..D).map(along).sum::<f64>()
        })
    }

    /// The inverse of its Jacobian.
    pub fn inverse(&self) -> &[[f64; D]; D] {
        &self.inverse
    }
}

/// Facets with the nodes of each.
pub(super) type FacetNodes = Vec<(Facet, Vec<u32>)>;

/// The nodes of a space that lives on some facets: those of each facet in the order of [`Element::facet_nodes`], shared where facets share
/// vertices, edges and faces, unless each facet has its own; of elements that have no node on facets, one per facet. The two sides of
/// an interior facet share its nodes. Facets come in sorted order, positions with the nodes.
pub(super) fn facet_nodes<const D: usize>(
    mesh: &Mesh<D>,
    elements: &PerShape<Element>,
    scope: &Scope,
    lists: &CellLists,
    entities: &[Vec<Facet>],
) -> (FacetNodes, Vec<[f64; D]>) {
    let mut positions = Vec::new();
    let mut found = Vec::new();
    let mut walk: Vec<&Vec<Facet>> = entities.iter().collect();
    walk.sort_by_key(|sides| mesh.walk_of_facet(sides));
    if elements.values().all(|element| !element.has_traces()) {
        for sides in walk {
            let node = positions.len() as u32;
            positions.push(mesh.facet_centre(sides[0]));
            found.extend(sides.iter().map(|facet| (*facet, vec![node])));
        }
    } else {
        // The numbers of the whole mesh's space, renumbered in the order of first use.
        let whole = cell_numbers(mesh, elements, Sharing::Entities, lists, &|_| true);
        let places = node_positions(mesh, elements, lists, &whole);
        let mut renumbered: HashMap<u32, u32> = HashMap::new();
        for sides in walk {
            if matches!(scope, Scope::EachFacet(_)) {
                renumbered.clear();
            }
            for facet in sides {
                let cell = &whole[lists.of(facet.cell as usize)];
                let element = &elements[mesh.cell_shape(facet.cell as usize)];
                let nodes = element.facet_nodes(usize::from(facet.local)).into_iter().map(|local| {
                    *renumbered.entry(cell[local]).or_insert_with(|| {
                        positions.push(places[cell[local] as usize]);
                        positions.len() as u32 - 1
                    })
                });
                found.push((*facet, nodes.collect()));
            }
        }
    }
    found.sort_unstable();
    (found, positions)
}
