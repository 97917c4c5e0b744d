//! Geometry of a flat facet by its corners: a segment in the plane, a triangle in space.

use crate::locate::long_normal;

/// A facet whose height is less than this part of its longest side has no normal.
const FLAT: f64 = 1e-10;

fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn length<const D: usize>(a: &[f64; D]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// The outward unit normal; `None` of a facet that has none.
pub(super) fn normal<const D: usize>(corners: &[[f64; D]; D]) -> Option<[f64; D]> {
    let normal = long_normal(corners);
    let size = length(&normal);
    let sides = (0..D).map(|k| length(&minus(&corners[(k + 1) % D], &corners[k])));
    let longest = sides.fold(0.0, f64::max);
    let least = if D == 2 { 0.0 } else { FLAT * longest * longest };
    (size > least && size.is_finite()).then(|| normal.map(|component| component / size))
}

/// The signed area or volume between a facet and a point \[length^D\].
pub(super) fn signed_cone<const D: usize>(corners: &[[f64; D]; D], apex: &[f64; D]) -> f64 {
    let (normal, off) = (long_normal(corners), minus(&corners[0], apex));
    let product: f64 = normal.iter().zip(off).map(|(n, off)| n * off).sum();
    product / if D == 2 { 2.0 } else { 6.0 }
}
