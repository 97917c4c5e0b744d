//! Clearing of wide vector registers after kernels that leave numbers in them.
//!
//! faer's products come from kernels in assembler that return without clearing the upper halves of vector registers. Until these are
//! cleared, instructions of the older sets, to which most code is compiled, keep the halves and wait for them. A loop over a sparse row
//! takes up to five times as long then, on this thread, until another routine clears them.

#![allow(unsafe_code)]

/// The result of a routine of faer, with clear registers behind it.
#[inline(always)]
pub(crate) fn cleared<R>(routine: impl FnOnce() -> R) -> R {
    let result = routine();
    clear();
    result
}

#[inline]
fn clear() {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx") {
        // SAFETY: the processor has the instruction. The upper halves hold nothing that code after a call may read.
        unsafe { zero_upper_halves() };
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
fn zero_upper_halves() {
    std::arch::x86_64::_mm256_zeroupper();
}

#[cfg(test)]
mod tests {
    use faer::linalg::matmul::matmul;
    use faer::{Accum, Mat, Par};

    use super::*;

    /// The upper half of a register, as a kernel left it.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn upper_half_is_set() -> bool {
        let half: u64;
        // SAFETY: reads a register and writes another, which the compiler knows.
        unsafe {
            std::arch::asm!(
                "vextractf128 xmm1, ymm0, 1",
                "vmovq {half}, xmm1",
                half = out(reg) half,
                out("xmm1") _,
                options(nomem, nostack, preserves_flags)
            );
        }
        half != 0
    }

    /// Fills a register as a kernel without clearing does.
    #[cfg(target_arch = "x86_64")]
    fn fill() {
        // SAFETY: the caller has seen that the processor has these instructions; the register is named.
        unsafe {
            std::arch::asm!("vcmptrueps ymm0, ymm0, ymm0", out("xmm0") _, options(nomem, nostack));
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn upper_halves_are_zero_behind_a_routine() {
        if std::is_x86_feature_detected!("avx") {
            cleared(fill);
            // SAFETY: the processor has the instructions.
            assert!(!unsafe { upper_half_is_set() });
        }
    }

    #[test]
    fn products_are_returned() {
        let matrix = Mat::from_fn(40, 40, |i, j| (i + 2 * j) as f64);
        let mut product = Mat::<f64>::zeros(40, 40);
        cleared(|| matmul(product.as_mut(), Accum::Replace, &matrix, &matrix, 1.0, Par::Seq));
        let entry: f64 = (0..40).map(|k| (3 + 2 * k) as f64 * (k + 10) as f64).sum();
        assert_eq!(product[(3, 5)], entry);
    }
}
