//! Lanes of AArch64: four doubles in two NEON registers. Every such processor has NEON, so no check is needed at start-up.

// The loops over registers and lanes are as plain as those of the other sets.
#![allow(clippy::needless_range_loop)]

use std::arch::aarch64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use forms_core::contract::Lane;

use super::{SharedWork, SimdLane, WIDEST, power};

/// Four doubles.
#[derive(Clone, Copy)]
pub(crate) struct Neon([float64x2_t; 2]);

/// Two truth values, all bits of one set or none.
type Mask = [uint64x2_t; 2];

macro_rules! simd {
    ($e:expr) => {
        // SAFETY: AArch64 has NEON. Loads and stores are of references to arrays that hold what is read or written.
        #[allow(unused_unsafe, reason = "intrinsics without pointers are safe where the target has their instructions")]
        unsafe {
            $e
        }
    };
}

/// An intrinsic on each of the two registers.
macro_rules! each {
    ($intrinsic:ident, $($operand:expr),+) => {
        simd!([0, 1].map(|k| $intrinsic($($operand[k]),+)))
    };
}

impl Add for Neon {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Neon(each!(vaddq_f64, self.0, other.0))
    }
}
impl Sub for Neon {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Neon(each!(vsubq_f64, self.0, other.0))
    }
}
impl Mul for Neon {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Neon(each!(vmulq_f64, self.0, other.0))
    }
}
impl Div for Neon {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Neon(each!(vdivq_f64, self.0, other.0))
    }
}
impl Neg for Neon {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Neon(each!(vnegq_f64, self.0))
    }
}
impl AddAssign for Neon {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Neon {
    #[inline(always)]
    fn array(self) -> [f64; 4] {
        let mut values = [0.0; 4];
        self.store(&mut values);
        values
    }
}

impl Lane for Neon {
    const WIDTH: usize = 4;
    type Mask = Mask;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Neon(simd!([vdupq_n_f64(value); 2]))
    }
    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        let values = &values[..4];
        Neon(simd!([vld1q_f64(values[..2].as_ptr()), vld1q_f64(values[2..].as_ptr())]))
    }
    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        let (first, second) = values[..4].split_at_mut(2);
        simd!({
            vst1q_f64(first.as_mut_ptr(), self.0[0]);
            vst1q_f64(second.as_mut_ptr(), self.0[1]);
        })
    }
    #[inline(always)]
    fn multiply_add(self, factor: Self, addend: Self) -> Self {
        Neon(each!(vfmaq_f64, addend.0, self.0, factor.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Neon(each!(vsqrtq_f64, self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Neon(each!(vabsq_f64, self.0))
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        power(self, exponent)
    }
    #[inline(always)]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        let mut values = self.array();
        for lane in 0..4 {
            values[lane] = function(values[lane]);
        }
        Self::load(&values)
    }
    #[inline(always)]
    fn each_pair(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let (mut values, others) = (self.array(), other.array());
        for lane in 0..4 {
            values[lane] = function(values[lane], others[lane]);
        }
        Self::load(&values)
    }
    // Not NEON's own minimum and maximum, which give NaN where either is one; the other sets give `self` then.
    #[inline(always)]
    fn minimum(self, other: Self) -> Self {
        Self::select(other.less(self), other, self)
    }
    #[inline(always)]
    fn maximum(self, other: Self) -> Self {
        Self::select(self.less(other), other, self)
    }
    #[inline(always)]
    fn less(self, other: Self) -> Mask {
        each!(vcltq_f64, self.0, other.0)
    }
    #[inline(always)]
    fn less_equal(self, other: Self) -> Mask {
        each!(vcleq_f64, self.0, other.0)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> Mask {
        each!(vceqq_f64, self.0, other.0)
    }
    #[inline(always)]
    fn and(first: Mask, second: Mask) -> Mask {
        each!(vandq_u64, first, second)
    }
    #[inline(always)]
    fn or(first: Mask, second: Mask) -> Mask {
        each!(vorrq_u64, first, second)
    }
    #[inline(always)]
    fn not(mask: Mask) -> Mask {
        simd!([0, 1].map(|k| veorq_u64(mask[k], vdupq_n_u64(u64::MAX))))
    }
    #[inline(always)]
    fn select(mask: Mask, taken: Self, otherwise: Self) -> Self {
        Neon(each!(vbslq_f64, mask, taken.0, otherwise.0))
    }
}

impl SimdLane for Neon {
    // Two of 32 registers each.
    const REGISTERS: usize = 16;

    #[inline(never)]
    fn call<W: SharedWork<Self>>(work: W) -> W::Output {
        work.run()
    }
}

const _: () = assert!(WIDEST >= Neon::WIDTH);
