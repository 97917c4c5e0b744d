//! All that the macros read of the program that runs them, which is rustc, rustdoc or an editor: its arguments and its name. No other
//! module reads them.
//!
//! | read | from | for |
//! | --- | --- | --- |
//! | [`optimised`] | the last `opt-level`, after `--crate-name` | the notice that kernels are slow without optimisation |
//! | [`only_checked`] | `--emit` without machine code; `rustdoc`, `rust-analyzer` as the program | kernels are left out |
//! | [`in_editor`] | `rust-analyzer` as the program | bodies are written once more, for the names in them |
//!
//! What is emitted has the same names, types and errors in all cases. `debug_assertions` and a build script's `OPT_LEVEL` do not say
//! how kernels are compiled: the first is on in profiles with an `opt-level`, the second is that of another crate.

use std::fs;
use std::path::Path;

/// Are kernels compiled with optimisation? Also where nothing is known: outside of rustc, in an editor, and in the examples of
/// documentation, to which no profile applies.
pub fn optimised() -> bool {
    level(std::env::args()).is_none_or(|level| level != "0")
}

/// Is no machine code made of the crate: by `cargo check`, clippy, rustdoc or an editor? Kernels, which are most of what a
/// macro writes, are left out there.
pub fn only_checked() -> bool {
    emits_no_code(std::env::args())
}

/// Does an editor expand the macro, and no compiler? Then names are written in addition to what [`only_checked`] leaves.
pub fn in_editor() -> bool {
    let program = std::env::current_exe().unwrap_or_default();
    program.file_stem().is_some_and(|name| name.to_string_lossy().starts_with("rust-analyzer"))
}

/// Of the arguments of rustc, and of those of rustdoc and rust-analyzer, which have none of these.
fn emits_no_code(arguments: impl Iterator<Item = String>) -> bool {
    let arguments: Vec<String> = arguments.flat_map(in_file).collect();
    let program = arguments.first().map(|path| Path::new(path).file_stem().unwrap_or_default());
    if program.is_some_and(|name| name == "rustdoc" || name.to_string_lossy().starts_with("rust-analyzer")) {
        return true;
    }
    let emitted = arguments.iter().enumerate().filter_map(|(index, argument)| match argument.as_str() {
        "--emit" => arguments.get(index + 1).map(String::as_str),
        other => other.strip_prefix("--emit="),
    });
    let mut kinds = emitted.flat_map(|list| list.split(',')).peekable();
    // `metadata=path` says where.
    let is_code = |kind: &str| !matches!(kind.split('=').next(), Some("metadata" | "dep-info"));
    kinds.peek().is_some() && !kinds.any(is_code)
}

/// The last `opt-level` among the arguments, `0` where there is none. `None` if the program is not rustc, called by cargo.
fn level(arguments: impl Iterator<Item = String>) -> Option<String> {
    let arguments: Vec<String> = arguments.flat_map(in_file).collect();
    let name = arguments.iter().position(|argument| argument == "--crate-name")?;
    if arguments.get(name + 1)?.starts_with("doctest_") {
        return None;
    }
    let mut level = "0".to_string();
    for (index, argument) in arguments.iter().enumerate() {
        let option = match argument.as_str() {
            "-C" | "--codegen" => arguments.get(index + 1).map(String::as_str),
            "-O" => Some("opt-level=3"),
            other => other.strip_prefix("-C").or_else(|| other.strip_prefix("--codegen=")),
        };
        if let Some(value) = option.and_then(|option| option.strip_prefix("opt-level=")) {
            level = value.to_string();
        }
    }
    Some(level)
}

/// `@path` means the lines of a file: long command lines come so.
fn in_file(argument: String) -> Vec<String> {
    match argument.strip_prefix('@').map(fs::read_to_string) {
        Some(Ok(text)) => text.lines().map(str::to_string).collect(),
        _ => vec![argument],
    }
}

#[cfg(test)]
mod tests {
    use super::{emits_no_code, in_editor, level};

    fn of(arguments: &str) -> Option<String> {
        level(arguments.split(' ').map(str::to_string))
    }

    #[test]
    fn levels_of_command_lines() {
        assert_eq!(of("rustc --crate-name a src/main.rs -C debuginfo=2").as_deref(), Some("0"));
        assert_eq!(of("rustc --crate-name a src/main.rs -C opt-level=1").as_deref(), Some("1"));
        assert_eq!(of("rustc --crate-name a -Copt-level=s").as_deref(), Some("s"));
        assert_eq!(of("rustc --crate-name a --codegen opt-level=2 -C lto=off").as_deref(), Some("2"));
        assert_eq!(of("rustc --crate-name a --codegen=opt-level=2").as_deref(), Some("2"));
        assert_eq!(of("rustc --crate-name a -O").as_deref(), Some("3"));
        // The profile's level, then RUSTFLAGS.
        assert_eq!(of("rustc --crate-name a -C opt-level=3 -C opt-level=0").as_deref(), Some("0"));
        assert_eq!(of("rust-analyzer-proc-macro-srv"), None);
        assert_eq!(of("rustc --crate-type bin -o rust_out -"), None);
        assert_eq!(of("rustc --crate-name=doctest_bundle_2024 --crate-type lib"), None);
    }

    #[test]
    fn checks_make_no_code() {
        let no_code = |arguments: &str| emits_no_code(arguments.split(' ').map(str::to_string));
        assert!(no_code("rustc --crate-name a --emit=dep-info,metadata -C opt-level=1"));
        assert!(no_code("clippy-driver /bin/rustc --crate-name a --emit dep-info,metadata=a.rmeta"));
        assert!(no_code("/bin/rustdoc --crate-name a src/lib.rs -o doc"));
        assert!(no_code("/bin/rust-analyzer-proc-macro-srv"));
        assert!(!no_code("rustc --crate-name a --emit=dep-info,metadata,link"));
        assert!(!no_code("rustc --crate-name a --emit=metadata --emit=llvm-ir=a.ll"));
        assert!(!no_code("rustc --crate-name a src/main.rs"));
        assert!(!no_code("forms_compiler-0123 proof"));
        assert!(!in_editor());
    }

    #[test]
    fn arguments_in_a_file() {
        let path = std::env::temp_dir().join(format!("forms_arguments_{}", std::process::id()));
        std::fs::write(&path, "--crate-name\na\n-C\nopt-level=2\n").expect("it can be written");
        let found = level(["rustc".to_string(), format!("@{}", path.display())].into_iter());
        std::fs::remove_file(&path).expect("it is there");
        assert_eq!(found.as_deref(), Some("2"));
    }
}
