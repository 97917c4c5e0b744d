//! Names and lints of what is emitted.

use proc_macro2::TokenStream;
use quote::quote;

/// Lints that emitted modules are free of.
pub fn allow() -> TokenStream {
    quote! {
        #[allow(missing_docs, dead_code, unused_variables, non_snake_case, non_camel_case_types, uncommon_codepoints, mixed_script_confusables)]
        #[allow(clippy::all)]
    }
}
