//! The optimisation of the crate that is being compiled, as the arguments of rustc tell: macros run inside it.
//!
//! `debug_assertions` and a build script's `OPT_LEVEL` are no such signs: the first is on in profiles with an `opt-level`,
//! the second is that of another crate.

use std::fs;

/// Are kernels compiled with optimisation? Also where nothing is known: outside of rustc, in an editor, and in the examples of
/// documentation, to which no profile applies.
pub fn optimised() -> bool {
    level(std::env::args()).is_none_or(|level| level != "0")
}

/// The last `opt-level` among the arguments, `0` where there is none. `None` for the arguments of another program than rustc
/// as cargo calls it.
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

/// `@path` stands for the lines of a file: long command lines come so.
fn in_file(argument: String) -> Vec<String> {
    match argument.strip_prefix('@').map(fs::read_to_string) {
        Some(Ok(text)) => text.lines().map(str::to_string).collect(),
        _ => vec![argument],
    }
}

#[cfg(test)]
mod tests {
    use super::level;

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
    fn arguments_in_a_file() {
        let path = std::env::temp_dir().join(format!("forms_arguments_{}", std::process::id()));
        std::fs::write(&path, "--crate-name\na\n-C\nopt-level=2\n").expect("it can be written");
        let found = level(["rustc".to_string(), format!("@{}", path.display())].into_iter());
        std::fs::remove_file(&path).expect("it is there");
        assert_eq!(found.as_deref(), Some("2"));
    }
}
