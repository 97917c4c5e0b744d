//! Memory of large arrays, in pages of two megabytes where the system has them.
//!
//! Assembly adds to places all over a matrix. With pages of four kilobytes the processor looks up the page of nearly every
//! one of them, and the system hands the pages over one by one when they are first touched.

/// Arrays below this size \[byte\] have nothing to gain.
const SMALLEST: usize = 1 << 23;

/// So many zeros.
pub(crate) fn zeros(count: usize) -> Vec<f64> {
    let values = vec![0.0; count];
    if size_of_val(&values[..]) >= SMALLEST {
        ask(&values);
    }
    values
}

/// Asks for large pages; a system that has none says no, and nothing is lost.
#[cfg(target_os = "linux")]
fn ask(values: &[f64]) {
    /// A page of the least size \[byte\] on every machine that runs Linux divides this.
    const PAGE: usize = 1 << 16;
    let range = values.as_ptr_range();
    let start = range.start.addr().next_multiple_of(PAGE);
    let end = range.end.addr() / PAGE * PAGE;
    if start < end {
        let first = range.start.with_addr(start).cast_mut().cast();
        // SAFETY: a foreign function. The range lies within the array, and the advice does not change what is there.
        unsafe { libc::madvise(first, end - start, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn ask(_: &[f64]) {}

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
