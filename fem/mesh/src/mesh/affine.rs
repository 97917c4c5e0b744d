//! Cells and facets with an affine map: straight simplices, parallelograms and parallelepipeds, with further nodes in the middles.

use super::{Facet, Mesh};
use crate::element::{CellShape, PerShape};

/// Largest distance of nodes from an affine map, as a part of the cell's shortest edge: coordinates that are made by formulas have rounding errors.
const ROUNDED: f64 = 1e-12;

/// The same in units in the last place of the largest coordinate of the cell.
const LAST_PLACES: f64 = 16.0 * f64::EPSILON;

/// A test for affine maps of a mesh's cells and facets.
#[doc(hidden)]
pub struct AffineMaps<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    /// By shape: the cell, and each of its facets with the facet's nodes among the cell's.
    frames: PerShape<(Frame, Vec<Vec<usize>>)>,
    /// That of all facets over their own reference cell.
    of_facets: Frame,
}

/// Reference coordinates of an element's nodes, and those of the nodes that determine an affine map.
struct Frame {
    points: Vec<[f64; 3]>,
    origin: usize,
    axes: Vec<usize>,
}

impl Frame {
    fn new(points: Vec<[f64; 3]>, dimension: usize) -> Self {
        let node = |wanted: [f64; 3]| points.iter().position(|point| *point == wanted).unwrap_or(0);
        let axis = |k: usize| node(std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
        let (origin, axes) = (node([0.0; 3]), (0..dimension).map(axis).collect());
        Frame { points, origin, axes }
    }

    /// Whether nodes at these places are those of an affine map, up to rounding.
    fn is_affine<const D: usize>(&self, place: impl Fn(usize) -> [f64; D]) -> bool {
        let origin = place(self.origin);
        let (mut edges, mut shortest) = ([[0.0; D]; 3], f64::INFINITY);
        for (edge, &axis) in edges.iter_mut().zip(&self.axes) {
            let end = place(axis);
            *edge = std::array::from_fn(|i| end[i] - origin[i]);
            shortest = shortest.min(edge.iter().map(|x| x * x).sum::<f64>().sqrt());
        }
        let (mut deviation, mut largest) = (0.0_f64, 0.0_f64);
        for (node, point) in self.points.iter().enumerate() {
            let x = place(node);
            for i in 0..D {
                let affine = (0..self.axes.len()).fold(origin[i], |sum, k| sum + point[k] * edges[k][i]);
                deviation = deviation.max((x[i] - affine).abs());
                largest = largest.max(x[i].abs());
            }
        }
        deviation <= ROUNDED * shortest + LAST_PLACES * largest
    }
}

impl<const D: usize> AffineMaps<'_, D> {
    /// Whether a cell's Jacobian is constant, up to rounding.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    pub fn of_cell(&self, cell: usize) -> bool {
        let shape = self.mesh.cell_shape(cell);
        let nodes = self.mesh.cell(cell);
        self.mesh.is_affine_on(shape) || self.frames[shape].0.is_affine(|node| self.place(nodes[node]))
    }

    /// Whether a facet's tangents are constant, up to rounding.
    ///
    /// # Panics
    /// When the mesh has no such facet.
    pub fn of_facet(&self, facet: Facet) -> bool {
        let shape = self.mesh.cell_shape(facet.cell as usize);
        let (nodes, on_facet) =
            (self.mesh.cell(facet.cell as usize), &self.frames[shape].1[usize::from(facet.local)]);
        self.mesh.has_affine_facets() || self.of_facets.is_affine(|node| self.place(nodes[on_facet[node]]))
    }

    fn place(&self, node: u32) -> [f64; D] {
        self.mesh.nodes[node as usize]
    }
}

impl<const D: usize> Mesh<D> {
    /// A test that tells affine cells and facets from others.
    #[doc(hidden)]
    pub fn affine_maps(&self) -> AffineMaps<'_, D> {
        let of_shape = |shape: CellShape| {
            let element = self.element_of(shape);
            let points = element.node_points::<D>().into_iter();
            let points = points.map(|point| std::array::from_fn(|k| if k < D { point[k] } else { 0.0 }));
            let facets = (0..shape.facets()).map(|local| element.facet_nodes(local)).collect();
            (shape, (Frame::new(points.collect(), D), facets))
        };
        let points = self.element_of(self.shape_of_facets()).facet_node_points().into_iter();
        let of_facets = Frame::new(points.map(|[s, t]| [s, t, 0.0]).collect(), D - 1);
        AffineMaps { mesh: self, frames: self.shapes().into_iter().map(of_shape).collect(), of_facets }
    }

    /// Whether the tangents of all facets are constant by their shape and degree.
    #[doc(hidden)]
    pub fn has_affine_facets(&self) -> bool {
        self.degree == 1 && (D == 2 || self.shape_of_facets().is_simplex())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshError, annulus, ball, cuboid, rectangle};

    /// Numbers of cells and of exterior facets whose maps are affine.
    fn affine<const D: usize>(mesh: &Mesh<D>) -> [usize; 2] {
        let maps = mesh.affine_maps();
        [
            (0..mesh.cell_count()).filter(|cell| maps.of_cell(*cell)).count(),
            mesh.boundary_facets().iter().filter(|facet| maps.of_facet(**facet)).count(),
        ]
    }

    fn all<const D: usize>(mesh: &Mesh<D>) -> [usize; 2] {
        [mesh.cell_count(), mesh.boundary_facets().len()]
    }

    fn mapped<const D: usize>(
        mesh: &Mesh<D>,
        map: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Result<Mesh<D>, MeshError> {
        mesh.with_nodes(mesh.nodes().iter().map(map).collect())
    }

    #[test]
    fn images_of_boxes_under_affine_maps_are_affine() -> Result<(), MeshError> {
        let sheared = |x: &[f64; 2]| [1e3 + 0.7 * x[0] + 0.3 * x[1], -0.2 * x[0] + 1.1 * x[1]];
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            for degree in 1..=2 {
                let mesh = rectangle([-1.0, -0.7], [1.0, 1e-4], [37, 23], shape, degree)?;
                assert_eq!(affine(&mesh), all(&mesh));
                let mesh = mapped(&mesh, sheared)?;
                assert_eq!(affine(&mesh), all(&mesh));
            }
        }
        let sheared = |x: &[f64; 3]| [x[0] + 0.3 * x[1], x[1] - 0.2 * x[2], x[2] + 0.1 * x[0]];
        for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
            for degree in 1..=2 {
                let mesh = mapped(&cuboid([-1.0; 3], [1.0, 0.3, 7.0], [5, 3, 4], shape, degree)?, sheared)?;
                assert_eq!(affine(&mesh), all(&mesh));
            }
        }
        Ok(())
    }

    #[test]
    fn skewed_and_curved_cells_are_not() -> Result<(), MeshError> {
        // Trapezoids with straight sides.
        let ring = annulus(1.0, 2.0, 2, 8, CellShape::Quadrilateral, 1)?;
        assert_eq!(affine(&ring), [0, 16]);
        assert_eq!(affine(&annulus(1.0, 2.0, 2, 8, CellShape::Quadrilateral, 2)?), [0, 0]);
        // Simplices of degree 1 are always affine. Curved ones of degree 2 are not.
        let ring = annulus(1.0, 2.0, 2, 8, CellShape::Triangle, 1)?;
        assert_eq!(affine(&ring), all(&ring));
        let [cells, facets] = affine(&annulus(1.0, 2.0, 2, 8, CellShape::Triangle, 2)?);
        assert_eq!((cells, facets), (0, 0));
        // The cube in the middle of a ball is rounded; faces in the planes of its cuts are skewed.
        let eighth = ball(1.0, [true; 3], 1, 1, CellShape::Hexahedron, 1)?;
        assert_eq!(affine(&eighth)[0], 0);
        // A relative 1e-10 in one node is no rounding.
        let mut nodes = rectangle([0.0; 2], [1.0; 2], [2, 1], CellShape::Quadrilateral, 1)?.nodes().to_vec();
        nodes[5][0] += 1e-10;
        let cells = vec![0, 1, 4, 3, 1, 2, 5, 4];
        assert_eq!(affine(&Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, cells)?), [1, 6]);
        Ok(())
    }
}
