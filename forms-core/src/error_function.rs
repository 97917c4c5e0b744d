//! The error function to double precision.
//!
//! Source: the rational approximations of `s_erf.c` in FDLIBM, "Copyright (C) 1993 by Sun Microsystems, Inc.
//! All rights reserved. Developed at SunPro, a Sun Microsystems, Inc. business. Permission to use, copy,
//! modify, and distribute this software is freely granted, provided that this notice is preserved."
//! Their error is below one unit in the last place.

/// erf x = 2/√π ∫₀ˣ exp(−t²) dt
pub fn erf(x: f64) -> f64 {
    let a = x.abs();
    // The first comparison is false for a NaN, which passes through the last branch.
    if a < 0.84375 {
        // Below 2⁻²⁸ the next term is lost in rounding; written so that nothing underflows.
        if a < 3.7e-9 {
            return 0.125 * (8.0 * x + LINEAR_TIMES_8 * x);
        }
        return x + x * near_zero(x);
    }
    let magnitude = if a < 1.25 {
        ERF_ONE + near_one(a)
    } else if a < 6.0 {
        1.0 - tail(a)
    } else if x.is_nan() {
        return x;
    } else {
        1.0
    };
    magnitude.copysign(x)
}

/// erfc x = 1 − erf x, accurate also where it is small.
pub fn erfc(x: f64) -> f64 {
    let a = x.abs();
    if a < 0.84375 {
        let change = x * near_zero(x);
        return if x < 0.25 { 1.0 - (x + change) } else { 0.5 - (x - 0.5 + change) };
    }
    let beyond = if a < 1.25 {
        1.0 - ERF_ONE - near_one(a)
    } else if a < 28.0 {
        tail(a)
    } else if x.is_nan() {
        return x;
    } else {
        0.0
    };
    if x < 0.0 { 2.0 - beyond } else { beyond }
}

/// Σ c_k zᵏ
fn polynomial(z: f64, coefficients: &[f64]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * z + coefficient)
}

/// erf x / x − 1 for |x| < 0.84375.
fn near_zero(x: f64) -> f64 {
    let z = x * x;
    polynomial(z, &NUMERATOR_ZERO) / polynomial(z, &DENOMINATOR_ZERO)
}

/// erf a − [`ERF_ONE`] for 0.84375 ≤ a < 1.25.
fn near_one(a: f64) -> f64 {
    let s = a - 1.0;
    polynomial(s, &NUMERATOR_ONE) / polynomial(s, &DENOMINATOR_ONE)
}

/// erfc a for a ≥ 1.25.
fn tail(a: f64) -> f64 {
    let s = 1.0 / (a * a);
    let quotient = if a < 1.0 / 0.35 {
        polynomial(s, &NUMERATOR_MIDDLE) / polynomial(s, &DENOMINATOR_MIDDLE)
    } else {
        polynomial(s, &NUMERATOR_FAR) / polynomial(s, &DENOMINATOR_FAR)
    };
    // exp(−a²) in two factors, the first with an argument that has no rounding error.
    let short = f64::from_bits(a.to_bits() & 0xffff_ffff_0000_0000);
    (-short * short - 0.5625).exp() * ((short - a) * (short + a) + quotient).exp() / a
}

/// 8 (2/√π − 1)
const LINEAR_TIMES_8: f64 = 1.0270333367641007;
/// erf 1 rounded to single precision.
const ERF_ONE: f64 = 0.8450629115104675;
const NUMERATOR_ZERO: [f64; 5] = [
    0.12837916709551256,
    -0.3250421072470015,
    -0.02848174957559851,
    -0.005770270296489442,
    -2.3763016656650163e-05,
];
const DENOMINATOR_ZERO: [f64; 6] = [
    1.0,
    0.39791722395915535,
    0.0650222499887673,
    0.005081306281875766,
    0.00013249473800432164,
    -3.960228278775368e-06,
];
const NUMERATOR_ONE: [f64; 7] = [
    -0.0023621185607526594,
    0.41485611868374833,
    -0.3722078760357013,
    0.31834661990116175,
    -0.11089469428239668,
    0.035478304325618236,
    -0.002166375594868791,
];
const DENOMINATOR_ONE: [f64; 7] = [
    1.0,
    0.10642088040084423,
    0.540397917702171,
    0.07182865441419627,
    0.12617121980876164,
    0.01363708391202905,
    0.011984499846799107,
];
const NUMERATOR_MIDDLE: [f64; 8] = [
    -0.009864944034847148,
    -0.6938585727071818,
    -10.558626225323291,
    -62.375332450326006,
    -162.39666946257347,
    -184.60509290671104,
    -81.2874355063066,
    -9.814329344169145,
];
const DENOMINATOR_MIDDLE: [f64; 9] = [
    1.0,
    19.651271667439257,
    137.65775414351904,
    434.56587747522923,
    645.3872717332679,
    429.00814002756783,
    108.63500554177944,
    6.570249770319282,
    -0.0604244152148581,
];
const NUMERATOR_FAR: [f64; 7] = [
    -0.0098649429247001,
    -0.799283237680523,
    -17.757954917754752,
    -160.63638485582192,
    -637.5664433683896,
    -1025.0951316110772,
    -483.5191916086514,
];
const DENOMINATOR_FAR: [f64; 8] = [
    1.0,
    30.33806074348246,
    325.7925129965739,
    1536.729586084437,
    3199.8582195085955,
    2553.0504064331644,
    474.52854120695537,
    -22.44095244658582,
];

#[cfg(test)]
mod tests {
    use super::{erf, erfc};

    /// x, erf x, erfc x: computed with 40 digits by mpmath (`mpmath.erf(mpmath.mpf(x))`) at the very `f64` x,
    /// and rounded to the nearest `f64`.
    const TABLE: &[(f64, f64, f64)] = &[
        (0.0, 0.0, 1.0),
        (1e-300, 1.1283791670955126e-300, 1.0),
        (1e-10, 1.1283791670955126e-10, 0.999999999887162),
        (0.01, 0.011283415555849618, 0.9887165844441503),
        (0.1, 0.1124629160182849, 0.887537083981715),
        (0.25, 0.27632639016823696, 0.7236736098317631),
        (0.5, 0.5204998778130465, 0.4795001221869535),
        (0.75, 0.7111556336535151, 0.28884436634648486),
        (0.84, 0.7651427114549945, 0.23485728854500548),
        (0.85, 0.7706680576083526, 0.22933194239164748),
        (1.0, 0.8427007929497149, 0.15729920705028513),
        (1.2, 0.9103139782296353, 0.08968602177036464),
        (1.25, 0.9229001282564583, 0.07709987174354177),
        (1.3, 0.9340079449406524, 0.06599205505934755),
        (1.5, 0.9661051464753108, 0.033894853524689274),
        (2.0, 0.9953222650189527, 0.004677734981047266),
        (2.5, 0.999593047982555, 0.0004069520174449589),
        (2.8, 0.9999249868053346, 7.501319466545911e-05),
        (2.9, 0.9999589021219005, 4.109787809945886e-05),
        (3.0, 0.9999779095030014, 2.209049699858544e-05),
        (3.5, 0.9999992569016276, 7.430983723414128e-07),
        (4.0, 0.9999999845827421, 1.541725790028002e-08),
        (5.0, 0.9999999999984626, 1.537459794428035e-12),
        (5.9, 0.9999999999999999, 7.190409783550478e-17),
        (6.0, 1.0, 2.1519736712498913e-17),
        (7.0, 1.0, 4.183825607779414e-23),
        (10.0, 1.0, 2.088487583762545e-45),
        (20.0, 1.0, 5.395865611607901e-176),
        (26.0, 1.0, 5.663192408856143e-296),
    ];

    #[test]
    fn agrees_with_forty_digits() {
        let near = |found: f64, expected: f64| {
            // One unit in the last place, or two.
            assert!((found - expected).abs() <= 4.5e-16 * expected.abs(), "{found:e} is not {expected:e}");
        };
        for &(x, value, complement) in TABLE {
            near(erf(x), value);
            near(erf(-x), -value);
            near(erfc(x), complement);
            near(erfc(-x), 1.0 + value);
        }
    }

    #[test]
    fn ends() {
        assert_eq!([erf(f64::INFINITY), erf(f64::NEG_INFINITY), erfc(f64::INFINITY)], [1.0, -1.0, 0.0]);
        assert_eq!([erf(-0.0).to_bits(), erfc(0.0).to_bits()], [(-0.0_f64).to_bits(), 1.0_f64.to_bits()]);
        assert!(erf(f64::NAN).is_nan() && erfc(f64::NAN).is_nan());
    }
}
