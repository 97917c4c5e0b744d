//! Memory of a long array that is handed over piece by piece, just before it is written from its beginning to its end.
//!
//! One call for a piece takes the place of a fault for each of its pages. Large pages are quicker still where the system has some at
//! hand, but a virtual machine may have given them back to its host, and then waits longer for one than for all the small pages in its
//! place. So they are asked for as long as they come quickly.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{Advice, SMALLEST, advise, pages_in};

/// Bytes of a large page.
const LARGE: usize = 1 << 21;
/// Small pages in the place of a large one take about so long.
const SLOW: Duration = Duration::from_millis(1);
/// After this number of slow ones an array gets no more large pages; a single one may be slow because another process had its turn.
const MAX_SLOW_FAULTS: u32 = 3;
/// Bytes of an array for which one large page is tried where the last ones were slow.
const WORTH_TRYING: usize = 1 << 26;

/// True if the last array ran out of fast huge pages. A race only affects speed.
static HAS_BEEN_SLOW: AtomicBool = AtomicBool::new(false);

/// The handing over of an array.
pub(crate) struct PrefaultedArray {
    patience: u32,
}

impl PrefaultedArray {
    /// For an array of the given number of bytes.
    pub(crate) fn of(bytes: usize) -> Self {
        let patience = match HAS_BEEN_SLOW.load(Ordering::Relaxed) {
            true => u32::from(bytes >= WORTH_TRYING),
            false => MAX_SLOW_FAULTS,
        };
        PrefaultedArray { patience }
    }

    /// Prefaults memory from the beginning of an array on, where the given number of items are about to be written, and returns the
    /// number of those up to the last whole page. What has been handed over stays as it is.
    pub(crate) fn prefault<T>(&mut self, array: &mut [T], needed: usize) -> usize {
        let (begin, bytes) = (array.as_ptr(), size_of_val(array));
        let end = (begin.addr() + needed * size_of::<T>()).next_multiple_of(LARGE);
        let pages = pages_in(begin.addr(), (end - begin.addr()).min(bytes));
        let count = (pages.end - begin.addr()) / size_of::<T>();
        self.prefault_pages(begin, pages);
        count
    }

    /// Has pages handed over, and says whether the large ones among them come quickly.
    pub(super) fn has_fast_pages<T>(mut self, begin: *const T, pages: Range<usize>) -> bool {
        self.prefault_pages(begin, pages);
        self.patience > 0
    }

    fn prefault_pages<T>(&mut self, begin: *const T, pages: Range<usize>) {
        let mut start = pages.start;
        while start < pages.end {
            let end = (start + 1).next_multiple_of(LARGE).min(pages.end);
            let is_large = end - start == LARGE && self.patience > 0;
            if is_large {
                advise(begin, &(start..end), Advice::Large);
            }
            let called = Instant::now();
            advise(begin, &(start..end), Advice::Now);
            if is_large {
                let is_slow = called.elapsed() > SLOW;
                self.patience -= u32::from(is_slow);
                HAS_BEEN_SLOW.store(is_slow && self.patience == 0, Ordering::Relaxed);
            }
            start = end;
        }
    }
}

/// A new array, or a part of it, that is written from its beginning to its end.
pub(crate) struct PrefaultedSlice<'a, T> {
    array: &'a mut [T],
    /// Number of items that have their memory.
    handed_over: usize,
    supply: PrefaultedArray,
}

impl<'a, T> PrefaultedSlice<'a, T> {
    /// Of an array that nothing was written to.
    pub(crate) fn new(array: &'a mut [T]) -> Self {
        // Small ones are left alone.
        let bytes = size_of_val(array);
        let handed_over = if bytes < SMALLEST { array.len() } else { 0 };
        PrefaultedSlice { array, handed_over, supply: PrefaultedArray::of(bytes) }
    }

    /// The items before the given one, which are about to be written.
    #[inline]
    pub(crate) fn written_up_to(&mut self, end: usize) -> &mut [T] {
        if end > self.handed_over {
            let first = self.handed_over;
            self.handed_over += self.supply.prefault(&mut self.array[first..], end - first);
            // What is left beyond the last whole page is small.
            self.handed_over = self.handed_over.max(end);
        }
        &mut self.array[..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_that_are_handed_over_keep_their_numbers() {
        let mut values = vec![0.0; 1 << 20];
        values[400_000] = 3.0;
        let (mut first, mut supply) = (5, PrefaultedArray::of(1 << 23));
        while first < 900_000 {
            let count = supply.prefault(&mut values[first..], 1_000);
            assert!(count >= 1_000, "{count}");
            first += count;
        }
        // Not beyond the end.
        let rest = values.len() - first;
        assert!(supply.prefault(&mut values[first..], rest) <= rest);
        assert_eq!(values.iter().sum::<f64>(), 3.0);
    }

    #[test]
    fn slices_are_written_to_their_end() {
        for count in [0, 10, 300_000] {
            let mut list = vec![0; count];
            let mut slice = PrefaultedSlice::new(&mut list);
            for k in 0..count {
                slice.written_up_to(k + 1)[k] = k;
            }
            assert!(list.iter().enumerate().all(|(k, item)| *item == k));
        }
    }
}
