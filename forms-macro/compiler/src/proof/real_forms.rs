//! The forms of the paper, as they stand in the repository.

use super::comparison::compare;
use super::source::Source;

/// The body of the attribute's module in a source file.
fn module_of(file: &str) -> String {
    let file = syn::parse_file(file).expect("a Rust file");
    let module = file.items.into_iter().find(|item| matches!(item, syn::Item::Mod(_)));
    let Some(syn::Item::Mod(mut module)) = module else { panic!("no module in this file") };
    module.attrs.clear();
    quote::quote! { #module }.to_string()
}

#[test]
fn the_forms_of_the_paper() {
    let text = module_of(include_str!("../../../../contact/src/nitsche.rs"));
    for dimension in [2, 3] {
        let source = Source::new(dimension, &text);
        let mut compared = 0;
        for seed in 0..4 {
            compared += compare(&source, seed).unwrap_or_else(|difference| panic!("{difference}")).compared;
        }
        assert!(compared > 1000, "{compared} numbers compared");
    }
}
