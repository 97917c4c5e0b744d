//! Gather, scatter and transposition between memory and the lanes of AVX2.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lanes are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use std::arch::x86_64::*;

use forms_core::contract::Lane;

use super::{Avx2, ask_for_line, simd};
use crate::lanes::{Entries, SharedWork, SimdLane, Starts, WIDEST, store_entries};

impl SimdLane for Avx2 {
    const REGISTERS: usize = 16;
    const STORES_FEW: bool = true;

    #[inline(always)]
    fn any(mask: __m256d) -> bool {
        simd!(_mm256_movemask_pd(mask)) != 0
    }

    #[inline(always)]
    fn prefetch<T>(values: &[T], place: usize) {
        ask_for_line(values, place);
    }

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
    fn gather<const COUNT: usize>(values: &[f64], places: &[usize; WIDEST]) -> [Self; COUNT] {
        Self::gather_from(values, &Starts::at::<Self>(places), 0)
    }

    #[inline(always)]
    fn gather_from<const COUNT: usize>(values: &[f64], starts: &Starts, offset: usize) -> [Self; COUNT] {
        assert!(starts.largest < values.len() && offset + COUNT <= values.len() - starts.largest);
        // SAFETY: no place is beyond the largest start and the offset, whose COUNT entries are in range.
        unsafe { gather_by_pairs(values.as_ptr().add(offset), &starts.places) }
    }

    #[inline(always)]
    fn store_transposed<const ADD: bool>(
        source: impl Entries<Self>,
        filled: usize,
        target: &mut [f64],
        stride: usize,
    ) {
        let (mut done, count) = (0, source.count());
        if filled == Self::WIDTH {
            assert!(count <= stride && (Self::WIDTH - 1) * stride + count <= target.len());
            let row = target.as_mut_ptr();
            // SAFETY: nothing goes beyond `count`, for which each lane has room.
            unsafe {
                while done + 4 <= count {
                    let [a, b, c, d] = source.four(done);
                    store_rows::<ADD>(*a, *b, *c, *d, row.add(done), stride);
                    done += 4;
                }
                if done + 2 <= count {
                    store_pair::<ADD>(source.entry(done), source.entry(done + 1), row.add(done), stride);
                    done += 2;
                }
                if done < count {
                    store_single::<ADD>(source.entry(done), row.add(done), stride);
                    done += 1;
                }
            }
        }
        store_entries::<ADD, _>(source, done..count, filled, target, stride);
    }

    #[inline(always)]
    unsafe fn store_few_from<const COUNT: usize>(entries: [Self; COUNT], row: *mut f64, stride: usize) {
        let mut done = 0;
        // SAFETY: the caller's contract.
        unsafe {
            while done + 4 <= COUNT {
                let [a, b, c, d] = [entries[done], entries[done + 1], entries[done + 2], entries[done + 3]];
                store_rows::<false>(a, b, c, d, row.add(done), stride);
                done += 4;
            }
            if done + 2 <= COUNT {
                store_pair::<false>(&entries[done], &entries[done + 1], row.add(done), stride);
                done += 2;
            }
            if done < COUNT {
                store_lanes(entries[done], row.add(done), stride);
            }
        }
    }
}

/// Writes or adds four numbers of a row.
///
/// # Safety
/// Four numbers can be read and written there.
#[inline(always)]
unsafe fn store_row<const ADD: bool>(row: *mut f64, values: __m256d) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe { _mm256_storeu_pd(row, if ADD { _mm256_add_pd(_mm256_loadu_pd(row), values) } else { values }) }
}

/// Writes four lanes of four entries, lane by lane, or adds them.
///
/// # Safety
/// Each of four rows of the target (`stride` apart) can be read and written for four doubles.
#[inline(always)]
unsafe fn store_rows<const ADD: bool>(a: Avx2, b: Avx2, c: Avx2, d: Avx2, target: *mut f64, stride: usize) {
    let rows = transposed(a, b, c, d);
    for lane in 0..4 {
        // SAFETY: the caller's contract.
        unsafe { store_row::<ADD>(target.add(lane * stride), rows[lane].0) };
    }
}

/// The same of four of the lanes of wider entries in memory.
///
/// # Safety
/// Each entry can be read for four doubles, each of four rows of the target (`stride` apart) read and written for
/// four.
#[inline(always)]
pub(super) unsafe fn store_tile<const ADD: bool>(
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
        store_row::<ADD>(target, _mm256_unpacklo_pd(ac, bd));
        store_row::<ADD>(target.add(stride), _mm256_unpackhi_pd(ac, bd));
        let (a, b, c, d) = (a.add(2), b.add(2), c.add(2), d.add(2));
        let ac = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(c));
        let bd = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(b)), _mm_loadu_pd(d));
        store_row::<ADD>(target.add(2 * stride), _mm256_unpacklo_pd(ac, bd));
        store_row::<ADD>(target.add(3 * stride), _mm256_unpackhi_pd(ac, bd));
    }
}

/// Writes four lanes of two entries, lane by lane, or adds them.
///
/// # Safety
/// Each of four rows of the target (`stride` apart) can be read and written for two doubles.
#[inline(always)]
unsafe fn store_pair<const ADD: bool>(first: &Avx2, second: &Avx2, target: *mut f64, stride: usize) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe {
        let (even, odd) = (_mm256_unpacklo_pd(first.0, second.0), _mm256_unpackhi_pd(first.0, second.0));
        store_short_row::<ADD>(target, _mm256_castpd256_pd128(even));
        store_short_row::<ADD>(target.add(stride), _mm256_castpd256_pd128(odd));
        store_short_row::<ADD>(target.add(2 * stride), _mm256_extractf128_pd::<1>(even));
        store_short_row::<ADD>(target.add(3 * stride), _mm256_extractf128_pd::<1>(odd));
    }
}

/// Writes or adds two numbers of a row.
///
/// # Safety
/// Two numbers can be read and written there.
#[inline(always)]
unsafe fn store_short_row<const ADD: bool>(row: *mut f64, values: __m128d) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe { _mm_storeu_pd(row, if ADD { _mm_add_pd(_mm_loadu_pd(row), values) } else { values }) }
}

/// Writes four lanes of one entry, lane by lane, or adds them.
///
/// # Safety
/// Each of four rows of the target (`stride` apart) can be read and written there.
#[inline(always)]
unsafe fn store_single<const ADD: bool>(entry: &Avx2, target: *mut f64, stride: usize) {
    let values = std::ptr::from_ref(entry).cast::<f64>();
    for lane in 0..4 {
        // SAFETY: an entry is four doubles; the rest is the caller's contract.
        unsafe {
            let (value, row) = (*values.add(lane), target.add(lane * stride));
            *row = if ADD { *row + value } else { value };
        }
    }
}

/// Writes four lanes of an entry that is in a register.
///
/// # Safety
/// Each of four rows of the target (`stride` apart) can be written there.
#[inline(always)]
unsafe fn store_lanes(entry: Avx2, target: *mut f64, stride: usize) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe {
        let (low, high) = (_mm256_castpd256_pd128(entry.0), _mm256_extractf128_pd::<1>(entry.0));
        _mm_storel_pd(target, low);
        _mm_storeh_pd(target.add(stride), low);
        _mm_storel_pd(target.add(2 * stride), high);
        _mm_storeh_pd(target.add(3 * stride), high);
    }
}

/// COUNT entries from each of the first four places on, two at a time.
///
/// # Safety
/// From each place on, COUNT doubles can be read.
#[inline(always)]
unsafe fn gather_by_pairs<const COUNT: usize>(values: *const f64, places: &[usize; WIDEST]) -> [Avx2; COUNT] {
    let mut entries = [Avx2::splat(0.0); COUNT];
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe {
        let lane = |number: usize, k: usize| values.add(places[number] + k);
        let mut k = 0;
        while k + 2 <= COUNT {
            // Lanes 0 and 2 side by side, and 1 and 3: that part of the shuffling is done by the loads.
            let even = _mm256_castpd128_pd256(_mm_loadu_pd(lane(0, k)));
            let even = _mm256_insertf128_pd::<1>(even, _mm_loadu_pd(lane(2, k)));
            let odd = _mm256_castpd128_pd256(_mm_loadu_pd(lane(1, k)));
            let odd = _mm256_insertf128_pd::<1>(odd, _mm_loadu_pd(lane(3, k)));
            entries[k] = Avx2(_mm256_unpacklo_pd(even, odd));
            entries[k + 1] = Avx2(_mm256_unpackhi_pd(even, odd));
            k += 2;
        }
        if k < COUNT {
            let low = _mm_loadh_pd(_mm_load_sd(lane(0, k)), lane(1, k));
            let high = _mm_loadh_pd(_mm_load_sd(lane(2, k)), lane(3, k));
            entries[k] = Avx2(_mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high));
        }
    }
    entries
}

/// Four lanes of four entries → four entries of four lanes.
#[inline(always)]
pub(super) fn transposed(a: Avx2, b: Avx2, c: Avx2, d: Avx2) -> [Avx2; 4] {
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
