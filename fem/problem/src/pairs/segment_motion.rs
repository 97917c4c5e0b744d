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
//! feet, with factors that are found with the cut ([`Shares`]); corners of the own facet do not move.

use super::PairGroup;
use super::curvature::FootCurve;
use super::surface::{SurfaceFacet, dot, minus};
use crate::mesh::Facet;

/// Nodes of the outline of an opposite facet, at most.
pub(super) const FEET: usize = 8;

/// The derivatives of a point by the feet: of the coordinate α by the coordinate β of the k-th foot \[k]\[β]\[α], and those of the
/// weight as parts of it \[k]\[β]\[D − 1].
pub(super) type Shares = [[[f64; 3]; 2]; FEET];

/// The motion of the points of a group's units.
#[derive(Clone, Debug)]
pub(crate) struct GroupMotion<const D: usize> {
    /// The derivatives of the numbers of each point along each of the own facet's coordinates, in the order of the points; that of the
    /// weight is left out.
    pub slopes: [Vec<f64>; 2],
    /// Their second derivatives, in the plane.
    pub bends: Vec<f64>,
    /// The [`Shares`] of each point: of each foot and coordinate D numbers.
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

/// The inverse of a symmetric matrix; in the plane of its first entry.
fn inverse<const D: usize>([[a, b], [_, c]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    if D == 2 {
        return [[1.0 / a, 0.0], [0.0; 2]];
    }
    let determinant = a * c - b * b;
    [[c / determinant, -b / determinant], [-b / determinant, a / determinant]]
}

/// M at a point of an own facet for a node that is `off` it.
pub(super) fn foot_matrix<const D: usize>(
    own: &SurfaceFacet<D>,
    s: &[f64; 2],
    off: &[f64; D],
) -> [[f64; 2]; 2] {
    let (tangents, bend) = (own.at(s).tangents, own.second(s));
    let entry = |a: usize, b: usize| dot(&tangents[a], &tangents[b]) - dot(off, &bend[a][b]);
    inverse::<D>([[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]])
}

/// The derivatives of a point's numbers along the own facet's coordinates, added to the lists of a search.
#[inline]
pub(super) fn add_slopes<const D: usize>(
    (own, s): (&SurfaceFacet<D>, &[f64; 2]),
    (opposite, met): (&SurfaceFacet<D>, &[f64; 2]),
    gap: f64,
    slopes: &mut [Vec<f64>; 2],
) {
    let (here, there) = (own.at(s), opposite.at(met));
    let (bend, n) = (own.second(s), here.normal());
    let (dual, across) = (here.frame().dual, there.frame());
    for along in 0..D - 1 {
        let mut turned = [0.0; D];
        for other in 0..D - 1 {
            let turning = -dot(&n, &bend[other][along]);
            (0..D).for_each(|k| turned[k] += turning * dual[other][k]);
        }
        let r: [f64; D] = std::array::from_fn(|k| here.tangents[along][k] + gap * turned[k]);
        let opening = -dot(&across.normal, &r) / dot(&across.normal, &n);
        let passed: [f64; D] = std::array::from_fn(|k| r[k] + opening * n[k]);
        let met = across.dual.map(|dual| dot(&dual, &passed));
        let first = slopes[along].len();
        slopes[along].resize(first + PairGroup::<D>::STRIDE, 0.0);
        let numbers = &mut slopes[along][first..];
        for k in 0..D {
            numbers[k] = own.tangents[along][k];
            numbers[D + k] = met[0] * opposite.tangents[0][k] + met[1] * opposite.tangents[1][k];
            numbers[2 * D + 2 + k] = turned[k];
        }
        numbers[2 * D + 1] = opening;
    }
}

/// The foot of a node of the outline of an opposite facet, whose coordinates were found.
pub(super) fn foot<const D: usize>(
    (own, s): (&SurfaceFacet<D>, &[f64; 2]),
    (opposite, node): (&SurfaceFacet<D>, usize),
) -> Foot<D> {
    let (here, at) = (own.at(s), opposite.outline()[node]);
    let (tangents, normal) = (here.tangents, here.normal());
    let off = minus(&opposite.at(&at).position, &here.position);
    let (inverse, gap) = (foot_matrix(own, s, &off), dot(&normal, &off));
    let sum = |[a, b]: [f64; 2], [first, second]: &[[f64; D]; 2]| -> [f64; D] {
        std::array::from_fn(|k| a * first[k] + b * second[k])
    };
    Foot {
        own: own.reference(s),
        facet: opposite.facet,
        node: opposite.reference(&at),
        apart: inverse.map(|row| sum(row, &tangents)),
        turning: inverse.map(|row| sum(row.map(|entry| gap * entry), &own.tangents)),
        normal,
        curve: (D == 2).then(|| FootCurve {
            along: own.tangents[0],
            tangent: tangents[0],
            bend: own.second(s)[0][0],
            off,
            factor: inverse[0][0],
        }),
    }
}
