//! Points of surfaces with tangents and normals, and flat facets; one point, or several side by side in lanes.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

/// The flat facet that has three of a facet's corners, in the plane both, and how far the facet is from it.
#[derive(Clone, Debug)]
pub(super) struct FlatFacet<const D: usize> {
    pub origin: [f64; D],
    pub frame: Frame<D>,
    /// The most that a point of the facet is away from the flat one's of the same coordinates; none where it is not known.
    pub away: Option<f64>,
    /// The lengths of the dual tangents.
    pub slopes: [f64; 2],
}

/// The normal of a surface and the vectors dual to its tangents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<const D: usize, L = f64> {
    /// Of the length of the surface element.
    pub normal: [L; D],
    pub dual: [[L; D]; 2],
}

/// A point of a facet with the derivatives of its position.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint<const D: usize, L = f64> {
    pub position: [L; D],
    /// Derivatives along the facet's own coordinates; the second is zero in the plane.
    pub tangents: [[L; D]; 2],
}

#[inline(always)]
pub(super) fn dot<L: Lane, const D: usize>(a: &[L; D], b: &[L; D]) -> L {
    let mut sum = a[0] * b[0];
    for k in 1..D {
        sum += a[k] * b[k];
    }
    sum
}

#[inline(always)]
pub(super) fn minus<L: Lane, const D: usize>(a: &[L; D], b: &[L; D]) -> [L; D] {
    let mut difference = *a;
    for k in 0..D {
        difference[k] = a[k] - b[k];
    }
    difference
}

#[inline(always)]
pub(super) fn unit<L: Lane, const D: usize>(a: &[L; D]) -> [L; D] {
    over(a, dot(a, a).sqrt())
}

/// A vector divided by a number.
#[inline(always)]
pub(super) fn over<L: Lane, const D: usize>(a: &[L; D], divisor: L) -> [L; D] {
    let mut quotient = *a;
    for k in 0..D {
        quotient[k] = a[k] / divisor;
    }
    quotient
}

/// The same vector in all lanes.
#[inline(always)]
pub(super) fn splat<L: Lane, const D: usize>(a: &[f64; D]) -> [L; D] {
    let mut lanes = [L::splat(0.0); D];
    for k in 0..D {
        lanes[k] = L::splat(a[k]);
    }
    lanes
}

#[inline(always)]
fn cross<L: Lane, const D: usize>(a: &[L; D], b: &[L; D]) -> [L; D] {
    let mut product = *a;
    for i in 0..D {
        let (j, k) = ((i + 1) % D, (i + 2) % D);
        product[i] = a[j] * b[k] - a[k] * b[j];
    }
    product
}

impl<L: Lane, const D: usize> SurfacePoint<D, L> {
    /// The outward normal, of the length of the surface element.
    #[inline(always)]
    pub fn long_normal(&self) -> [L; D] {
        let [s, t] = &self.tangents;
        if D == 2 {
            let mut normal = *s;
            (normal[0], normal[1]) = (s[1], -s[0]);
            return normal;
        }
        cross(s, t)
    }

    /// The outward unit normal.
    #[inline(always)]
    pub fn normal(&self) -> [L; D] {
        unit(&self.long_normal())
    }

    #[inline(always)]
    pub fn frame(&self) -> Frame<D, L> {
        let normal = self.long_normal();
        let square = dot(&normal, &normal);
        let [s, t] = &self.tangents;
        let dual = match D {
            2 => [over(s, square), [L::splat(0.0); D]],
            _ => [over(&cross(t, &normal), square), over(&cross(&normal, s), square)],
        };
        Frame { normal, dual }
    }
}

impl<const D: usize> SurfacePoint<D> {
    /// The surface element.
    pub fn element(&self) -> f64 {
        let [s, t] = &self.tangents;
        if D == 2 {
            return dot(s, s).sqrt();
        }
        let (first, mixed, last) = (dot(s, s), dot(s, t), dot(t, t));
        (first * last - mixed * mixed).max(0.0).sqrt()
    }
}

impl<const D: usize> Frame<D> {
    /// The same frame in all lanes.
    #[inline(always)]
    fn in_lanes<L: Lane>(&self) -> Frame<D, L> {
        Frame { normal: splat(&self.normal), dual: [splat(&self.dual[0]), splat(&self.dual[1])] }
    }
}

impl<L: Lane, const D: usize> Frame<D, L> {
    /// The coordinates along the tangents at which a line through a point along n meets the tangent plane; `off` is the vector
    /// from the frame's origin to the point. No numbers where the line runs along the plane.
    #[inline(always)]
    pub fn met_by(&self, off: &[L; D], n: &[L; D]) -> [L; 2] {
        let gap = -dot(&self.normal, off) / dot(&self.normal, n);
        let mut foot = *off;
        for k in 0..D {
            foot[k] = off[k] + gap * n[k];
        }
        let second = if D == 2 { L::splat(0.0) } else { dot(&self.dual[1], &foot) };
        [dot(&self.dual[0], &foot), second]
    }
}

impl<const D: usize> FlatFacet<D> {
    /// The intersection with a line through x along n, in coordinates of the facet.
    #[inline(always)]
    pub fn met_by<L: Lane>(&self, x: &[L; D], n: &[L; D]) -> [L; 2] {
        self.frame.in_lanes().met_by(&minus(x, &splat(&self.origin)), n)
    }

    /// The most by which coordinates at which a line along n meets the facet differ from those at which it meets the flat one.
    #[inline(always)]
    pub fn doubt<L: Lane>(&self, n: &[L; D]) -> [L; 2] {
        let Some(away) = self.away else { return [L::splat(f64::INFINITY); 2] };
        if away == 0.0 {
            return [L::splat(0.0); 2];
        }
        let normal = &self.frame.normal;
        let slant = (L::splat(dot(normal, normal).sqrt()) / dot(&splat(normal), n)).abs();
        let factor = L::splat(1.0) + slant;
        let [first, second] = self.slopes;
        [L::splat(away * first) * factor, L::splat(away * second) * factor]
    }
}
