//! Numbers of the nodes of a space, and their positions.

use std::collections::HashMap;

use super::{Family, orientation};
use crate::element::Lagrange;
use crate::mesh::{CellLists, Facet, Mesh};

const UNNUMBERED: u32 = u32::MAX;

// Cells share the nodes of the vertices, edges and faces that they share; an edge or face is known by its
// sorted vertices. Numbers are given in the order of first use along the mesh's cell order.
pub(super) fn share_nodes<const D: usize>(mesh: &Mesh<D>, degree: usize, lists: &CellLists) -> Vec<u32> {
    let mut next = 0;
    let mut fresh = || {
        next += 1;
        next - 1
    };
    let mut of_vertex = vec![UNNUMBERED; mesh.node_count()];
    let mut of_entity: HashMap<[u32; 4], u32> = HashMap::new();
    let mut cell_nodes = vec![UNNUMBERED; lists.length()];
    for &cell in mesh.cell_order().cells() {
        let shape = mesh.cell_shape(cell as usize);
        let element = Lagrange { shape, degree };
        let vertices = &mesh.cell(cell as usize)[..shape.vertices()];
        let mut numbers = cell_nodes[lists.of(cell as usize)].iter_mut();
        for (&vertex, number) in vertices.iter().zip(&mut numbers) {
            let node = &mut of_vertex[vertex as usize];
            if *node == UNNUMBERED {
                *node = fresh();
            }
            *number = *node;
        }
        if element.degree == 1 {
            continue;
        }
        let mut shared = |entity: &[usize], count: usize, places: &dyn Fn(&[u32; 4]) -> Vec<usize>| {
            let mut around = [u32::MAX; 4];
            for (entry, &vertex) in around.iter_mut().zip(entity) {
                *entry = vertices[vertex];
            }
            let mut key = around;
            key.sort_unstable();
            let first = *of_entity.entry(key).or_insert_with(|| {
                let first = fresh();
                (1..count).for_each(|_| {
                    fresh();
                });
                first
            });
            if count == 1 {
                numbers.by_ref().take(1).for_each(|number| *number = first);
                return;
            }
            for (number, place) in numbers.by_ref().take(count).zip(places(&around)) {
                *number = first + place as u32;
            }
        };
        let inside_edge = element.nodes_inside_edge();
        for edge in shape.edges() {
            shared(edge, inside_edge, &|around| orientation::along_edge(element.degree, around));
        }
        let inside_face = element.nodes_inside_face();
        if shape.dimension() == 3 && inside_face > 0 {
            for local in 0..shape.facets() {
                shared(shape.facet_vertices(local), inside_face, &|around| match shape.is_simplex() {
                    true => orientation::in_triangle(element.degree, around),
                    false => orientation::in_quadrilateral(element.degree, around),
                });
            }
        }
        for centre in numbers {
            *centre = fresh();
        }
    }
    cell_nodes
}

/// Nodes of its own for each cell, numbered along the mesh's cell order.
pub(super) fn separate_nodes<const D: usize>(mesh: &Mesh<D>, lists: &CellLists) -> Vec<u32> {
    let mut cell_nodes = vec![UNNUMBERED; lists.length()];
    let mut next = 0;
    for &cell in mesh.cell_order().cells() {
        for number in &mut cell_nodes[lists.of(cell as usize)] {
            *number = next;
            next += 1;
        }
    }
    cell_nodes
}

pub(super) fn node_positions<const D: usize>(
    mesh: &Mesh<D>,
    degree: usize,
    lists: &CellLists,
    cell_nodes: &[u32],
) -> Vec<[f64; D]> {
    let count = cell_nodes.iter().max().map_or(0, |last| *last as usize + 1);
    let mut positions = vec![[0.0; D]; count];
    let mut placed = vec![false; count];
    for block in mesh.blocks() {
        let points = Lagrange { shape: block.shape, degree }.node_points::<D>();
        let tables = mesh.element_of(block.shape).tabulate(&points);
        for cell in block.cells.clone() {
            let geometry = mesh.cell(cell);
            for (q, &node) in cell_nodes[lists.of(cell)].iter().enumerate() {
                if std::mem::replace(&mut placed[node as usize], true) {
                    continue;
                }
                let phi = &tables.value[q * tables.nodes..(q + 1) * tables.nodes];
                let position = &mut positions[node as usize];
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

/// Facets with the nodes of each.
pub(super) type FacetNodes = Vec<(Facet, Vec<u32>)>;

/// The nodes of a space that lives on some facets: those of each facet in the order of
/// [`Lagrange::facet_nodes`], shared where facets share vertices, edges and faces, unless values are discontinuous; one
/// per facet in degree 0. The two sides of an interior facet share its nodes. Facets come in sorted order, positions with
/// the nodes.
pub(super) fn facet_nodes<const D: usize>(
    mesh: &Mesh<D>,
    family: &Family,
    degree: usize,
    lists: &CellLists,
    entities: &[Vec<Facet>],
) -> (FacetNodes, Vec<[f64; D]>) {
    let mut positions = Vec::new();
    let mut found = Vec::new();
    let mut walk: Vec<&Vec<Facet>> = entities.iter().collect();
    walk.sort_by_key(|sides| mesh.walk_of_facet(sides));
    if degree == 0 {
        for sides in walk {
            let node = positions.len() as u32;
            positions.push(mesh.facet_centre(sides[0]));
            found.extend(sides.iter().map(|facet| (*facet, vec![node])));
        }
    } else {
        // The numbers of the whole mesh's space, renumbered in the order of first use.
        let whole = share_nodes(mesh, degree, lists);
        let places = node_positions(mesh, degree, lists, &whole);
        let mut renumbered: HashMap<u32, u32> = HashMap::new();
        for sides in walk {
            if matches!(family, Family::DiscontinuousOnFacets(_)) {
                renumbered.clear();
            }
            for facet in sides {
                let cell = &whole[lists.of(facet.cell as usize)];
                let element = Lagrange { shape: mesh.cell_shape(facet.cell as usize), degree };
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
