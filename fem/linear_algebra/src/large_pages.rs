//! Memory of large arrays, in pages of two megabytes where the system has them.
//!
//! Assembly adds to places all over a matrix. With pages of four kilobytes the processor looks up the page of nearly every
//! one of them, and the system hands the pages over one by one when they are first touched.

/// Arrays below this size \[byte\] have nothing to gain.
const SMALLEST: usize = 1 << 23;

/// So many zeros.
pub(crate) fn zeros(count: usize) -> Vec<f64> {
    let values = vec![0.0; count];
    ask(&values);
    values
}

/// An empty vector with room for so many numbers.
pub(crate) fn room(count: usize) -> Vec<f64> {
    let values = Vec::with_capacity(count);
    ask(&values);
    values
}

/// Asks for large pages; a system that has none says no, and nothing is lost.
#[cfg(target_os = "linux")]
fn ask(values: &Vec<f64>) {
    if size_of::<f64>() * values.capacity() < SMALLEST {
        return;
    }
    /// A page of the least size \[byte\] on every machine that runs Linux divides this.
    const PAGE: usize = 1 << 16;
    let begin = values.as_ptr();
    let start = begin.addr().next_multiple_of(PAGE);
    let end = (begin.addr() + size_of::<f64>() * values.capacity()) / PAGE * PAGE;
    if start < end {
        let first = begin.with_addr(start).cast_mut().cast();
        // SAFETY: a foreign function. The range lies within the memory of the vector, and the advice does not change what is there.
        unsafe { libc::madvise(first, end - start, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn ask(_: &Vec<f64>) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_arrays_are_zero_and_can_be_written() {
        for count in [0, 1, SMALLEST / 8 - 1, SMALLEST / 8 + 1_000] {
            let mut values = zeros(count);
            assert!(values.len() == count && values.iter().all(|value| *value == 0.0));
            values.fill(1.0);
            assert_eq!(values.iter().sum::<f64>(), count as f64);
        }
    }
}
