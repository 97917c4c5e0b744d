//! Element kernels: builds the plugin, lets the harness time it among FFCx's variants, reads the numbers.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use forms_fem::output::tell;

use super::machine::{ARCHITECTURE, CHOSEN, INSTRUCTION_SET, architecture};
use super::process::{environment_python, output, peers, succeeds, system_python, workspace};
use super::rows::{KernelRow, Timing};
use super::{ComparisonError, Options, Report};
use crate::basket::BASKET;

/// The harness's name of our plugin.
const OURS: &str = "ours";

/// The end of the names of forms with FFCx's sum-factorised elements.
const SUM_FACTORISED: &str = "_sumfact";

/// Builds the plugin and returns its path. It is built as a dependency of this program, an example, because that is
/// built already. By itself it would be compiled once more, with other features of its dependencies.
fn build() -> Result<PathBuf, ComparisonError> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(workspace()).args([
        "build",
        "--release",
        "-p",
        "forms-bench",
        "--example",
        "compare_with_peers",
        "--message-format=json",
    ]);
    if let Some(set) = CHOSEN {
        command.env(INSTRUCTION_SET, set);
    }
    command.stderr(std::process::Stdio::inherit());
    let messages = output("cargo build", &mut command)?;
    let files = messages.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let names = files.flat_map(|message| message["filenames"].as_array().cloned().unwrap_or_default());
    let library = std::env::consts::DLL_EXTENSION;
    let plugin = names
        .filter_map(|name| name.as_str().map(PathBuf::from))
        .filter(|path| path.extension().is_some_and(|extension| extension == library))
        .find(|path| path.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("forms_bench")));
    plugin.ok_or_else(|| ComparisonError::Output {
        program: "cargo build".to_owned(),
        reason: "it names no shared library forms_bench".to_owned(),
    })
}

/// The variants that this machine can make; the others are named in the report.
fn variants(report: &mut Report) -> Vec<&'static str> {
    let mut variants = vec!["gcc_O2", "gcc_O3n_fm"];
    let clang = succeeds("clang", &["--version"]);
    let old = succeeds(system_python(), &["-c", "import ffcx.parameters"]);
    if clang {
        variants.extend(["clang_O3n", "clang_O3n_fm"]);
    } else {
        report.missing.push(("clang".to_owned(), "package clang".to_owned()));
    }
    if old {
        variants.extend(["old_gcc_O2", "old_gcc_O3n_fm"]);
        variants.extend(clang.then_some(["old_clang_O3n", "old_clang_O3n_fm"]).into_iter().flatten());
    } else {
        report.missing.push(("FFCx 0.5.0".to_owned(), "Debian 12's package python3-ffcx".to_owned()));
    }
    variants
}

/// Times the basket.
pub(super) fn compare(options: &Options, report: &mut Report) -> Result<(), ComparisonError> {
    let plugin = build()?;
    if !succeeds("gcc", &["--version"]) {
        report.missing.push(("FFCx's kernels".to_owned(), "gcc, which compiles them".to_owned()));
        return Ok(());
    }
    if !environment_python().exists() {
        tell("making the virtual environment with FFCx 0.11: this needs a network");
    }
    let mut command = Command::new("bash");
    command.arg(peers().join("run_ffcx_kernels.sh"));
    command.args(["--variants", &variants(report).join(" ")]);
    command.args(options.quick.then_some("--quick")).env(ARCHITECTURE, architecture());
    if let Some(part) = &options.only_forms {
        command.args(["--only", part]);
    }
    command.arg(format!("{OURS}={}", plugin.display()));
    command.stderr(std::process::Stdio::inherit());
    match output("run_ffcx_kernels.sh", &mut command) {
        Ok(text) => report.kernels = read_timings(&text)?,
        Err(error) => {
            tell(&error);
            let how = "python3 with venv, gcc, bc, and a network for `pip install fenics-ffcx==0.11.0`";
            report.missing.push(("FFCx 0.11".to_owned(), how.to_owned()));
        }
    }
    Ok(())
}

/// Lists FFCx's kernels with sum factorisation as variants of the form that they compute, so that each form has one row.
fn count_once(forms: &mut BTreeMap<String, BTreeMap<String, serde_json::Value>>) {
    let factorised: Vec<String> =
        forms.keys().filter(|form| form.ends_with(SUM_FACTORISED)).cloned().collect();
    for name in factorised {
        let form = name.trim_end_matches(SUM_FACTORISED);
        if !forms.contains_key(form) {
            continue;
        }
        let variants = forms.remove(&name).unwrap_or_default();
        if let Some(all) = forms.get_mut(form) {
            let peers = variants.into_iter().filter(|(variant, _)| variant != OURS && variant != "flops");
            all.extend(peers.map(|(variant, value)| (format!("sumfact_{variant}"), value)));
        }
    }
}

/// Reads what the harness prints, in the basket's order. A form that FFCx computes in two ways has one row.
///
/// # Errors
/// [`ComparisonError::Output`].
pub fn read_timings(text: &str) -> Result<Vec<KernelRow>, ComparisonError> {
    let bad = |reason: String| ComparisonError::Output { program: "run_ffcx_kernels.sh".to_owned(), reason };
    let mut forms: BTreeMap<String, BTreeMap<String, serde_json::Value>> =
        serde_json::from_str(text).map_err(|error| bad(error.to_string()))?;
    count_once(&mut forms);
    let mut rows = Vec::new();
    for (form, mut entries) in forms {
        entries.remove("flops");
        let mut variants = BTreeMap::new();
        for (name, value) in entries {
            let timing: Timing = serde_json::from_value(value).map_err(|error| bad(error.to_string()))?;
            variants.insert(name, timing);
        }
        let ours = variants.remove(OURS);
        let fastest = variants.iter().min_by(|(_, a), (_, b)| a.ns.total_cmp(&b.ns));
        let Some((name, best)) = fastest.map(|(name, best)| (name.clone(), best.clone())) else {
            return Err(bad(format!("{form} has no variant")));
        };
        rows.push(KernelRow { form, ours, best: (name, best), variants });
    }
    // In the basket's order, then what it does not have.
    let place = |form: &str| BASKET.iter().position(|entry| entry.name == form).unwrap_or(BASKET.len());
    rows.sort_by_key(|row| place(&row.form));
    Ok(rows)
}
