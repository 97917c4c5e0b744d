//! Memory of large arrays, in pages of two megabytes where the system has them, or handed over many pages at once.
//!
//! Assembly adds to places all over a matrix. With pages of four kilobytes the processor looks up the page of nearly every
//! one of them, and the system hands the pages over one by one when they are first touched.

#![allow(unsafe_code)]

mod prefaulted_array;

use std::ops::Range;

pub(crate) use prefaulted_array::{PrefaultedArray, PrefaultedSlice};

/// Arrays below this size \[byte\] have nothing to gain.
const SMALLEST: usize = 1 << 21;
/// So much of an array is handed over before it is used \[byte\], to see whether large pages come quickly.
const TRIED: usize = 1 << 24;
/// A page of most machines \[byte\]. Where pages are larger, the system refuses some wishes, and nothing is lost.
const SMALLEST_PAGE: usize = 1 << 12;

/// The given number of zeros, or of other default values. Of numbers, memory beyond the first 16 megabytes that nothing is written to is never asked
/// for.
pub fn zeros<T: Clone + Default>(count: usize) -> Vec<T> {
    let values = vec![T::default(); count];
    ask(&values);
    values
}

/// An empty vector with room for the given number.
pub fn room<T>(count: usize) -> Vec<T> {
    let values = Vec::with_capacity(count);
    ask(&values);
    values
}

/// Memory that is about to be added to, handed over before anything was written to it.
///
/// Addition reads first. The system then shows a shared page of zeros, and takes it away from every processor when the sum is written.
/// On several threads these interruptions take longer than the additions.
pub fn hand_over<T>(values: &mut [T]) {
    let begin = values.as_ptr();
    advise(begin, &pages_of(SMALLEST_PAGE, begin.addr(), size_of_val(values)), Advice::Now);
}

/// Asks for large pages, if the first of them come quickly.
fn ask<T>(values: &Vec<T>) {
    let (begin, bytes) = (values.as_ptr(), size_of::<T>() * values.capacity());
    if bytes >= SMALLEST {
        let pages = pages_in(begin.addr(), bytes);
        let rest = (pages.start + TRIED).min(pages.end)..pages.end;
        if PrefaultedArray::of(bytes).has_fast_pages(begin, pages.start..rest.start) {
            advise(begin, &rest, Advice::Large);
        }
    }
}

/// The addresses of the whole pages among the given number of bytes.
fn pages_in(begin: usize, bytes: usize) -> Range<usize> {
    /// A page of the least size \[byte\] on every machine that runs Linux divides this.
    const PAGE: usize = 1 << 16;
    pages_of(PAGE, begin, bytes)
}

/// The addresses of whole pages of the given size \[byte\].
fn pages_of(page: usize, begin: usize, bytes: usize) -> Range<usize> {
    let start = begin.next_multiple_of(page);
    start..((begin + bytes) / page * page).max(start)
}

/// A wish for some pages.
#[derive(Clone, Copy)]
enum Advice {
    /// MADV_HUGEPAGE.
    Large,
    /// MADV_POPULATE_WRITE: prefault.
    Now,
}

/// Tells the system a wish for pages that lie within an array. A system that does not know it says no, and nothing is lost.
#[cfg(target_os = "linux")]
fn advise<T>(begin: *const T, pages: &Range<usize>, advice: Advice) {
    let advice = match advice {
        Advice::Large => libc::MADV_HUGEPAGE,
        Advice::Now => libc::MADV_POPULATE_WRITE,
    };
    if !pages.is_empty() {
        let first = begin.with_addr(pages.start).cast_mut().cast();
        // SAFETY: a foreign function. The pages lie within the memory of the array, and neither wish changes what is there.
        unsafe { libc::madvise(first, pages.len(), advice) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise<T>(_: *const T, _: &Range<usize>, _: Advice) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_arrays_are_zero_and_can_be_written() {
        for count in [0, 1, SMALLEST / 8 - 1, SMALLEST / 8 + 1_000] {
            let mut values: Vec<f64> = zeros(count);
            assert!(values.len() == count && values.iter().all(|value| *value == 0.0));
            values.fill(1.0);
            assert_eq!(values.iter().sum::<f64>(), count as f64);
        }
    }

    #[test]
    fn memory_that_is_handed_over_keeps_its_numbers() {
        let mut values: Vec<f64> = zeros(3 * SMALLEST / 8);
        values[SMALLEST / 8] = 2.0;
        for start in [0, 1, 511, 512, SMALLEST / 8 - 3] {
            for count in [0, 1, 600, 1 << 15] {
                hand_over(&mut values[start..start + count]);
            }
        }
        assert!(values[SMALLEST / 8] == 2.0 && values.iter().sum::<f64>() == 2.0);
    }
}
