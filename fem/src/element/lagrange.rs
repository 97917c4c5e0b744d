//! Lagrange elements: nodes, and tables of basis functions at given points.

use thiserror::Error;

use super::CellShape;

/// The most nodes that an element has: the complete quadratic hexahedron.
pub const MAXIMUM_NODES: usize = 27;

/// The Lagrange element of a degree on a reference cell.
///
/// The nodes are the vertices; in degree 2 then the edge midpoints in the order of
/// [`CellShape::edges`], then (hexahedron) the face centres in the order of the facets, and last
/// (quadrilateral, hexahedron) the cell's centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lagrange {
    /// Reference cell.
    pub shape: CellShape,
    /// Polynomial degree, 1 or 2.
    pub degree: usize,
}

/// Basis functions and their reference gradients at a list of points.
#[derive(Clone, Debug)]
pub struct Tables<const D: usize> {
    /// Number of nodes N.
    pub nodes: usize,
    /// Number of points Q.
    pub points: usize,
    /// φ_i(x_q) at `q * nodes + i`.
    pub value: Vec<f64>,
    /// ∇φ_i(x_q) in reference coordinates, at `q * nodes + i`.
    pub gradient: Vec<[f64; D]>,
}

/// Why an element does not exist.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ElementError {
    /// Only degrees 1 and 2 exist.
    #[error("there is no Lagrange element of degree {degree} on the {}; the degrees are 1 and 2", shape.name())]
    Degree {
        /// The shape asked for.
        shape: CellShape,
        /// The degree asked for.
        degree: usize,
    },
}

// Nodes of the quadratic tensor elements in half steps; those of degree 1 come first.
const QUADRILATERAL_NODES: [[u8; 3]; 9] =
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0], [1, 1, 0]];
const HEXAHEDRON_NODES: [[u8; 3]; 27] = [
    [0, 0, 0],
    [2, 0, 0],
    [2, 2, 0],
    [0, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [2, 2, 2],
    [0, 2, 2],
    [1, 0, 0],
    [2, 1, 0],
    [1, 2, 0],
    [0, 1, 0],
    [1, 0, 2],
    [2, 1, 2],
    [1, 2, 2],
    [0, 1, 2],
    [0, 0, 1],
    [2, 0, 1],
    [2, 2, 1],
    [0, 2, 1],
    [1, 1, 0],
    [1, 1, 2],
    [1, 0, 1],
    [2, 1, 1],
    [1, 2, 1],
    [0, 1, 1],
    [1, 1, 1],
];

impl Lagrange {
    /// The element of a degree on a shape.
    ///
    /// # Errors
    /// [`ElementError::Degree`] unless the degree is 1 or 2.
    pub fn new(shape: CellShape, degree: usize) -> Result<Self, ElementError> {
        if degree == 1 || degree == 2 {
            Ok(Lagrange { shape, degree })
        } else {
            Err(ElementError::Degree { shape, degree })
        }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        match (self.shape, self.degree) {
            (shape, 1) => shape.vertices(),
            (CellShape::Triangle, _) => 6,
            (CellShape::Quadrilateral, _) => 9,
            (CellShape::Tetrahedron, _) => 10,
            (CellShape::Hexahedron, _) => 27,
        }
    }

    /// Reference coordinates of the nodes.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn node_points<const D: usize>(&self) -> Vec<[f64; D]> {
        self.check_dimension::<D>();
        let vertices = self.shape.vertex_points();
        let mut points: Vec<[f64; D]> =
            vertices.iter().map(|vertex| std::array::from_fn(|k| vertex[k])).collect();
        if self.degree == 2 {
            for &[a, b] in self.shape.edges() {
                points.push(std::array::from_fn(|k| 0.5 * (vertices[a][k] + vertices[b][k])));
            }
            if self.shape == CellShape::Hexahedron {
                points.extend((0..self.shape.facets()).map(|local| self.shape.facet_centre::<D>(local)));
            }
            if !self.shape.is_simplex() {
                points.push(self.shape.centre());
            }
        }
        points
    }

    /// The element's nodes on a facet: its vertices in the order of [`CellShape::facet_vertices`], then
    /// the midpoints of the edges between successive vertices, then (hexahedron) the face centre.
    ///
    /// # Panics
    /// When `local` is not below [`CellShape::facets`].
    pub fn facet_nodes(&self, local: usize) -> Vec<usize> {
        let vertices = self.shape.facet_vertices(local);
        let mut nodes = vertices.to_vec();
        if self.degree == 2 {
            let edges = self.shape.edges();
            let sides = if vertices.len() == 2 { 1 } else { vertices.len() };
            for side in 0..sides {
                let (a, b) = (vertices[side], vertices[(side + 1) % vertices.len()]);
                let edge = edges.iter().position(|edge| *edge == [a, b] || *edge == [b, a]);
                nodes.extend(edge.map(|edge| self.shape.vertices() + edge));
            }
            if self.shape == CellShape::Hexahedron {
                nodes.push(self.shape.vertices() + edges.len() + local);
            }
        }
        nodes
    }

    /// Values and reference gradients of all basis functions at some points.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn tabulate<const D: usize>(&self, points: &[[f64; D]]) -> Tables<D> {
        let nodes = self.nodes();
        let mut value = vec![0.0; nodes * points.len()];
        let mut gradient = vec![[0.0; D]; nodes * points.len()];
        for (q, point) in points.iter().enumerate() {
            let range = q * nodes..(q + 1) * nodes;
            self.evaluate(point, &mut value[range.clone()], &mut gradient[range]);
        }
        Tables { nodes, points: points.len(), value, gradient }
    }

    /// Values and reference gradients at one point, written to slices of length [`Lagrange::nodes`].
    ///
    /// # Panics
    /// When D is not the shape's dimension, or a slice is too short.
    pub fn evaluate<const D: usize>(&self, point: &[f64; D], value: &mut [f64], gradient: &mut [[f64; D]]) {
        self.check_dimension::<D>();
        if self.shape.is_simplex() {
            self.evaluate_simplex(point, value, gradient);
        } else {
            self.evaluate_tensor(point, value, gradient);
        }
    }

    fn evaluate_simplex<const D: usize>(
        &self,
        point: &[f64; D],
        value: &mut [f64],
        gradient: &mut [[f64; D]],
    ) {
        // Barycentric coordinates: λ_0 = 1 - Σ x_k, λ_{k+1} = x_k.
        let lambda = |vertex: usize| {
            if vertex == 0 { 1.0 - point.iter().sum::<f64>() } else { point[vertex - 1] }
        };
        let slope = |vertex: usize, k: usize| {
            if vertex == 0 {
                -1.0
            } else if vertex == k + 1 {
                1.0
            } else {
                0.0
            }
        };
        for vertex in 0..=D {
            let l = lambda(vertex);
            let (phi, factor) =
                if self.degree == 1 { (l, 1.0) } else { (l * (2.0 * l - 1.0), 4.0 * l - 1.0) };
            value[vertex] = phi;
            gradient[vertex] = std::array::from_fn(|k| factor * slope(vertex, k));
        }
        if self.degree == 2 {
            for (edge, &[a, b]) in self.shape.edges().iter().enumerate() {
                let (la, lb) = (lambda(a), lambda(b));
                value[D + 1 + edge] = 4.0 * la * lb;
                gradient[D + 1 + edge] = std::array::from_fn(|k| 4.0 * (slope(a, k) * lb + la * slope(b, k)));
            }
        }
    }

    fn evaluate_tensor<const D: usize>(
        &self,
        point: &[f64; D],
        value: &mut [f64],
        gradient: &mut [[f64; D]],
    ) {
        let factors: [[[f64; 2]; 3]; D] = std::array::from_fn(|k| self.factors(point[k]));
        for (node, steps) in self.tensor_nodes().iter().enumerate() {
            value[node] = (0..D).map(|k| factors[k][usize::from(steps[k])][0]).product();
            gradient[node] = std::array::from_fn(|direction| {
                (0..D).map(|k| factors[k][usize::from(steps[k])][usize::from(k == direction)]).product()
            });
        }
    }

    fn tensor_nodes(&self) -> &'static [[u8; 3]] {
        let nodes: &[[u8; 3]] =
            if self.shape == CellShape::Hexahedron { &HEXAHEDRON_NODES } else { &QUADRILATERAL_NODES };
        &nodes[..self.nodes()]
    }

    // Value and slope at x of the Lagrange polynomials of the nodes 0, 1/2 and 1.
    fn factors(&self, x: f64) -> [[f64; 2]; 3] {
        if self.degree == 1 {
            [[1.0 - x, -1.0], [0.0, 0.0], [x, 1.0]]
        } else {
            [
                [(1.0 - x) * (1.0 - 2.0 * x), 4.0 * x - 3.0],
                [4.0 * x * (1.0 - x), 4.0 - 8.0 * x],
                [x * (2.0 * x - 1.0), 4.0 * x - 1.0],
            ]
        }
    }

    fn check_dimension<const D: usize>(&self) {
        assert_eq!(self.shape.dimension(), D, "the dimension of the reference {}", self.shape.name());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elements() -> impl Iterator<Item = Lagrange> {
        CellShape::ALL
            .into_iter()
            .flat_map(|shape| [1, 2].map(|degree| Lagrange::new(shape, degree).expect("degrees 1 and 2")))
    }

    // A few points, some outside the cell: the identities hold everywhere.
    fn samples<const D: usize>() -> Vec<[f64; D]> {
        [[0.1, 0.2, 0.3], [0.7, 0.05, 0.15], [0.0, 1.0, 0.25], [1.3, -0.4, 0.6]]
            .iter()
            .map(|point| std::array::from_fn(|k| point[k]))
            .collect()
    }

    fn check_nodes<const D: usize>(element: Lagrange) {
        let points = element.node_points::<D>();
        assert_eq!(points.len(), element.nodes());
        let tables = element.tabulate(&points);
        for q in 0..points.len() {
            for i in 0..element.nodes() {
                // Exact: all coordinates are 0, 1/2 or 1.
                assert_eq!(tables.value[q * tables.nodes + i], f64::from(u8::from(i == q)), "{element:?}");
            }
        }
    }

    // Interpolates a polynomial of the element's space and compares values and gradients.
    fn check_reproduction<const D: usize>(element: Lagrange) {
        let coefficient = [0.3, -1.7, 0.9];
        // (1 + c·x)^degree is in P_k; for the tensor elements Π (1 + c_k x_k)^degree is in Q_k.
        let p = element.degree as i32;
        let simplex = element.shape.is_simplex();
        let function = |x: &[f64; D]| -> (f64, [f64; D]) {
            if simplex {
                let s = 1.0 + (0..D).map(|k| coefficient[k] * x[k]).sum::<f64>();
                (s.powi(p), std::array::from_fn(|k| f64::from(p) * s.powi(p - 1) * coefficient[k]))
            } else {
                let s: [f64; D] = std::array::from_fn(|k| 1.0 + coefficient[k] * x[k]);
                let value = s.iter().map(|s| s.powi(p)).product();
                let gradient = std::array::from_fn(|k| {
                    let others: f64 = (0..D).filter(|&j| j != k).map(|j| s[j].powi(p)).product();
                    f64::from(p) * s[k].powi(p - 1) * coefficient[k] * others
                });
                (value, gradient)
            }
        };
        let nodal: Vec<f64> = element.node_points::<D>().iter().map(|x| function(x).0).collect();
        let points = samples::<D>();
        let tables = element.tabulate(&points);
        for (q, point) in points.iter().enumerate() {
            let row = q * tables.nodes..(q + 1) * tables.nodes;
            let value: f64 = tables.value[row.clone()].iter().zip(&nodal).map(|(phi, u)| phi * u).sum();
            let (expected, slope) = function(point);
            assert!((value - expected).abs() < 1e-13, "{element:?}");
            let unity: f64 = tables.value[row.clone()].iter().sum();
            assert!((unity - 1.0).abs() < 1e-14, "{element:?}");
            for k in 0..D {
                let derivative: f64 =
                    tables.gradient[row.clone()].iter().zip(&nodal).map(|(g, u)| g[k] * u).sum();
                assert!((derivative - slope[k]).abs() < 1e-12, "{element:?}");
            }
        }
    }

    // Central differences are exact for quadratics along an axis, up to round-off.
    fn check_differences<const D: usize>(element: Lagrange) {
        let step = 0.01;
        for point in samples::<D>() {
            let centre = element.tabulate(&[point]);
            for k in 0..D {
                let (mut left, mut right) = (point, point);
                left[k] -= step;
                right[k] += step;
                let tables = element.tabulate(&[left, right]);
                for i in 0..tables.nodes {
                    let difference = (tables.value[tables.nodes + i] - tables.value[i]) / (2.0 * step);
                    assert!((difference - centre.gradient[i][k]).abs() < 1e-12, "{element:?}");
                }
            }
        }
    }

    #[test]
    fn basis_is_one_at_its_node_and_zero_at_the_others() {
        for element in elements() {
            if element.shape.dimension() == 2 { check_nodes::<2>(element) } else { check_nodes::<3>(element) }
        }
    }

    #[test]
    fn polynomials_of_the_space_are_reproduced() {
        for element in elements() {
            if element.shape.dimension() == 2 {
                check_reproduction::<2>(element);
                check_differences::<2>(element);
            } else {
                check_reproduction::<3>(element);
                check_differences::<3>(element);
            }
        }
    }

    #[test]
    fn facet_nodes_are_those_on_the_facet() {
        for element in elements().filter(|element| element.shape.dimension() == 3) {
            let points = element.node_points::<3>();
            for local in 0..element.shape.facets() {
                let on_facet = |x: &[f64; 3]| match (element.shape, local) {
                    (CellShape::Tetrahedron, 0) => x.iter().sum::<f64>() == 1.0,
                    (CellShape::Tetrahedron, f) => x[f - 1] == 0.0,
                    (_, f) => {
                        [x[2] == 0.0, x[2] == 1.0, x[1] == 0.0, x[0] == 1.0, x[1] == 1.0, x[0] == 0.0][f]
                    }
                };
                let expected: Vec<usize> = (0..points.len()).filter(|&i| on_facet(&points[i])).collect();
                let mut nodes = element.facet_nodes(local);
                nodes.sort_unstable();
                assert_eq!(nodes, expected, "{element:?} facet {local}");
            }
        }
        let quadratic = Lagrange { shape: CellShape::Quadrilateral, degree: 2 };
        assert_eq!(quadratic.facet_nodes(3), [3, 0, 7]);
    }

    #[test]
    fn other_degrees_are_errors() {
        let message = Lagrange::new(CellShape::Triangle, 3).map_err(|error| error.to_string());
        assert_eq!(
            message,
            Err("there is no Lagrange element of degree 3 on the triangle; the degrees are 1 and 2".into())
        );
        assert!(Lagrange::new(CellShape::Hexahedron, 0).is_err());
    }
}
