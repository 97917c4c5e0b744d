//! Derivatives of moving segments: of their ends by displacements, and of their points along the own facet.
//!
//! With τ = x′(s), n the own deformed normal and g the gap at the end s, whose ray runs through a node y,
//!
//! ```text
//! δs = [(δu(y) − δu(s))·τ + g n·δu′] / (|τ|² − g n·x″)
//! ```
//!
//! and a point that goes along the own facet at fixed displacements has
//!
//! ```text
//! n′ = −(n·x″) τ/|τ|²,  r = τ + g n′,  g′ = −(m·r)/(m·n),  η′ = (r + g′ n)·y′/|y′|²
//! ```
//!
//! with the opposite normal m and the opposite coordinate η. Ends of the own facet do not move.

use super::surface::{SurfaceFacet, dot, minus};
use crate::mesh::Facet;

/// An end of a segment as the search finds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentEnd {
    pub s: f64,
    /// The opposite node whose ray cuts here, as a facet and its corner; none at an end of the own facet.
    pub node: Option<[u32; 2]>,
}

/// The motion of the points of a group's units.
#[derive(Clone, Debug)]
pub(crate) struct GroupMotion<const D: usize> {
    /// The derivatives of the numbers of each point along the own facet's coordinate, in the order of the points; that of the weight is left
    /// out, which is a part of the segment's length.
    pub slopes: Vec<f64>,
    /// Of each point, the part of the segment before it.
    pub fractions: Vec<f64>,
    /// Of each unit.
    pub ends: Vec<[MovingEnd<D>; 2]>,
}

impl<const D: usize> Default for GroupMotion<D> {
    fn default() -> Self {
        GroupMotion { slopes: vec![], fractions: vec![], ends: vec![] }
    }
}

/// An end of a segment with the node that moves it.
#[derive(Clone, Debug)]
pub(crate) struct MovingEnd<const D: usize> {
    /// The own facet's coordinate.
    pub s: f64,
    /// Reference coordinates in the own cell, and their derivative by s.
    pub reference: [f64; D],
    pub along: [f64; D],
    /// The opposite node whose ray cuts here; none at an end of the own facet.
    pub node: Option<MovingNode<D>>,
}

/// The node that an end follows.
#[derive(Clone, Debug)]
pub(crate) struct MovingNode<const D: usize> {
    /// A facet that has the node, and reference coordinates in its cell.
    pub facet: Facet,
    pub reference: [f64; D],
    /// The factors of δu(y) − δu(s), and of δu′.
    pub apart: [f64; D],
    pub turned: [f64; D],
}

/// As many numbers as a point has in space.
const NUMBERS: usize = 11;

/// The derivatives of a point's numbers along the own facet.
#[inline]
pub(super) fn slopes_of_point<const D: usize>(
    own: &SurfaceFacet<D>,
    s: f64,
    opposite: &SurfaceFacet<D>,
    met: f64,
    gap: f64,
) -> [f64; NUMBERS] {
    let (here, there) = (own.at(&[s, 0.0]), opposite.at(&[met, 0.0]));
    let (tau, bend, n) = (here.tangents[0], own.second(&[s, 0.0])[0][0], here.normal());
    let (m, across) = (there.long_normal(), there.tangents[0]);
    let turning = -dot(&n, &bend) / dot(&tau, &tau);
    let turned: [f64; D] = std::array::from_fn(|k| turning * tau[k]);
    let r: [f64; D] = std::array::from_fn(|k| tau[k] + gap * turned[k]);
    let opening = -dot(&m, &r) / dot(&m, &n);
    let passed: [f64; D] = std::array::from_fn(|k| r[k] + opening * n[k]);
    let passed = dot(&passed, &across) / dot(&across, &across);
    let mut slopes = [0.0; NUMBERS];
    for k in 0..D {
        slopes[k] = own.tangents[0][k];
        slopes[D + k] = passed * opposite.tangents[0][k];
        slopes[2 * D + 2 + k] = turned[k];
    }
    slopes[2 * D + 1] = opening;
    slopes
}

/// The motion of an end of a segment that sees an opposite facet.
pub(super) fn moving_end<const D: usize>(
    own: &SurfaceFacet<D>,
    end: &SegmentEnd,
    opposite: &[SurfaceFacet<D>],
    seen: usize,
) -> MovingEnd<D> {
    let s = [end.s, 0.0];
    let node = end.node.map(|[facet, corner]| {
        let (mut holder, mut corner) = (&opposite[facet as usize], corner as usize);
        // Facets share their ends: the one that is seen couples nothing new.
        let vertex = holder.vertices().nth(corner);
        let seen = &opposite[seen];
        if let Some(place) = seen.vertices().position(|known| Some(known) == vertex) {
            (holder, corner) = (seen, place);
        }
        let at = holder.parameters()[corner];
        let (here, n) = (own.at(&s), own.at(&s).normal());
        let (tau, bend) = (here.tangents[0], own.second(&s)[0][0]);
        let gap = dot(&n, &minus(&holder.at(&at).position, &here.position));
        let slope = dot(&tau, &tau) - gap * dot(&n, &bend);
        MovingNode {
            facet: holder.facet,
            reference: holder.reference(&at),
            apart: tau.map(|component| component / slope),
            turned: n.map(|component| gap * component / slope),
        }
    });
    MovingEnd { s: end.s, reference: own.reference(&s), along: own.tangents[0], node }
}
