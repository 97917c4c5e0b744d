//! Feet of the nodes of opposite facets in space, in an own facet's coordinates: the corners of the polygon that a facet is there.
//!
//! Of facets of degree two the middle nodes of edges have feet, too. An edge is the same chords for both of its facets, so that their polygons leave no
//! gap, and where it bends the polygon need not be convex.

use super::segment_motion::foot_matrix;
use super::surface::{SurfaceFacet, dot, minus};

/// Steps of Newton's method for a foot.
const STEPS: usize = 30;

/// The error after a step is the square of its length.
const LAST_STEP: f64 = 1e-9;

impl<const D: usize> SurfaceFacet<'_, D> {
    /// The nodes of its outline, in their order: of degree two in space each corner is followed by the middle node of an edge.
    pub fn outline(&self) -> &'static [[f64; 2]] {
        let corners = self.parameters();
        match (D == 3 && self.degree == 2, corners.len()) {
            (true, 3) => &[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [0.0, 0.5]],
            (true, _) => &[
                [0.0, 0.0],
                [0.5, 0.0],
                [1.0, 0.0],
                [1.0, 0.5],
                [1.0, 1.0],
                [0.5, 1.0],
                [0.0, 1.0],
                [0.0, 0.5],
            ],
            _ => corners,
        }
    }
}

/// Whether a symmetric matrix is positive definite.
pub(super) fn is_positive(matrix: &[[f64; 2]; 2]) -> bool {
    matrix[0][0] > 0.0 && matrix[0][0] * matrix[1][1] > matrix[0][1] * matrix[1][0]
}

/// The coordinates of a node's foot, on the own facet continued beyond its outline; none where the own facet curves so much that there is no foot that
/// follows the node.
pub(super) fn foot_of<const D: usize>(own: &SurfaceFacet<D>, y: &[f64; D]) -> Option<[f64; 2]> {
    let mut s = own.middle();
    for step in 0..STEPS {
        let here = own.at(&s);
        let off = minus(y, &here.position);
        // Coordinates in the tangent plane: exact on affine facets, near enough to start from on others.
        let in_plane = || here.frame().dual.each_ref().map(|dual| dot(dual, &off));
        if own.affine {
            let along = in_plane();
            s = [s[0] + along[0], s[1] + along[1]];
            return (s[0] + s[1]).is_finite().then_some(s);
        }
        let inverse = foot_matrix(own, &s, &off);
        let follows = is_positive(&inverse);
        let along = here.tangents.each_ref().map(|tangent| dot(tangent, &off));
        let along = match step > 0 && follows {
            true => inverse.map(|row| row[0] * along[0] + row[1] * along[1]),
            false => in_plane(),
        };
        s = [s[0] + along[0], s[1] + along[1]];
        let length = along[0].abs().max(along[1].abs());
        if follows && length < LAST_STEP * (1.0 + s[0].abs().max(s[1].abs())) {
            return (s[0] + s[1]).is_finite().then_some(s);
        }
    }
    None
}
