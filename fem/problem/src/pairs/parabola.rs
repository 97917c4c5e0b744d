//! Quadratic curves in the plane and the lines that meet them, in closed form.

use super::frame::{dot, minus, splat};
use super::tolerances::INSIDE;
use crate::lanes::SimdLane;

/// The curve start + s along + s² bend of a facet in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parabola<'a, const D: usize> {
    pub start: &'a [f64; D],
    pub along: &'a [f64; D],
    pub bend: &'a [f64; D],
}

impl<const D: usize> Parabola<'_, D> {
    /// The coordinate s at which a line through x along n meets the curve. If there are two points, it is the one at which the curve faces the line
    /// (its normal has a negative product with n), provided that it lies on the facet, and otherwise the one nearer to the facet's middle, s = 1/2.
    /// Not a number if the line misses the curve.
    #[inline(always)]
    pub fn met_by<L: SimdLane>(&self, x: &[L; D], n: &[L; D]) -> L {
        // With t = s − 1/2 the curve is middle + t tangent + t² bend, and across · (curve − x) = 0 for the normal of the line.
        let (mut middle, mut tangent) = (*self.start, *self.along);
        for k in 0..D {
            middle[k] += 0.5 * self.along[k] + 0.25 * self.bend[k];
            tangent[k] += self.bend[k];
        }
        let mut across = *n;
        (across[0], across[D - 1]) = (-n[D - 1], n[0]);
        let a = dot(&across, &splat(self.bend));
        let b = dot(&across, &splat(&tangent));
        let c = dot(&across, &minus(&splat(&middle), x));
        let (zero, two) = (L::splat(0.0), L::splat(2.0));
        let root = (b * b - two * two * a * c).sqrt();
        // Both roots are quotients with b and √(b² − 4 a c) of one sign, without cancellation. across · (derivative of the curve),
        // the normal's product with n, is b + 2 a t = ±√(b² − 4 a c): the smaller root is the facing one where b < 0.
        let size = b.abs() + root;
        let backward = zero.less_equal(b);
        let mut t = L::select(backward, -two * c, two * c) / size;
        if L::any(backward) {
            let facing = -size / (two * a);
            let half = L::splat(0.5 + INSIDE);
            t = L::select(L::and(backward, facing.abs().less_equal(half)), facing, t);
        }
        L::splat(0.5) + t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point of a curve is met again by lines through it, from both sides; beyond the vertex of a parabola nothing is met, and before
    /// it the side that faces the line.
    #[test]
    fn lines_meet_the_curve_where_they_come_from() {
        let (start, along) = ([0.3, -0.2], [1.1, 0.4]);
        for bend in [[0.0; 2], [0.1, -0.3], [1e-17, 0.2]] {
            let curve = Parabola { start: &start, along: &along, bend: &bend };
            for s in [0.0, 0.25, 0.5, 0.9, 1.0] {
                for n in [[0.0, 1.0], [0.0, -1.0], [0.6, -0.8], [-0.28, 0.96]] {
                    let x: [f64; 2] =
                        std::array::from_fn(|k| start[k] + s * along[k] + s * s * bend[k] - 0.7 * n[k]);
                    let found = curve.met_by(&x, &n);
                    assert!((found - s).abs() < 1e-14, "{bend:?} {s} {n:?}: {found}");
                }
            }
        }
        let arch = Parabola { start: &[0.0, 0.0], along: &[1.0, 1.0], bend: &[0.0, -1.0] };
        assert!(arch.met_by(&[5.0, 0.24], &[-1.0, 0.0]).is_finite());
        assert!(arch.met_by(&[5.0, 0.26], &[-1.0, 0.0]).is_nan());
        // Of two meetings on the facet, at s = 0.2 and 0.8, that where the curve's normal (1 − 2 s, −1) is against the line.
        for (n, s) in [([1.0, 0.0], 0.8), ([-1.0, 0.0], 0.2)] {
            let found = arch.met_by(&[5.0, 0.16], &n);
            assert!((found - s).abs() < 1e-15, "{n:?}: {found}");
        }
        // Where only one lies on the facet that one, seen from behind too.
        let steep = Parabola { start: &[0.0, 0.0], along: &[1.0, 0.0], bend: &[0.0, 1.0] };
        assert!((steep.met_by(&[0.0, 0.16], &[1.0, 0.0]) - 0.4_f64).abs() < 1e-15);
    }
}
