//! Facets cut into pieces, each with a rule of its own: what has a kink or a jump inside a facet is integrated as exactly
//! as what has none.

use std::collections::BTreeMap;

use super::{Quadrature, QuadratureError, QuadratureRule, check_degree, simplex};
use crate::element::CellShape;
use crate::facet::Facet;

/// A piece by its corners on the facet's own reference cell: a part of the segment \[0, 1\] from the first to the second, or
/// a triangle.
pub type Piece = [[f64; 2]; 3];

/// The facets that are cut, with their pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SplitFacets {
    pieces: BTreeMap<(u32, u8), Vec<Piece>>,
}

impl SplitFacets {
    /// The pieces of a facet that is cut; they cover it without overlap. Without pieces the facet is whole again.
    pub fn cut(&mut self, facet: Facet, pieces: Vec<Piece>) {
        let key = (facet.cell, facet.local);
        match pieces.is_empty() {
            true => self.pieces.remove(&key),
            false => self.pieces.insert(key, pieces),
        };
    }

    /// The pieces of a facet, if it is cut.
    #[inline]
    pub fn pieces(&self, facet: Facet) -> Option<&[Piece]> {
        self.pieces.get(&(facet.cell, facet.local)).map(Vec::as_slice)
    }

    /// Number of facets that are cut.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Whether every facet is whole.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }
}

impl<const D: usize> Quadrature<D> {
    /// The rule on the pieces of a facet, on the facet's own reference cell: on each piece the rule that the whole facet
    /// would have, on the triangles of a quadrilateral one of twice the degree.
    ///
    /// # Errors
    /// A degree that is too high, points and weights that are not accepted, or explicit ones for a quadrilateral, which say
    /// nothing about triangles.
    pub fn rule_on_pieces(
        &self,
        shape: CellShape,
        estimated: usize,
        pieces: &[Piece],
    ) -> Result<QuadratureRule<2>, QuadratureError> {
        let one = match (shape, self) {
            (_, Quadrature::Split { whole, .. }) => return whole.rule_on_pieces(shape, estimated, pieces),
            (CellShape::Hexahedron, Quadrature::Explicit { .. }) => return Err(QuadratureError::Pieces),
            (CellShape::Hexahedron, Quadrature::Degree(degree)) => triangle(2 * degree)?,
            (CellShape::Hexahedron, Quadrature::Estimated) => triangle(2 * estimated)?,
            _ => self.facet_reference_rule(shape, estimated)?,
        };
        let mut rule = QuadratureRule { points: vec![], weights: vec![] };
        for [origin, along, across] in pieces {
            let edges = [along, across].map(|corner| [corner[0] - origin[0], corner[1] - origin[1]]);
            let plane = shape.dimension() == 2;
            let measure = match plane {
                true => edges[0][0].abs(),
                false => (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]).abs(),
            };
            for ([s, t], weight) in one.points.iter().zip(&one.weights) {
                let t = if plane { 0.0 } else { *t };
                rule.points.push([0, 1].map(|k| origin[k] + s * edges[0][k] + t * edges[1][k]));
                rule.weights.push(weight * measure);
            }
        }
        Ok(rule)
    }
}

fn triangle(degree: usize) -> Result<QuadratureRule<2>, QuadratureError> {
    check_degree(degree)?;
    let (points, weights) = simplex::triangle(degree);
    Ok(QuadratureRule { points, weights })
}
