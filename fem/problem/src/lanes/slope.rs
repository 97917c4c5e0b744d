//! Derivatives that lanes carry, along one direction or two.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::{Add, Neg, Sub};

use forms_core::contract::Lane;

use super::{SimdLane, WIDEST};

/// Derivatives of values, along one direction or two.
pub(crate) trait Slope<L>:
    Copy + Send + Sync + 'static + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self>
{
    /// The number of directions.
    const DIRECTIONS: usize;

    /// The same number in all directions.
    fn all(slope: L) -> Self;
    /// That along one direction.
    fn along(self, direction: usize) -> L;
    fn times(self, factor: L) -> Self;
    fn times_add(self, factor: L, addend: Self) -> Self;
    fn over(self, divisor: L) -> Self;
}

/// Derivatives along two directions.
#[derive(Clone, Copy)]
pub(crate) struct Both<L>(pub [L; 2]);

impl<L: Lane> Slope<L> for L {
    const DIRECTIONS: usize = 1;

    #[inline(always)]
    fn all(slope: L) -> Self {
        slope
    }
    #[inline(always)]
    fn along(self, _direction: usize) -> L {
        self
    }
    #[inline(always)]
    fn times(self, factor: L) -> Self {
        self * factor
    }
    #[inline(always)]
    fn times_add(self, factor: L, addend: Self) -> Self {
        self.multiply_add(factor, addend)
    }
    #[inline(always)]
    fn over(self, divisor: L) -> Self {
        self / divisor
    }
}

impl<L: Lane> Slope<L> for Both<L> {
    const DIRECTIONS: usize = 2;

    #[inline(always)]
    fn all(slope: L) -> Self {
        Both([slope; 2])
    }
    #[inline(always)]
    fn along(self, direction: usize) -> L {
        self.0[direction]
    }
    #[inline(always)]
    fn times(self, factor: L) -> Self {
        Both([self.0[0] * factor, self.0[1] * factor])
    }
    #[inline(always)]
    fn times_add(self, factor: L, addend: Self) -> Self {
        let [first, second] = addend.0;
        Both([self.0[0].multiply_add(factor, first), self.0[1].multiply_add(factor, second)])
    }
    #[inline(always)]
    fn over(self, divisor: L) -> Self {
        Both([self.0[0] / divisor, self.0[1] / divisor])
    }
}

impl<L: Lane> Add for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Both([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl<L: Lane> Sub for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Both([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl<L: Lane> Neg for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Both([-self.0[0], -self.0[1]])
    }
}

/// Slopes whose lanes are chosen one by one, and come from memory.
pub(crate) trait SimdSlope<L: SimdLane>: Slope<L> {
    fn chosen(mask: L::Mask, taken: Self, otherwise: Self) -> Self;
    /// Whether it is zero along all directions.
    fn is_zero(self) -> L::Mask;
    /// That of f from f′: what does not move along a direction has no derivative there, whatever f′ is.
    fn chained(self, slope: L) -> Self;
    /// From lists of the first and second derivatives, or of those along two directions.
    fn gathered<const COUNT: usize>(slopes: [&[f64]; 2], places: &[usize; WIDEST]) -> [Self; COUNT];
}

impl<L: SimdLane> SimdSlope<L> for L {
    #[inline(always)]
    fn chosen(mask: L::Mask, taken: Self, otherwise: Self) -> Self {
        L::select(mask, taken, otherwise)
    }
    #[inline(always)]
    fn is_zero(self) -> L::Mask {
        self.vanishes()
    }
    #[inline(always)]
    fn chained(self, slope: L) -> Self {
        L::select(self.vanishes(), L::splat(0.0), slope * self)
    }
    #[inline(always)]
    fn gathered<const COUNT: usize>([slopes, bends]: [&[f64]; 2], places: &[usize; WIDEST]) -> [Self; COUNT] {
        // Inside of values with two derivatives there are values with one.
        L::gather_with_slopes::<COUNT>(slopes, [bends, &[]], places)
    }
}

impl<L: SimdLane> SimdSlope<L> for Both<L> {
    #[inline(always)]
    fn chosen(mask: L::Mask, taken: Self, otherwise: Self) -> Self {
        let ([a, b], [c, d]) = (taken.0, otherwise.0);
        Both([L::select(mask, a, c), L::select(mask, b, d)])
    }
    #[inline(always)]
    fn is_zero(self) -> L::Mask {
        L::and(self.0[0].vanishes(), self.0[1].vanishes())
    }
    #[inline(always)]
    fn chained(self, slope: L) -> Self {
        Both([self.0[0].chained(slope), self.0[1].chained(slope)])
    }
    #[inline(always)]
    fn gathered<const COUNT: usize>(slopes: [&[f64]; 2], places: &[usize; WIDEST]) -> [Self; COUNT] {
        let first = L::gather::<COUNT>(slopes[0], places);
        let second = L::gather::<COUNT>(slopes[1], places);
        let mut both = [Both([L::splat(0.0); 2]); COUNT];
        for k in 0..COUNT {
            both[k] = Both([first[k], second[k]]);
        }
        both
    }
}
