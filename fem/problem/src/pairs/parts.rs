//! Quadrature points of a part of an own facet that sees one opposite facet: a unit of a moving segment, in the plane and in space.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::PairGroup;
use super::curvature::CurvedRays;
use super::found::{Found, MovingUnit, PairPoint, Unit};
use super::rays::Rays;
use super::search::Search;
use super::segment_motion::slopes_of;
use super::surface::{SurfaceFacet, dot, over};
use super::tolerances::{CONTINUED, INSIDE};
use crate::lanes::{SimdLane, WIDEST};

/// A quadrature point of a part of an own facet.
#[derive(Clone, Debug)]
pub(super) struct PartPoint {
    pub s: [f64; 2],
    /// Weight on the own facet's reference cell.
    pub weight: f64,
}

/// The quadrature points of a part of an own facet.
#[derive(Default)]
pub(super) struct PartPoints {
    pub points: Vec<PartPoint>,
    /// As [`GroupMotion::shares`](super::GroupMotion::shares).
    pub shares: Vec<f64>,
}

impl PartPoints {
    pub fn clear(&mut self) {
        self.points.clear();
        self.shares.clear();
    }
}

/// The derivatives of points' numbers along an own coordinate, lane after lane: of the opposite coordinates, the gap and the own normal.
#[derive(Clone, Copy)]
struct Derivatives<const D: usize> {
    met: [[f64; WIDEST]; 2],
    gap: [f64; WIDEST],
    normal: [[f64; WIDEST]; D],
}

impl<const D: usize> Default for Derivatives<D> {
    fn default() -> Self {
        Derivatives { met: [[0.0; WIDEST]; 2], gap: [0.0; WIDEST], normal: [[0.0; WIDEST]; D] }
    }
}

impl<const D: usize> Derivatives<D> {
    #[inline(always)]
    fn take<L: SimdLane>(&mut self, met: &[L; 2], gap: L, normal: &[L; D]) {
        met[0].store(&mut self.met[0]);
        met[1].store(&mut self.met[1]);
        gap.store(&mut self.gap);
        for k in 0..D {
            normal[k].store(&mut self.normal[k]);
        }
    }

    /// Those of the point of a lane as [`PairGroup::points`] has the numbers, where the point moves along an own vector.
    #[inline(always)]
    fn add(&self, lane: usize, own: &[f64; D], opposite: &[[f64; D]; 2], list: &mut Vec<f64>) {
        let first = list.len();
        list.extend_from_slice(&[0.0; PairGroup::<3>::STRIDE][..PairGroup::<D>::STRIDE]);
        let numbers = &mut list[first..][..PairGroup::<D>::STRIDE];
        let met = [self.met[0][lane], self.met[1][lane]];
        for k in 0..D {
            numbers[k] = own[k];
            numbers[D + k] = met[0] * opposite[0][k] + met[1] * opposite[1][k];
            numbers[2 * D + 2 + k] = self.normal[k][lane];
        }
        numbers[2 * D + 1] = self.gap[lane];
    }
}

/// The tolerance by which opposite facets are continued: between the feet of its nodes an edge does not follow its rays where a facet in space is not
/// affine.
pub(super) fn continued_by<const D: usize>(own: &SurfaceFacet<D>, opposite: &SurfaceFacet<D>) -> f64 {
    if D == 3 && !(own.affine && opposite.affine) { CONTINUED } else { INSIDE }
}

impl<const D: usize> Search<'_, '_, D> {
    /// A unit of the points of a part that sees an opposite facet. Its feet are the last ones that were found, from a first one on.
    #[inline(always)]
    pub fn add_part<L: SimdLane>(
        &self,
        (own, facet): (&SurfaceFacet<D>, usize),
        reach: f64,
        PartPoints { points, shares }: &PartPoints,
        first_foot: usize,
        found: &mut Found<D>,
    ) {
        let opposite = &self.opposite[facet];
        let continued = continued_by(own, opposite);
        let (mut count, start) = (0, found.next_point());
        let numbers = (found.feet.len() - first_foot) * (D - 1) * D;
        for batch in (0..points.len()).step_by(L::WIDTH) {
            let filled = L::WIDTH.min(points.len() - batch);
            let mut places = [[0.0; WIDEST]; 2];
            for lane in 0..L::WIDTH {
                for k in 0..2 {
                    places[k][lane] = points[batch + lane.min(filled - 1)].s[k];
                }
            }
            let s = [L::load(&places[0]), L::load(&places[1])];
            let point = own.at(&s);
            let normal = point.long_normal();
            let element = dot(&normal, &normal).sqrt();
            let rays = Rays { x: point.position, n: over(&normal, element) };
            let nearest = self.nearest_on_rays(own, &s, &rays, &[facet], reach, continued);
            let [mut seen, mut rejected, mut gaps, mut elements] = [[0.0; WIDEST]; 4];
            let mut met = [[0.0; WIDEST]; 2];
            let (one, zero) = (L::splat(1.0), L::splat(0.0));
            L::select(nearest.found, one, zero).store(&mut seen);
            L::select(nearest.rejected, one, zero).store(&mut rejected);
            nearest.gap.store(&mut gaps);
            element.store(&mut elements);
            let [mut x, mut n] = [[[0.0; WIDEST]; D]; 2];
            for k in 0..2 {
                nearest.s[k].store(&mut met[k]);
            }
            for k in 0..D {
                rays.x[k].store(&mut x[k]);
                rays.n[k].store(&mut n[k]);
            }
            let (bend, there) = (own.second(&s), opposite.at(&nearest.s));
            let slopes = slopes_of((&point, &rays.n, &bend), &there, nearest.gap);
            let [mut along, mut across] = [Derivatives::<D>::default(); 2];
            along.take(&slopes[0].met, slopes[0].gap, &slopes[0].normal);
            if D == 3 {
                across.take(&slopes[1].met, slopes[1].gap, &slopes[1].normal);
            } else {
                let rays = CurvedRays {
                    tangent: point.tangents[0],
                    bend: bend[0][0],
                    normal: rays.n,
                    gap: nearest.gap,
                    opposite_tangent: there.tangents[0],
                    opposite_bend: opposite.second(&nearest.s)[0][0],
                };
                let second = rays.second();
                across.take(&[second.met, zero], second.gap, &second.normal);
            }
            for lane in 0..filled {
                let PartPoint { s, weight } = &points[batch + lane];
                let counts = found.counts();
                if seen[lane] == 0.0 {
                    counts.open += 1;
                    counts.rejected += usize::from(rejected[lane] != 0.0);
                    continue;
                }
                let (mut position, mut toward) = ([0.0; D], [0.0; D]);
                for k in 0..D {
                    (position[k], toward[k]) = (x[k][lane], n[k][lane]);
                }
                let (gap, met) = (gaps[lane], [met[0][lane], met[1][lane]]);
                counts.add_point(&position, gap, weight * elements[lane]);
                let reference = [own.reference(s), opposite.reference(&met)];
                let rigid_normal = opposite.rigid_normal;
                found.add_point(&PairPoint { reference, weight: *weight, gap, toward, rigid_normal });
                let [list, others] = &mut found.slopes;
                along.add(lane, &own.tangents[0], &opposite.tangents, list);
                match D {
                    3 => across.add(lane, &own.tangents[1], &opposite.tangents, others),
                    // The own place has no second derivative.
                    _ => across.add(lane, &[0.0; D], &opposite.tangents, &mut found.bends),
                }
                found.shares.extend_from_slice(&shares[(batch + lane) * numbers..][..numbers]);
                count += 1;
            }
        }
        if count == 0 {
            return found.feet.truncate(first_foot);
        }
        let place = self.mesh.walk_of_facet(&[own.facet]);
        let feet = first_foot..found.feet.len();
        let shares = found.shares.len() - count * numbers;
        let segment = Some(MovingUnit { feet, shares });
        found.units.push(Unit { place, facets: [own.facet, opposite.facet], count, start, segment });
    }
}
