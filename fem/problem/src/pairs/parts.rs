//! Quadrature points of a part of an own facet that sees one opposite facet: a unit of a moving segment, in the plane and in space.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::curvature::add_bends;
use super::found::{Found, MovingUnit, PairPoint, Unit};
use super::rays::Rays;
use super::search::Search;
use super::segment_motion::{Foot, Shares, add_slopes};
use super::surface::SurfaceFacet;
use super::tolerances::{CONTINUED, INSIDE};
use crate::lanes::{SimdLane, WIDEST};

/// A quadrature point of a part of an own facet.
#[derive(Clone, Debug)]
pub(super) struct PartPoint {
    pub s: [f64; 2],
    /// Weight on the own facet's reference cell.
    pub weight: f64,
    pub shares: Shares,
}

/// The tolerance by which opposite facets are continued: between the feet of its nodes an edge does not follow its rays where a facet in space is not
/// affine.
pub(super) fn continued_by<const D: usize>(own: &SurfaceFacet<D>, opposite: &SurfaceFacet<D>) -> f64 {
    if D == 3 && !(own.affine && opposite.affine) { CONTINUED } else { INSIDE }
}

impl<const D: usize> Search<'_, '_, D> {
    /// A unit of the points of a part that sees an opposite facet.
    #[inline(always)]
    pub fn add_part<L: SimdLane>(
        &self,
        (own, facet): (&SurfaceFacet<D>, usize),
        reach: f64,
        points: &[PartPoint],
        feet: impl IntoIterator<Item = Option<Foot<D>>>,
        found: &mut Found<D>,
    ) {
        let opposite = &self.opposite[facet];
        let continued = continued_by(own, opposite);
        let (mut count, start) = (0, found.next_point());
        let first_foot = found.feet.len();
        found.feet.extend(feet);
        let numbers = (found.feet.len() - first_foot) * (D - 1);
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
            let rays = Rays { x: point.position, n: point.normal() };
            let nearest = self.nearest_on_rays(own, &s, &rays, &[facet], reach, continued);
            let [mut seen, mut rejected, mut gaps] = [[0.0; WIDEST]; 3];
            let mut met = [[0.0; WIDEST]; 2];
            let (one, zero) = (L::splat(1.0), L::splat(0.0));
            L::select(nearest.found, one, zero).store(&mut seen);
            L::select(nearest.rejected, one, zero).store(&mut rejected);
            nearest.gap.store(&mut gaps);
            let [mut x, mut n] = [[[0.0; WIDEST]; D]; 2];
            for k in 0..2 {
                nearest.s[k].store(&mut met[k]);
            }
            for k in 0..D {
                rays.x[k].store(&mut x[k]);
                rays.n[k].store(&mut n[k]);
            }
            for lane in 0..filled {
                let PartPoint { s, weight, shares } = &points[batch + lane];
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
                counts.add_point(&position, gap, weight * own.at(s).element());
                let reference = [own.reference(s), opposite.reference(&met)];
                let rigid_normal = opposite.rigid_normal;
                found.add_point(&PairPoint { reference, weight: *weight, gap, toward, rigid_normal });
                add_slopes((own, s), (opposite, &met), gap, &mut found.slopes);
                if D == 2 {
                    add_bends((own, s), (opposite, &met), gap, &mut found.bends);
                }
                let shares = shares.iter().flat_map(|foot| &foot[..D - 1]).take(numbers);
                found.shares.extend(shares.flat_map(|share| &share[..D]));
                count += 1;
            }
        }
        if count == 0 {
            return found.feet.truncate(first_foot);
        }
        let place = self.mesh.walk_of_facet(&[own.facet]);
        let feet = first_foot..found.feet.len();
        let shares = found.shares.len() - count * numbers * D;
        let segment = Some(MovingUnit { feet, shares });
        found.units.push(Unit { place, facets: [own.facet, opposite.facet], count, start, segment });
    }
}
