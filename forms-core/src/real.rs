//! The number type of a function written in Rust: `f64`, or a dual number that carries derivatives along.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number. A function that is generic over it can be called by a form, which needs its derivatives too:
/// the compiler runs it with [`Dual`](crate::dual::Dual) numbers.
///
/// ```
/// use forms_core::contract::Real;
/// /// |g|^(p-2) g, the flux of the p-Laplacian, regularised at zero.
/// pub fn flux<R: Real, const D: usize>(g: [R; D], p: R) -> [R; D] {
///     let squares: R = g.iter().map(|component| *component * *component).sum();
///     if squares > 0.0 { g.map(|component| squares.powf((p - 2.0) / 2.0) * component) } else { g }
/// }
/// assert_eq!(flux([3.0, 4.0], 3.0), [15.0, 20.0]);
/// ```
///
/// An `f64` may be on the right of an operator (`x * 2.0`); on the left it is `R::from(2.0) * x`, because
/// `f64` cannot know all number types. Comparisons compare values, so an `if` takes the branch that it takes
/// for `f64`, and the derivative is that of the branch.
pub trait Real:
    Copy
    + Debug
    + 'static
    + From<f64>
    + PartialEq
    + PartialOrd
    + PartialEq<f64>
    + PartialOrd<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + AddAssign<f64>
    + SubAssign<f64>
    + MulAssign<f64>
    + DivAssign<f64>
    + Sum
{
    /// The number of derivatives that are carried along: 0 for `f64`.
    const ORDER: usize;

    /// The number without its derivatives.
    fn value(self) -> f64;
    /// The number and all its derivatives are zero.
    fn vanishes(self) -> bool;

    /// Square root.
    fn sqrt(self) -> Self;
    /// Cube root.
    fn cbrt(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// exp(x) − 1, accurate near zero.
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// ln(1 + x), accurate near zero.
    fn ln_1p(self) -> Self;
    /// Integer power.
    fn powi(self, exponent: i32) -> Self;
    /// Real power of a non-negative base.
    fn powf(self, exponent: Self) -> Self;
    /// Sine (radian).
    fn sin(self) -> Self;
    /// Cosine (radian).
    fn cos(self) -> Self;
    /// Tangent (radian).
    fn tan(self) -> Self;
    /// Arc sine \[radian\].
    fn asin(self) -> Self;
    /// Arc cosine \[radian\].
    fn acos(self) -> Self;
    /// Arc tangent \[radian\].
    fn atan(self) -> Self;
    /// The angle \[radian\] of the point (`x`, `self`).
    fn atan2(self, x: Self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Absolute value; its derivative at 0 is 0.
    fn abs(self) -> Self;
    /// −1, 0 or 1; its derivative is 0.
    fn signum(self) -> Self;
    /// The smaller of two numbers; where they are equal, the derivative is that of `self`. NaN if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers; where they are equal, the derivative is that of `other`. NaN if one is NaN.
    fn max(self, other: Self) -> Self;

    /// 0.
    fn zero() -> Self {
        Self::from(0.0)
    }
    /// 1.
    fn one() -> Self {
        Self::from(1.0)
    }
}

/// Methods of `f64` under the same name.
macro_rules! as_f64 {
    ($($name:ident),*) => {
        $(#[inline]
        fn $name(self) -> Self {
            f64::$name(self)
        })*
    };
}

impl Real for f64 {
    const ORDER: usize = 0;

    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn vanishes(self) -> bool {
        self == 0.0
    }
    as_f64!(sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, abs);
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }
    #[inline]
    fn powf(self, exponent: Self) -> Self {
        f64::powf(self, exponent)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }
    #[inline]
    fn signum(self) -> Self {
        if self == 0.0 { 0.0 } else { f64::signum(self) }
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        if self.is_nan() || self <= other { self } else { other }
    }
    #[inline]
    fn max(self, other: Self) -> Self {
        if self.is_nan() || self > other { self } else { other }
    }
}
