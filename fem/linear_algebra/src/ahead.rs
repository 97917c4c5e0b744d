//! Memory that the processor is asked for ahead.

#![allow(unsafe_code)]

/// Bytes that the processor fetches at once.
const LINE: usize = 64;

/// Lets the processor fetch a list in advance, while other work goes on.
#[inline(always)]
pub(crate) fn ask_for<T>(list: &[T]) {
    #[cfg(target_arch = "x86_64")]
    for value in list.iter().step_by(LINE / size_of::<T>()) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: an instruction that every such processor has; it reads nothing, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (list, LINE);
}
