//! Quadrature rules on reference cells and facets.

mod facet;
mod gauss;
#[doc(hidden)]
pub mod sign_changes;
mod simplex;
mod split_facets;
mod tables;
#[cfg(test)]
mod tests;

#[doc(hidden)]
pub use facet::map_to_corners;
pub use facet::{FacetRule, facet_node_rule, facet_reference_rule, facet_rule, map_to_facet};
pub use gauss::gauss_jacobi;
pub use split_facets::{Piece, SplitFacets};

use std::sync::Arc;

use thiserror::Error;

use crate::element::{CellShape, plurals};

/// The highest degree of a rule. The 51 points per direction that it takes are more than any estimate of
/// an integrand's degree should ask for.
pub const MAXIMUM_DEGREE: usize = 100;

/// Points and weights on a reference cell (or on a facet's own reference cell of dimension D − 1).
#[derive(Clone, Debug, PartialEq)]
pub struct QuadratureRule<const D: usize> {
    /// Points in reference coordinates.
    pub points: Vec<[f64; D]>,
    /// Weights; they sum to the reference cell's volume.
    pub weights: Vec<f64>,
}

/// The user's choice of quadrature.
///
/// ```
/// # use forms_mesh::quadrature::Quadrature;
/// let rule = Quadrature::<2>::Degree(4);
/// assert_ne!(rule, Quadrature::default()); // the compiler's estimate
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Quadrature<const D: usize> {
    /// Rules that are exact for polynomials of this degree: total degree on simplices, degree per
    /// direction on quadrilaterals and hexahedra (⌊degree/2⌋ + 1 Gauss points per direction).
    Degree(usize),
    /// The degree that the compiler estimated for each integral, and that of the measure (det J, or the surface element) on cells and
    /// facets whose map is not affine.
    #[default]
    Estimated,
    /// The user's own points.
    Explicit {
        /// On the reference cell.
        cell: QuadratureRule<D>,
        /// On the facet's own reference cell; on a segment the second coordinate is zero
        /// ([`QuadratureRule::on_segment`]).
        facet: QuadratureRule<2>,
    },
    /// Another choice, with some facets in pieces (`Assembler::split_at_zeros`).
    Split {
        /// On cells, on facets that are whole, and on each piece.
        whole: Box<Quadrature<D>>,
        /// The facets that are cut.
        facets: Arc<SplitFacets>,
    },
}

/// Errors of quadrature rules.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum QuadratureError {
    /// The degree is beyond [`MAXIMUM_DEGREE`].
    #[error("quadrature degree {degree} is too high; the highest is {MAXIMUM_DEGREE}")]
    Degree { degree: usize },
    /// The shape does not live in D dimensions.
    #[error("a {} has {} reference coordinates, not {dimension}", shape.name(), shape.dimension())]
    Dimension {
        shape: CellShape,
        /// The D asked for.
        dimension: usize,
    },
    /// No such local facet.
    #[error("a {} has no facet {local}; its facets are 0 to {}", shape.name(), shape.facets() - 1)]
    Facet {
        shape: CellShape,
        /// The local number asked for.
        local: usize,
    },
    /// Triangles are asked for where squares were given.
    #[error(
        "an explicit rule on the square says nothing about the triangles of a split facet; choose a degree"
    )]
    Pieces,
    /// One rule for cells of several shapes.
    #[error(
        "an explicit rule on cells needs a mesh of one shape; this one has {}: choose a degree",
        plurals(shapes)
    )]
    SeveralShapes { shapes: Vec<CellShape> },
    /// Not as many weights as points.
    #[error("the explicit {entity} rule has {points} points and {weights} weights")]
    Length {
        /// "cell" or "facet".
        entity: &'static str,
        points: usize,
        weights: usize,
    },
    /// No points at all.
    #[error("the explicit {entity} rule has no points")]
    Empty {
        /// "cell" or "facet".
        entity: &'static str,
    },
    /// A coordinate or weight is NaN or infinite.
    #[error("point {index} of the explicit {entity} rule has a coordinate or weight that is not finite")]
    NotFinite {
        /// "cell" or "facet".
        entity: &'static str,
        /// Index of the point.
        index: usize,
    },
    /// A point lies outside the reference cell.
    #[error("point {index} of the explicit {entity} rule, {point:?}, lies outside the reference {reference}")]
    Outside {
        /// "cell" or "facet".
        entity: &'static str,
        /// Name of the reference cell.
        reference: &'static str,
        /// Index of the point.
        index: usize,
        point: Vec<f64>,
    },
}

impl QuadratureRule<2> {
    /// A facet rule for cells in two dimensions, from pairs (coordinate on \[0,1\], weight).
    pub fn on_segment(rule: &[(f64, f64)]) -> Self {
        QuadratureRule {
            points: rule.iter().map(|&(s, _)| [s, 0.0]).collect(),
            weights: rule.iter().map(|&(_, weight)| weight).collect(),
        }
    }
}

impl<const D: usize> QuadratureRule<D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the rule has no points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    // A point may lie outside by the round-off of whoever computed it.
    fn validate(
        &self,
        entity: &'static str,
        reference: &'static str,
        contains: impl Fn(&[f64; D]) -> bool,
    ) -> Result<(), QuadratureError> {
        if self.points.len() != self.weights.len() {
            let (points, weights) = (self.points.len(), self.weights.len());
            return Err(QuadratureError::Length { entity, points, weights });
        }
        if self.points.is_empty() {
            return Err(QuadratureError::Empty { entity });
        }
        for (index, (point, weight)) in self.points.iter().zip(&self.weights).enumerate() {
            if !weight.is_finite() || point.iter().any(|coordinate| !coordinate.is_finite()) {
                return Err(QuadratureError::NotFinite { entity, index });
            }
            if !contains(point) {
                return Err(QuadratureError::Outside { entity, reference, index, point: point.to_vec() });
            }
        }
        Ok(())
    }
}

const ROUND_OFF: f64 = 1e-12;

impl<const D: usize> Quadrature<D> {
    /// Whether integrals over the same entities may have different rules, as the compiler estimates their degrees.
    #[doc(hidden)]
    pub fn follows_estimates(&self) -> bool {
        match self {
            Quadrature::Estimated => true,
            Quadrature::Degree(_) | Quadrature::Explicit { .. } => false,
            Quadrature::Split { whole, .. } => whole.follows_estimates(),
        }
    }

    /// The rule on cells; `estimated` is the degree of [`Quadrature::Estimated`].
    ///
    /// # Errors
    /// Any [`QuadratureError`].
    pub fn cell_rule(
        &self,
        shape: CellShape,
        estimated: usize,
    ) -> Result<QuadratureRule<D>, QuadratureError> {
        match self {
            Quadrature::Degree(degree) => cell_rule(shape, *degree),
            Quadrature::Estimated => cell_rule(shape, estimated),
            Quadrature::Explicit { cell, .. } => {
                check_dimension::<D>(shape)?;
                cell.validate("cell", shape.name(), |point| shape.contains(point, ROUND_OFF))?;
                Ok(cell.clone())
            }
            Quadrature::Split { whole, .. } => whole.cell_rule(shape, estimated),
        }
    }

    /// The degree of its rules, for parts of cells and facets that have rules of their own; `estimated` is that of
    /// [`Quadrature::Estimated`]. None where points are given explicitly.
    #[doc(hidden)]
    pub fn degree(&self, estimated: usize) -> Option<usize> {
        match self {
            Quadrature::Degree(degree) => Some(*degree),
            Quadrature::Estimated => Some(estimated),
            Quadrature::Explicit { .. } => None,
            Quadrature::Split { whole, .. } => whole.degree(estimated),
        }
    }

    /// The rule on the cells of one of a mesh's shapes.
    ///
    /// # Errors
    /// [`QuadratureError`]: a rule that is given explicitly, on a mesh of several shapes.
    #[doc(hidden)]
    pub fn rule_on_cells(
        &self,
        shapes: &[CellShape],
        shape: CellShape,
        estimated: usize,
    ) -> Result<QuadratureRule<D>, QuadratureError> {
        let mut choice = self;
        while let Quadrature::Split { whole, .. } = choice {
            choice = whole;
        }
        match (choice, shapes) {
            (Quadrature::Explicit { .. }, shapes) if shapes.len() > 1 => {
                Err(QuadratureError::SeveralShapes { shapes: shapes.to_vec() })
            }
            _ => self.cell_rule(shape, estimated),
        }
    }

    /// The rule on a local facet that is whole; `estimated` is the degree of [`Quadrature::Estimated`].
    ///
    /// # Errors
    /// Any [`QuadratureError`].
    pub fn facet_rule(
        &self,
        shape: CellShape,
        local: usize,
        estimated: usize,
    ) -> Result<FacetRule<D>, QuadratureError> {
        map_to_facet(shape, local, &self.facet_reference_rule(shape, estimated)?)
    }

    /// The rule on the own reference cell of a facet that is whole, before it is mapped to a facet.
    ///
    /// # Errors
    /// A degree that is too high, or points and weights that are not accepted.
    pub fn facet_reference_rule(
        &self,
        shape: CellShape,
        estimated: usize,
    ) -> Result<QuadratureRule<2>, QuadratureError> {
        match self {
            Quadrature::Degree(degree) => facet_reference_rule(shape, *degree),
            Quadrature::Estimated => facet_reference_rule(shape, estimated),
            Quadrature::Explicit { facet, .. } => {
                let (reference, inside): (_, fn(&[f64; 2]) -> bool) = match shape {
                    CellShape::Triangle | CellShape::Quadrilateral => ("segment", |point| {
                        point[1] == 0.0 && CellShape::Quadrilateral.contains(point, ROUND_OFF)
                    }),
                    CellShape::Tetrahedron => {
                        ("triangle", |point| CellShape::Triangle.contains(point, ROUND_OFF))
                    }
                    CellShape::Hexahedron => {
                        ("quadrilateral", |point| CellShape::Quadrilateral.contains(point, ROUND_OFF))
                    }
                };
                facet.validate("facet", reference, inside)?;
                Ok(facet.clone())
            }
            Quadrature::Split { whole, .. } => whole.facet_reference_rule(shape, estimated),
        }
    }
}

/// The rule of a degree on a reference cell: exact for polynomials of this total degree, on
/// quadrilaterals and hexahedra also of this degree in each direction. Points lie inside, weights are
/// positive.
///
/// # Errors
/// A wrong dimension or a degree that is too high.
pub fn cell_rule<const D: usize>(
    shape: CellShape,
    degree: usize,
) -> Result<QuadratureRule<D>, QuadratureError> {
    check_dimension::<D>(shape)?;
    check_degree(degree)?;
    let (points, weights) = match shape {
        CellShape::Triangle => resize(simplex::triangle(degree)),
        CellShape::Tetrahedron => resize(simplex::tetrahedron(degree)),
        CellShape::Quadrilateral | CellShape::Hexahedron => tensor(degree),
    };
    Ok(QuadratureRule { points, weights })
}

// The shape has D dimensions: this only tells the type so.
fn resize<const N: usize, const D: usize>(
    (points, weights): (Vec<[f64; N]>, Vec<f64>),
) -> (Vec<[f64; D]>, Vec<f64>) {
    (points.into_iter().map(|point| std::array::from_fn(|k| point[k])).collect(), weights)
}

// Gauss points on [0, 1].
fn segment(degree: usize) -> Vec<(f64, f64)> {
    gauss_jacobi(degree / 2 + 1, 0)
}

// Tensor products of Gauss points; the first coordinate runs fastest.
fn tensor<const D: usize>(degree: usize) -> (Vec<[f64; D]>, Vec<f64>) {
    let line = segment(degree);
    let count = line.len().pow(D as u32);
    let digit = |index: usize, k: usize| line[index / line.len().pow(k as u32) % line.len()];
    let points = (0..count).map(|index| std::array::from_fn(|k| digit(index, k).0)).collect();
    let weights = (0..count).map(|index| (0..D).map(|k| digit(index, k).1).product()).collect();
    (points, weights)
}

fn check_degree(degree: usize) -> Result<(), QuadratureError> {
    if degree > MAXIMUM_DEGREE { Err(QuadratureError::Degree { degree }) } else { Ok(()) }
}

fn check_dimension<const D: usize>(shape: CellShape) -> Result<(), QuadratureError> {
    if shape.dimension() == D { Ok(()) } else { Err(QuadratureError::Dimension { shape, dimension: D }) }
}
