//! An element of any kind: the nodes and functions on one reference cell.

use std::sync::Arc;

use super::CellShape;
use super::lagrange::{ElementError, Lagrange, Tables};
use super::layout::Layout;
use super::points::RulePoints;
use super::polynomial::Polynomial;
use super::table::{Meaning, Table, inverse};
use crate::quadrature::{FacetRule, facet_rule};

/// The functions on a reference cell, with a node each: a Lagrange element or a table of polynomials.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    /// A Lagrange element, with its ways of fast evaluation.
    Lagrange(Lagrange),
    /// Sums of monomials.
    Table(Arc<Table>),
    /// Values at points.
    Points(Arc<RulePoints>),
}

impl Element {
    pub(super) fn of(table: Result<Table, ElementError>) -> Result<Self, ElementError> {
        Ok(Element::Table(Arc::new(table?)))
    }

    /// An element of one's own: the span of some polynomials, given by their values at nodes.
    ///
    /// - `of_entity`: numbers of nodes per vertex, edge, face and cell (in two dimensions cells are the third entry). Edges and
    ///   faces have one node at most, in the middle, so that cells on both sides agree.
    /// - `points`: reference coordinates of the nodes, in the order vertices, edges, faces, cell, as those of [`Lagrange`].
    /// - `span`: polynomials, each a list of terms, exponents with a coefficient. There are as many as nodes.
    /// - `degree`: what the estimates of quadrature degrees count.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::{CellShape, Element};
    ///
    /// // Bilinear functions and a bubble on the square.
    /// let vertices = CellShape::Quadrilateral.vertex_points();
    /// let points: Vec<[f64; 2]> = vertices.iter().map(|x| [x[0], x[1]]).chain([[0.5, 0.5]]).collect();
    /// let one = |x, y| vec![([x, y], 1.0)];
    /// let bubble = vec![([1, 1], 1.0), ([2, 1], -1.0), ([1, 2], -1.0), ([2, 2], 1.0)];
    /// let span = [one(0, 0), one(1, 0), one(0, 1), one(1, 1), bubble];
    /// let element = Element::from_table("Q1 with a bubble", CellShape::Quadrilateral, [1, 0, 1, 0], &points, &span, 2)?;
    /// assert_eq!(element.nodes(), 5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ElementError::Table`] says what does not fit; [`ElementError::NotUnisolvent`] where the values at the nodes do not determine
    /// the polynomial.
    pub fn from_table<const D: usize>(
        name: &str,
        shape: CellShape,
        of_entity: [usize; 4],
        points: &[[f64; D]],
        span: &[Vec<([u8; D], f64)>],
        degree: usize,
    ) -> Result<Self, ElementError> {
        let refused = |reason| Err(ElementError::Table { name: name.to_owned(), reason });
        if shape.dimension() != D {
            return refused("its points have the dimension of its shape");
        }
        let points = points.iter().map(|x| std::array::from_fn(|k| if k < D { x[k] } else { 0.0 })).collect();
        let layout = Layout { shape, of_entity, points };
        if layout.counted() != layout.nodes() || (D == 2 && of_entity[3] > 0) {
            return refused(
                "it has the number of points that its vertices, edges, faces and its cell have nodes",
            );
        }
        if of_entity[..D].iter().any(|count| *count > 1) {
            return refused("it has one node at most per vertex, edge and face");
        }
        let shared = Layout::centred(shape, std::array::from_fn(|k| if k < D { of_entity[k] } else { 0 }));
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-12);
        if shared.points.iter().zip(&layout.points).any(apart) {
            return refused("its nodes at vertices, edges and faces are in their middle");
        }
        let polynomial = |terms: &Vec<([u8; D], f64)>| Polynomial {
            terms: terms
                .iter()
                .map(|(e, c)| (std::array::from_fn(|k| if k < D { e[k] } else { 0 }), *c))
                .collect(),
        };
        let span: Vec<Polynomial> = span.iter().map(polynomial).collect();
        Element::of(Table::nodal(name.to_owned(), layout, degree, &span))
    }

    /// The reference cell.
    pub fn shape(&self) -> CellShape {
        match self {
            Element::Lagrange(lagrange) => lagrange.shape,
            Element::Table(table) => table.layout.shape,
            Element::Points(points) => points.shape,
        }
    }

    /// Name of the element, for messages.
    pub fn name(&self) -> &str {
        match self {
            Element::Lagrange(_) => "Lagrange",
            Element::Table(table) => &table.name,
            Element::Points(_) => "points",
        }
    }

    /// The degree that estimates of quadrature degrees count.
    pub fn degree(&self) -> usize {
        match self {
            Element::Lagrange(lagrange) => lagrange.degree,
            Element::Table(table) => table.degree,
            // Their integrals take the rule of their points.
            Element::Points(_) => 0,
        }
    }

    /// Number of nodes, and of functions.
    #[inline]
    pub fn nodes(&self) -> usize {
        match self {
            Element::Lagrange(lagrange) => lagrange.nodes(),
            Element::Table(table) => table.layout.nodes(),
            Element::Points(points) => points.points.len(),
        }
    }

    /// Nodes per vertex, edge, face and cell; in two dimensions cells are the third entry.
    pub fn of_entity(&self) -> [usize; 4] {
        match self {
            Element::Table(table) => table.layout.of_entity,
            Element::Points(points) => {
                let mut of_entity = [0; 4];
                of_entity[points.shape.dimension()] = points.points.len();
                of_entity
            }
            Element::Lagrange(lagrange) => {
                let [edge, face] = [lagrange.nodes_inside_edge(), lagrange.nodes_inside_face()];
                let (shape, vertex) = (lagrange.shape, usize::from(lagrange.degree > 0));
                let boundary = shape.vertices() * vertex + shape.edges().len() * edge;
                match shape.dimension() {
                    2 => [vertex, edge, lagrange.nodes() - boundary, 0],
                    _ => [vertex, edge, face, lagrange.nodes() - boundary - shape.facets() * face],
                }
            }
        }
    }

    /// The Lagrange element, if it is one.
    #[inline]
    pub fn as_lagrange(&self) -> Option<Lagrange> {
        match self {
            Element::Lagrange(lagrange) => Some(*lagrange),
            Element::Table(_) | Element::Points(_) => None,
        }
    }

    /// The table, if it is one.
    #[doc(hidden)]
    pub fn as_table(&self) -> Option<&Table> {
        match self {
            Element::Lagrange(_) | Element::Points(_) => None,
            Element::Table(table) => Some(table),
        }
    }

    /// The Lagrange element that has the same functions on facets, with the same numbers of the nodes there.
    #[doc(hidden)]
    pub fn traces(&self) -> Option<Lagrange> {
        match self {
            Element::Lagrange(lagrange) => Some(*lagrange),
            Element::Table(table) => table.traces,
            Element::Points(_) => None,
        }
    }

    /// Reference coordinates of the nodes.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn node_points<const D: usize>(&self) -> Vec<[f64; D]> {
        match self {
            Element::Lagrange(lagrange) => lagrange.node_points(),
            Element::Table(table) => {
                table.layout.points.iter().map(|x| std::array::from_fn(|k| x[k])).collect()
            }
            Element::Points(points) => points.points.iter().map(|x| std::array::from_fn(|k| x[k])).collect(),
        }
    }

    /// The nodes on a facet, as [`Lagrange::facet_nodes`].
    pub fn facet_nodes(&self, local: usize) -> Vec<usize> {
        match self {
            Element::Lagrange(lagrange) => lagrange.facet_nodes(local),
            Element::Table(table) => table.layout.facet_nodes(local),
            Element::Points(_) => vec![],
        }
    }

    /// Places of a facet's nodes on its own reference cell, as [`Lagrange::facet_node_points`].
    #[doc(hidden)]
    pub fn facet_node_points(&self) -> Vec<[f64; 2]> {
        match self {
            Element::Lagrange(lagrange) => lagrange.facet_node_points(),
            Element::Table(table) => table.layout.facet_node_points(),
            Element::Points(_) => vec![],
        }
    }

    /// The functions that do not vanish on a facet.
    pub fn seen(&self, local: usize) -> Vec<usize> {
        match self {
            Element::Lagrange(lagrange) if lagrange.degree == 0 => vec![0],
            Element::Lagrange(lagrange) => lagrange.facet_nodes(local),
            Element::Table(table) => table.seen[local].clone(),
            Element::Points(points) => (0..points.points.len()).collect(),
        }
    }

    /// Whether a function's values on a facet follow from those at the nodes on it. Crouzeix and Raviart's do not, nor those of nodes
    /// inside a cell.
    pub fn has_traces(&self) -> bool {
        let sorted = |mut nodes: Vec<usize>| {
            nodes.sort_unstable();
            nodes
        };
        match self {
            Element::Lagrange(lagrange) => lagrange.degree > 0,
            Element::Points(_) => false,
            Element::Table(table) => (0..table.layout.shape.facets())
                .all(|local| sorted(self.facet_nodes(local)) == self.seen(local)),
        }
    }

    /// Whether functions with the same values at the nodes that cells share are the same on the facets that they share.
    pub fn conforms(&self) -> bool {
        match self {
            Element::Lagrange(lagrange) => lagrange.degree > 0,
            Element::Table(table) => table.conforms,
            Element::Points(_) => false,
        }
    }

    /// Whether its functions on facets are those that are dual to the element's own.
    #[doc(hidden)]
    pub fn is_dual(&self) -> bool {
        self.as_table().is_some_and(|table| matches!(table.meaning, Meaning::Dual | Meaning::DualOfBernstein))
    }

    /// Coefficients of dual functions in the functions of the nodes on a facet, row after row: D M⁻¹ with ∫ φ_i φ_j and ∫ φ_i over the facet.
    #[doc(hidden)]
    pub fn dual_on_facet(&self, local: usize) -> Option<Vec<f64>> {
        let table = self.as_table().filter(|_| self.is_dual())?;
        // Products of two functions of degree 2 at most.
        let (shape, degree) = (table.layout.shape, 4);
        let rule: Vec<([f64; 3], f64)> = match shape.dimension() {
            2 => weighted_points(&facet_rule::<2>(shape, local, degree).ok()?),
            _ => weighted_points(&facet_rule::<3>(shape, local, degree).ok()?),
        };
        let nodes = self.facet_nodes(local);
        let (mut value, mut areas) = (vec![0.0; self.nodes()], vec![0.0; nodes.len()]);
        let mut moments = vec![vec![0.0; nodes.len()]; nodes.len()];
        for (point, weight) in rule {
            table.evaluate_values(&point, &mut value);
            for (i, a) in nodes.iter().enumerate() {
                areas[i] += weight * value[*a];
                for (j, b) in nodes.iter().enumerate() {
                    moments[i][j] += weight * value[*a] * value[*b];
                }
            }
        }
        for row in &mut moments {
            row.iter_mut().zip(&areas).for_each(|(entry, area)| *entry /= area);
        }
        Some(inverse(moments)?.concat())
    }

    /// The Lagrange element with the same nodes, whose values at nodes are this one's coefficients, where these are no values.
    #[doc(hidden)]
    pub fn of_coefficients(&self) -> Option<Lagrange> {
        let table = self.as_table()?;
        let degree = match table.meaning {
            Meaning::Values => return None,
            Meaning::Dual => 1,
            Meaning::Bernstein | Meaning::DualOfBernstein => 2,
        };
        Some(Lagrange { shape: table.layout.shape, degree })
    }

    /// The coefficients of a function on a facet by its values at the nodes there, row after row, where they are Bernstein's.
    #[doc(hidden)]
    pub fn coefficients_by_values(&self) -> Option<Vec<Vec<f64>>> {
        let table = self.as_table().filter(|table| table.meaning == Meaning::Bernstein)?;
        let (nodes, mut value) = (self.facet_nodes(0), vec![0.0; self.nodes()]);
        let row = |at: &usize| {
            table.evaluate_values(&table.layout.points[*at], &mut value);
            nodes.iter().map(|node| value[*node]).collect()
        };
        inverse(nodes.iter().map(row).collect())
    }

    /// Whether it has values at the points of a rule only.
    pub fn is_at_points(&self) -> bool {
        matches!(self, Element::Points(_))
    }

    /// Whether the functions are polynomials of the position.
    #[inline]
    pub fn is_in_space(&self) -> bool {
        matches!(self, Element::Table(table) if table.in_space)
    }

    /// Values and reference gradients of all functions at some points.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn tabulate<const D: usize>(&self, points: &[[f64; D]]) -> Tables<D> {
        let Element::Lagrange(lagrange) = self else {
            let nodes = self.nodes();
            let mut value = vec![0.0; nodes * points.len()];
            let mut gradient = vec![[0.0; D]; nodes * points.len()];
            for (q, point) in points.iter().enumerate() {
                let range = q * nodes..(q + 1) * nodes;
                self.evaluate(point, &mut value[range.clone()], &mut gradient[range]);
            }
            return Tables { nodes, points: points.len(), value, gradient, hessian: vec![] };
        };
        lagrange.tabulate(points)
    }

    /// [`Element::tabulate`] with second derivatives.
    ///
    /// # Panics
    /// When D is not the shape's dimension.
    pub fn tabulate_with_hessians<const D: usize>(&self, points: &[[f64; D]]) -> Tables<D> {
        match self {
            Element::Lagrange(lagrange) => lagrange.tabulate_with_hessians(points),
            Element::Points(_) => {
                let hessian = vec![[[f64::NAN; D]; D]; self.nodes() * points.len()];
                Tables { hessian, ..self.tabulate(points) }
            }
            Element::Table(table) => {
                let hessian = points.iter().flat_map(|point| table.hessians(point)).collect();
                Tables { hessian, ..self.tabulate(points) }
            }
        }
    }

    /// Values and reference gradients at one point, written to slices of length [`Element::nodes`] or more.
    ///
    /// # Panics
    /// When D is not the shape's dimension, or a slice is too short.
    pub fn evaluate<const D: usize>(&self, point: &[f64; D], value: &mut [f64], gradient: &mut [[f64; D]]) {
        match self {
            Element::Lagrange(lagrange) => lagrange.evaluate(point, value, gradient),
            Element::Table(table) => table.evaluate(point, value, gradient),
            Element::Points(points) => {
                points.values(point, value);
                gradient.fill([f64::NAN; D]);
            }
        }
    }

    /// Values at one point, written to a slice of length [`Element::nodes`] or more.
    ///
    /// # Panics
    /// As [`Element::evaluate`].
    #[inline]
    pub fn evaluate_values<const D: usize>(&self, point: &[f64; D], value: &mut [f64]) {
        match self {
            Element::Lagrange(lagrange) => lagrange.evaluate_values(point, value),
            Element::Table(table) => table.evaluate_values(point, value),
            Element::Points(points) => points.values(point, value),
        }
    }
}

#[cfg(test)]
mod tests;

/// The points of a rule with their weights.
fn weighted_points<const D: usize>(rule: &FacetRule<D>) -> Vec<([f64; 3], f64)> {
    let padded = |point: &[f64; D]| std::array::from_fn(|k| if k < D { point[k] } else { 0.0 });
    rule.points.iter().map(padded).zip(rule.weights.iter().copied()).collect()
}
