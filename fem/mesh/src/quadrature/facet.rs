//! Rules on the facets of a cell, in the cell's reference coordinates.

use super::{QuadratureError, QuadratureRule, check_dimension, segment, simplex, tensor};
use crate::element::{CellShape, Lagrange};

/// A quadrature rule on one local facet of a reference cell.
///
/// With the cell's Jacobian J and the tangents t, the surface element at a point is |J t₀| in two
/// dimensions and |J t₀ × J t₁| in three; the outward normal is J t₀ turned clockwise, (y, −x), or the
/// direction of J t₀ × J t₁.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetRule<const D: usize> {
    /// Points in the cell's reference coordinates.
    pub points: Vec<[f64; D]>,
    /// Weights; they sum to the measure of the facet's own reference cell.
    pub weights: Vec<f64>,
    /// ∂(cell coordinates)/∂(facet coordinates), constant on the facet; the second is zero for D = 2.
    pub tangents: [[f64; D]; 2],
}

/// The rule of a degree on a facet's own reference cell: the segment \[0,1\] (second coordinate zero),
/// the unit triangle, or the unit square, as the shape's facets are.
///
/// # Errors
/// [`QuadratureError::Degree`] when the degree is too high.
pub fn facet_reference_rule(shape: CellShape, degree: usize) -> Result<QuadratureRule<2>, QuadratureError> {
    super::check_degree(degree)?;
    let (points, weights) = match shape {
        CellShape::Triangle | CellShape::Quadrilateral => {
            let (points, weights): (Vec<f64>, Vec<f64>) = segment(degree).into_iter().unzip();
            (points.into_iter().map(|s| [s, 0.0]).collect(), weights)
        }
        CellShape::Tetrahedron => simplex::triangle(degree),
        CellShape::Hexahedron => tensor(degree),
    };
    Ok(QuadratureRule { points, weights })
}

/// The nodes of degree 1 or 2 of a facet's own reference cell, each with an equal part of its measure, which is the integral of its Bernstein
/// polynomial. With those of degree 1, its vertices, the rule is exact for functions of degree 1, in each direction on quadrilaterals.
pub fn facet_node_rule(shape: CellShape, degree: usize) -> QuadratureRule<2> {
    let points = Lagrange { shape, degree }.facet_node_points();
    let measure = if shape == CellShape::Tetrahedron { 0.5 } else { 1.0 };
    QuadratureRule { weights: vec![measure / points.len() as f64; points.len()], points }
}

/// The rule of a degree on a local facet.
///
/// # Errors
/// A wrong dimension, an unknown local facet, or a degree that is too high.
pub fn facet_rule<const D: usize>(
    shape: CellShape,
    local: usize,
    degree: usize,
) -> Result<FacetRule<D>, QuadratureError> {
    map_to_facet(shape, local, &facet_reference_rule(shape, degree)?)
}

/// A rule of the facet's own reference cell, mapped to a local facet: the first facet coordinate runs from
/// the facet's first vertex to its second, the second one from the first vertex to the last
/// ([`CellShape::facet_vertices`]).
///
/// # Errors
/// A wrong dimension or an unknown local facet.
pub fn map_to_facet<const D: usize>(
    shape: CellShape,
    local: usize,
    rule: &QuadratureRule<2>,
) -> Result<FacetRule<D>, QuadratureError> {
    check_dimension::<D>(shape)?;
    if local >= shape.facets() {
        return Err(QuadratureError::Facet { shape, local });
    }
    let vertices = shape.facet_vertices(local);
    let last = vertices[vertices.len() - 1];
    let corner = shape.vertex_points();
    let corners = [vertices[0], vertices[1], last].map(|vertex| std::array::from_fn(|k| corner[vertex][k]));
    Ok(map_to_corners(corners, rule))
}

/// A rule of the facet's own reference cell, mapped to the facet, or a part of one, with these vertices in the cell's
/// reference coordinates: the first facet coordinate runs from the first to the second, the other from the first to the
/// last. In two dimensions the last one does not matter. Any order of a facet's vertices that runs around it will do, so
/// that the points of one side of an interior facet can be found on the other.
#[doc(hidden)]
pub fn map_to_corners<const D: usize>(
    [first, second, last]: [[f64; D]; 3],
    rule: &QuadratureRule<2>,
) -> FacetRule<D> {
    let along: [f64; D] = std::array::from_fn(|k| second[k] - first[k]);
    let across: [f64; D] = std::array::from_fn(|k| if D == 2 { 0.0 } else { last[k] - first[k] });
    let points = rule
        .points
        .iter()
        .map(|[s, t]| std::array::from_fn(|k| first[k] + s * along[k] + t * across[k]))
        .collect();
    FacetRule { points, weights: rule.weights.clone(), tangents: [along, across] }
}
