//! The points at which rays meet a facet; one ray, or several side by side in lanes.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::opposite::ClosestPoint;
use super::surface::{SurfaceFacet, SurfacePoint, dot, minus, splat};
use super::tolerances::{INSIDE, STEPS};
use crate::lanes::SimdLane;

/// Lines x + g n with unit vectors n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays<const D: usize, L = f64> {
    pub x: [L; D],
    pub n: [L; D],
}

/// The points at which rays meet a facet.
pub(super) struct Met<const D: usize, L: SimdLane> {
    /// Whether a ray meets it at all.
    pub met: L::Mask,
    /// Coordinates on the facet.
    pub s: [L; 2],
    pub point: SurfacePoint<D, L>,
}

/// The points at which rays meet a facet, continued by a tolerance in its coordinates; none where all pass it by. What a ray meets does not
/// depend on its neighbours.
#[inline(always)]
pub(super) fn along_rays<L: SimdLane, const D: usize>(
    facet: &SurfaceFacet<D>,
    rays: &Rays<D, L>,
    tolerance: f64,
) -> Option<Met<D, L>> {
    let Rays { x, n } = rays;
    let (s, met) = match facet.parabola() {
        Some(parabola) => {
            let s = [parabola.met_by(x, n), L::splat(0.0)];
            (s, facet.contains(&s, tolerance))
        }
        None => {
            let (s, found) = along_flat(facet, rays, tolerance)?;
            (s, L::and(found, facet.contains(&s, tolerance)))
        }
    };
    if !L::any(met) {
        return None;
    }
    Some(Met { met, s, point: facet.at(&s) })
}

/// The coordinates at which rays meet a facet's surface, by way of the flat facet, and for which of them they were found; none
/// where all rays pass the facet by.
#[inline(always)]
fn along_flat<L: SimdLane, const D: usize>(
    facet: &SurfaceFacet<D>,
    rays: &Rays<D, L>,
    tolerance: f64,
) -> Option<([L; 2], L::Mask)> {
    let Rays { x, n } = rays;
    // A line passes the facet by where its distance from the centre exceeds the radius.
    let off = minus(&splat(&facet.centre), x);
    let along = dot(&off, n);
    let largest = L::splat((facet.radius * (1.0 + 2.0 * tolerance)).powi(2) * (1.0 + 1e-6));
    let mut open = (dot(&off, &off) - along * along).less_equal(largest);
    if !L::any(open) {
        return None;
    }
    let own = facet.flat()?;
    let flat = own.met_by(x, n);
    let [first, second] = own.doubt(n);
    let tolerance = L::splat(tolerance);
    open = L::and(open, L::not(facet.is_missed_by(&flat, &[first + tolerance, second + tolerance])));
    if !L::any(open) {
        return None;
    }
    Some(if facet.affine { (flat, open) } else { newton(facet, rays, &flat, open) })
}

/// Whether both coordinates are numbers.
#[inline(always)]
fn finite<L: SimdLane>(pair: &[L; 2]) -> L::Mask {
    let infinity = L::splat(f64::INFINITY);
    L::and(pair[0].abs().less(infinity), pair[1].abs().less(infinity))
}

/// Newton's method for the coordinates at which the `open` rays meet a facet's surface, continued beyond the facet. It starts from the coordinates on
/// the flat facet. The mask has the rays for which it ended.
#[inline(always)]
fn newton<L: SimdLane, const D: usize>(
    facet: &SurfaceFacet<D>,
    Rays { x, n }: &Rays<D, L>,
    flat: &[L; 2],
    mut open: L::Mask,
) -> ([L; 2], L::Mask) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let starts = finite(flat);
    let middle = facet.middle();
    let mut s = *flat;
    for k in 0..2 {
        s[k] = L::select(starts, flat[k].maximum(zero).minimum(one), L::splat(middle[k]));
    }
    let mut ended = one.less(zero);
    let mut previous = L::splat(f64::INFINITY);
    for _ in 0..STEPS {
        let point = facet.at(&s);
        let step = point.frame().met_by(&minus(x, &point.position), n);
        open = L::and(open, finite(&step));
        let length = step[0].abs().maximum(step[1].abs());
        let factor = one / length.maximum(one);
        for k in 0..2 {
            s[k] = L::select(open, s[k] + factor * step[k], s[k]);
        }
        // The error after a step is the square of its length.
        let stalls = L::and(length.less(L::splat(1e-8)), (L::splat(0.5) * previous).less_equal(length));
        let ends = L::or(length.less(L::splat(1e-9)), stalls);
        ended = L::or(ended, L::and(open, ends));
        open = L::and(open, L::not(ends));
        if !L::any(open) {
            break;
        }
        previous = length;
    }
    (s, ended)
}

/// The point at which one ray meets a facet.
pub(super) fn along_ray<const D: usize>(
    facet: &SurfaceFacet<D>,
    x: &[f64; D],
    n: &[f64; D],
) -> Option<ClosestPoint<D>> {
    let Met { s, point, .. } = along_rays(facet, &Rays { x: *x, n: *n }, INSIDE)?;
    Some(ClosestPoint { s, position: point.position, normal: point.normal(), at_rim: false })
}
