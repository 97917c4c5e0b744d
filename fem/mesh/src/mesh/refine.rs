//! Uniform refinement: every cell into 2^D, curved ones along their geometry map, regions carried over.

use std::collections::HashMap;

use super::small_matrices::determinant;
use super::{CellBlock, CellLists, Facet, Mesh, MeshError};
use crate::element::{CellShape, Lagrange, PerShape};
use crate::instantiate;

/// A region of facets and the surface that its nodes shall lie on: a map from a position near the surface to one on it.
pub type Surface<'a, const D: usize> = (&'a str, &'a dyn Fn(&[f64; D]) -> [f64; D]);

/// For [`Mesh::refined_onto`]: the point of a circle (in the plane) or sphere that is nearest, seen from its centre.
pub fn onto_sphere<const D: usize>(centre: [f64; D], radius: f64) -> impl Fn(&[f64; D]) -> [f64; D] {
    move |x| {
        let from_centre: [f64; D] = std::array::from_fn(|k| x[k] - centre[k]);
        let length = from_centre.iter().map(|x| x * x).sum::<f64>().sqrt();
        std::array::from_fn(|k| centre[k] + from_centre[k] * (radius / length))
    }
}

impl<const D: usize> Mesh<D> {
    /// The mesh with each cell divided into 2^D. The children of cell c are the cells c·2^D to (c + 1)·2^D − 1.
    ///
    /// New nodes are where the geometry map has them, so that the mesh covers the same set: quadratic cells stay
    /// curved, but come no nearer to a circle than they were; see [`Mesh::refined_onto`]. All regions are kept. Of the
    /// three ways to divide the middle of a tetrahedron the one is taken whose worst child is best.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`].
    #[inline(never)]
    pub fn refined(&self) -> Result<Self, MeshError> {
        self.refined_onto(&[])
    }

    /// The mesh of [`Mesh::refined`] where the nodes on the facets of each region are moved by its map, for example onto the
    /// circle that the region approximates. Where regions meet, their maps follow each other in the order given.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{annulus, onto_sphere};
    ///
    /// let coarse = annulus(1.0, 2.0, 1, 8, CellShape::Quadrilateral, 2)?;
    /// let fine = coarse.refined_onto(&[("outer", &onto_sphere([0.0, 0.0], 2.0))])?;
    /// assert_eq!(fine.cell_count(), 32);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Mesh::refined`]; [`MeshError::UnknownRegion`]; [`MeshError::NotFinite`] and [`MeshError::Inverted`] where a
    /// map moves nodes to infinity or through a cell.
    #[inline(never)]
    pub fn refined_onto(&self, surfaces: &[Surface<'_, D>]) -> Result<Self, MeshError> {
        self.without_rigid_surfaces("refinement")?;
        self.without_facet_parts("uniform refinement")?;
        let children = 1 << D;
        if self.cell_count().checked_mul(children).is_none_or(|count| u32::try_from(count).is_err()) {
            return Err(MeshError::TooLarge { what: "cells" });
        }
        let ways = |shape: &CellShape| {
            let element = self.element_of(*shape);
            (*shape, divisions(*shape).map(|way| Division::new(&element, way)).collect::<Vec<_>>())
        };
        let ways: PerShape<Vec<Division<D>>> = self.shapes().iter().map(ways).collect();
        let way_of = |cell: usize, chosen: u8| &ways[self.cell_shape(cell)][usize::from(chosen)];
        let chosen: Vec<u8> = (0..self.cell_count()).map(|cell| self.best_way(cell)).collect();

        let mut numbers: HashMap<[u64; 8], u32> = HashMap::with_capacity(self.node_count() * children);
        let mut nodes: Vec<[f64; D]> = Vec::with_capacity(self.node_count() * children);
        let mut cells: Vec<u32> = Vec::with_capacity(self.cells.len() * children);
        let mut of_point = Vec::new();
        for (cell, way) in chosen.iter().enumerate() {
            let way = way_of(cell, *way);
            let old = self.cell(cell);
            of_point.clear();
            for (weights, values) in way.weights.iter().zip(way.values.chunks(old.len())) {
                let number = *numbers.entry(key(old, weights)).or_insert_with(|| {
                    let terms = old.iter().zip(values);
                    nodes.push(terms.fold([0.0; D], |x, (&node, value)| {
                        let node = &self.nodes[node as usize];
                        std::array::from_fn(|k| x[k] + value * node[k])
                    }));
                    nodes.len() as u32 - 1
                });
                of_point.push(number);
            }
            cells.extend(way.children.iter().flatten().map(|&point| of_point[point]));
        }
        let small_facets = |facet: Facet| {
            let way = way_of(facet.cell as usize, chosen[facet.cell as usize]);
            way.facets[usize::from(facet.local)]
                .iter()
                .map(move |&(child, local)| Facet { cell: facet.cell * children as u32 + child, local })
        };
        let blocks: Vec<CellBlock> = self.blocks().iter().map(|block| block.divided(children)).collect();
        let lists = CellLists::new(&blocks, |shape| self.element_of(shape).nodes());
        for (region, map) in surfaces {
            let mut moved = std::collections::HashSet::new();
            for facet in self.sides_of(region)?.iter().flat_map(|sides| small_facets(sides[0])) {
                let element = self.cell_element(facet.cell as usize / children);
                let of_cell = &cells[lists.of(facet.cell as usize)];
                for node in element.facet_nodes(usize::from(facet.local)) {
                    moved.insert(of_cell[node] as usize);
                }
            }
            for node in moved {
                nodes[node] = map(&nodes[node]);
            }
        }

        let of_block = |block: &CellBlock| {
            let (first, last) = (lists.of(block.cells.start), lists.of(block.cells.end - 1));
            (block.shape, cells[first.start..last.end].to_vec())
        };
        // Cells touch where those of this mesh do.
        let mut mesh = Mesh::of_sound_cells(self.degree, nodes, blocks.iter().map(of_block).collect())?;
        let children = children as u32;
        mesh.inherit_regions(self, &|cell| cell * children..(cell + 1) * children, &|facet| {
            small_facets(facet).collect()
        })?;
        Ok(mesh)
    }

    // Which of the three ways to divide the middle of a tetrahedron gives the best worst child. The four children of the
    // middle have equal volumes, so that the sum of their squared edges tells their mean ratios apart.
    fn best_way(&self, cell: usize) -> u8 {
        let shape = self.cell_shape(cell);
        if shape != CellShape::Tetrahedron {
            return 0;
        }
        let vertices = self.cell(cell);
        let middles: Vec<[f64; D]> = shape
            .edges()
            .iter()
            .map(|edge| edge.map(|vertex| self.nodes[vertices[vertex] as usize]))
            .map(|[a, b]| std::array::from_fn(|k| a[k] + b[k]))
            .collect();
        let squared = |a: usize, b: usize| -> f64 {
            let [a, b] = [a, b].map(|node| middles[node - 4]);
            a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let badness = |child: [usize; 4]| -> f64 {
            shape.edges().iter().map(|&[a, b]| squared(child[a], child[b])).sum()
        };
        let mut best = (0, f64::INFINITY);
        for way in 0..3 {
            let worst = middle_children(way).into_iter().map(badness).fold(0.0, f64::max);
            // Where two are equal, round-off must not choose.
            if worst < best.1 * (1.0 - 1e-10) {
                best = (way as u8, worst);
            }
        }
        best.0
    }
}

/// The nodes of the quadratic tetrahedron that the diagonals of its middle, an octahedron, join.
const DIAGONALS: [[usize; 2]; 3] = [[4, 9], [5, 7], [6, 8]];

/// The four tetrahedra around one of these diagonals.
fn middle_children(way: usize) -> [[usize; 4]; 4] {
    let [[a, b], [c, e], [d, f]] = [0, 1, 2].map(|next| DIAGONALS[(way + next) % 3]);
    [[a, b, c, d], [a, b, d, e], [a, b, e, f], [a, b, f, c]]
}

/// Equal for a point as seen from all cells that share it: the vertices that it lies between, with its weights.
pub(super) fn key(nodes: &[u32], weights: &[u8]) -> [u64; 8] {
    let mut key = [u64::MAX; 8];
    for ((entry, &weight), &node) in key.iter_mut().zip(weights).zip(nodes) {
        if weight > 0 {
            *entry = u64::from(node) << 8 | u64::from(weight);
        }
    }
    key.sort_unstable();
    key
}

/// The vertices of the children, as reference points: one way for most shapes, three for a tetrahedron.
fn divisions<const D: usize>(shape: CellShape) -> impl Iterator<Item = Vec<Vec<[f64; D]>>> {
    let points = Lagrange { shape, degree: 2 }.node_points::<D>();
    let at = |nodes: &[usize]| -> Vec<[f64; D]> { nodes.iter().map(|&node| points[node]).collect() };
    let ways: Vec<Vec<Vec<[f64; D]>>> = match shape {
        CellShape::Triangle => {
            vec![[[0, 3, 5], [3, 1, 4], [5, 4, 2], [4, 5, 3]].iter().map(|child| at(child)).collect()]
        }
        CellShape::Tetrahedron => {
            let corners = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];
            let way = |way| {
                let children = corners.into_iter().chain(middle_children(way));
                children.map(|child| oriented(at(&child))).collect()
            };
            (0..3).map(way).collect()
        }
        CellShape::Quadrilateral | CellShape::Hexahedron => {
            let vertices = Lagrange { shape, degree: 1 }.node_points::<D>();
            let child = |corner: &[f64; D]| {
                let vertex = |vertex: &[f64; D]| std::array::from_fn(|k| 0.5 * (corner[k] + vertex[k]));
                vertices.iter().map(vertex).collect()
            };
            vec![vertices.iter().map(child).collect()]
        }
    };
    ways.into_iter()
}

fn oriented<const D: usize>(mut vertices: Vec<[f64; D]>) -> Vec<[f64; D]> {
    let edges: [[f64; D]; D] =
        std::array::from_fn(|k| std::array::from_fn(|i| vertices[k + 1][i] - vertices[0][i]));
    if determinant(&edges) < 0.0 {
        vertices.swap(D - 1, D);
    }
    vertices
}

/// One way to divide a cell: tables over the different nodes of its children.
pub(super) struct Division<const D: usize> {
    /// For each node, 64 times the linear basis functions of the parent there; they are whole numbers.
    pub(super) weights: Vec<Vec<u8>>,
    /// The parent's basis functions there, node after node.
    pub(super) values: Vec<f64>,
    /// For each child its nodes.
    pub(super) children: Vec<Vec<usize>>,
    /// For each facet of the parent the facets of children on it: child and local number.
    facets: Vec<Vec<(u32, u8)>>,
}

impl<const D: usize> Division<D> {
    /// The division of a quadrilateral or hexahedron: part k lies at vertex k, and has it as its own vertex k.
    pub(super) fn at_vertices(element: &Lagrange) -> Self {
        let mut ways = divisions(element.shape);
        Division::new(element, ways.next().unwrap_or_default())
    }

    fn new(element: &Lagrange, children: Vec<Vec<[f64; D]>>) -> Self {
        let shape = element.shape;
        let linear = Lagrange { shape, degree: 1 };
        let inside = linear.tabulate(&element.node_points::<D>());
        let mut points: Vec<[f64; D]> = Vec::new();
        let mut nodes_of_children = Vec::new();
        for vertices in &children {
            let mut nodes = Vec::new();
            for values in inside.value.chunks(inside.nodes) {
                let terms = vertices.iter().zip(values);
                let point: [f64; D] = terms
                    .fold([0.0; D], |x, (vertex, value)| std::array::from_fn(|k| x[k] + value * vertex[k]));
                // Quarters are exact, so that equal points have equal coordinates.
                let place = points.iter().position(|other| *other == point).unwrap_or_else(|| {
                    points.push(point);
                    points.len() - 1
                });
                nodes.push(place);
            }
            nodes_of_children.push(nodes);
        }
        let table = linear.tabulate(&points);
        let weights: Vec<Vec<u8>> = table
            .value
            .chunks(table.nodes)
            .map(|values| values.iter().map(|value| (64.0 * value) as u8).collect())
            .collect();
        // A point is on a facet where the vertices that are not weigh nothing.
        let lies_on = |point: usize, facet: &[usize]| {
            weights[point].iter().enumerate().all(|(vertex, &weight)| weight == 0 || facet.contains(&vertex))
        };
        let facets = (0..shape.facets()).map(|parent| {
            let parent = shape.facet_vertices(parent);
            let mut found = Vec::new();
            for (child, nodes) in nodes_of_children.iter().enumerate() {
                for local in 0..shape.facets() {
                    if shape.facet_vertices(local).iter().all(|&vertex| lies_on(nodes[vertex], parent)) {
                        found.push((child as u32, local as u8));
                    }
                }
            }
            found
        });
        let facets = facets.collect();
        let values = element.tabulate(&points).value;
        Division { weights, values, children: nodes_of_children, facets }
    }
}

instantiate!(refine: Mesh::<D>::refined, Mesh::<D>::refined_onto);

#[cfg(test)]
mod tests;
