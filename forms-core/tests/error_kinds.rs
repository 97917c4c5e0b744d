//! Counts the kinds of compiler errors in the golden files, and looks for messages of the compiler that none of
//! them shows.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Texts of files with an ending, below a folder.
fn texts(folder: &Path, ending: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(texts(&path, ending));
        } else if path.to_string_lossy().ends_with(ending) {
            let text = fs::read_to_string(&path).expect("a text");
            found.push((path.display().to_string(), text));
        }
    }
    found
}

/// A message without what it says of the user's names and numbers.
fn kind(message: &str) -> String {
    let mut kind = String::new();
    for (index, part) in message.split('`').enumerate() {
        kind += if index % 2 == 1 { "`..`" } else { part };
    }
    kind.split_whitespace()
        .map(|word| if word.chars().any(|c| c.is_ascii_digit()) { "#" } else { word })
        .collect::<Vec<_>>()
        .join(" ")
}

fn golden() -> Vec<(String, String)> {
    texts(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compile_errors"), ".stderr")
}

#[test]
fn there_are_many_kinds_of_errors() {
    let mut kinds: BTreeMap<String, String> = BTreeMap::new();
    for (file, text) in golden() {
        for message in text.lines().filter_map(|line| line.strip_prefix("error: ")) {
            kinds.entry(kind(message)).or_insert_with(|| file.clone());
        }
    }
    let list: Vec<_> = kinds.keys().cloned().collect();
    println!("{} kinds:\n{}", list.len(), list.join("\n"));
    assert!(list.len() >= 30, "{} kinds:\n{}", list.len(), list.join("\n"));
}

/// The string literals of a Rust text that are given as messages.
fn messages(text: &str) -> Vec<String> {
    let calls = [
        "diagnostics.error(",
        "diagnostics.error_with_help(",
        ".error(",
        ".error_with_help(",
        "let message =",
    ];
    let mut found = Vec::new();
    for call in calls {
        for (at, _) in text.match_indices(call) {
            // The first literal after the call, before its statement ends.
            let rest = &text[at + call.len()..];
            let statement = &rest[..rest.find(';').unwrap_or(rest.len())];
            if let Some(start) = statement.find('"') {
                let literal: String = statement[start + 1..].chars().take_while(|c| *c != '"').collect();
                found.push(literal.replace("\\n", "\n"));
            }
        }
    }
    found
}

/// The longest run of words of a message that holds no name or number.
fn fixed_part(message: &str) -> String {
    let mut text = String::new();
    let mut inside = 0;
    for character in message.chars() {
        match character {
            '{' => inside += 1,
            '}' => {
                inside -= 1;
                text.push('\u{0}');
            }
            _ if inside == 0 => text.push(character),
            _ => {}
        }
    }
    let parts = text.split(['\u{0}', '`', '\n']).map(str::trim);
    parts.max_by_key(|part| part.len()).unwrap_or_default().to_string()
}

/// Messages that no golden file shows, each with the reason.
const WITHOUT_CASE: &[(&str, &str)] = &[
    (
        "could not be brought into a form linear in",
        "`check` rules it out: a guard against mistakes of the compiler",
    ),
    ("needs the module's body", "rustc itself refuses an attribute on a module in another file"),
    ("the derivatives of this unfold to more", "a limit of size: its case would compile for long"),
    (
        "unfolds to more than 1.5 million scalar operations",
        "a limit of size: its case would compile for long",
    ),
    (
        "operations stand one inside the other",
        "a limit of depth: its case would be hundreds of functions; the compiler's tests of growth have it",
    ),
    ("does not come from a forms module", "the text of an import comes from another attribute's macro"),
];

#[test]
fn every_message_has_a_case() {
    let compiler = Path::new(env!("CARGO_MANIFEST_DIR")).join("../forms-macro/compiler/src");
    let golden: String = golden().into_iter().map(|(_, text)| text).collect::<Vec<_>>().join("\n");
    let mut missing = BTreeSet::new();
    for (file, text) in texts(&compiler, ".rs") {
        // Tests of the compiler give no messages to users.
        if file.contains("/src/proof/") || file.contains("/src/reference/") {
            continue;
        }
        for message in messages(&text) {
            let part = fixed_part(&message);
            let excused = WITHOUT_CASE.iter().any(|(known, _)| message.contains(known));
            if part.len() >= 8 && !golden.contains(&part) && !excused {
                missing.insert(format!("{part}    ({file})"));
            }
        }
    }
    let missing: Vec<_> = missing.into_iter().collect();
    assert!(missing.is_empty(), "no golden file shows these messages:\n{}", missing.join("\n"));
}
