//! Derivatives of moving segments: of the feet of opposite nodes by displacements, and of points along the own facet.
//!
//! The foot s of a node y is where the ray along the own normal runs through it: (y − x(s))·a_α = 0 with the tangents a_α = x,_α. With
//! the own normal n and the gap g
//!
//! ```text
//! M = (a_α·a_β − (y − x)·x,_αβ)⁻¹,  δs^α = M^αβ [a_β·(δu(y) − δu(s)) + g n·δu,_β]
//! ```
//!
//! and a point that goes along the own coordinate β at fixed displacements has
//!
//! ```text
//! n,_β = −(n·x,_αβ) a^α,  r = a_β + g n,_β,  g,_β = −(m·r)/(m·n),  η,_β = b^γ·(r + g,_β n)
//! ```
//!
//! with the opposite normal m, dual tangents b^γ and coordinates η. In the plane there is one coordinate. Points are linear functions of the
//! feet, with factors that are found with the cut ([`GroupMotion::shares`]); corners of the own facet do not move.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

use super::PairGroup;
use super::curvature::FootCurve;
use super::surface::{SurfaceFacet, SurfacePoint, dot, minus};
use crate::lanes::{SimdLane, WIDEST};
use crate::mesh::Facet;

/// Nodes of the outline of an opposite facet, at most.
pub(super) const FEET: usize = 8;

/// The motion of the points of a group's units.
#[derive(Clone, Debug)]
pub(crate) struct GroupMotion<const D: usize> {
    /// The derivatives of the numbers of each point along each of the own facet's coordinates, in the order of the points; that of the
    /// weight is left out.
    pub slopes: [Vec<f64>; 2],
    /// Their second derivatives, in the plane.
    pub bends: Vec<f64>,
    /// Of each point the derivatives by the coordinates of its unit's feet: by each one those of its own coordinates, and that of its weight as a part of
    /// it.
    pub shares: Vec<f64>,
    /// The feet of each unit, as many of each one; none is an end of the own facet in the plane.
    pub feet: Vec<Option<Foot<D>>>,
}

impl<const D: usize> Default for GroupMotion<D> {
    fn default() -> Self {
        GroupMotion { slopes: [vec![], vec![]], bends: vec![], shares: vec![], feet: vec![] }
    }
}

impl<const D: usize> GroupMotion<D> {
    /// Lists with room for some feet in all, of units with the given number of points each.
    pub(super) fn with_room(feet: usize, units: usize, points: usize) -> Self {
        let all = if feet == 0 { 0 } else { units * points };
        let numbers = all * PairGroup::<D>::STRIDE;
        let room = |is_there: bool| Vec::with_capacity(if is_there { numbers } else { 0 });
        GroupMotion {
            slopes: [room(true), room(D == 3)],
            bends: room(D == 2),
            shares: Vec::with_capacity(feet * points * (D - 1) * D),
            feet: Vec::with_capacity(feet),
        }
    }

    /// Numbers that move each of some units: those of their feet.
    pub fn coordinates(&self, units: usize) -> usize {
        self.feet.len() / units.max(1) * (D - 1)
    }

    /// The feet of one of some units.
    pub fn feet_of(&self, unit: usize, units: usize) -> &[Option<Foot<D>>] {
        let count = self.feet.len() / units.max(1);
        &self.feet[unit * count..][..count]
    }
}

/// The place on an own facet whose ray runs through a node.
#[derive(Clone, Debug)]
pub(crate) struct Foot<const D: usize> {
    /// Reference coordinates in the own cell.
    pub own: [f64; D],
    /// An opposite facet that has the node, and the node's reference coordinates in its cell.
    pub facet: Facet,
    pub node: [f64; D],
    /// Of each coordinate of the foot: the factor of δu(y) − δu(s), and the direction in the own cell's reference coordinates of the
    /// derivative whose product with the normal is added.
    pub apart: [[f64; D]; 2],
    pub turning: [[f64; D]; 2],
    pub normal: [f64; D],
    /// Its second derivatives, in the plane.
    pub curve: Option<FootCurve<D>>,
}

/// Second derivatives of positions along the coordinates of a facet.
type Bends<const D: usize, L> = [[[L; D]; 2]; 2];

/// The inverse of a symmetric matrix; in the plane of its first entry.
#[inline(always)]
fn inverse<L: Lane, const D: usize>([[a, b], [_, c]]: [[L; 2]; 2]) -> [[L; 2]; 2] {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    if D == 2 {
        return [[one / a, zero], [zero; 2]];
    }
    let determinant = a * c - b * b;
    [[c / determinant, -b / determinant], [-b / determinant, a / determinant]]
}

/// M by the first and second derivatives of the own facet, for a node that is `off` it.
#[inline(always)]
pub(super) fn foot_matrix<L: Lane, const D: usize>(
    tangents: &[[L; D]; 2],
    bend: &Bends<D, L>,
    off: &[L; D],
) -> [[L; 2]; 2] {
    let mut matrix = [[L::splat(0.0); 2]; 2];
    for a in 0..D - 1 {
        for b in 0..=a {
            matrix[a][b] = dot(&tangents[a], &tangents[b]) - dot(off, &bend[a][b]);
            matrix[b][a] = matrix[a][b];
        }
    }
    inverse::<L, D>(matrix)
}

/// The derivatives of points along an own coordinate: of the opposite coordinates, the gap and the own normal.
#[derive(Clone, Copy)]
pub(super) struct PointSlopes<const D: usize, L> {
    pub met: [L; 2],
    pub gap: L,
    pub normal: [L; D],
}

/// The derivatives of points along the own coordinates, from the own facet's points and unit normals there, and from the opposite points.
#[inline(always)]
pub(super) fn slopes_of<L: Lane, const D: usize>(
    (here, n, bend): (&SurfacePoint<D, L>, &[L; D], &Bends<D, L>),
    there: &SurfacePoint<D, L>,
    gap: L,
) -> [PointSlopes<D, L>; 2] {
    let zero = L::splat(0.0);
    let mut slopes = [PointSlopes { met: [zero; 2], gap: zero, normal: [zero; D] }; 2];
    let (dual, across) = (here.frame().dual, there.frame());
    let closing = -dot(&across.normal, n);
    for along in 0..D - 1 {
        let PointSlopes { met, gap: opening, normal: turned } = &mut slopes[along];
        for other in 0..D - 1 {
            let turning = -dot(n, &bend[other][along]);
            for k in 0..D {
                turned[k] += turning * dual[other][k];
            }
        }
        let mut passed = here.tangents[along];
        for k in 0..D {
            passed[k] += gap * turned[k];
        }
        *opening = dot(&across.normal, &passed) / closing;
        for k in 0..D {
            passed[k] += *opening * n[k];
        }
        for other in 0..D - 1 {
            met[other] = dot(&across.dual[other], &passed);
        }
    }
    slopes
}

/// Derivatives of feet by displacements, several side by side.
struct FeetInLanes<const D: usize, L> {
    /// From a foot to its node.
    off: [L; D],
    tangents: [[L; D]; 2],
    bend: Bends<D, L>,
    normal: [L; D],
    matrix: [[L; 2]; 2],
    /// M and M times the gap in the directions of the own tangents, deformed and in the own cell's reference coordinates.
    apart: [[L; D]; 2],
    turning: [[L; D]; 2],
}

impl<L: Lane, const D: usize> FeetInLanes<D, L> {
    #[inline(always)]
    fn new(own: &SurfaceFacet<D>, s: &[L; 2], y: &[L; D]) -> Self {
        let (here, bend) = (own.at(s), own.second(s));
        let (tangents, normal, off) = (here.tangents, here.normal(), minus(y, &here.position));
        let (matrix, gap) = (foot_matrix(&tangents, &bend, &off), dot(&normal, &off));
        let [mut apart, mut turning] = [[[L::splat(0.0); D]; 2]; 2];
        for row in 0..2 {
            for k in 0..D {
                for other in 0..D - 1 {
                    let entry = matrix[row][other];
                    apart[row][k] += entry * tangents[other][k];
                    turning[row][k] += gap * entry * L::splat(own.tangents[other][k]);
                }
            }
        }
        FeetInLanes { off, tangents, bend, normal, matrix, apart, turning }
    }
}

/// The foot of a node of the outline of an opposite facet, whose coordinates were found.
pub(super) fn foot<const D: usize>(
    (own, s): (&SurfaceFacet<D>, &[f64; 2]),
    (opposite, node): (&SurfaceFacet<D>, usize),
) -> Foot<D> {
    let at = opposite.outline()[node];
    let FeetInLanes { off, tangents, bend, normal, matrix, apart, turning } =
        FeetInLanes::new(own, s, &opposite.at(&at).position);
    let curve = FootCurve {
        along: own.tangents[0],
        tangent: tangents[0],
        bend: bend[0][0],
        off,
        factor: matrix[0][0],
    };
    let (own, node) = (own.reference(s), opposite.reference(&at));
    Foot { own, facet: opposite.facet, node, apart, turning, normal, curve: (D == 2).then_some(curve) }
}

/// The feet of all nodes of the outline of an opposite facet in space, added to a list.
#[inline(always)]
pub(super) fn add_feet<L: SimdLane, const D: usize>(
    own: &SurfaceFacet<D>,
    feet: &[[f64; 2]],
    opposite: &SurfaceFacet<D>,
    list: &mut Vec<Option<Foot<D>>>,
) {
    let nodes = opposite.outline();
    for first in (0..nodes.len()).step_by(L::WIDTH) {
        let filled = L::WIDTH.min(nodes.len() - first);
        let mut places = [[0.0; WIDEST]; 4];
        for lane in 0..L::WIDTH {
            let node = first + lane.min(filled - 1);
            for k in 0..2 {
                (places[k][lane], places[2 + k][lane]) = (feet[node][k], nodes[node][k]);
            }
        }
        let s = [L::load(&places[0]), L::load(&places[1])];
        let at = [L::load(&places[2]), L::load(&places[3])];
        let found = FeetInLanes::new(own, &s, &opposite.at(&at).position);
        let [mut apart, mut turning] = [[[[0.0; WIDEST]; D]; 2]; 2];
        let mut normal = [[0.0; WIDEST]; D];
        for k in 0..D {
            for row in 0..2 {
                found.apart[row][k].store(&mut apart[row][k]);
                found.turning[row][k].store(&mut turning[row][k]);
            }
            found.normal[k].store(&mut normal[k]);
        }
        for lane in 0..filled {
            let (s, at) = (&feet[first + lane], &nodes[first + lane]);
            let of_lane =
                |rows: &[[[f64; WIDEST]; D]; 2]| [0, 1].map(|row: usize| rows[row].map(|of| of[lane]));
            list.push(Some(Foot {
                own: own.reference(s),
                facet: opposite.facet,
                node: opposite.reference(at),
                apart: of_lane(&apart),
                turning: of_lane(&turning),
                normal: normal.map(|of| of[lane]),
                curve: None,
            }));
        }
    }
}
