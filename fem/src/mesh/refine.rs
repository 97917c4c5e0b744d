//! Uniform refinement: every cell into 2^D, curved ones along their geometry map, regions carried over.

use std::collections::HashMap;

use super::geometry::determinant;
use super::{BOUNDARY, EVERYWHERE, Facet, INTERIOR, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};

/// A region of facets and the surface that its nodes shall lie on: a map from a position near the surface to one on it.
pub type Surface<'a, const D: usize> = (&'a str, &'a dyn Fn(&[f64; D]) -> [f64; D]);

impl<const D: usize> Mesh<D> {
    /// The mesh with each cell divided into 2^D. The children of cell c are the cells c·2^D to (c + 1)·2^D − 1.
    ///
    /// New nodes stand where the geometry map has them, so that the mesh covers the same set: quadratic cells stay
    /// curved, but come no nearer to a circle than they were; see [`Mesh::refined_onto`]. All regions are kept. Of the
    /// three ways to divide the middle of a tetrahedron the one is taken whose worst child is best.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`].
    pub fn refined(&self) -> Result<Self, MeshError> {
        self.refined_onto(&[])
    }

    /// As [`Mesh::refined`], and then the nodes on the facets of each region are moved by its map, for example onto the
    /// circle that the region stands for. Where regions meet, their maps follow each other in the order given.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let coarse = annulus(1.0, 2.0, 1, 8, CellShape::Quadrilateral, 2)?;
    /// let onto_circle = |x: &[f64; 2]| x.map(|coordinate| coordinate * 2.0 / x[0].hypot(x[1]));
    /// let fine = coarse.refined_onto(&[("outer", &onto_circle)])?;
    /// assert_eq!(fine.cell_count(), 32);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Mesh::refined`]; [`MeshError::UnknownRegion`]; [`MeshError::NotFinite`] and [`MeshError::Inverted`] where a
    /// map moves nodes to infinity or through a cell.
    pub fn refined_onto(&self, surfaces: &[Surface<'_, D>]) -> Result<Self, MeshError> {
        let children = 1 << D;
        if self.cell_count().checked_mul(children).is_none_or(|count| u32::try_from(count).is_err()) {
            return Err(MeshError::TooLarge { what: "cells" });
        }
        let element = self.element();
        let ways: Vec<Division<D>> = divisions(self.shape).map(|way| Division::new(&element, way)).collect();
        let chosen: Vec<u8> = (0..self.cell_count()).map(|cell| self.best_way(cell)).collect();

        let mut numbers: HashMap<[u64; 8], u32> = HashMap::with_capacity(self.node_count() * children);
        let mut nodes: Vec<[f64; D]> = Vec::with_capacity(self.node_count() * children);
        let mut cells: Vec<u32> = Vec::with_capacity(self.cells.len() * children);
        let mut of_point = Vec::new();
        for (cell, way) in chosen.iter().enumerate() {
            let way = &ways[usize::from(*way)];
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
            let way = &ways[usize::from(chosen[facet.cell as usize])];
            way.facets[usize::from(facet.local)]
                .iter()
                .map(move |&(child, local)| Facet { cell: facet.cell * children as u32 + child, local })
        };
        for (region, map) in surfaces {
            let mut moved = std::collections::HashSet::new();
            for facet in self.sides_of(region)?.iter().flat_map(|sides| small_facets(sides[0])) {
                let start = facet.cell as usize * element.nodes();
                for node in element.facet_nodes(usize::from(facet.local)) {
                    moved.insert(cells[start + node] as usize);
                }
            }
            for node in moved {
                nodes[node] = map(&nodes[node]);
            }
        }

        let mut mesh = Mesh::from_parts(self.shape, self.degree, nodes, cells)?;
        for (name, cells) in self.cell_regions.iter().filter(|(name, _)| *name != EVERYWHERE) {
            let children = children as u32;
            let cells: Vec<u32> =
                cells.iter().flat_map(|cell| cell * children..(cell + 1) * children).collect();
            mesh.name_listed_cells(name, &cells)?;
        }
        for (name, facets) in self.facet_regions.iter().filter(|(name, _)| *name != BOUNDARY) {
            let facets: Vec<Facet> = facets.iter().flat_map(|facet| small_facets(*facet)).collect();
            mesh.name_listed_facets(name, &facets)?;
        }
        for (name, facets) in self.interior_regions.iter().filter(|(name, _)| *name != INTERIOR) {
            let facets: Vec<Facet> = facets.iter().flat_map(|sides| small_facets(sides[0])).collect();
            mesh.name_listed_interior_facets(name, &facets)?;
        }
        Ok(mesh)
    }

    // Which of the three ways to divide the middle of a tetrahedron gives the best worst child. The four children of the
    // middle have equal volumes, so that the sum of their squared edges tells their mean ratios apart.
    fn best_way(&self, cell: usize) -> u8 {
        if self.shape != CellShape::Tetrahedron {
            return 0;
        }
        let vertices = self.cell(cell);
        let middles: Vec<[f64; D]> = self
            .shape
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
            self.shape.edges().iter().map(|&[a, b]| squared(child[a], child[b])).sum()
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
fn key(nodes: &[u32], weights: &[u8]) -> [u64; 8] {
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
struct Division<const D: usize> {
    /// For each node, 64 times the linear basis functions of the parent there; they are whole numbers.
    weights: Vec<Vec<u8>>,
    /// The parent's basis functions there, node after node.
    values: Vec<f64>,
    /// For each child its nodes.
    children: Vec<Vec<usize>>,
    /// For each facet of the parent the facets of children on it: child and local number.
    facets: Vec<Vec<(u32, u8)>>,
}

impl<const D: usize> Division<D> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::geometry::inverse;
    use crate::mesh::measures::{close, surface, volume};
    use crate::mesh::{annulus, cuboid, rectangle, structured};

    // Regions with their measures, and how many facets there are, before and after.
    fn check<const D: usize>(coarse: &Mesh<D>) -> Result<Mesh<D>, MeshError> {
        let fine = coarse.refined()?;
        assert_eq!((fine.shape(), fine.degree()), (coarse.shape(), coarse.degree()));
        assert_eq!(fine.cell_count(), coarse.cell_count() << D);
        close(volume(&fine), volume(coarse), 1e-12);
        let small = 1 << (D - 1);
        assert_eq!(fine.boundary_facets().len(), coarse.boundary_facets().len() * small);
        // A facet between cells gives 2^(D-1); inside a cell there are 3, 4, 8 and 12.
        let inside = match coarse.shape() {
            CellShape::Triangle => 3,
            CellShape::Quadrilateral => 4,
            CellShape::Tetrahedron => 8,
            CellShape::Hexahedron => 12,
        };
        let between = coarse.interior_facets().len() * small + coarse.cell_count() * inside;
        assert_eq!(fine.interior_facets().len(), between);
        assert_eq!(
            fine.cell_regions.keys().collect::<Vec<_>>(),
            coarse.cell_regions.keys().collect::<Vec<_>>()
        );
        let exterior = coarse.facet_region_names().chain(coarse.interior_facet_region_names());
        for name in exterior {
            if name == INTERIOR {
                continue;
            }
            assert_eq!(fine.sides_of(name)?.len(), coarse.sides_of(name)?.len() * small, "{name}");
            let ((area, flux), (old_area, old_flux)) = (surface(&fine, name)?, surface(coarse, name)?);
            // The measure of what is curved is no integral of a polynomial.
            let tolerance = if coarse.is_affine() { 1e-12 } else { 1e-6 };
            close(area, old_area, tolerance);
            close(flux, old_flux, 1e-12);
        }
        // Every node is used, and none stands twice.
        let mut used = vec![false; fine.node_count()];
        fine.cells().iter().for_each(|&node| used[node as usize] = true);
        assert!(used.iter().all(|&used| used));
        let mut sorted: Vec<_> = fine.nodes().to_vec();
        sorted.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        assert!(sorted.windows(2).all(|pair| pair[0] != pair[1]));
        Ok(fine)
    }

    #[test]
    fn regions_and_volumes_stay() -> Result<(), MeshError> {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            for degree in 1..=2 {
                let mut mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], shape, degree)?;
                mesh.name_cells("left part", |centre| centre[0] < 1.0)?;
                mesh.name_cells("right part", |centre| centre[0] > 1.0)?;
                mesh.name_interface("seam", "right part", "left part")?;
                let fine = check(&check(&mesh)?)?;
                assert_eq!(fine.cell_region("left part")?.len(), mesh.cell_region("left part")?.len() * 16);
                // What was the first side still is.
                for [first, second] in fine.interior_facet_region("seam")? {
                    assert!(fine.cell_centre(first.cell as usize)[0] > 1.0);
                    assert!(fine.cell_centre(second.cell as usize)[0] < 1.0);
                }
                check(&check(&annulus(1.0, 2.0, 1, 5, shape, degree)?)?)?;
            }
        }
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            for degree in 1..=2 {
                let mut mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0], [1, 2, 1], shape, degree)?;
                mesh.name_interior_facets("middle", INTERIOR, |centre| (centre[1] - 1.0).abs() < 1e-12)?;
                check(&check(&mesh)?)?;
                let twist = |[r, s, t]: [f64; 3]| {
                    let (sine, cosine) = (0.5 * t).sin_cos();
                    [cosine * r - sine * s, sine * r + cosine * s, t + 0.1 * r * s]
                };
                check(&structured([2, 1, 1], shape, degree, twist)?)?;
            }
        }
        Ok(())
    }

    // A refined grid is the finer grid.
    #[test]
    fn the_nodes_are_those_of_the_finer_grid() -> Result<(), MeshError> {
        let sorted = |mesh: Mesh<2>| {
            let mut nodes = mesh.nodes().to_vec();
            nodes.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            nodes
        };
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            for degree in 1..=2 {
                let coarse = rectangle([0.0; 2], [4.0, 2.0], [2, 2], shape, degree)?;
                let fine = rectangle([0.0; 2], [4.0, 2.0], [4, 4], shape, degree)?;
                assert_eq!(sorted(coarse.refined()?), sorted(fine));
            }
        }
        Ok(())
    }

    // Children of a cell lie in it, in their places.
    #[test]
    fn children_lie_in_their_parents() -> Result<(), MeshError> {
        let mesh = cuboid([0.0; 3], [1.0; 3], [2, 1, 1], CellShape::Tetrahedron, 1)?;
        let fine = mesh.refined()?;
        for cell in 0..fine.cell_count() {
            let (origin, jacobian) = mesh.map(cell / 8, &[0.0; 3]);
            let inverse = inverse(&jacobian).expect("the cell is not degenerate");
            let centre = fine.cell_centre(cell);
            let reference: [f64; 3] =
                std::array::from_fn(|i| (0..3).map(|j| inverse[i][j] * (centre[j] - origin[j])).sum());
            assert!(mesh.shape().contains(&reference, 0.0), "{cell} {reference:?}");
        }
        Ok(())
    }

    // Chords: order 2 in h. Parabolas: order 4.
    #[test]
    fn nodes_moved_onto_circles_make_the_area_converge() -> Result<(), MeshError> {
        let onto = |radius: f64| move |x: &[f64; 2]| x.map(|k| k * radius / x[0].hypot(x[1]));
        let (inner, outer) = (onto(1.0), onto(2.0));
        let surfaces: [Surface<2>; 2] = [("inner", &inner), ("outer", &outer)];
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            for (degree, order) in [(1, 2.0), (2, 4.0)] {
                let mut mesh = annulus(1.0, 2.0, 1, 6, shape, degree)?;
                let mut errors = vec![];
                for _ in 0..4 {
                    errors.push((volume(&mesh) - 3.0 * std::f64::consts::PI).abs());
                    mesh = mesh.refined_onto(&surfaces)?;
                }
                let rate = (errors[2] / errors[3]).log2();
                assert!((rate - order).abs() < 0.1, "{shape:?} {degree}: order {rate}");
                for facet in mesh.facet_region("outer")? {
                    for node in mesh.element().facet_nodes(facet.local.into()) {
                        let x = mesh.nodes()[mesh.cell(facet.cell as usize)[node] as usize];
                        assert!((x[0].hypot(x[1]) - 2.0).abs() < 1e-15 * 4.0);
                    }
                }
            }
        }
        Ok(())
    }

    // The tetrahedra of a cube have children like themselves (Freudenthal); others do not degenerate.
    #[test]
    fn tetrahedra_keep_their_shape() -> Result<(), MeshError> {
        let mut mesh = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Tetrahedron, 1)?;
        let start = mesh.quality();
        for _ in 0..3 {
            mesh = mesh.refined()?;
            for (found, expected) in mesh.quality().scaled_jacobian().into_iter().zip(start.scaled_jacobian())
            {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
        let nodes = vec![[0.0; 3], [1.0, 0.1, 0.3], [0.2, 0.9, -0.1], [0.4, 0.2, 1.3]];
        let mut mesh = Mesh::from_parts(CellShape::Tetrahedron, 1, nodes, vec![0, 1, 2, 3])?;
        let first = mesh.refined()?.quality().scaled_jacobian()[0];
        for _ in 0..5 {
            mesh = mesh.refined()?;
        }
        let last = mesh.quality().scaled_jacobian()[0];
        assert!(last > 0.999 * first, "{last} {first}");
        Ok(())
    }

    #[test]
    fn mistakes_are_named() -> Result<(), MeshError> {
        let mesh = annulus(1.0, 2.0, 1, 6, CellShape::Quadrilateral, 2)?;
        let message = |region: &str, map: &dyn Fn(&[f64; 2]) -> [f64; 2]| {
            mesh.refined_onto(&[(region, map)]).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(message("rim", &|x| *x).starts_with("there is no region \"rim\""));
        assert!(message("outer", &|_| [f64::NAN; 2]).contains("has a coordinate that is not finite"));
        assert!(message("outer", &|x| x.map(|x| 0.1 * x)).contains("is inverted or degenerate"));
        Ok(())
    }
}
