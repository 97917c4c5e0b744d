//! Golden messages: one case per kind of mistake in `compile_errors/`. After each module its names are used,
//! and what is in the `.stderr` files shows that no further errors follow.
//!
//! `TRYBUILD=overwrite cargo test -p forms-core --test compile_errors` writes the files anew.

#[test]
fn mistakes_are_told_on_their_tokens() {
    trybuild::TestCases::new().compile_fail("tests/compile_errors/*.rs");
}
