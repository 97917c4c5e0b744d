//! Gather, scatter and transposition between memory and the lanes of AVX-512.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lanes are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use std::arch::x86_64::*;

use forms_core::contract::Lane;

use super::avx2_memory::{store_tile, transposed};
use super::{Avx2, Avx512, ask_for_line, simd};
use crate::lanes::{Entries, SharedWork, SimdLane, Starts, WIDEST, store_entries};

impl SimdLane for Avx512 {
    const REGISTERS: usize = 32;

    #[inline(always)]
    fn any(mask: __mmask8) -> bool {
        mask != 0
    }

    #[inline(always)]
    fn prefetch<T>(values: &[T], place: usize) {
        ask_for_line(values, place);
    }

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
        Self::gather_from(values, &Starts::at::<Self>(places), 0)
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
        source: impl Entries<Self>,
        filled: usize,
        target: &mut [f64],
        stride: usize,
    ) {
        let (mut done, count) = (0, source.count());
        if filled == Self::WIDTH {
            assert!(count <= stride && (Self::WIDTH - 1) * stride + count <= target.len());
            let row = target.as_mut_ptr();
            let squares = count / 8;
            // SAFETY: each entry is eight doubles; no square goes beyond `count`, for which each lane has room.
            unsafe {
                if count < BEYOND_THE_FIRST_CACHE {
                    store_squares::<ADD, false>(source, squares, row, stride);
                } else {
                    store_squares::<ADD, true>(source, squares, row, stride);
                }
            }
            done = 8 * squares;
            if done + 1 == count {
                // SAFETY: each lane has room for `count` entries.
                unsafe { store_last::<ADD>(source, done, row, stride) };
                done = count;
            }
            while let Some(first) = next_tile::<ADD>(done, count) {
                let entry = |k: usize| std::ptr::from_ref(source.entry(first + k)).cast::<f64>();
                let (a, b, c, d) = (entry(0), entry(1), entry(2), entry(3));
                // SAFETY: each entry is eight doubles; `first + 4 <= count`, and each lane has room for `count`.
                unsafe {
                    let row = target.as_mut_ptr().add(first);
                    store_tile::<ADD>(a, b, c, d, row, stride);
                    store_tile::<ADD>(a.add(4), b.add(4), c.add(4), d.add(4), row.add(4 * stride), stride);
                }
                done = first + 4;
            }
        }
        store_entries::<ADD, _>(source, done..count, filled, target, stride);
    }
}

/// Entries per lane from which eight lanes of results and the values they are made from do not fit the first cache.
const BEYOND_THE_FIRST_CACHE: usize = 256;

/// The start of the next four of `count` entries. The last four may have been written in part before, which does not matter
/// unless they are added.
#[inline(always)]
fn next_tile<const ADD: bool>(done: usize, count: usize) -> Option<usize> {
    if done + 4 <= count {
        Some(done)
    } else if !ADD && done < count && count >= 4 {
        Some(count - 4)
    } else {
        None
    }
}

/// Writes the first `8 * squares` entries, lane by lane, or adds them, eight entries of eight lanes at a time. If FETCH,
/// the lines that come next are asked for before they are written: otherwise the writes wait for them one after the other,
/// which takes twice the time (docs/decisions/lanes.md).
///
/// # Safety
/// There are as many entries, and each of eight rows of the target (`stride` apart) can be read and written for as many
/// doubles.
#[inline(always)]
unsafe fn store_squares<const ADD: bool, const FETCH: bool>(
    source: impl Entries<Avx512>,
    squares: usize,
    target: *mut f64,
    stride: usize,
) {
    for square in 0..squares {
        let mut entries = [std::ptr::null::<f64>(); 8];
        for k in 0..8 {
            entries[k] = std::ptr::from_ref(source.entry(8 * square + k)).cast();
        }
        // SAFETY: the caller's contract; a prefetch may go anywhere.
        unsafe {
            let rows = target.add(8 * square);
            if FETCH {
                for lane in 0..8 {
                    _mm_prefetch::<_MM_HINT_T0>(rows.wrapping_add(lane * stride + 24).cast());
                }
            }
            store_half_square::<ADD>(&entries, 0, rows, stride);
            store_half_square::<ADD>(&entries, 4, rows.add(4 * stride), stride);
        }
    }
}

/// Writes or adds one entry, lane by lane.
///
/// # Safety
/// Each of eight rows of the target (`stride` apart) can be read and written at the entry's place.
#[inline(always)]
unsafe fn store_last<const ADD: bool>(
    source: impl Entries<Avx512>,
    k: usize,
    target: *mut f64,
    stride: usize,
) {
    let values = std::ptr::from_ref(source.entry(k)).cast::<f64>();
    for lane in 0..8 {
        // SAFETY: an entry is eight doubles, and each lane has room for entry k: the caller's contract.
        unsafe {
            let (value, row) = (*values.add(lane), target.add(lane * stride + k));
            *row = if ADD { *row + value } else { value };
        }
    }
}

/// Writes four lanes, from `lane` on, of eight entries, lane by lane, or adds them.
///
/// # Safety
/// Each entry can be read for four doubles from `lane` on, each of four rows of the target (`stride` apart) read and written
/// for eight.
#[inline(always)]
unsafe fn store_half_square<const ADD: bool>(
    entries: &[*const f64; 8],
    lane: usize,
    target: *mut f64,
    stride: usize,
) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe {
        // Four lanes of entries k and k + 4 side by side: that part of the shuffling is done by the loads.
        let mut pairs = [_mm512_setzero_pd(); 4];
        for k in 0..4 {
            let (first, second) = (entries[k].add(lane), entries[k + 4].add(lane));
            let low = _mm512_castpd256_pd512(_mm256_loadu_pd(first));
            pairs[k] = _mm512_insertf64x4::<1>(low, _mm256_loadu_pd(second));
        }
        let even = [_mm512_unpacklo_pd(pairs[0], pairs[1]), _mm512_unpacklo_pd(pairs[2], pairs[3])];
        let odd = [_mm512_unpackhi_pd(pairs[0], pairs[1]), _mm512_unpackhi_pd(pairs[2], pairs[3])];
        let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        store_long_row::<ADD>(target, _mm512_permutex2var_pd(even[0], first, even[1]));
        store_long_row::<ADD>(target.add(stride), _mm512_permutex2var_pd(odd[0], first, odd[1]));
        store_long_row::<ADD>(target.add(2 * stride), _mm512_permutex2var_pd(even[0], second, even[1]));
        store_long_row::<ADD>(target.add(3 * stride), _mm512_permutex2var_pd(odd[0], second, odd[1]));
    }
}

/// Writes or adds eight numbers of a row.
///
/// # Safety
/// Eight numbers can be read and written there.
#[inline(always)]
unsafe fn store_long_row<const ADD: bool>(row: *mut f64, values: __m512d) {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe { _mm512_storeu_pd(row, if ADD { _mm512_add_pd(_mm512_loadu_pd(row), values) } else { values }) }
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
    if const { COUNT == 2 } {
        // SAFETY: the caller's contract: two entries are read from each place on.
        let pair = unsafe { gather_pairs(values.as_ptr().add(offset), places) };
        let mut entries = [Avx512::splat(0.0); COUNT];
        for k in 0..COUNT {
            entries[k] = pair[k];
        }
        return entries;
    }
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

/// The two entries from each lane's place on.
///
/// # Safety
/// From each place on, two doubles can be read.
#[inline(always)]
unsafe fn gather_pairs(values: *const f64, places: &[usize; WIDEST]) -> [Avx512; 2] {
    // SAFETY: the caller's contract, and the machine's instructions as for all lanes.
    unsafe {
        let pair = |lane: usize| _mm_loadu_pd(values.add(places[lane]));
        // Lanes 0, 2, 4, 6 side by side, and 1, 3, 5, 7: what is left to do stays within pairs.
        let mut halves = [_mm512_setzero_pd(); 2];
        for odd in 0..2 {
            let low = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair(odd)), pair(odd + 2));
            let high = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair(odd + 4)), pair(odd + 6));
            halves[odd] = _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high);
        }
        [Avx512(_mm512_unpacklo_pd(halves[0], halves[1])), Avx512(_mm512_unpackhi_pd(halves[0], halves[1]))]
    }
}
