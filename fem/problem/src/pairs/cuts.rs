//! Cuts of an own facet in the plane: the places whose rays run through the end nodes of opposite facets.
//!
//! With the own curve x(s) and a node y the cut is the zero of (y − x(s))·x′(s), linear where the facet is straight and a cubic
//! where it is a parabola.

use super::PairError;
use super::parabola::Parabola;
use super::surface::{SurfaceFacet, dot, minus};

/// Steps for a root, at most: bisection alone would end within them.
const STEPS: usize = 100;

/// Whether surfaces can be cut.
///
/// # Errors
/// [`PairError::SegmentsOfDegree`].
pub(super) fn check<const D: usize>(
    surfaces: [&str; 2],
    [own, opposite]: [&[SurfaceFacet<D>]; 2],
) -> Result<(), PairError> {
    let known = [own, opposite].map(|facets| facets.iter().all(|facet| facet.degree <= 2));
    match known.iter().position(|known| !known) {
        Some(place) => Err(PairError::SegmentsOfDegree { surface: surfaces[place].to_owned() }),
        None => Ok(()),
    }
}

/// The degree of the rule on segments where the user leaves it to an estimate. That of the integrand's fields would count kinks that
/// segments do not have.
///
/// Products of the functions of both sides are exact on affine facets, as those of a gap, or of its derivative, with a test function. On triangles they
/// have twice the degree, 2 or 4, with 3 or 6 points. On quadrilaterals the degree is that in each of two directions, and they have 4 or 8, with 6 or 16
/// points of a triangle. In the plane two or three points are exact to one degree more.
pub(super) fn degree_of<const D: usize>(own: &[SurfaceFacet<D>], opposite: &[SurfaceFacet<D>]) -> usize {
    let all = || own.iter().chain(opposite);
    let degree = all().map(|facet| facet.degree).max().unwrap_or(1);
    match D {
        2 => 2 * degree + 1,
        _ if all().all(|facet| facet.parameters().len() == 3) => 2 * degree,
        _ => 4 * degree,
    }
}

/// The coordinates inside (0, 1) at which the normal of a curve in the plane runs through a point, ascending; of three the first ones of
/// the list count.
pub(super) fn normals_through<const D: usize>(curve: &Parabola<D>, y: &[f64; D]) -> ([f64; 3], usize) {
    let (a, b) = (curve.along, curve.bend);
    let off = minus(y, curve.start);
    let bent = dot(b, b);
    if bent == 0.0 {
        let s = dot(&off, a) / dot(a, a);
        return ([s, 0.0, 0.0], usize::from(s > 0.0 && s < 1.0));
    }
    let product = [dot(&off, a), 2.0 * dot(&off, b) - dot(a, a), -3.0 * dot(a, b), -2.0 * bent];
    roots(&product)
}

/// The zeros of a cubic inside (0, 1) at which it changes its sign, ascending.
fn roots(c: &[f64; 4]) -> ([f64; 3], usize) {
    let at = |s: f64| c[0] + s * (c[1] + s * (c[2] + s * c[3]));
    let slope = |s: f64| c[1] + s * (2.0 * c[2] + s * 3.0 * c[3]);
    // Between its extrema a cubic is monotone.
    let mut places = [0.0, 1.0, 1.0, 1.0];
    let mut count = 1;
    let discriminant = c[2] * c[2] - 3.0 * c[1] * c[3];
    if discriminant > 0.0 {
        let sum = -(c[2] + discriminant.sqrt().copysign(c[2]));
        let (first, second) = (sum / (3.0 * c[3]), c[1] / sum);
        for place in [first.min(second), first.max(second)] {
            if place > 0.0 && place < 1.0 {
                places[count] = place;
                count += 1;
            }
        }
    }
    places[count] = 1.0;
    let (mut found, mut number) = ([0.0; 3], 0);
    for ends in places[..=count].windows(2) {
        let (mut low, mut high) = (ends[0], ends[1]);
        let (first, last) = (at(low), at(high));
        let product = first * last;
        if product.is_nan() || product >= 0.0 {
            continue;
        }
        let mut s = low + (high - low) * first / (first - last);
        for _ in 0..STEPS {
            let value = at(s);
            if value == 0.0 {
                break;
            }
            if value * first > 0.0 {
                low = s
            } else {
                high = s
            }
            let newton = s - value / slope(s);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let ends_here = (next - s).abs() <= f64::EPSILON * 0.5;
            s = next;
            if ends_here {
                break;
            }
        }
        if s > 0.0 && s < 1.0 {
            found[number] = s;
            number += 1;
        }
    }
    (found, number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on the normals of a curve are seen from where those begin; beyond the centre of curvature a point is on three.
    #[test]
    fn normals_run_through_their_points() {
        let (start, along) = ([0.3, -0.2], [1.1, 0.4]);
        for bend in [[0.0; 2], [1e-9, 2e-9], [0.2, -0.3]] {
            let curve = Parabola { start: &start, along: &along, bend: &bend };
            for s in [1e-3, 0.25, 0.5, 0.9] {
                for gap in [-0.3, 0.0, 0.4] {
                    let tangent: [f64; 2] = std::array::from_fn(|k| along[k] + 2.0 * s * bend[k]);
                    let length = dot(&tangent, &tangent).sqrt();
                    let normal = [tangent[1] / length, -tangent[0] / length];
                    let y: [f64; 2] =
                        std::array::from_fn(|k| start[k] + s * along[k] + s * s * bend[k] + gap * normal[k]);
                    let (found, count) = normals_through(&curve, &y);
                    let least = found[..count].iter().map(|root| (root - s).abs()).fold(1.0, f64::min);
                    assert!(least < 1e-14, "{bend:?} {s} {gap}: {found:?}");
                }
            }
        }
        let arch = Parabola { start: &[0.0, 0.0], along: &[1.0, 1.0], bend: &[0.0, -1.0] };
        let (found, count) = normals_through(&arch, &[0.5, -0.4]);
        assert!(count == 3 && (found[1] - 0.5).abs() < 1e-15 && (found[0] + found[2] - 1.0).abs() < 1e-14);
        assert_eq!(normals_through(&arch, &[0.5, 0.5]).1, 1);
    }
}
