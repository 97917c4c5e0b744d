//! Lagrange elements: nodes, and tables of basis functions at given points.

use thiserror::Error;

use super::CellShape;
use super::lattice::{MAXIMUM_DEGREE, Steps, facet_lattice, lattice, on_facet};

/// The most nodes that an element has: the hexahedron of degree 4.
pub const MAXIMUM_NODES: usize = 125;

/// The most nodes that a cell's geometry has: the complete quadratic hexahedron.
pub const MAXIMUM_GEOMETRY_NODES: usize = 27;

/// The Lagrange element of a degree on a reference cell: complete polynomials of that degree on triangles and
/// tetrahedra, of that degree in each direction on quadrilaterals and hexahedra.
///
/// In degree 0, which only discontinuous spaces have, the node is the cell's centre. Otherwise the nodes are
/// the vertices; then those inside the edges, in the order of [`CellShape::edges`] and along them; then (in three
/// dimensions) those inside the faces in the order of the facets, and last those inside the cell. Inside a face they
/// are counted first from its first vertex towards its second, then towards its last.
///
/// Nodes are equispaced. Conditioning suffers with the degree: on a segment the condition of the mass matrix grows
/// from 3 in degree 1 to 14 in degree 4, with the dimension as its power on quadrilaterals and hexahedra, and
/// iterative solvers without a preconditioner that knows the degree feel it. Up to degree 4 interpolation itself is
/// harmless (Lebesgue constant 2.2 on a segment).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lagrange {
    /// Reference cell.
    pub shape: CellShape,
    /// Polynomial degree: 0 to 4.
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

/// Errors of an element's definition.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum ElementError {
    /// Only degrees 1 to 4 exist with continuous values.
    #[error("there is no Lagrange element of degree {degree} on the {}; the degrees are 1 to 4", shape.name())]
    Degree { shape: CellShape, degree: usize },
    /// Elements that only triangles and tetrahedra have.
    #[error("there are no {elements} on the {}; they exist on triangles and tetrahedra", shape.name())]
    Shape { elements: String, shape: CellShape },
    /// There is no rule whose points would be the nodes.
    #[error("there is no rule of degree {degree} on the {} whose points could have values", shape.name())]
    Rule { shape: CellShape, degree: usize },
    /// Bubbles come with degree 1 or 2.
    #[error("there are no elements of degree {degree} with bubbles; the degrees are 1 and 2")]
    Bubbles { degree: usize },
    /// Bernstein's polynomials come with degree 1 or 2.
    #[error("there are no Bernstein elements of degree {degree}; the degrees are 1 and 2")]
    Bernstein { degree: usize },
    /// A user's elements lack one of the shapes of a mesh.
    #[error("the mesh has {} cells, for which there is no element among those given", shape.name())]
    Missing { shape: CellShape },
    /// The values at the nodes do not determine a polynomial.
    #[error("values at the nodes of the element \"{name}\" on the {} do not determine its polynomials", shape.name())]
    NotUnisolvent { name: String, shape: CellShape },
    /// An invalid table of an element.
    #[error("the element \"{name}\" is not as it must be: {reason}")]
    Table { name: String, reason: &'static str },
    /// Cells are straight or quadratic.
    #[error("there is no geometry of degree {degree} for the {}; the degrees are 1 and 2", shape.name())]
    Geometry { shape: CellShape, degree: usize },
}

/// A function of one variable with its first two derivatives.
type Jet = [f64; 3];

/// Jets of one factor per degree.
type Factors = [Jet; MAXIMUM_DEGREE + 1];

impl Lagrange {
    /// The element of a degree on a shape.
    ///
    /// # Errors
    /// [`ElementError::Degree`] unless the degree is 1 to 4.
    pub fn new(shape: CellShape, degree: usize) -> Result<Self, ElementError> {
        if (1..=MAXIMUM_DEGREE).contains(&degree) {
            Ok(Lagrange { shape, degree })
        } else {
            Err(ElementError::Degree { shape, degree })
        }
    }

    /// The element that maps the reference cell to cells of a mesh.
    ///
    /// # Errors
    /// [`ElementError::Geometry`] unless the degree is 1 or 2.
    pub fn geometry(shape: CellShape, degree: usize) -> Result<Self, ElementError> {
        if degree == 1 || degree == 2 {
            Ok(Lagrange { shape, degree })
        } else {
            Err(ElementError::Geometry { shape, degree })
        }
    }

    /// Number of nodes.
    #[inline]
    pub fn nodes(&self) -> usize {
        let k = self.degree;
        match self.shape {
            _ if k == 0 => 1,
            CellShape::Triangle => (k + 1) * (k + 2) / 2,
            CellShape::Quadrilateral => (k + 1) * (k + 1),
            CellShape::Tetrahedron => (k + 1) * (k + 2) * (k + 3) / 6,
            CellShape::Hexahedron => (k + 1) * (k + 1) * (k + 1),
        }
    }

    /// Number of nodes strictly inside each edge.
    #[doc(hidden)]
    #[inline]
    pub fn nodes_inside_edge(&self) -> usize {
        self.degree.saturating_sub(1)
    }

    /// Number of nodes strictly inside each face of a cell in three dimensions.
    #[doc(hidden)]
    #[inline]
    pub fn nodes_inside_face(&self) -> usize {
        let k = self.degree.max(1);
        if self.shape.is_simplex() { (k - 1) * k.saturating_sub(2) / 2 } else { (k - 1) * (k - 1) }
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
        let point = |steps: &Steps| std::array::from_fn(|k| f64::from(steps[k]) / self.degree as f64);
        lattice(self.shape, self.degree).iter().map(point).collect()
    }

    /// The element's nodes on a facet: its vertices in the order of [`CellShape::facet_vertices`], then
    /// those inside the edges between successive vertices, then (in three dimensions) those inside the face. None in
    /// degree 0.
    ///
    /// # Panics
    /// When `local` is not below [`CellShape::facets`].
    pub fn facet_nodes(&self, local: usize) -> Vec<usize> {
        if self.degree == 0 {
            return vec![];
        }
        let facet = self.shape.facet_vertices(local);
        let nodes = lattice(self.shape, self.degree);
        let points = facet_lattice(self.shape, self.degree).into_iter();
        let steps = points.map(|point| on_facet(self.shape, self.degree, facet, point));
        steps.filter_map(|steps| nodes.iter().position(|node| *node == steps)).collect()
    }

    /// Places of a facet's nodes on its own reference cell (second coordinate zero on a segment), in the order
    /// of [`Lagrange::facet_nodes`].
    #[doc(hidden)]
    pub fn facet_node_points(&self) -> Vec<[f64; 2]> {
        if self.degree == 0 {
            return vec![];
        }
        let points = facet_lattice(self.shape, self.degree).into_iter();
        points.map(|point| point.map(|step| step as f64 / self.degree as f64)).collect()
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
        if self.degree == 0 {
            return vec![[[0.0; D]; D]];
        }
        let (factors, first) = self.factors(point);
        let at_node = |steps: &Steps| -> [[f64; D]; D] {
            std::array::from_fn(|k| {
                std::array::from_fn(|l| {
                    let mut orders = [0; D];
                    orders[k] += 1;
                    orders[l] += 1;
                    let along = |orders: &[usize; D], of_first: usize| {
                        product(&factors, steps, orders) * first[self.first_step(steps)][of_first]
                    };
                    if !self.shape.is_simplex() {
                        return along(&orders, 0);
                    }
                    // Each ∂/∂ξ is ∂/∂λ of its own coordinate less ∂/∂λ₀.
                    let (mut only_k, mut only_l) = ([0; D], [0; D]);
                    only_k[k] = 1;
                    only_l[l] = 1;
                    along(&orders, 0) - along(&only_k, 1) - along(&only_l, 1) + along(&[0; D], 2)
                })
            })
        };
        lattice(self.shape, self.degree).iter().map(at_node).collect()
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
            return;
        }
        let simplex = self.shape.is_simplex();
        // The geometry of affine cells, which is evaluated more often than all else: the same bits as below.
        if simplex && self.degree == 1 {
            value[0] = 1.0 - point.iter().sum::<f64>();
            gradient[0] = [-1.0; D];
            for k in 0..D {
                value[k + 1] = point[k];
                gradient[k + 1] = std::array::from_fn(|l| f64::from(u8::from(k == l)));
            }
            return;
        }
        let (factors, first) = self.factors(point);
        for (node, steps) in lattice(self.shape, self.degree).iter().enumerate() {
            let [zeroth, slope, _] = first[self.first_step(steps)];
            let others = product(&factors, steps, &[0; D]);
            value[node] = zeroth * others;
            gradient[node] = std::array::from_fn(|k| {
                let orders: [usize; D] = std::array::from_fn(|l| usize::from(l == k));
                let own = zeroth * product(&factors, steps, &orders);
                if simplex { own - slope * others } else { own }
            });
        }
    }

    /// Values at one point, written to a slice of length [`Lagrange::nodes`]: those of [`Lagrange::evaluate`].
    ///
    /// # Panics
    /// As there.
    pub fn evaluate_values<const D: usize>(&self, point: &[f64; D], value: &mut [f64]) {
        self.check_dimension::<D>();
        if self.degree == 0 {
            value[0] = 1.0;
            return;
        }
        let nodes = lattice(self.shape, self.degree);
        if self.shape.is_simplex() {
            let first = self.values_along(1.0 - point.iter().sum::<f64>());
            let others: [_; D] = std::array::from_fn(|k| self.values_along(point[k]));
            for (value, steps) in value.iter_mut().zip(nodes) {
                let along = (0..D).map(|k| others[k][usize::from(steps[k])]);
                *value = first[self.first_step(steps)] * along.product::<f64>();
            }
            return;
        }
        let (factors, first) = self.factors(point);
        for (value, steps) in value.iter_mut().zip(nodes) {
            *value = first[self.first_step(steps)][0] * product(&factors, steps, &[0; D]);
        }
    }

    /// The factors of the basis functions: per coordinate and number of steps, and those of the first barycentric
    /// coordinate λ₀ = 1 − Σ ξ_k, which are 1 for the tensor elements.
    fn factors<const D: usize>(&self, point: &[f64; D]) -> ([Factors; D], Factors) {
        if self.shape.is_simplex() {
            let first = self.ascending(1.0 - point.iter().sum::<f64>());
            return (std::array::from_fn(|k| self.ascending(point[k])), first);
        }
        (std::array::from_fn(|k| self.segment(point[k])), [[1.0, 0.0, 0.0]; MAXIMUM_DEGREE + 1])
    }

    /// The basis on the segment, the simplex of one dimension, where two factors make one.
    fn segment(&self, x: f64) -> Factors {
        let (left, right) = (self.ascending(1.0 - x), self.ascending(x));
        std::array::from_fn(|steps| {
            let Some(rest) = self.degree.checked_sub(steps) else { return [0.0; 3] };
            let ([a, da, dda], [b, db, ddb]) = (left[rest], right[steps]);
            [a * b, a * db - da * b, dda * b - 2.0 * da * db + a * ddb]
        })
    }

    /// Value and derivative, at one coordinate, of the degree + 1 functions whose products are the basis functions of
    /// quadrilaterals and hexahedra.
    #[doc(hidden)]
    pub fn axis_factors(&self, t: f64) -> Vec<[f64; 2]> {
        self.segment(t)[..=self.degree].iter().map(|[value, slope, _]| [*value, *slope]).collect()
    }

    /// The number of the function that is each node's factor along each axis; `None` where basis functions are no products.
    #[doc(hidden)]
    pub fn grid_steps<const D: usize>(&self) -> Option<Vec<[usize; D]>> {
        if self.shape.is_simplex() || self.degree == 0 || self.shape.dimension() != D {
            return None;
        }
        let of_node = |steps: &Steps| std::array::from_fn(|axis| usize::from(steps[axis]));
        Some(lattice(self.shape, self.degree).iter().map(of_node).collect())
    }

    /// p_n(λ) = Π_{m < n} (kλ − m)/(m + 1): 1 at λ = n/k, zero at the multiples of 1/k below.
    fn ascending(&self, lambda: f64) -> Factors {
        let k = self.degree as f64;
        let mut factors = [[1.0, 0.0, 0.0]; MAXIMUM_DEGREE + 1];
        for n in 0..self.degree {
            let m = n as f64;
            let (scale, root) = (1.0 / (m + 1.0), k * lambda - m);
            let [p, dp, ddp] = factors[n];
            factors[n + 1] =
                [scale * (p * root), scale * (dp * root + k * p), scale * (ddp * root + 2.0 * k * dp)];
        }
        factors
    }

    /// The values alone of [`Lagrange::ascending`].
    fn values_along(&self, lambda: f64) -> [f64; MAXIMUM_DEGREE + 1] {
        let k = self.degree as f64;
        let mut values = [1.0; MAXIMUM_DEGREE + 1];
        for n in 0..self.degree {
            let m = n as f64;
            values[n + 1] = 1.0 / (m + 1.0) * (values[n] * (k * lambda - m));
        }
        values
    }

    /// Number of steps along λ₀; 0 for the tensor elements.
    fn first_step(&self, steps: &Steps) -> usize {
        let all: usize = steps.iter().map(|step| usize::from(*step)).sum();
        if self.shape.is_simplex() { self.degree - all } else { 0 }
    }

    fn check_dimension<const D: usize>(&self) {
        assert_eq!(self.shape.dimension(), D, "the dimension of the reference {}", self.shape.name());
    }
}

/// The product of the coordinates' factors, each differentiated as often as its order says.
fn product<const D: usize>(factors: &[Factors; D], steps: &Steps, orders: &[usize; D]) -> f64 {
    (0..D).map(|k| factors[k][usize::from(steps[k])][orders[k]]).product()
}

#[cfg(test)]
mod tests;
