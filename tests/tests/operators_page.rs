//! `docs/operators.md` names everything that the language has built in, and the reference has an example of it.

/// The names in the tables of the compiler: `("dot", Builtin::Dot, …)`, `("h", Constant::…)`.
fn built_in_names() -> Vec<&'static str> {
    let source = include_str!("../../forms-macro/compiler/src/check/builtins.rs");
    let entry = |line: &'static str| {
        let name = line.trim().strip_prefix("(\"")?.split('"').next()?;
        (line.contains("Builtin::") || line.contains("Constant::")).then_some(name)
    };
    source.lines().filter_map(entry).collect()
}

/// Is the name a word of some code on the page?
fn names(page: &str, name: &str) -> bool {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    // Every second piece is between backticks.
    page.split('`').skip(1).step_by(2).any(|code| code.split(|c| !word(c)).any(|found| found == name))
}

#[test]
fn every_built_in_name_is_on_the_page() {
    let all = built_in_names();
    assert!(all.len() > 40 && all.contains(&"dot") && all.contains(&"facet_area"), "{all:?}");
    let page = include_str!("../../docs/operators.md");
    // Our own column only: a name of UFL or GWFL does not count.
    let ours: String = page.lines().filter_map(|line| line.split('|').nth(1)).collect();
    let missing: Vec<_> = all.into_iter().filter(|name| !names(&ours, name)).collect();
    assert!(missing.is_empty(), "not in docs/operators.md: {missing:?}");
}

/// The examples of the language reference, whose doctests run: the code between the fences of its pages.
fn examples() -> String {
    let pages = [
        include_str!("../../fem/problem/src/language/calculus.rs"),
        include_str!("../../fem/problem/src/language/derivatives.rs"),
        include_str!("../../fem/problem/src/language/facets.rs"),
        include_str!("../../fem/problem/src/language/functions.rs"),
        include_str!("../../fem/problem/src/language/geometry.rs"),
        include_str!("../../fem/problem/src/language/kinks.rs"),
        include_str!("../../fem/problem/src/language/laws.rs"),
        include_str!("../../fem/problem/src/language/products.rs"),
        include_str!("../../fem/problem/src/language/reuse.rs"),
        include_str!("../../fem/problem/src/language/tensors.rs"),
    ];
    pages.map(|page| page.split("```").skip(1).step_by(2).collect::<String>()).concat()
}

#[test]
fn every_built_in_name_has_an_example_in_the_reference() {
    let examples = examples();
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let words: std::collections::BTreeSet<&str> = examples.split(|c| !word(c)).collect();
    let missing: Vec<_> = built_in_names().into_iter().filter(|name| !words.contains(name)).collect();
    assert!(missing.is_empty(), "no example in fem/problem/src/language: {missing:?}");
}
