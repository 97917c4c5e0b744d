//! Golden messages of contact laws that lack what a driver asks for.
//!
//! `TRYBUILD=overwrite cargo test -p forms-contact --test compile_errors` writes the files anew.

#[test]
#[ignore = "a sweep: `FORMS_SWEEPS=1 .ci/run` runs it"]
fn what_a_law_lacks_is_named() {
    trybuild::TestCases::new().compile_fail("tests/compile_errors/*.rs");
}
