//! Reference cells: vertices, edges, facets, and how facets are parametrised.

/// The shape of a cell. Reference cells live on \[0,1\]: the unit simplex or the unit cube.
///
/// ```
/// # use forms_mesh::element::CellShape;
/// assert_eq!((CellShape::Hexahedron.dimension(), CellShape::Hexahedron.facets()), (3, 6));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CellShape {
    /// Vertices (0,0) (1,0) (0,1).
    Triangle,
    /// Vertices (0,0) (1,0) (1,1) (0,1), counter-clockwise.
    Quadrilateral,
    /// Vertices (0,0,0) (1,0,0) (0,1,0) (0,0,1).
    Tetrahedron,
    /// Vertices of the lower face counter-clockwise, then those of the upper face.
    Hexahedron,
}

const TRIANGLE_VERTICES: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const QUADRILATERAL_VERTICES: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const TETRAHEDRON_VERTICES: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const HEXAHEDRON_VERTICES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

// The edge orders are those of VTK, so that second-order cells need no permutation there.
const TRIANGLE_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];
const QUADRILATERAL_EDGES: [[usize; 2]; 4] = [[0, 1], [1, 2], [2, 3], [3, 0]];
const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
const HEXAHEDRON_EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

const TETRAHEDRON_FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
const HEXAHEDRON_FACETS: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

impl CellShape {
    /// All shapes.
    pub const ALL: [CellShape; 4] =
        [CellShape::Triangle, CellShape::Quadrilateral, CellShape::Tetrahedron, CellShape::Hexahedron];

    /// Number of reference coordinates: 2 or 3.
    #[inline]
    pub fn dimension(self) -> usize {
        match self {
            CellShape::Triangle | CellShape::Quadrilateral => 2,
            CellShape::Tetrahedron | CellShape::Hexahedron => 3,
        }
    }

    /// True for the triangle and the tetrahedron.
    #[inline]
    pub fn is_simplex(self) -> bool {
        matches!(self, CellShape::Triangle | CellShape::Tetrahedron)
    }

    /// The shape's name, for messages.
    pub fn name(self) -> &'static str {
        match self {
            CellShape::Triangle => "triangle",
            CellShape::Quadrilateral => "quadrilateral",
            CellShape::Tetrahedron => "tetrahedron",
            CellShape::Hexahedron => "hexahedron",
        }
    }

    /// The name of several, for messages.
    pub fn plural(self) -> &'static str {
        match self {
            CellShape::Triangle => "triangles",
            CellShape::Quadrilateral => "quadrilaterals",
            CellShape::Tetrahedron => "tetrahedra",
            CellShape::Hexahedron => "hexahedra",
        }
    }

    /// Number of vertices.
    #[inline]
    pub fn vertices(self) -> usize {
        self.vertex_points().len()
    }

    /// Reference coordinates of the vertices; the third is zero in two dimensions.
    pub fn vertex_points(self) -> &'static [[f64; 3]] {
        match self {
            CellShape::Triangle => &TRIANGLE_VERTICES,
            CellShape::Quadrilateral => &QUADRILATERAL_VERTICES,
            CellShape::Tetrahedron => &TETRAHEDRON_VERTICES,
            CellShape::Hexahedron => &HEXAHEDRON_VERTICES,
        }
    }

    /// Pairs of vertices.
    ///
    /// Triangle: 01 12 20. Quadrilateral: 01 12 23 30. Tetrahedron: 01 12 20 03 13 23.
    /// Hexahedron: lower face 01 12 23 30, upper face 45 56 67 74, upright 04 15 26 37.
    pub fn edges(self) -> &'static [[usize; 2]] {
        match self {
            CellShape::Triangle => &TRIANGLE_EDGES,
            CellShape::Quadrilateral => &QUADRILATERAL_EDGES,
            CellShape::Tetrahedron => &TETRAHEDRON_EDGES,
            CellShape::Hexahedron => &HEXAHEDRON_EDGES,
        }
    }

    /// Number of facets: edges in two dimensions, faces in three.
    #[inline]
    pub fn facets(self) -> usize {
        match self {
            CellShape::Triangle => 3,
            CellShape::Quadrilateral | CellShape::Tetrahedron => 4,
            CellShape::Hexahedron => 6,
        }
    }

    /// Number of vertices of each facet.
    #[inline]
    pub fn vertices_per_facet(self) -> usize {
        match self {
            CellShape::Triangle | CellShape::Quadrilateral => 2,
            CellShape::Tetrahedron => 3,
            CellShape::Hexahedron => 4,
        }
    }

    /// Vertices of a facet, in an order that gives the outward normal.
    ///
    /// - Triangle, quadrilateral: facet f joins the vertices f and f + 1 (cyclic). The tangent
    ///   t = v₁ − v₀ turned clockwise, (t₁, −t₀), points outward.
    /// - Tetrahedron: facet f is opposite vertex f. Hexahedron: 0 bottom (z = 0), 1 top (z = 1),
    ///   2 front (y = 0), 3 right (x = 1), 4 back (y = 1), 5 left (x = 0). The vertices run
    ///   counter-clockwise seen from outside: (v₁ − v₀) × (v_last − v₀) points outward.
    ///
    /// # Panics
    /// When `local` is not below [`CellShape::facets`].
    #[inline]
    pub fn facet_vertices(self, local: usize) -> &'static [usize] {
        match self {
            CellShape::Triangle => &TRIANGLE_EDGES[local],
            CellShape::Quadrilateral => &QUADRILATERAL_EDGES[local],
            CellShape::Tetrahedron => &TETRAHEDRON_FACETS[local],
            CellShape::Hexahedron => &HEXAHEDRON_FACETS[local],
        }
    }

    /// Volume of the reference cell.
    pub fn volume(self) -> f64 {
        match self {
            CellShape::Triangle => 0.5,
            CellShape::Tetrahedron => 1.0 / 6.0,
            CellShape::Quadrilateral | CellShape::Hexahedron => 1.0,
        }
    }

    /// Measure of a facet's own reference cell: the segment \[0,1\], the unit triangle, the unit square.
    pub fn facet_volume(self) -> f64 {
        if self == CellShape::Tetrahedron { 0.5 } else { 1.0 }
    }

    /// The mean of the reference cell's vertices.
    pub fn centre<const D: usize>(self) -> [f64; D] {
        let points = self.vertex_points();
        std::array::from_fn(|k| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64)
    }

    /// The mean of a facet's vertices, in the cell's reference coordinates.
    ///
    /// # Panics
    /// When `local` is not below [`CellShape::facets`].
    pub fn facet_centre<const D: usize>(self, local: usize) -> [f64; D] {
        let vertices = self.facet_vertices(local);
        let points = self.vertex_points();
        std::array::from_fn(|k| {
            vertices.iter().map(|&vertex| points[vertex][k]).sum::<f64>() / vertices.len() as f64
        })
    }

    /// Whether a reference point lies in the cell, enlarged by `tolerance` in reference coordinates.
    /// A NaN coordinate lies outside.
    pub fn contains<const D: usize>(self, point: &[f64; D], tolerance: f64) -> bool {
        let above = point.iter().all(|&coordinate| coordinate >= -tolerance);
        if self.is_simplex() {
            above && point.iter().sum::<f64>() <= 1.0 + tolerance
        } else {
            above && point.iter().all(|&coordinate| coordinate <= 1.0 + tolerance)
        }
    }

    /// A point of the cell near a reference point: the point itself when it lies inside.
    pub fn clamp<const D: usize>(self, point: &[f64; D]) -> [f64; D] {
        if !self.is_simplex() {
            return point.map(|coordinate| coordinate.clamp(0.0, 1.0));
        }
        // The nearest point of the face x + y (+ z) = 1 may itself have negative coordinates; dropping
        // those and projecting the others again ends after at most D rounds (Michelot's algorithm).
        let mut clamped = point.map(|coordinate| coordinate.max(0.0));
        if clamped.iter().sum::<f64>() <= 1.0 {
            return clamped;
        }
        clamped = *point;
        let mut active = [true; D];
        for _ in 0..D {
            let count = active.iter().filter(|&&is_active| is_active).count();
            let sum: f64 = clamped.iter().zip(&active).filter(|(_, a)| **a).map(|(c, _)| c).sum();
            let shift = (1.0 - sum) / count as f64;
            let mut done = true;
            for (coordinate, is_active) in clamped.iter_mut().zip(&mut active) {
                if *is_active {
                    *coordinate += shift;
                    if *coordinate < 0.0 {
                        *is_active = false;
                        done = false;
                    }
                }
                if !*is_active {
                    *coordinate = 0.0;
                }
            }
            if done {
                break;
            }
        }
        clamped
    }
}

/// "triangles and quadrilaterals", for messages.
pub(crate) fn plurals(shapes: &[CellShape]) -> String {
    shapes.iter().map(|shape| shape.plural()).collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| a[k] - b[k])
    }

    #[test]
    fn facet_vertices_give_outward_normals() {
        for shape in CellShape::ALL {
            let points = shape.vertex_points();
            let centre = shape.centre::<3>();
            for local in 0..shape.facets() {
                let vertices = shape.facet_vertices(local);
                let origin = points[vertices[0]];
                let t = difference(points[vertices[1]], origin);
                let normal = if shape.dimension() == 2 {
                    [t[1], -t[0], 0.0]
                } else {
                    let s = difference(points[vertices[vertices.len() - 1]], origin);
                    [t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2], t[0] * s[1] - t[1] * s[0]]
                };
                let outward = difference(shape.facet_centre::<3>(local), centre);
                let product: f64 = (0..3).map(|k| normal[k] * outward[k]).sum();
                assert!(product > 0.1, "{shape:?} facet {local}");
            }
        }
    }

    #[test]
    fn tetrahedron_facets_are_opposite_their_vertex() {
        for local in 0..4 {
            assert!(!CellShape::Tetrahedron.facet_vertices(local).contains(&local));
        }
    }

    #[test]
    fn clamp_projects_on_the_simplex() {
        let triangle = CellShape::Triangle;
        assert_eq!(triangle.clamp(&[0.25, 0.5]), [0.25, 0.5]);
        assert_eq!(triangle.clamp(&[1.0, 1.0]), [0.5, 0.5]);
        assert_eq!(triangle.clamp(&[2.0, 0.5]), [1.0, 0.0]);
        assert_eq!(triangle.clamp(&[-1.0, 0.5]), [0.0, 0.5]);
        assert_eq!(triangle.clamp(&[-1.0, 1.5]), [0.0, 1.0]);
        assert_eq!(CellShape::Tetrahedron.clamp(&[1.0, 1.0, -3.0]), [0.5, 0.5, 0.0]);
        assert_eq!(CellShape::Hexahedron.clamp(&[1.5, 0.5, -3.0]), [1.0, 0.5, 0.0]);
    }

    #[test]
    fn contains_respects_the_tolerance() {
        assert!(CellShape::Triangle.contains(&[0.5, 0.5], 0.0));
        assert!(!CellShape::Triangle.contains(&[0.5, 0.5 + 1e-9], 1e-10));
        assert!(CellShape::Triangle.contains(&[0.5, 0.5 + 1e-11], 1e-10));
        assert!(CellShape::Quadrilateral.contains(&[1.0, 1.0], 0.0));
        assert!(!CellShape::Quadrilateral.contains(&[f64::NAN, 0.5], 1.0));
    }
}
