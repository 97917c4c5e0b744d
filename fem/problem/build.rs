//! Leaves instruction sets out: kernels are compiled for one set, the best of this machine or the one that is asked for, unless
//! all are asked for or the build is for another target (decision: docs/decisions/lanes.md).

use std::env;

/// Set to compile all sets of the target, for programs that go to other machines.
const ALL_SETS: &str = "FORMS_ALL_INSTRUCTION_SETS";

/// Set to the name of one of [`SETS`], which is compiled alone: AVX2 on a machine with AVX-512, for comparisons.
const ONE_SET: &str = "FORMS_INSTRUCTION_SET";

/// Sets that can be left out, by the names that [`ONE_SET`] knows, and the `cfg` that leaves each out.
const SETS: [(&str, &str); 3] =
    [("plain", "without_plain"), ("avx2", "without_avx2"), ("avx512", "without_avx512")];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for variable in [ALL_SETS, ONE_SET] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    println!("cargo::rustc-check-cfg=cfg(without_plain, without_avx2, without_avx512)");
    let variable = |name| env::var(name).unwrap_or_default();
    let all = env::var_os(ALL_SETS).is_some();
    let kept = match env::var(ONE_SET) {
        Ok(_) if all => return refuse(format!("{ONE_SET} asks for one set, {ALL_SETS} for all")),
        Ok(name) => match of_target(&name, &variable("CARGO_CFG_TARGET_ARCH")) {
            Ok(kept) => kept,
            Err(reason) => return refuse(reason),
        },
        Err(_) if all || variable("TARGET") != variable("HOST") => return,
        Err(_) => {
            let best = best();
            warn(best, &variable("PROFILE"));
            best
        }
    };
    // Where there is nothing but the plain set, or NEON, which is part of its architecture, nothing of x86 is compiled anyway.
    for (name, left_out) in SETS {
        if name != kept {
            println!("cargo::rustc-cfg={left_out}");
        }
    }
}

/// Says which machines a release build is for, as programs are copied from those. Kernels without vectors run anywhere, and NEON is
/// part of its architecture.
fn warn(best: &str, profile: &str) {
    if best.starts_with("avx") && profile == "release" {
        println!(
            "cargo::warning=kernels are compiled for {best}: programs run on machines that have it. {ALL_SETS}=1 in the environment \
             builds for others, too; {ONE_SET}={best} silences this"
        );
    }
}

/// A set that is asked for, if the target has it.
fn of_target(name: &str, architecture: &str) -> Result<&'static str, String> {
    let known: &[&'static str] = match architecture {
        "x86_64" => &["plain", "avx2", "avx512"],
        "aarch64" => &["neon"],
        _ => &["plain"],
    };
    let found = known.iter().find(|known| **known == name);
    found
        .copied()
        .ok_or_else(|| format!("{ONE_SET} is `{name}`; on {architecture} it is one of: {}", known.join(", ")))
}

fn refuse(reason: String) {
    println!("cargo::error={reason}");
}

/// The best set of this machine, as `has_avx512` and `has_avx2` in `src/lanes/x86.rs` ask for them.
#[cfg(target_arch = "x86_64")]
fn best() -> &'static str {
    let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    let avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl");
    match (avx2, avx512) {
        (true, true) => "avx512",
        (true, false) => "avx2",
        (false, _) => "plain",
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn best() -> &'static str {
    if cfg!(target_arch = "aarch64") { "neon" } else { "plain" }
}
