//! Leaves instruction sets out of the development profile: kernels for the best set of this machine and the plain one, for
//! debug builds run where they are built (decision: docs/decisions/lanes.md).

use std::env;

/// Set to compile all sets of the target in the development profile, too.
const ALL_SETS: &str = "FORMS_ALL_INSTRUCTION_SETS";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={ALL_SETS}");
    println!("cargo::rustc-check-cfg=cfg(without_avx2, without_avx512)");
    let variable = |name| env::var(name).unwrap_or_default();
    let stays = variable("PROFILE") == "debug" && variable("TARGET") == variable("HOST");
    if stays
        && env::var_os(ALL_SETS).is_none()
        && let Some(left_out) = left_out()
    {
        println!("cargo::rustc-cfg={left_out}");
    }
}

/// AVX2 where there is AVX-512, as `has_avx512` in `src/lanes/x86.rs` asks for it, and the other way round.
#[cfg(target_arch = "x86_64")]
fn left_out() -> Option<&'static str> {
    let best = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl");
    Some(if best { "without_avx2" } else { "without_avx512" })
}

#[cfg(not(target_arch = "x86_64"))]
fn left_out() -> Option<&'static str> {
    None
}
