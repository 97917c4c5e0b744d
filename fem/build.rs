//! Leaves instruction sets out: kernels are compiled for the best set of this machine alone, unless all are asked for or
//! the build is for another target (decision: docs/decisions/lanes.md).

use std::env;

/// Set to compile all sets of the target, for programs that go to other machines.
const ALL_SETS: &str = "FORMS_ALL_INSTRUCTION_SETS";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={ALL_SETS}");
    println!("cargo::rustc-check-cfg=cfg(without_plain, without_avx2, without_avx512)");
    let variable = |name| env::var(name).unwrap_or_default();
    if variable("TARGET") == variable("HOST") && env::var_os(ALL_SETS).is_none() {
        for left_out in left_out() {
            println!("cargo::rustc-cfg={left_out}");
        }
    }
}

/// All but the best set, as `has_avx512` and `has_avx2` in `src/lanes/x86.rs` ask for them.
#[cfg(target_arch = "x86_64")]
fn left_out() -> &'static [&'static str] {
    let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    let avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl");
    match (avx2, avx512) {
        (true, true) => &["without_plain", "without_avx2"],
        (true, false) => &["without_plain", "without_avx512"],
        (false, _) => &["without_avx2", "without_avx512"],
    }
}

/// NEON is part of the architecture.
#[cfg(target_arch = "aarch64")]
fn left_out() -> &'static [&'static str] {
    &["without_plain"]
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn left_out() -> &'static [&'static str] {
    &[]
}
