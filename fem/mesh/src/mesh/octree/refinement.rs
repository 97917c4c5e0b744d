//! The mesh with some cells divided, with regions carried over.

use std::collections::{BTreeSet, HashMap};

use super::parts::facet_parts;
use super::{Divided, OctreeMesh, Origin, lies_outside};
use crate::mesh::nesting::{Nesting, Parts};
use crate::mesh::refine::{Division, key};
use crate::mesh::{Facet, Mesh, MeshError, Surface};

/// The nodes of divided cells, identified by the vertices that they lie between and their weights.
struct SharedNodes<'a, const D: usize> {
    division: &'a Division<D>,
    /// For each point of the division the node of the whole cell at that point.
    own: Vec<Option<usize>>,
    numbers: HashMap<[u64; 8], u32>,
}

impl<'a, const D: usize> SharedNodes<'a, D> {
    /// The nodes of what has been divided before: those on facets of the divided cells, which others may share.
    fn of(coarse: &OctreeMesh<D>, division: &'a Division<D>) -> Self {
        let per_cell = coarse.mesh.element_of(coarse.shape()).nodes();
        let own = division.values.chunks(per_cell).map(|values| {
            let is_one =
                |node: &usize| values.iter().enumerate().all(|(k, v)| *v == f64::from(u8::from(k == *node)));
            (0..per_cell).find(is_one)
        });
        let own = own.collect();
        let mut shared = SharedNodes { division, own, numbers: HashMap::new() };
        for (cell, origin) in coarse.origins.iter().enumerate() {
            shared.enter(&coarse.divided, *origin, coarse.mesh.cell(cell));
        }
        for (whole, origin) in coarse.divided.origins.iter().enumerate() {
            shared.enter(&coarse.divided, *origin, coarse.divided.cell(whole));
        }
        shared
    }

    /// Enters the nodes of a part of a divided cell.
    fn enter(&mut self, divided: &Divided, origin: Option<Origin>, nodes: &[u32]) {
        let Some(Origin { whole, part }) = origin else { return };
        let vertices = divided.cell(whole as usize);
        for (&point, node) in self.division.children[usize::from(part)].iter().zip(nodes) {
            let weights = &self.division.weights[point];
            let inside = weights.iter().all(|weight| *weight > 0);
            if self.own[point].is_none() && !inside {
                self.numbers.insert(key(vertices, weights), *node);
            }
        }
    }

    /// The nodes at the points of a cell's division; new ones are added to the mesh's.
    fn at_points(&mut self, whole: &[u32], nodes: &mut Vec<[f64; D]>, found: &mut Vec<u32>) {
        found.clear();
        let values = self.division.values.chunks(whole.len());
        for ((weights, values), own) in self.division.weights.iter().zip(values).zip(&self.own) {
            if let Some(own) = own {
                found.push(whole[*own]);
                continue;
            }
            found.push(*self.numbers.entry(key(whole, weights)).or_insert_with(|| {
                let terms = whole.iter().zip(values);
                nodes.push(terms.fold([0.0; D], |x, (&node, value)| {
                    let node = &nodes[node as usize];
                    std::array::from_fn(|k| x[k] + value * node[k])
                }));
                nodes.len() as u32 - 1
            }));
        }
    }
}

/// Divides cells into 2^D each.
pub(super) fn divide<const D: usize>(
    coarse: &OctreeMesh<D>,
    is_divided: &[bool],
    surfaces: &[Surface<'_, D>],
) -> Result<(OctreeMesh<D>, Nesting<D>), MeshError> {
    let (old, shape) = (&coarse.mesh, coarse.shape());
    let more = is_divided.iter().filter(|divided| **divided).count() * (1 << D);
    if u32::try_from((old.cell_count() + more) * shape.vertices()).is_err() {
        return Err(MeshError::TooLarge { what: "cells" });
    }
    let division = Division::at_vertices(&old.element_of(shape));
    let mut shared = SharedNodes::of(coarse, &division);
    let mut nodes = old.nodes.clone();
    let mut divided = coarse.divided.clone();
    let (mut cells, mut origins) = (Vec::new(), Vec::new());
    let mut parts = Parts::new(shape);
    let mut at_points = Vec::new();
    for (cell, origin) in coarse.origins.iter().enumerate() {
        parts.next_coarse();
        let whole = old.cell(cell);
        if !is_divided[cell] {
            cells.extend_from_slice(whole);
            origins.push(*origin);
            parts.add(&[]);
            continue;
        }
        shared.at_points(whole, &mut nodes, &mut at_points);
        let number = divided.count() as u32;
        divided.origins.push(*origin);
        divided.nodes.extend_from_slice(whole);
        for (part, points) in division.children.iter().enumerate() {
            cells.extend(points.iter().map(|point| at_points[*point]));
            origins.push(Some(Origin { whole: number, part: part as u8 }));
            parts.add(&[part as u8]);
        }
    }
    let nesting = parts.nesting();
    // Cells touch where those of the coarse mesh do.
    let mut mesh = Mesh::of_sound_cells(old.degree, nodes, vec![(shape, cells)])?;
    mesh.join_parts(facet_parts(&mesh, &divided, &origins));
    let small_facets = |facet: Facet| -> Vec<Facet> {
        let fine = nesting.fine_cells(facet.cell as usize);
        if fine.len() == 1 {
            return vec![Facet { cell: fine.start as u32, ..facet }];
        }
        let on_facet = (0..fine.len() as u8).filter(|part| lies_outside(shape, *part, facet.local));
        on_facet.map(|part| Facet { cell: fine.start as u32 + u32::from(part), ..facet }).collect()
    };
    if !surfaces.is_empty() {
        let nodes = moved_nodes(old, &mesh, surfaces, &small_facets)?;
        mesh.put_nodes(nodes);
        mesh.check_places()?;
    }
    let children = |cell: u32| {
        let fine = nesting.fine_cells(cell as usize);
        fine.start as u32..fine.end as u32
    };
    mesh.inherit_regions(old, &children, &small_facets)?;
    Ok((OctreeMesh { mesh, origins, divided }, nesting))
}

/// The nodes of a refined mesh, with those on surfaces where these have them: nodes that do not hang, and are new or have hung before.
fn moved_nodes<const D: usize>(
    old: &Mesh<D>,
    mesh: &Mesh<D>,
    surfaces: &[Surface<'_, D>],
    small_facets: &dyn Fn(Facet) -> Vec<Facet>,
) -> Result<Vec<[f64; D]>, MeshError> {
    let mut may_move = vec![true; mesh.node_count()];
    may_move[..old.node_count()].fill(false);
    old.nodes_on_parts().iter().for_each(|(node, ..)| may_move[*node as usize] = true);
    mesh.nodes_on_parts().iter().for_each(|(node, ..)| may_move[*node as usize] = false);
    let element = mesh.element_of(mesh.cell_shape(0));
    let on_facets: Vec<Vec<usize>> =
        (0..element.shape.facets()).map(|local| element.facet_nodes(local)).collect();
    let mut nodes = mesh.nodes.clone();
    for (region, map) in surfaces {
        let mut moved = BTreeSet::new();
        for facet in old.sides_of(region)?.iter().flatten().flat_map(|side| small_facets(*side)) {
            let of_cell = mesh.cell(facet.cell as usize);
            let on_facet = on_facets[usize::from(facet.local)].iter().map(|node| of_cell[*node] as usize);
            moved.extend(on_facet.filter(|node| may_move[*node]));
        }
        for node in moved {
            nodes[node] = map(&nodes[node]);
        }
    }
    Ok(nodes)
}
