//! Cells that touch without sharing a facet: cracks, hanging nodes, overlaps.

use std::collections::BTreeMap;
use std::fmt;

use super::point_tree::PointTree;
use super::{Facet, Mesh, MeshError};
use crate::element::{CellShape, PerShape};
use crate::instantiate;
use crate::locate::{Locator, nearest_on_facet};

/// Nodes and facets are at one place within this part of a facet's size: files with single precision say no more.
pub(super) const SAME_PLACE: f64 = 1e-6;

/// In thin cells no further than this part of the cell's least width: the vertices of one cell are never at one place.
const OF_WIDTH: f64 = 0.01;

/// No nearer than this part of a facet's size, where cells are so thin that widths are round-off.
const ROUND_OFF: f64 = 1e-14;

/// Cracks, hanging nodes and overlaps of a mesh. Displayed as a list.
///
/// A crack is allowed: it is how a mesh says that nothing holds the two sides together. So is a hanging node, in meshes that
/// ask for it ([`Mesh::from_nonconforming_blocks`], files); nothing holds the sides together there either. An overlap is a
/// mistake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conformity<const D: usize> {
    /// Pairs of exterior facets that coincide, their cells on opposite sides.
    pub cracks: Vec<[Facet; 2]>,
    /// Vertices on facets that do not have them.
    pub hanging_nodes: Vec<HangingNode<D>>,
    /// Two cells, where one contains the centre of the other, or of an exterior facet of the other.
    pub overlaps: Vec<Overlap<D>>,
}

/// A vertex on a facet of a cell that does not have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HangingNode<const D: usize> {
    /// Node number.
    pub node: u32,
    /// Its coordinates \[length\].
    pub position: [f64; D],
    /// The facet.
    pub facet: Facet,
}

/// Two cells with a point in common that is not on their boundaries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap<const D: usize> {
    /// The cells.
    pub cells: [u32; 2],
    /// The point \[length\].
    pub position: [f64; D],
}

/// Relations of exterior facets that touch.
pub(super) struct Touching<const D: usize> {
    pub(super) cracks: Vec<[Facet; 2]>,
    pub(super) hanging_nodes: Vec<HangingNode<D>>,
    /// The first two facets that coincide with their cells on the same side.
    pub(super) same_side: Option<[Facet; 2]>,
}

impl<const D: usize> Conformity<D> {
    /// True if cells touch only in shared facets.
    pub fn is_conforming(&self) -> bool {
        self.cracks.is_empty() && self.hanging_nodes.is_empty() && self.overlaps.is_empty()
    }
}

impl<const D: usize> Mesh<D> {
    /// Cracks, hanging nodes and overlaps: places where cells touch or overlap without sharing a facet.
    ///
    /// Cracks and hanging nodes are found among all exterior facets, hanging nodes of an [`super::OctreeMesh`] among interior ones. Overlaps are found where the centre of a cell or of an
    /// exterior facet lies in another cell, further from its boundary than round-off: cells that overlap by less than half
    /// of their size may go unseen. The work is that of finding a cell for each point.
    #[inline(never)]
    pub fn conformity(&self) -> Conformity<D> {
        let Touching { cracks, mut hanging_nodes, .. } = self.touching();
        hanging_nodes.extend(self.nodes_hanging_on_parts());
        hanging_nodes.sort_unstable_by_key(|hanging| (hanging.node, hanging.facet));
        Conformity { cracks, hanging_nodes, overlaps: self.overlaps() }
    }

    /// Check that no exterior facets coincide with their cells on the same side, and that no vertex hangs.
    pub(super) fn check_conformity(&self) -> Result<(), MeshError> {
        let touching = self.touching();
        touching.check_sides(self)?;
        match touching.hanging_nodes.first() {
            Some(hanging) => Err(MeshError::HangingNode {
                node: hanging.node as usize,
                position: hanging.position.to_vec(),
                facet: hanging.facet,
            }),
            None => Ok(()),
        }
    }

    pub(super) fn touching(&self) -> Touching<D> {
        let exterior = self.boundary_facets();
        let boxes = self.boxes_of(exterior);
        let sizes: Vec<f64> = boxes.iter().map(|(lower, upper)| distance(lower, upper)).collect();
        let tolerance = |(facet, size): (&Facet, &f64)| {
            (SAME_PLACE * size).min((OF_WIDTH * self.least_width(*facet)).max(ROUND_OFF * size))
        };
        let tolerances: Vec<f64> = exterior.iter().zip(&sizes).map(tolerance).collect();
        // The smallest facet at each vertex says what is near.
        let mut near: BTreeMap<u32, f64> = BTreeMap::new();
        for (facet, tolerance) in exterior.iter().zip(&tolerances) {
            for vertex in self.facet_vertices(*facet) {
                let least = near.entry(vertex).or_insert(f64::INFINITY);
                *least = least.min(*tolerance);
            }
        }
        let place = |vertex: u32| self.nodes[vertex as usize];
        let tree = PointTree::new(near.keys().map(|&vertex| (place(vertex), vertex)).collect());
        // The vertex with the lowest number represents all vertices at one place.
        let mut first: BTreeMap<u32, u32> = BTreeMap::new();
        for (&vertex, &tolerance) in &near {
            let (x, mut lowest) = (place(vertex), vertex);
            tree.for_each_within(&x.map(|x| x - tolerance), &x.map(|x| x + tolerance), &mut |_, other| {
                lowest = lowest.min(other);
            });
            if lowest != vertex {
                first.insert(vertex, first.get(&lowest).copied().unwrap_or(lowest));
            }
        }
        let stand_in = |vertex: u32| first.get(&vertex).copied().unwrap_or(vertex);
        let mut hanging_nodes = Vec::new();
        for (((&facet, size), &tolerance), (lower, upper)) in
            exterior.iter().zip(&sizes).zip(&tolerances).zip(&boxes)
        {
            let (lower, upper) = (lower.map(|x| x - tolerance), upper.map(|x| x + tolerance));
            let own: Vec<u32> = self.facet_vertices(facet).map(stand_in).collect();
            tree.for_each_within(&lower, &upper, &mut |position, node| {
                // Beyond the facet's end lies the next vertex of a facet that may be tiny.
                let beyond = near.get(&node).map_or(SAME_PLACE, |near| SAME_PLACE.min(near / size));
                let on_facet = || nearest_on_facet(self, facet, position, beyond);
                if !own.contains(&stand_in(node))
                    && on_facet().is_some_and(|(_, distance)| distance <= tolerance)
                {
                    hanging_nodes.push(HangingNode { node, position: *position, facet });
                }
            });
        }
        hanging_nodes.sort_unstable_by_key(|hanging: &HangingNode<D>| (hanging.node, hanging.facet));
        let (mut cracks, mut same_side) = (Vec::new(), None);
        // Facets can coincide only where all of their vertices have company.
        let shared: std::collections::BTreeSet<u32> = first.values().copied().collect();
        let places = |facet: Facet| self.facet_vertices(facet).map(stand_in).collect::<Vec<_>>();
        let mut keys: Vec<(Vec<u32>, Facet)> = Vec::new();
        for &facet in exterior {
            let mut key = places(facet);
            if key.iter().any(|vertex| shared.contains(vertex)) {
                key.sort_unstable();
                keys.push((key, facet));
            }
        }
        keys.sort_unstable();
        for group in keys.chunk_by(|a, b| a.0 == b.0) {
            for (index, (_, a)) in group.iter().enumerate() {
                for (_, b) in &group[index + 1..] {
                    let tolerance = self.facet_vertices(*a).map(|vertex| near[&vertex]).fold(0.0, f64::max);
                    let [centre, other] = [*a, *b].map(|facet| self.facet_centre(facet));
                    if distance(&centre, &other) > tolerance {
                        continue;
                    }
                    match runs_alike(&places(*a), &places(*b)) {
                        true => same_side = same_side.or(Some([*a, *b])),
                        false => cracks.push([*a, *b]),
                    }
                }
            }
        }
        cracks.sort_unstable();
        Touching { cracks, hanging_nodes, same_side }
    }

    /// The least distance between two vertices of a facet's cell, or between a vertex and the plane of the facet.
    fn least_width(&self, facet: Facet) -> f64 {
        let place = |vertex: &u32| self.nodes[*vertex as usize];
        let all: Vec<[f64; D]> = self.cell_vertices(facet.cell as usize).iter().map(place).collect();
        let on_facet: Vec<[f64; D]> = self.facet_vertices(facet).map(|vertex| place(&vertex)).collect();
        let pairs = all.iter().enumerate().flat_map(|(k, a)| all[..k].iter().map(move |b| distance(a, b)));
        let (first, last) = (on_facet[0], on_facet[on_facet.len() - 1]);
        let to = |x: &[f64; D]| -> [f64; D] { std::array::from_fn(|k| x[k] - first[k]) };
        let (s, t) = (to(&on_facet[1]), to(&last));
        let normal: [f64; D] = std::array::from_fn(|i| match (D, i) {
            (2, 0) => s[1],
            (2, _) => -s[0],
            _ => s[(i + 1) % D] * t[(i + 2) % D] - s[(i + 2) % D] * t[(i + 1) % D],
        });
        let length = distance(&normal, &[0.0; D]);
        let height = |x: &[f64; D]| -> f64 {
            to(x).iter().zip(&normal).map(|(x, n)| x * n).sum::<f64>().abs() / length
        };
        let others = all.iter().filter(|x| !on_facet.contains(x));
        pairs.chain(others.map(height)).fold(f64::INFINITY, f64::min)
    }

    fn overlaps(&self) -> Vec<Overlap<D>> {
        let locator = Locator::new(self);
        let mut found: BTreeMap<[u32; 2], [f64; D]> = BTreeMap::new();
        let mut look = |cell: u32, point: [f64; D]| {
            for other in locator.cells_around(&point, SAME_PLACE) {
                if other as u32 != cell {
                    let pair = [cell.min(other as u32), cell.max(other as u32)];
                    found.entry(pair).or_insert(point);
                }
            }
        };
        for cell in self.body_cells() {
            look(cell as u32, self.cell_centre(cell));
        }
        for &facet in self.boundary_facets() {
            look(facet.cell, self.facet_centre(facet));
        }
        found.into_iter().map(|(cells, position)| Overlap { cells, position }).collect()
    }

    /// A box around each facet: that of its Bézier points, which a quadratic facet does not leave.
    fn boxes_of(&self, facets: &[Facet]) -> Vec<([f64; D], [f64; D])> {
        let of_shape = |shape: CellShape| {
            let element = self.element_of(shape);
            (shape, (0..shape.facets()).map(|local| element.facet_nodes(local)).collect::<Vec<_>>())
        };
        let local: PerShape<_> = self.shapes().into_iter().map(of_shape).collect();
        let nodes_of = |facet: &Facet| &local[self.cell_shape(facet.cell as usize)][usize::from(facet.local)];
        facets.iter().map(|facet| self.box_of(*facet, nodes_of(facet))).collect()
    }

    fn box_of(&self, facet: Facet, local: &[usize]) -> ([f64; D], [f64; D]) {
        let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        let mut include = |x: &[f64; D]| {
            for k in 0..D {
                lower[k] = lower[k].min(x[k]);
                upper[k] = upper[k].max(x[k]);
            }
        };
        let corners: Vec<[f64; D]> =
            self.facet_vertices(facet).map(|vertex| self.nodes[vertex as usize]).collect();
        corners.iter().for_each(&mut include);
        if self.degree == 1 {
            return (lower, upper);
        }
        let nodes = self.cell(facet.cell as usize);
        let inside: Vec<[f64; D]> =
            local[corners.len()..].iter().map(|&node| self.nodes[nodes[node] as usize]).collect();
        let edges = if D == 2 { 1 } else { corners.len() };
        // m = (a + 2 c + b)/4 in the middle of an edge, and likewise in both directions of a square.
        let mut sum = [0.0; D];
        for (edge, middle) in inside[..edges].iter().enumerate() {
            let (a, b) = (corners[edge], corners[(edge + 1) % corners.len()]);
            let point: [f64; D] = std::array::from_fn(|k| 2.0 * middle[k] - 0.5 * (a[k] + b[k]));
            include(&point);
            (0..D).for_each(|k| sum[k] += 0.25 * a[k] + 0.5 * point[k]);
        }
        if let Some(centre) = inside.get(edges) {
            include(&std::array::from_fn(|k| 4.0 * centre[k] - sum[k]));
        }
        (lower, upper)
    }
}

impl<const D: usize> Touching<D> {
    /// Check that no facets coincide with their cells on the same side.
    pub(super) fn check_sides(&self, mesh: &Mesh<D>) -> Result<(), MeshError> {
        match self.same_side {
            Some(sides) => {
                let position = mesh.facet_centre(sides[0]).to_vec();
                Err(MeshError::Overlap { cells: sides.map(|facet| facet.cell), position })
            }
            None => Ok(()),
        }
    }
}

/// Whether two lists of the same vertices run around a facet in the same direction.
fn runs_alike(a: &[u32], b: &[u32]) -> bool {
    let start = b.iter().position(|vertex| *vertex == a[0]).unwrap_or(0);
    if a.len() == 2 { start == 0 } else { a[1] == b[(start + 1) % b.len()] }
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

impl<const D: usize> fmt::Display for Conformity<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_conforming() {
            return writeln!(f, "cells touch in shared facets alone");
        }
        if let Some([a, b]) = self.cracks.first() {
            writeln!(
                f,
                "pairs of facets in cracks: {}; the first between cells {} and {}",
                self.cracks.len(),
                a.cell,
                b.cell
            )?;
        }
        if let Some(HangingNode { node, position, facet }) = self.hanging_nodes.first() {
            let (count, Facet { cell, local }) = (self.hanging_nodes.len(), facet);
            writeln!(
                f,
                "hanging nodes: {count}; the first is node {node} at {position:?}, on facet {local} of cell {cell}"
            )?;
        }
        if let Some(Overlap { cells: [a, b], position }) = self.overlaps.first() {
            writeln!(
                f,
                "overlaps: {}; the first of cells {a} and {b}, at {position:?}",
                self.overlaps.len()
            )?;
        }
        Ok(())
    }
}

instantiate!(conformity: Mesh::<D>::conformity);

#[cfg(test)]
mod tests;
