//! Lanes of x86-64: four doubles in AVX2, eight in AVX-512.
//!
//! The unsafe code of lanes is here, in `avx2_memory` and in `avx512_memory` (and in `ordered`, for what those read). It has one reason: an intrinsic may run only where
//! the processor has its instructions. The two lane types are private to the package and reach other code only
//! through `with_lanes!`, whose sets are checked.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]
#![cfg_attr(
    any(without_avx2, without_avx512),
    allow(dead_code, reason = "kernels leave one set out, tests do not")
)]

mod avx2_memory;
mod avx512_memory;

use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use forms_core::contract::{Lane, Parts};

use super::logarithm::{self, Split};
use super::{WIDEST, power};

pub(super) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

pub(super) fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && has_avx2()
}

/// Four doubles.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(__m256d);

/// Eight doubles.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(__m512d);

/// A value of a lane type exists only where the set was checked, and the features are there.
macro_rules! simd {
    ($e:expr) => {
        // SAFETY: lane types are only used where the processor has their instructions; see the head of the
        // file. Loads and stores are of references to arrays of the vector's size.
        unsafe { $e }
    };
}
use simd;

/// [`super::SimdLane::prefetch`].
#[inline(always)]
fn ask_for_line<T>(values: &[T], place: usize) {
    if let Some(value) = values.get(place) {
        simd!(_mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast()));
    }
}

macro_rules! lane {
    ($lane:ident, $width:literal, $mask:ty, $add:ident, $sub:ident, $mul:ident, $div:ident, $fma:ident,
     $sqrt:ident, $min:ident, $max:ident, $splat:ident, $load:ident, $store:ident, $xor:ident, $andnot:ident, $features:literal) => {
        impl Add for $lane {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                simd!($lane($add(self.0, other.0)))
            }
        }
        impl Sub for $lane {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                simd!($lane($sub(self.0, other.0)))
            }
        }
        impl Mul for $lane {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                simd!($lane($mul(self.0, other.0)))
            }
        }
        impl Div for $lane {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                simd!($lane($div(self.0, other.0)))
            }
        }
        impl Neg for $lane {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                simd!($lane($xor(self.0, $splat(-0.0))))
            }
        }
        impl AddAssign for $lane {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl $lane {
            #[inline(always)]
            fn array(self) -> [f64; $width] {
                let mut values = [0.0; $width];
                simd!($store(values.as_mut_ptr(), self.0));
                values
            }
            #[inline(always)]
            fn from_array(values: &[f64; $width]) -> Self {
                simd!($lane($load(values.as_ptr())))
            }
        }

        impl Lane for $lane {
            const WIDTH: usize = $width;
            type Mask = $mask;

            #[inline(always)]
            fn apart<K: Parts<Self, NUMBER>, const NUMBER: usize>(
                kernel: &K,
                argument: K::Argument<'_>,
            ) -> K::Kept {
                #[target_feature(enable = $features)]
                #[inline(never)]
                fn enter<K: Parts<$lane, NUMBER>, const NUMBER: usize>(
                    kernel: &K,
                    argument: K::Argument<'_>,
                ) -> K::Kept {
                    kernel.part(argument)
                }
                simd!(enter::<K, NUMBER>(kernel, argument))
            }
            #[inline(always)]
            fn splat(value: f64) -> Self {
                simd!($lane($splat(value)))
            }
            #[inline(always)]
            fn load(values: &[f64]) -> Self {
                let values = &values[..$width];
                simd!($lane($load(values.as_ptr())))
            }
            #[inline(always)]
            fn store(self, values: &mut [f64]) {
                let values = &mut values[..$width];
                simd!($store(values.as_mut_ptr(), self.0))
            }
            #[inline(always)]
            fn multiply_add(self, factor: Self, addend: Self) -> Self {
                simd!($lane($fma(self.0, factor.0, addend.0)))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                simd!($lane($sqrt(self.0)))
            }
            #[inline(always)]
            fn ln(self) -> Self {
                logarithm::ln(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                simd!($lane($andnot($splat(-0.0), self.0)))
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                power(self, exponent)
            }
            #[inline(always)]
            fn each(self, function: impl Fn(f64) -> f64) -> Self {
                let mut values = self.array();
                for lane in 0..$width {
                    values[lane] = function(values[lane]);
                }
                Self::from_array(&values)
            }
            #[inline(always)]
            fn each_pair(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
                let (mut values, others) = (self.array(), other.array());
                for lane in 0..$width {
                    values[lane] = function(values[lane], others[lane]);
                }
                Self::from_array(&values)
            }
            #[inline(always)]
            fn minimum(self, other: Self) -> Self {
                simd!($lane($min(other.0, self.0)))
            }
            #[inline(always)]
            fn maximum(self, other: Self) -> Self {
                simd!($lane($max(other.0, self.0)))
            }
            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                self.compare::<_CMP_LT_OQ>(other)
            }
            #[inline(always)]
            fn less_equal(self, other: Self) -> $mask {
                self.compare::<_CMP_LE_OQ>(other)
            }
            #[inline(always)]
            fn equal(self, other: Self) -> $mask {
                self.compare::<_CMP_EQ_OQ>(other)
            }
            #[inline(always)]
            fn and(first: $mask, second: $mask) -> $mask {
                $lane::both(first, second)
            }
            #[inline(always)]
            fn or(first: $mask, second: $mask) -> $mask {
                $lane::either(first, second)
            }
            #[inline(always)]
            fn not(mask: $mask) -> $mask {
                $lane::opposite(mask)
            }
            #[inline(always)]
            fn select(mask: $mask, taken: Self, otherwise: Self) -> Self {
                taken.where_or(mask, otherwise)
            }
        }
    };
}

lane!(
    Avx2,
    4,
    __m256d,
    _mm256_add_pd,
    _mm256_sub_pd,
    _mm256_mul_pd,
    _mm256_div_pd,
    _mm256_fmadd_pd,
    _mm256_sqrt_pd,
    _mm256_min_pd,
    _mm256_max_pd,
    _mm256_set1_pd,
    _mm256_loadu_pd,
    _mm256_storeu_pd,
    _mm256_xor_pd,
    _mm256_andnot_pd,
    "avx2,fma"
);
lane!(
    Avx512,
    8,
    __mmask8,
    _mm512_add_pd,
    _mm512_sub_pd,
    _mm512_mul_pd,
    _mm512_div_pd,
    _mm512_fmadd_pd,
    _mm512_sqrt_pd,
    _mm512_min_pd,
    _mm512_max_pd,
    _mm512_set1_pd,
    _mm512_loadu_pd,
    _mm512_storeu_pd,
    _mm512_xor_pd,
    _mm512_andnot_pd,
    "avx512f,avx512dq,avx512vl,avx2,fma"
);

impl Avx2 {
    #[inline(always)]
    fn compare<const OPERATOR: i32>(self, other: Self) -> __m256d {
        simd!(_mm256_cmp_pd::<OPERATOR>(self.0, other.0))
    }
    #[inline(always)]
    fn both(first: __m256d, second: __m256d) -> __m256d {
        simd!(_mm256_and_pd(first, second))
    }
    #[inline(always)]
    fn either(first: __m256d, second: __m256d) -> __m256d {
        simd!(_mm256_or_pd(first, second))
    }
    #[inline(always)]
    fn opposite(mask: __m256d) -> __m256d {
        simd!(_mm256_xor_pd(mask, _mm256_castsi256_pd(_mm256_set1_epi64x(-1))))
    }
    #[inline(always)]
    fn where_or(self, mask: __m256d, otherwise: Self) -> Self {
        simd!(Avx2(_mm256_blendv_pd(otherwise.0, self.0, mask)))
    }
}

impl Avx512 {
    #[inline(always)]
    fn compare<const OPERATOR: i32>(self, other: Self) -> __mmask8 {
        simd!(_mm512_cmp_pd_mask::<OPERATOR>(self.0, other.0))
    }
    #[inline(always)]
    fn both(first: __mmask8, second: __mmask8) -> __mmask8 {
        first & second
    }
    #[inline(always)]
    fn either(first: __mmask8, second: __mmask8) -> __mmask8 {
        first | second
    }
    #[inline(always)]
    fn opposite(mask: __mmask8) -> __mmask8 {
        !mask
    }
    #[inline(always)]
    fn where_or(self, mask: __mmask8, otherwise: Self) -> Self {
        simd!(Avx512(_mm512_mask_blend_pd(mask, otherwise.0, self.0)))
    }
}

impl Split for Avx2 {
    #[inline(always)]
    fn is_normal(self) -> bool {
        let normal = Avx2::both(
            Avx2::splat(f64::MIN_POSITIVE).less_equal(self),
            self.less(Avx2::splat(f64::INFINITY)),
        );
        simd!(_mm256_movemask_pd(normal)) == 0b1111
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        simd!({
            let bits = _mm256_castpd_si256(self.0);
            let one = _mm256_castpd_si256(_mm256_set1_pd(1.0));
            let fraction = _mm256_and_si256(bits, _mm256_set1_epi64x(0x000f_ffff_ffff_ffff));
            let mantissa = _mm256_castsi256_pd(_mm256_or_si256(fraction, one));
            // A double of exponent 52 has its integer part in the lowest bits.
            let shifted = _mm256_srli_epi64::<52>(bits);
            let large = _mm256_or_si256(shifted, _mm256_castpd_si256(_mm256_set1_pd(TWO_TO_52)));
            let exponent = _mm256_sub_pd(_mm256_castsi256_pd(large), _mm256_set1_pd(TWO_TO_52 + 1023.0));
            (Avx2(mantissa), Avx2(exponent))
        })
    }
    #[inline(always)]
    fn plain_ln(self) -> Self {
        self.each(f64::ln)
    }
}

impl Split for Avx512 {
    #[inline(always)]
    fn is_normal(self) -> bool {
        Avx512::splat(f64::MIN_POSITIVE).less_equal(self) & self.less(Avx512::splat(f64::INFINITY)) == 0xff
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        simd!((
            Avx512(_mm512_getmant_pd::<_MM_MANT_NORM_1_2, _MM_MANT_SIGN_SRC>(self.0)),
            Avx512(_mm512_getexp_pd(self.0))
        ))
    }
    #[inline(always)]
    fn plain_ln(self) -> Self {
        self.each(f64::ln)
    }
}

const TWO_TO_52: f64 = 4_503_599_627_370_496.0;

const _: () = assert!(WIDEST >= Avx512::WIDTH);
