//! Lanes of x86-64: four doubles in AVX2, eight in AVX-512.
//!
//! The unsafe code of this package stands here. All of it has one reason: an intrinsic may run only where
//! the processor has its instructions. The two lane types are private to the package and reach other code only
//! through [`run_avx2`] and [`run_avx512`], which check that first.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use forms_core::contract::Lane;

use super::logarithm::{self, Split};
use super::{Entries, LaneWork, SharedWork, SimdLane, Starts, WIDEST, store_entries};

pub(super) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

pub(super) fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && has_avx2()
}

/// Runs some work in AVX2.
///
/// # Safety
/// The machine has it: [`has_avx2`].
#[target_feature(enable = "avx2,fma")]
pub(super) fn run_avx2<W: LaneWork>(work: W) -> W::Output {
    work.run::<Avx2>()
}

/// Runs some work in AVX-512.
///
/// # Safety
/// The machine has it: [`has_avx512`].
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
pub(super) fn run_avx512<W: LaneWork>(work: W) -> W::Output {
    work.run::<Avx512>()
}

/// Four doubles.
#[derive(Clone, Copy)]
pub(super) struct Avx2(__m256d);

/// Eight doubles.
#[derive(Clone, Copy)]
pub(super) struct Avx512(__m512d);

/// A value of a lane type exists only below [`run_avx2`] or [`run_avx512`], where the features are there.
macro_rules! simd {
    ($e:expr) => {
        // SAFETY: lane types are only used where the processor has their instructions; see the head of the
        // file. Loads and stores are of references to arrays of the vector's size.
        unsafe { $e }
    };
}

macro_rules! lane {
    ($lane:ident, $width:literal, $mask:ty, $add:ident, $sub:ident, $mul:ident, $div:ident, $fma:ident,
     $sqrt:ident, $min:ident, $max:ident, $splat:ident, $load:ident, $store:ident, $xor:ident, $andnot:ident) => {
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
            /// A function of one number, lane by lane.
            #[inline(always)]
            fn map(self, function: fn(f64) -> f64) -> Self {
                let mut values = self.array();
                for lane in 0..$width {
                    values[lane] = function(values[lane]);
                }
                Self::from_array(&values)
            }
        }

        impl Lane for $lane {
            const WIDTH: usize = $width;
            type Mask = $mask;

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
            fn exp(self) -> Self {
                self.map(f64::exp)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                logarithm::ln(self)
            }
            #[inline(always)]
            fn sin(self) -> Self {
                self.map(f64::sin)
            }
            #[inline(always)]
            fn cos(self) -> Self {
                self.map(f64::cos)
            }
            #[inline(always)]
            fn tan(self) -> Self {
                self.map(f64::tan)
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                self.map(f64::tanh)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                simd!($lane($andnot($splat(-0.0), self.0)))
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                let (mut rest, mut square, mut power) = (exponent.unsigned_abs(), self, Self::splat(1.0));
                while rest > 0 {
                    if rest % 2 == 1 {
                        power = power * square;
                    }
                    square = square * square;
                    rest /= 2;
                }
                if exponent < 0 { Self::splat(1.0) / power } else { power }
            }
            #[inline(always)]
            fn powf(self, exponent: Self) -> Self {
                let (mut values, exponents) = (self.array(), exponent.array());
                for lane in 0..$width {
                    values[lane] = values[lane].powf(exponents[lane]);
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
    _mm256_andnot_pd
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
    _mm512_andnot_pd
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
        self.map(f64::ln)
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
        self.map(f64::ln)
    }
}

const TWO_TO_52: f64 = 4_503_599_627_370_496.0;

impl SimdLane for Avx2 {
    #[inline(always)]
    fn call<W: SharedWork<Avx2>>(work: W) -> W::Output {
        #[target_feature(enable = "avx2,fma")]
        #[inline(never)]
        fn enter<W: SharedWork<Avx2>>(work: W) -> W::Output {
            work.run()
        }
        simd!(enter(work))
    }
    #[inline(always)]
    fn store_transposed<const ADD: bool>(
        source: &(impl Entries<Self> + ?Sized),
        count: usize,
        filled: usize,
        target: &mut [f64],
        stride: usize,
    ) {
        let mut done = 0;
        if filled == Self::WIDTH {
            assert!(count <= stride && (Self::WIDTH - 1) * stride + count <= target.len());
            while done + 4 <= count {
                let entry = |k: usize| std::ptr::from_ref(source.entry(done + k)).cast::<f64>();
                let (a, b, c, d) = (entry(0), entry(1), entry(2), entry(3));
                // SAFETY: each entry is four doubles; `done + 4 <= count`, and each lane has room for `count`.
                unsafe { store_tile::<ADD>(a, b, c, d, target.as_mut_ptr().add(done), stride) };
                done += 4;
            }
        }
        store_entries::<ADD, _>(source, done..count, filled, target, stride);
    }
}

/// Writes or adds four numbers of a row.
///
/// # Safety
/// Four numbers can be read and written there.
#[inline(always)]
unsafe fn put_row<const ADD: bool>(row: *mut f64, values: __m256d) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe { _mm256_storeu_pd(row, if ADD { _mm256_add_pd(_mm256_loadu_pd(row), values) } else { values }) }
}

/// Writes four lanes of four entries, lane by lane, or adds them.
///
/// # Safety
/// Each entry can be read for four doubles, each of four rows of the target (`stride` apart) read and written for
/// four.
#[inline(always)]
unsafe fn store_tile<const ADD: bool>(
    a: *const f64,
    b: *const f64,
    c: *const f64,
    d: *const f64,
    target: *mut f64,
    stride: usize,
) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe {
        // Two lanes of two entries side by side in each register: half of the shuffling is done by the loads.
        let ac = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(c));
        let bd = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(b)), _mm_loadu_pd(d));
        put_row::<ADD>(target, _mm256_unpacklo_pd(ac, bd));
        put_row::<ADD>(target.add(stride), _mm256_unpackhi_pd(ac, bd));
        let (a, b, c, d) = (a.add(2), b.add(2), c.add(2), d.add(2));
        let ac = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(c));
        let bd = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(b)), _mm_loadu_pd(d));
        put_row::<ADD>(target.add(2 * stride), _mm256_unpacklo_pd(ac, bd));
        put_row::<ADD>(target.add(3 * stride), _mm256_unpackhi_pd(ac, bd));
    }
}

/// Four lanes of four entries → four entries of four lanes.
#[inline(always)]
fn transposed(a: Avx2, b: Avx2, c: Avx2, d: Avx2) -> [Avx2; 4] {
    simd!({
        let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a.0, b.0), _mm256_unpackhi_pd(a.0, b.0));
        let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c.0, d.0), _mm256_unpackhi_pd(c.0, d.0));
        [
            Avx2(_mm256_permute2f128_pd::<0x20>(ab_even, cd_even)),
            Avx2(_mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd)),
            Avx2(_mm256_permute2f128_pd::<0x31>(ab_even, cd_even)),
            Avx2(_mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd)),
        ]
    })
}

impl SimdLane for Avx512 {
    #[inline(always)]
    fn call<W: SharedWork<Avx512>>(work: W) -> W::Output {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
        #[inline(never)]
        fn enter<W: SharedWork<Avx512>>(work: W) -> W::Output {
            work.run()
        }
        simd!(enter(work))
    }
    #[inline(always)]
    fn gather<const COUNT: usize>(values: &[f64], places: &[usize; WIDEST]) -> [Self; COUNT] {
        let mut largest = places[0];
        for lane in 1..8 {
            largest = if places[lane] > largest { places[lane] } else { largest };
        }
        assert!(largest < values.len() && COUNT <= values.len() - largest);
        let mut entries = [Avx512::splat(0.0); COUNT];
        if COUNT > 4 {
            for k in 0..COUNT {
                let mut lanes = [0.0; 8];
                for lane in 0..8 {
                    lanes[lane] = values[places[lane] + k];
                }
                entries[k] = Avx512::from_array(&lanes);
            }
            return entries;
        }
        // SAFETY: places are in range, up to their COUNT entries.
        unsafe { gather_transposed(values, places, 0) }
    }

    #[inline(always)]
    fn gather_from<const COUNT: usize>(values: &[f64], starts: &Starts, offset: usize) -> [Self; COUNT] {
        const { assert!(COUNT <= 4) }
        assert!(starts.largest < values.len() && offset + COUNT <= values.len() - starts.largest);
        // SAFETY: no place is beyond the largest start and the offset, whose COUNT entries are in range.
        unsafe { gather_transposed(values, &starts.places, offset) }
    }

    #[inline(always)]
    fn store_transposed<const ADD: bool>(
        source: &(impl Entries<Self> + ?Sized),
        count: usize,
        filled: usize,
        target: &mut [f64],
        stride: usize,
    ) {
        let mut done = 0;
        if filled == Self::WIDTH {
            assert!(count <= stride && (Self::WIDTH - 1) * stride + count <= target.len());
            while done + 4 <= count {
                let entry = |k: usize| std::ptr::from_ref(source.entry(done + k)).cast::<f64>();
                let (a, b, c, d) = (entry(0), entry(1), entry(2), entry(3));
                // SAFETY: each entry is eight doubles; `done + 4 <= count`, and each lane has room for `count`.
                unsafe {
                    let row = target.as_mut_ptr().add(done);
                    store_tile::<ADD>(a, b, c, d, row, stride);
                    store_tile::<ADD>(a.add(4), b.add(4), c.add(4), d.add(4), row.add(4 * stride), stride);
                }
                done += 4;
            }
        }
        store_entries::<ADD, _>(source, done..count, filled, target, stride);
    }
}

/// COUNT (at most four) entries from each lane's place on.
///
/// # Safety
/// From each place plus the offset on, COUNT entries of `values` can be read.
#[inline(always)]
unsafe fn gather_transposed<const COUNT: usize>(
    values: &[f64],
    places: &[usize; WIDEST],
    offset: usize,
) -> [Avx512; COUNT] {
    // Four lanes' entries each, transposed; what lies beyond the last entry is not read.
    let mask: __mmask8 = (1 << COUNT) - 1;
    let mut rows = [Avx2::splat(0.0); 8];
    for lane in 0..8 {
        // SAFETY: the caller's contract; a masked load reads no entries but the COUNT first.
        rows[lane] = unsafe { Avx2(_mm256_maskz_loadu_pd(mask, values.as_ptr().add(places[lane] + offset))) };
    }
    let low = transposed(rows[0], rows[1], rows[2], rows[3]);
    let high = transposed(rows[4], rows[5], rows[6], rows[7]);
    let mut entries = [Avx512::splat(0.0); COUNT];
    for k in 0..COUNT {
        entries[k] = simd!(Avx512(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low[k].0), high[k].0)));
    }
    entries
}

const _: () = assert!(WIDEST >= Avx512::WIDTH);
