//! The number type of a kernel: one cell, or several cells side by side in a SIMD register.

use crate::error_function;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// No lane type has more lanes.
pub const LARGEST_WIDTH: usize = 64;

/// A real number for one cell (`f64`), or for [`Lane::WIDTH`] cells at once.
///
/// Kernels are generic over this trait, so that one emitted source serves every instruction set.
/// All operations act lane by lane. Comparisons give a mask; [`Lane::select`] picks without arithmetic,
/// so a NaN in the branch that is not taken never reaches the result.
pub trait Lane:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// Number of cells processed at once.
    const WIDTH: usize;
    /// Result of a comparison, one truth value per lane.
    type Mask: Copy;

    /// The same value in every lane.
    fn splat(value: f64) -> Self;
    /// Builds a lane value from the first [`Lane::WIDTH`] entries of `values`.
    fn load(values: &[f64]) -> Self;
    /// Writes the lanes to the first [`Lane::WIDTH`] entries of `values`.
    fn store(self, values: &mut [f64]);

    /// `self * factor + addend`, contracted to one instruction where the hardware has it.
    fn multiply_add(self, factor: Self, addend: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Integer power, by repeated multiplication; negative exponents divide.
    fn powi(self, exponent: i32) -> Self;
    /// The smaller of two values.
    fn minimum(self, other: Self) -> Self;
    /// The larger of two values.
    fn maximum(self, other: Self) -> Self;

    /// A function of one number, lane by lane.
    #[inline]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        const { assert!(Self::WIDTH <= LARGEST_WIDTH) }
        let mut values = [0.0; LARGEST_WIDTH];
        self.store(&mut values);
        for value in &mut values[..Self::WIDTH] {
            *value = function(*value);
        }
        Self::load(&values)
    }
    /// A function of two numbers, lane by lane.
    #[inline]
    fn each_pair(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        const { assert!(Self::WIDTH <= LARGEST_WIDTH) }
        let (mut values, mut others) = ([0.0; LARGEST_WIDTH], [0.0; LARGEST_WIDTH]);
        self.store(&mut values);
        other.store(&mut others);
        for (value, other) in values[..Self::WIDTH].iter_mut().zip(others) {
            *value = function(*value, other);
        }
        Self::load(&values)
    }
    /// Exponential.
    #[inline(always)]
    fn exp(self) -> Self {
        self.each(f64::exp)
    }
    /// Natural logarithm.
    #[inline(always)]
    fn ln(self) -> Self {
        self.each(f64::ln)
    }
    /// Sine (radian).
    #[inline(always)]
    fn sin(self) -> Self {
        self.each(f64::sin)
    }
    /// Cosine (radian).
    #[inline(always)]
    fn cos(self) -> Self {
        self.each(f64::cos)
    }
    /// Tangent (radian).
    #[inline(always)]
    fn tan(self) -> Self {
        self.each(f64::tan)
    }
    /// Hyperbolic tangent.
    #[inline(always)]
    fn tanh(self) -> Self {
        self.each(f64::tanh)
    }
    /// Real power of a non-negative base.
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        self.each_pair(exponent, f64::powf)
    }
    /// Arcsine (radian); a NaN outside [−1, 1].
    #[inline]
    fn asin(self) -> Self {
        self.each(f64::asin)
    }
    /// Arccosine (radian); a NaN outside [−1, 1].
    #[inline]
    fn acos(self) -> Self {
        self.each(f64::acos)
    }
    /// Arctangent (radian).
    #[inline]
    fn atan(self) -> Self {
        self.each(f64::atan)
    }
    /// The angle of the point (`x`, `self`) with the first axis (radian), in (−π, π]; 0 at the origin.
    #[inline]
    fn atan2(self, x: Self) -> Self {
        self.each_pair(x, f64::atan2)
    }
    /// Hyperbolic sine.
    #[inline]
    fn sinh(self) -> Self {
        self.each(f64::sinh)
    }
    /// Hyperbolic cosine.
    #[inline]
    fn cosh(self) -> Self {
        self.each(f64::cosh)
    }
    /// Inverse hyperbolic sine.
    #[inline]
    fn asinh(self) -> Self {
        self.each(f64::asinh)
    }
    /// Inverse hyperbolic cosine; a NaN below 1.
    #[inline]
    fn acosh(self) -> Self {
        self.each(f64::acosh)
    }
    /// Inverse hyperbolic tangent; a NaN outside [−1, 1].
    #[inline]
    fn atanh(self) -> Self {
        self.each(f64::atanh)
    }
    /// Logarithm to the base 10.
    #[inline]
    fn log10(self) -> Self {
        self.each(f64::log10)
    }
    /// The error function 2/√π ∫₀ˣ exp(−t²) dt.
    #[inline]
    fn erf(self) -> Self {
        self.each(error_function::erf)
    }
    /// One minus the error function, accurate also where it is small.
    #[inline]
    fn erfc(self) -> Self {
        self.each(error_function::erfc)
    }

    /// A part of a long computation, in a function of its own that is compiled for the lane's instructions: compilers take more
    /// than linear time over long functions.
    #[inline(never)]
    fn apart<K: Parts<Self, NUMBER>, const NUMBER: usize>(kernel: &K, argument: K::Argument<'_>) -> K::Kept {
        kernel.part(argument)
    }

    /// `self < other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn less_equal(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn equal(self, other: Self) -> Self::Mask;
    /// Both masks.
    fn and(first: Self::Mask, second: Self::Mask) -> Self::Mask;
    /// Either mask.
    fn or(first: Self::Mask, second: Self::Mask) -> Self::Mask;
    /// The opposite mask.
    fn not(mask: Self::Mask) -> Self::Mask;
    /// `taken` where the mask holds, `otherwise` elsewhere.
    fn select(mask: Self::Mask, taken: Self, otherwise: Self) -> Self;
}

/// A kernel whose computation at a point is long and comes in parts, with the part of a number. A trait and no function that is handed
/// over: what calls such a function is compiled for any machine, and the lane's instructions would be calls in it.
pub trait Parts<L, const NUMBER: usize> {
    /// Input of the part: geometry, fields, values kept by earlier parts.
    type Argument<'a>;
    /// Values that later parts read of it.
    type Kept;
    /// Computes the part; `#[inline(always)]`.
    fn part(&self, argument: Self::Argument<'_>) -> Self::Kept;
}

impl Lane for f64 {
    const WIDTH: usize = 1;
    type Mask = bool;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        values[0]
    }
    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        values[0] = self;
    }
    // Not `f64::mul_add`: without the FMA target feature that is a library call.
    #[inline(always)]
    fn multiply_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }
    #[inline(always)]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        function(self)
    }
    #[inline(always)]
    fn each_pair(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        function(self, other)
    }
    #[inline(always)]
    fn minimum(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    #[inline(always)]
    fn maximum(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn less_equal(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn equal(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn and(first: bool, second: bool) -> bool {
        first && second
    }
    #[inline(always)]
    fn or(first: bool, second: bool) -> bool {
        first || second
    }
    #[inline(always)]
    fn not(mask: bool) -> bool {
        !mask
    }
    #[inline(always)]
    fn select(mask: bool, taken: Self, otherwise: Self) -> Self {
        if mask { taken } else { otherwise }
    }
}
