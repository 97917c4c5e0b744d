//! Golden messages of contact laws that lack what a driver asks for.
//!
//! `FORMS_SWEEPS=1 cargo test -p forms-contact --test compile_errors` compiles the cases, which has the library checked a second
//! time; without it their notes are compared with the library's text. `TRYBUILD=overwrite` writes the files anew.

use std::path::Path;

#[test]
fn what_a_law_lacks_is_named() {
    if std::env::var_os("FORMS_SWEEPS").is_some() {
        trybuild::TestCases::new().compile_fail("tests/compile_errors/*.rs");
        return;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read =
        |path: &Path| std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let library = read(&here.join("problem/src/law.rs")).replace("{{", "{").replace("}}", "}");
    let mut notes = 0;
    for entry in std::fs::read_dir(here.join("tests/compile_errors")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            let golden = read(&path.with_extension("stderr"));
            for note in golden.lines().filter_map(|line| line.trim().strip_prefix("= note: ")) {
                if note.contains("`contact_law!`") {
                    assert!(library.contains(note), "{}: {note}", path.display());
                    notes += 1;
                }
            }
        }
    }
    assert!(notes >= 2, "{notes} notes");
    lists_the_first_laws(
        &here.join("src/laws"),
        &read(&here.join("tests/compile_errors/law_without_an_adjoint.stderr")),
    );
}

/// rustc lists the first eight laws with an adjoint problem, in alphabetical order: the paper's and seven of the library's.
fn lists_the_first_laws(laws: &Path, golden: &str) {
    let files = std::fs::read_dir(laws).unwrap().map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = files
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .filter(|path| {
            let text = std::fs::read_to_string(path).unwrap();
            text.contains("    adjoint: ")
                || text.contains("> WithAdjoint<")
                || text.contains("impl WithAdjoint<")
        })
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let listed: Vec<&str> = golden
        .lines()
        .filter_map(|line| line.trim().trim_start_matches('`').strip_prefix("forms_contact::laws::"))
        .filter_map(|rest| rest.split("::").next())
        .take(7)
        .collect();
    assert_eq!(listed, names[..7], "law_without_an_adjoint.stderr");
}
