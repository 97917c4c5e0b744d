//! The kinds of elements that a space can have, each on the shapes that it knows.

use std::fmt;
use std::sync::Arc;

use super::lagrange::{ElementError, Lagrange};
use super::lattice::MAXIMUM_DEGREE;
use super::layout::Layout;
use super::points::RulePoints;
use super::polynomial::{Polynomial, bernstein, complete, products, serendipity};
use super::table::Table;
use super::{CellShape, Element};

/// A kind of element: the functions on a reference cell of each shape.
///
/// A coefficient is the value at a node, unless an element says otherwise. Who shares a coefficient is the matter of a space's scope.
#[derive(Clone, Debug, PartialEq)]
pub enum Elements {
    /// [`Lagrange`] elements of degree 1 to 4, and of degree 0 where values may jump.
    Lagrange(usize),
    /// Lagrange elements of degree 1 or 2 on triangles and tetrahedra with bubbles: in degree 1 the product of the barycentric
    /// coordinates, for the MINI element with a continuous pressure of degree 1; in degree 2 also the products of three of them on each
    /// face of a tetrahedron, for a discontinuous pressure of degree 1.
    Mini(usize),
    /// Crouzeix and Raviart's element on triangles and tetrahedra: polynomials of degree 1 that are continuous in the centres of the
    /// facets, where their nodes are.
    CrouzeixRaviart,
    /// The serendipity element of degree 2: 8 nodes on quadrilaterals, 20 on hexahedra; on simplices the Lagrange element of degree 2.
    ///
    /// On cells with an affine map it holds all polynomials of degree 2, on straight ones and on those of 8 or 20 nodes those of degree
    /// 1. Only the Lagrange element of degree 2 keeps its order on cells that stay distorted under refinement.
    Serendipity,
    /// Polynomials of degree 1 of the position, not of the reference coordinates: P₋₁, the pressure of the Q2/P₋₁ element. Its D + 1
    /// nodes are those of a simplex around the centre, mapped by the cell's map linearised there. For scopes of one cell.
    LinearInSpace,
    /// Multipliers on facets that are dual to Lagrange elements of degree 1: with ψ_i of a vertex and φ_j of another one, ∫ ψ_i φ_j over
    /// a facet is zero, and ∫ ψ_i φ_i = ∫ φ_i. On a segment these are 2 − 3s and 3s − 1. They are dual on facets with an affine map;
    /// coefficients are no values of functions. On own facets of contact pairs the integrals are those over the part that has opposite points, and duality is
    /// given up gradually where that part is small: functions stay bounded, their sum is 1, and ∫ ψ_i = ∫ φ_i. For scopes on facets.
    Dual,
    /// Multipliers on facets that are dual to Bernstein's polynomials of degree 2, as [`Elements::Dual`] to those of degree 1.
    DualOfBernstein,
    /// Bernstein's polynomials of degree 1, those of Lagrange, or 2, on facets: multipliers of contact, as their functions are nowhere negative.
    /// On a segment those of degree 2 are (1 − s)², 2s(1 − s) and s², on quadrilaterals their products. They sum to one, and the coefficients
    /// of a function that is linear on an affine facet are its values at the nodes; else coefficients are no values. For scopes on facets.
    Bernstein(usize),
    /// Values at the points of the cells' rule of a degree, for `Scope::Point`: laws with an
    /// unknown at each point. They have no gradient. Integrals that read them take that rule.
    Points(usize),
    /// Elements of a user, one per shape ([`Element::from_table`]).
    Own(Arc<Vec<Element>>),
}

impl Elements {
    /// A user's elements, one per shape of the mesh's cells.
    pub fn own(elements: impl IntoIterator<Item = Element>) -> Self {
        Elements::Own(Arc::new(elements.into_iter().collect()))
    }

    /// Whether a coefficient is the value at its node.
    #[doc(hidden)]
    pub fn is_nodal(&self) -> bool {
        !(self.is_dual() || matches!(self, Elements::Bernstein(2..)))
    }

    /// Whether functions on facets are dual to others.
    #[doc(hidden)]
    pub fn is_dual(&self) -> bool {
        matches!(self, Elements::Dual | Elements::DualOfBernstein)
    }

    /// The element on a shape.
    ///
    /// # Errors
    /// [`ElementError`]: a degree or a shape that there is no such element for.
    pub fn on(&self, shape: CellShape) -> Result<Element, ElementError> {
        let dimension = shape.dimension();
        let only_on_simplices = || match shape.is_simplex() {
            true => Ok(()),
            false => Err(ElementError::Shape { elements: self.to_string(), shape }),
        };
        match self {
            Elements::Lagrange(degree) if *degree <= MAXIMUM_DEGREE => {
                Ok(Element::Lagrange(Lagrange { shape, degree: *degree }))
            }
            Elements::Lagrange(degree) => Err(ElementError::Degree { shape, degree: *degree }),
            Elements::Mini(degree @ (1 | 2)) => {
                only_on_simplices()?;
                let mut of_entity = [1, degree - 1, 0, 0];
                of_entity[dimension] = 1;
                let mut span = complete(dimension, *degree);
                let coordinates = Polynomial::barycentric(dimension);
                let product = |left_out: Option<usize>| {
                    let factors = coordinates.iter().enumerate().filter(|(k, _)| Some(*k) != left_out);
                    factors.fold(Polynomial::monomial([0; 3]), |product, (_, factor)| product.times(factor))
                };
                if dimension == 3 && *degree == 2 {
                    of_entity[2] = 1;
                    span.extend((0..4).map(|face| product(Some(face))));
                }
                span.push(product(None));
                let layout = Layout::centred(shape, of_entity);
                // Rules count the polynomials that are complete; bubbles are of higher degree.
                Element::of(Table::nodal(self.to_string(), layout, dimension + 1, &span))
            }
            Elements::Mini(degree) => Err(ElementError::Bubbles { degree: *degree }),
            Elements::CrouzeixRaviart => {
                only_on_simplices()?;
                let mut of_entity = [0; 4];
                of_entity[dimension - 1] = 1;
                let layout = Layout::centred(shape, of_entity);
                Element::of(Table::nodal(self.to_string(), layout, 1, &complete(dimension, 1)))
            }
            Elements::Serendipity if shape.is_simplex() => {
                Ok(Element::Lagrange(Lagrange { shape, degree: 2 }))
            }
            Elements::Serendipity => {
                let layout = Layout::centred(shape, [1, 1, 0, 0]);
                Element::of(Table::nodal(self.to_string(), layout, 2, &serendipity(dimension)))
            }
            Elements::LinearInSpace => {
                let centre = shape.centre::<3>();
                // The corners of a simplex whose mean is the centre.
                let spread = if shape.is_simplex() { 0.5 } else { 0.75 };
                let mean = spread / (dimension + 1) as f64;
                let point = |corner: usize| {
                    let step = |k: usize| if k < dimension { -mean } else { 0.0 };
                    let towards = |k: usize| if k + 1 == corner { spread } else { 0.0 };
                    std::array::from_fn(|k| centre[k] + step(k) + towards(k))
                };
                let points = (0..=dimension).map(point).collect();
                let mut of_entity = [0; 4];
                of_entity[dimension] = dimension + 1;
                let layout = Layout { shape, of_entity, points };
                let table = Table::nodal(self.to_string(), layout, 1, &complete(dimension, 1));
                Element::of(table.map(Table::in_space))
            }
            Elements::Dual => {
                let span = if shape.is_simplex() { complete(dimension, 1) } else { products(dimension) };
                let layout = Layout::centred(shape, [1, 0, 0, 0]);
                Element::of(Table::nodal(self.to_string(), layout, 1, &span).map(Table::dual))
            }
            Elements::Bernstein(1) => Ok(Element::Lagrange(Lagrange { shape, degree: 1 })),
            Elements::Bernstein(2) | Elements::DualOfBernstein => {
                let layout = Layout::of_degree_two(shape);
                let functions: Vec<Polynomial> =
                    layout.points.iter().map(|node| bernstein(shape.is_simplex(), dimension, node)).collect();
                let table = Table::of_functions(self.to_string(), layout, 2, &functions);
                let meant = if self.is_dual() { Table::dual_of_bernstein } else { Table::of_bernstein };
                Element::of(table.map(meant))
            }
            Elements::Bernstein(degree) => Err(ElementError::Bernstein { degree: *degree }),
            Elements::Points(degree) => Ok(Element::Points(Arc::new(RulePoints::of(shape, *degree)?))),
            Elements::Own(elements) => {
                let own = elements.iter().find(|element| element.shape() == shape);
                own.cloned().ok_or(ElementError::Missing { shape })
            }
        }
    }
}

impl fmt::Display for Elements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Elements::Lagrange(degree) => write!(f, "Lagrange elements of degree {degree}"),
            Elements::Mini(degree) => write!(f, "elements of degree {degree} with bubbles"),
            Elements::CrouzeixRaviart => write!(f, "Crouzeix-Raviart elements"),
            Elements::Serendipity => write!(f, "serendipity elements"),
            Elements::LinearInSpace => write!(f, "elements that are linear in space"),
            Elements::Points(degree) => write!(f, "values at the points of the rule of degree {degree}"),
            Elements::Bernstein(degree) => write!(f, "Bernstein elements of degree {degree}"),
            Elements::Dual => write!(f, "dual elements of degree 1"),
            Elements::DualOfBernstein => write!(f, "dual elements of degree 2"),
            Elements::Own(elements) => {
                let names: Vec<&str> = elements.iter().map(Element::name).collect();
                write!(f, "elements \"{}\"", names.join("\" and \""))
            }
        }
    }
}
