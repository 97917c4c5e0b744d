//! The natural logarithm of several numbers at once.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

/// Lane types whose numbers come apart into mantissa and exponent.
pub(super) trait Split: Lane {
    /// Whether all lanes are positive, finite and not subnormal.
    fn is_normal(self) -> bool;
    /// Mantissas in [1, 2) and exponents, for normal numbers.
    fn split(self) -> (Self, Self);
    /// The logarithm, one number at a time.
    fn plain_ln(self) -> Self;
}

/// 1/(2k + 1) for k = 11 … 1: the series of artanh(s)/s in s², s ≤ 0.172; what is left out is below 2⁻⁵⁸.
const SERIES: [f64; 11] = [
    1.0 / 23.0,
    1.0 / 21.0,
    1.0 / 19.0,
    1.0 / 17.0,
    1.0 / 15.0,
    1.0 / 13.0,
    1.0 / 11.0,
    1.0 / 9.0,
    1.0 / 7.0,
    1.0 / 5.0,
    1.0 / 3.0,
];

/// ln 2 in two parts, the first with zeros in its last bits, so that its products with exponents are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// ln x = e ln 2 + 2 artanh((m − 1)/(m + 1)) with x = m 2ᵉ and m in [√½, √2); within two units in the last place.
#[inline(always)]
pub(super) fn ln<L: Split>(x: L) -> L {
    if !x.is_normal() {
        return x.plain_ln();
    }
    let one = L::splat(1.0);
    let (mantissa, exponent) = x.split();
    let large = L::splat(std::f64::consts::SQRT_2).less(mantissa);
    let mantissa = L::select(large, mantissa * L::splat(0.5), mantissa);
    let exponent = L::select(large, exponent + one, exponent);
    let s = (mantissa - one) / (mantissa + one);
    let z = s * s;
    let sum = series(z);
    let double = s + s;
    let series = (sum * z).multiply_add(double, exponent * L::splat(LN_2_LOW));
    exponent.multiply_add(L::splat(LN_2_HIGH), double + series)
}

/// The series in z. Pairs of terms, then pairs of those: one term after the other each would wait for the one before, and a kernel with
/// a logarithm at each point for all of them.
#[inline(always)]
fn series<L: Lane>(z: L) -> L {
    let square = z * z;
    let fourth = square * square;
    let mut parts = [L::splat(SERIES[0]); 3];
    // From the lowest powers on: z⁰ to z³, z⁴ to z⁷, z⁸ to z¹⁰.
    for k in 0..3 {
        let lowest = SERIES.len() - 1 - 4 * k;
        let low = L::splat(SERIES[lowest - 1]).multiply_add(z, L::splat(SERIES[lowest]));
        let mut high = L::splat(SERIES[lowest - 2]);
        if lowest > 2 {
            high = L::splat(SERIES[lowest - 3]).multiply_add(z, high);
        }
        parts[k] = high.multiply_add(square, low);
    }
    parts[2].multiply_add(fourth, parts[1]).multiply_add(fourth, parts[0])
}
