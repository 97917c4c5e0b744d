//! `use` declarations of a forms module and `#[includes(..)]` → [`Import`]s.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::{Item, ItemUse, UseTree};

use super::inclusion;
use super::names::{Asked, Import};
use crate::check::builtins::is_built_in;
use crate::diagnostics::{Diagnostics, SourceSpan};

/// The imports of a module in their order, those of its data's members among them. Names of the vocabulary need none, and do no
/// harm.
pub fn read<'a>(items: impl Iterator<Item = &'a Item>, diagnostics: &mut Diagnostics) -> Vec<Import> {
    let mut imports = Vec::new();
    for item in items {
        match item {
            Item::Use(item) => {
                let start = match item.leading_colon {
                    Some(colon) => quote! { #colon },
                    None => TokenStream::new(),
                };
                read_tree(item, &item.tree, start, &mut imports, diagnostics);
            }
            Item::Struct(item) => inclusion::read(item, &mut imports, diagnostics),
            _ => {}
        }
    }
    imports
}

fn read_tree(
    item: &ItemUse,
    tree: &UseTree,
    path: TokenStream,
    imports: &mut Vec<Import>,
    diagnostics: &mut Diagnostics,
) {
    let mut leaf = |name: &Ident, local: &Ident| {
        if name == "self" {
            diagnostics.error_with_help(
                SourceSpan::of(name),
                "a module cannot be imported into a forms module, its functions can",
                "name them: `use path::{stress, strain};`",
            );
        } else if !is_vocabulary(&name.to_string()) {
            imports.push(Import {
                path: quote! { #path #name },
                name: name.clone(),
                local: local.clone(),
                visibility: item.vis.clone(),
                asked: Asked::Item,
            });
        }
    };
    match tree {
        UseTree::Path(step) => {
            let name = &step.ident;
            read_tree(item, &step.tree, quote! { #path #name :: }, imports, diagnostics);
        }
        UseTree::Name(name) => leaf(&name.ident, &name.ident),
        UseTree::Rename(renamed) => leaf(&renamed.ident, &renamed.rename),
        UseTree::Group(group) => {
            for tree in &group.items {
                read_tree(item, tree, path.clone(), imports, diagnostics);
            }
        }
        UseTree::Glob(glob) => diagnostics.error_with_help(
            SourceSpan::of(glob),
            "a forms module cannot import everything: the macro does not see which names there are",
            "name the functions: `use path::{stress, strain};`; the vocabulary itself needs no `use`",
        ),
    }
}

/// Words that a forms module knows by itself.
fn is_vocabulary(name: &str) -> bool {
    const TYPES: &[&str] = &[
        "Scalar",
        "Vector",
        "Tensor",
        "Tensor4",
        "Matrix",
        "Param",
        "Table",
        "History",
        "Given",
        "Carried",
        "Unknown",
        "Test",
        "State",
        "Form",
        "Energy",
        "Functional",
    ];
    TYPES.contains(&name) || is_built_in(name)
}
