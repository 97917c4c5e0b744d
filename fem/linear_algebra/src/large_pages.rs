//! Memory of large arrays, in pages of two megabytes where the system has them.
//!
//! Assembly adds to places all over a matrix. With pages of four kilobytes the processor looks up the page of nearly every
//! one of them, and the system hands the pages over one by one when they are first touched.

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
    /// A page of the least size \[byte\] on every machine that runs Linux divides this.
    const PAGE: usize = 1 << 16;
    let begin = values.as_ptr();
    let start = begin.addr().next_multiple_of(PAGE);
    let end = (begin.addr() + size_of::<T>() * values.capacity()) / PAGE * PAGE;
    if start < end {
        let first = begin.with_addr(start).cast_mut().cast();
        // SAFETY: a foreign function. The range lies within the memory of the vector, and the advice does not change what is there.
        unsafe { libc::madvise(first, end - start, libc::MADV_HUGEPAGE) };
    }
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
}
