//! Properties of the attribute for any tokens whatever. The fuzz target includes this file.

use proc_macro2::TokenStream;

/// No output is longer, in characters.
const LONGEST: usize = 20_000_000;

/// Compiles tokens: no panic, and what comes out is Rust of bounded length. Tokens that are no module are an error.
pub fn survives(options: &str, tokens: TokenStream) {
    let attribute: TokenStream = options.parse().expect("tokens");
    let output = forms_compiler::forms(attribute, tokens);
    let text = output.to_string();
    assert!(text.len() <= LONGEST, "{} characters came out", text.len());
    // Not at the head of a file, where `#![..]` would be the file's.
    let mut file: TokenStream = "struct Before;".parse().expect("tokens");
    file.extend(output);
    assert!(syn::parse2::<syn::File>(file).is_ok(), "the output is not Rust: {text}");
    assert!(text.contains("mod ") || text.contains("compile_error"), "nothing came out");
}
