//! Leaves instruction sets out: kernels for the best set of this machine and the plain one, unless all are asked for or
//! the build is for another target (decision: docs/decisions/lanes.md).

use std::env;

/// Set to compile all sets of the target, for programs that go to other machines.
const ALL_SETS: &str = "FORMS_ALL_INSTRUCTION_SETS";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={ALL_SETS}");
    println!("cargo::rustc-check-cfg=cfg(without_avx2, without_avx512)");
    let variable = |name| env::var(name).unwrap_or_default();
    if variable("TARGET") == variable("HOST")
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
