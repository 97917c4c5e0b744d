//! Memory of large arrays, in pages of two megabytes where the system has them, or handed over many pages at once.
//!
//! Assembly adds to places all over a matrix. With pages of four kilobytes the processor looks up the page of nearly every
//! one of them, and the system hands the pages over one by one when they are first touched.

#[cfg(target_os = "linux")]
use std::ops::Range;

/// Arrays below this size \[byte\] have nothing to gain.
const SMALLEST: usize = 1 << 21;

/// So many zeros, or what else is the default. Of numbers, memory that nothing is written to is never asked for.
pub fn zeros<T: Clone + Default>(count: usize) -> Vec<T> {
    let values = vec![T::default(); count];
    ask(&values);
    values
}

/// An empty vector with room for so many.
pub fn room<T>(count: usize) -> Vec<T> {
    let values = Vec::with_capacity(count);
    ask(&values);
    values
}

/// Asks for large pages; a system that has none says no, and nothing is lost.
#[cfg(target_os = "linux")]
fn ask<T>(values: &Vec<T>) {
    if size_of::<T>() * values.capacity() < SMALLEST {
        return;
    }
    let begin = values.as_ptr();
    let pages = pages_in(begin.addr(), size_of::<T>() * values.capacity());
    let first = begin.with_addr(pages.start).cast_mut().cast();
    // SAFETY: a foreign function. The range lies within the memory of the vector, and the advice does not change what is there.
    unsafe { libc::madvise(first, pages.len(), libc::MADV_HUGEPAGE) };
}

/// The addresses of the whole pages among so many bytes.
#[cfg(target_os = "linux")]
fn pages_in(begin: usize, bytes: usize) -> Range<usize> {
    /// A page of the least size \[byte\] on every machine that runs Linux divides this.
    const PAGE: usize = 1 << 16;
    let start = begin.next_multiple_of(PAGE);
    start..((begin + bytes) / PAGE * PAGE).max(start)
}

/// Has the system hand over the pages of numbers that are about to be written, in one call in place of a fault for each page, and
/// gives the number of those up to the last whole page. What has been handed over stays as it is; a system that knows no such call
/// says no, and nothing is lost.
#[cfg(target_os = "linux")]
pub(crate) fn hand_over(values: &mut [f64]) -> usize {
    let begin = values.as_mut_ptr();
    let pages = pages_in(begin.addr(), size_of_val(values));
    let first = begin.with_addr(pages.start).cast();
    // SAFETY: a foreign function. The range lies within the memory of the numbers, and the advice does not change what is there.
    unsafe { libc::madvise(first, pages.len(), libc::MADV_POPULATE_WRITE) };
    (pages.end - begin.addr()) / size_of::<f64>()
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn hand_over(values: &mut [f64]) -> usize {
    values.len()
}

#[cfg(not(target_os = "linux"))]
fn ask<T>(_: &Vec<T>) {}

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
    fn pages_that_are_handed_over_keep_their_numbers() {
        let mut values = vec![0.0; 1 << 16];
        values[10_000] = 3.0;
        let mut first = 5;
        while first < 50_000 {
            // At least one whole page of 64 kilobytes.
            let count = hand_over(&mut values[first..first + 16_384]);
            assert!((8_192..=16_384).contains(&count), "{count}");
            first += count;
        }
        assert_eq!(values.iter().sum::<f64>(), 3.0);
    }
}
