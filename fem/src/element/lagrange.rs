//! Lagrange elements: nodes, and tables of basis functions at given points.

use thiserror::Error;

use super::CellShape;

/// The most nodes that an element has: the complete quadratic hexahedron.
pub const MAXIMUM_NODES: usize = 27;

/// The Lagrange element of a degree on a reference cell.
///
/// In degree 0, which only discontinuous spaces have, the node is the cell's centre. Otherwise the nodes are
/// the vertices; in degree 2 then the edge midpoints in the order of
/// [`CellShape::edges`], then (hexahedron) the face centres in the order of the facets, and last
/// (quadrilateral, hexahedron) the cell's centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lagrange {
    /// Reference cell.
    pub shape: CellShape,
    /// Polynomial degree: 0, 1 or 2.
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
    /// ∂²φ_i/∂ξ_k∂ξ_l(x_q) in reference coordinates, at `q * nodes + i`; empty unless it was asked for.
    pub hessian: Vec<[[f64; D]; D]>,
}

/// Why an element does not exist.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ElementError {
    /// Only degrees 1 and 2 exist with continuous values.
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
            (_, 0) => 1,
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
        if self.degree == 0 {
            return vec![self.shape.centre()];
        }
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
    /// the midpoints of the edges between successive vertices, then (hexahedron) the face centre. None in
    /// degree 0.
    ///
    /// # Panics
    /// When `local` is not below [`CellShape::facets`].
    pub fn facet_nodes(&self, local: usize) -> Vec<usize> {
        if self.degree == 0 {
            return vec![];
        }
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
        Tables { nodes, points: points.len(), value, gradient, hessian: vec![] }
    }

    /// [`Lagrange::tabulate`] with second derivatives.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn tabulate_with_hessians<const D: usize>(&self, points: &[[f64; D]]) -> Tables<D> {
        let hessian = points.iter().flat_map(|point| self.hessians(point)).collect();
        Tables { hessian, ..self.tabulate(points) }
    }

    /// Second derivatives of all basis functions at a point, in reference coordinates.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn hessians<const D: usize>(&self, point: &[f64; D]) -> Vec<[[f64; D]; D]> {
        self.check_dimension::<D>();
        let matrix = |entry: &dyn Fn(usize, usize) -> f64| -> [[f64; D]; D] {
            std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l)))
        };
        if self.degree == 0 || (self.degree == 1 && self.shape.is_simplex()) {
            return vec![matrix(&|_, _| 0.0); self.nodes()];
        }
        if self.shape.is_simplex() {
            let vertices = (0..=D).map(|v| matrix(&|k, l| 4.0 * slope(v, k) * slope(v, l)));
            let edges =
                self.shape.edges().iter().map(|&[a, b]| {
                    matrix(&|k, l| 4.0 * (slope(a, k) * slope(b, l) + slope(a, l) * slope(b, k)))
                });
            return vertices.chain(edges).collect();
        }
        let factors: [[[f64; 3]; 3]; D] = std::array::from_fn(|k| self.factors(point[k]));
        let at_node = |steps: &[u8; 3]| {
            matrix(&|first, second| {
                let order = |k: usize| usize::from(k == first) + usize::from(k == second);
                (0..D).map(|k| factors[k][usize::from(steps[k])][order(k)]).product()
            })
        };
        self.tensor_nodes().iter().map(at_node).collect()
    }

    /// Values and reference gradients at one point, written to slices of length [`Lagrange::nodes`].
    ///
    /// # Panics
    /// When D is not the shape's dimension, or a slice is too short.
    pub fn evaluate<const D: usize>(&self, point: &[f64; D], value: &mut [f64], gradient: &mut [[f64; D]]) {
        self.check_dimension::<D>();
        if self.degree == 0 {
            value[0] = 1.0;
            gradient[0] = [0.0; D];
        } else if self.shape.is_simplex() {
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
        let factors: [[[f64; 3]; 3]; D] = std::array::from_fn(|k| self.factors(point[k]));
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

    // Value and both derivatives at x of the Lagrange polynomials of the nodes 0, 1/2 and 1.
    fn factors(&self, x: f64) -> [[f64; 3]; 3] {
        if self.degree == 1 {
            [[1.0 - x, -1.0, 0.0], [0.0; 3], [x, 1.0, 0.0]]
        } else {
            [
                [(1.0 - x) * (1.0 - 2.0 * x), 4.0 * x - 3.0, 4.0],
                [4.0 * x * (1.0 - x), 4.0 - 8.0 * x, -8.0],
                [x * (2.0 * x - 1.0), 4.0 * x - 1.0, 4.0],
            ]
        }
    }

    fn check_dimension<const D: usize>(&self) {
        assert_eq!(self.shape.dimension(), D, "the dimension of the reference {}", self.shape.name());
    }
}

/// ∂λ_vertex/∂ξ_k of a barycentric coordinate.
fn slope(vertex: usize, k: usize) -> f64 {
    match vertex {
        0 => -1.0,
        _ if vertex == k + 1 => 1.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests;
