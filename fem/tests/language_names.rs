//! The documentation's items for the language's names: none is missing, none is too many.

use std::collections::BTreeSet;

/// The words between a prefix and a sign, in the lines that begin with the prefix.
fn words<'a>(text: &'a str, prefix: &str, until: &[char]) -> BTreeSet<&'a str> {
    let rest = text.lines().filter_map(|line| line.trim_start().strip_prefix(prefix));
    rest.filter_map(|rest| rest.split(until).next()).collect()
}

#[test]
fn every_name_of_the_language_has_an_item() {
    let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(here.join(path)).unwrap();
    let compiler = read("../forms-macro/compiler/src/check/builtins.rs");
    let tables = compiler.split("pub fn builtin(").next().unwrap();
    let mut known = words(tables, "(\"", &['"']);
    // On one line with their table.
    known.extend(["gap", "toward"]);
    let items = read("problem/src/language/operators.rs");
    let mut documented = words(&items, "fn ", &['(', '<']);
    documented.extend(words(&items, "const ", &[':']));
    documented.retain(|name| !name.starts_with('$'));
    assert!(known.len() > 70, "{known:?}");
    assert_eq!(documented, known);
}
