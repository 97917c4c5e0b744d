//! The opposite points of rays, several rays of an own facet side by side in lanes.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::rays::{Met, Rays, along_rays};
use super::search::{FACING, Search};
use super::surface::{SurfaceFacet, dot, minus};
use crate::lanes::{SimdLane, WIDEST};

/// The points opposite to those from which rays go.
pub(super) struct NearestOnRays<L: SimdLane> {
    /// Whether there is one.
    pub found: L::Mask,
    /// Whether a facet was met from behind, or beyond the reach.
    pub rejected: L::Mask,
    /// The facet, by index among the opposite ones, and coordinates on it.
    pub facet: L,
    pub s: [L; 2],
    pub gap: L,
}

impl<const D: usize> Search<'_, '_, D> {
    /// The points opposite to those of an own facet with coordinates `from`: of the points that are accepted those with the smallest
    /// |g|; of several those on the facet with the lowest number. Candidates are ascending;
    /// facets are continued by a tolerance in their own coordinates.
    #[inline(always)]
    pub fn nearest_on_rays<L: SimdLane>(
        &self,
        own: &SurfaceFacet<D>,
        from: &[L; 2],
        rays: &Rays<D, L>,
        candidates: &[usize],
        reach: f64,
        continued: f64,
    ) -> NearestOnRays<L> {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let (reach, facing) = (L::splat(reach), L::splat(FACING * FACING));
        let nothing = one.less(zero);
        let mut best =
            NearestOnRays { found: nothing, rejected: nothing, facet: zero, s: [zero; 2], gap: zero };
        let mut least = L::splat(f64::INFINITY);
        for index in 0..candidates.len() {
            let facet = &self.opposite[candidates[index]];
            let Some(Met { met, s, point }) = along_rays(facet, rays, continued) else { continue };
            let gap = dot(&rays.n, &minus(&point.position, &rays.x));
            let distance = gap.abs();
            // Without the normal's length: the product is negative, and its square not below that of FACING.
            let normal = point.long_normal();
            let product = dot(&rays.n, &normal);
            let faces = L::and(product.less(zero), (facing * dot(&normal, &normal)).less(product * product));
            let in_sight = L::and(faces, distance.less_equal(reach));
            let mut accepted = L::and(met, in_sight);
            if self.within && L::any(accepted) {
                accepted = L::and(accepted, self.not_through_the_body(own, from, facet, &s));
            }
            best.rejected = L::or(best.rejected, L::and(met, L::not(accepted)));
            let nearer = L::and(accepted, distance.less(least));
            least = L::select(nearer, distance, least);
            best.facet = L::select(nearer, L::splat(candidates[index] as f64), best.facet);
            best.gap = L::select(nearer, gap, best.gap);
            for k in 0..2 {
                best.s[k] = L::select(nearer, s[k], best.s[k]);
            }
            best.found = L::or(best.found, nearer);
        }
        best
    }

    /// The mask of points of an own facet that see what was found without looking through the body itself.
    #[inline(never)]
    fn not_through_the_body<L: SimdLane>(
        &self,
        own: &SurfaceFacet<D>,
        from: &[L; 2],
        facet: &SurfaceFacet<D>,
        s: &[L; 2],
    ) -> L::Mask {
        let mut points = [[0.0; WIDEST]; 4];
        for k in 0..2 {
            from[k].store(&mut points[k]);
            s[k].store(&mut points[2 + k]);
        }
        let mut through = [0.0; WIDEST];
        for lane in 0..L::WIDTH {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| points[k][lane]);
            through[lane] = f64::from(u8::from(self.through_the_body((own, &[a, b]), (facet, &[c, d]))));
        }
        L::load(&through).less(L::splat(0.5))
    }
}
