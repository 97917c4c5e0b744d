//! What must hold of the attribute for any tokens whatever. The fuzz target includes this file.

use proc_macro2::TokenStream;

/// Compiles tokens: no panic, and what comes out is Rust. Tokens that are no module are an error.
pub fn survives(tokens: TokenStream) {
    let attribute: TokenStream = "dimension = 2".parse().expect("tokens");
    let output = forms_compiler::forms(attribute, tokens);
    let text = output.to_string();
    // Not at the head of a file, where `#![..]` would be the file's.
    let mut file: TokenStream = "struct Before;".parse().expect("tokens");
    file.extend(output);
    assert!(syn::parse2::<syn::File>(file).is_ok(), "the output is not Rust: {text}");
    assert!(text.contains("mod ") || text.contains("compile_error"), "nothing came out");
}
