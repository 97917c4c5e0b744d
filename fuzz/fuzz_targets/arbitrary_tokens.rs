//! `cargo +nightly fuzz run arbitrary_tokens`: any text that lexes goes through the attribute.
#![no_main]

#[path = "../../forms-macro/compiler/tests/arbitrary_tokens/harness.rs"]
mod harness;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(tokens) = text.parse::<proc_macro2::TokenStream>() {
        harness::survives("dimension = 2", tokens);
    }
});
