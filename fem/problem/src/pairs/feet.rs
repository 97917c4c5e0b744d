//! Feet of the nodes of opposite facets in space, in an own facet's coordinates: the corners of the polygon that a facet is there.
//!
//! Of facets of degree two the middle nodes of edges have feet, too. An edge is the same chords for both of its facets, so that their polygons leave no
//! gap, and where it bends the polygon need not be convex.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

use super::segment_motion::{FEET, foot_matrix};
use super::surface::{SurfaceFacet, dot, minus, splat};
use crate::lanes::{SimdLane, WIDEST};

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
#[inline(always)]
pub(super) fn is_positive<L: Lane>(matrix: &[[L; 2]; 2]) -> L::Mask {
    let product = matrix[0][0] * matrix[1][1];
    L::and(L::splat(0.0).less(matrix[0][0]), (matrix[0][1] * matrix[0][1]).less(product))
}

/// The middle of an own facet, from which the coordinates of feet are found.
pub(super) struct MiddleOfFacet<const D: usize> {
    s: [f64; 2],
    position: [f64; D],
    dual: [[f64; D]; 2],
    pub normal: [f64; D],
}

impl<const D: usize> MiddleOfFacet<D> {
    pub fn of(own: &SurfaceFacet<D>) -> Self {
        let point = own.at(&own.middle());
        let dual = point.frame().dual;
        MiddleOfFacet { s: own.middle(), position: point.position, dual, normal: point.normal() }
    }
}

/// The coordinates of an opposite facet's feet, in the order of its outline's nodes, on the own facet continued beyond its outline; none where the own
/// facet curves so much that a node has no foot that follows it.
#[inline(always)]
pub(super) fn feet_of<L: SimdLane, const D: usize>(
    own: &SurfaceFacet<D>,
    middle: &MiddleOfFacet<D>,
    opposite: &SurfaceFacet<D>,
) -> Option<[[f64; 2]; FEET]> {
    let (nodes, mut feet) = (opposite.outline(), [[0.0; 2]; FEET]);
    for first in (0..nodes.len()).step_by(L::WIDTH) {
        let filled = L::WIDTH.min(nodes.len() - first);
        let mut places = [[0.0; WIDEST]; 2];
        for lane in 0..L::WIDTH {
            let node = nodes[first + lane.min(filled - 1)];
            (places[0][lane], places[1][lane]) = (node[0], node[1]);
        }
        let at = [L::load(&places[0]), L::load(&places[1])];
        let (s, found) = feet_of_points(own, middle, &opposite.at(&at).position);
        if L::any(L::not(found)) {
            return None;
        }
        for k in 0..2 {
            s[k].store(&mut places[k]);
        }
        for lane in 0..filled {
            feet[first + lane] = [places[0][lane], places[1][lane]];
        }
    }
    Some(feet)
}

/// The coordinates of the feet of points, and for which of them they were found. They do not depend on the neighbours.
#[inline(always)]
fn feet_of_points<L: SimdLane, const D: usize>(
    own: &SurfaceFacet<D>,
    middle: &MiddleOfFacet<D>,
    y: &[L; D],
) -> ([L; 2], L::Mask) {
    let infinity = L::splat(f64::INFINITY);
    // Coordinates in the tangent plane: exact on affine facets, near enough to start from on others.
    let off = minus(y, &splat(&middle.position));
    let mut s = [L::splat(0.0); 2];
    for k in 0..2 {
        s[k] = L::splat(middle.s[k]) + dot(&splat(&middle.dual[k]), &off);
    }
    if own.affine {
        return (s, (s[0] + s[1]).abs().less(infinity));
    }
    let mut found = L::splat(1.0).less(L::splat(0.0));
    let mut open = L::not(found);
    for _ in 1..STEPS {
        let here = own.at(&s);
        let off = minus(y, &here.position);
        let inverse = foot_matrix(&here.tangents, &own.second(&s), &off);
        let follows = is_positive(&inverse);
        let (mut products, mut along) = ([L::splat(0.0); 2], [L::splat(0.0); 2]);
        for k in 0..2 {
            products[k] = dot(&here.tangents[k], &off);
        }
        for k in 0..2 {
            along[k] = inverse[k][0] * products[0] + inverse[k][1] * products[1];
        }
        if L::any(L::and(open, L::not(follows))) {
            let dual = here.frame().dual;
            for k in 0..2 {
                along[k] = L::select(follows, along[k], dot(&dual[k], &off));
            }
        }
        for k in 0..2 {
            s[k] = L::select(open, s[k] + along[k], s[k]);
        }
        let length = along[0].abs().maximum(along[1].abs());
        let size = L::splat(1.0) + s[0].abs().maximum(s[1].abs());
        let ends = L::and(follows, length.less(L::splat(LAST_STEP) * size));
        found = L::or(found, L::and(open, ends));
        open = L::and(open, L::not(ends));
        if !L::any(open) {
            break;
        }
    }
    (s, L::and(found, (s[0] + s[1]).abs().less(infinity)))
}
