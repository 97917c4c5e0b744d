//! For tests that read forms from source files: a module with its imports written out, as text.

use quote::quote;
use syn::{Item, ItemMod};

use super::import::{Arrived, add_declarations, add_functions, read, written_here};
use super::payload::write;
use super::uses;
use crate::diagnostics::Diagnostics;
use crate::parse::inclusion::{is_first, of_member};
use crate::parse::parse;

/// The forms of the paper, with what they import from the library of operators.
pub fn nitsche() -> String {
    flatten(
        include_str!("../../../../contact/problem/src/nitsche.rs"),
        "nitsche",
        &[
            include_str!("../../../../contact/problem/src/operators/materials.rs"),
            include_str!("../../../../contact/problem/src/operators/parameters.rs"),
            include_str!("../../../../contact/problem/src/operators/interfaces.rs"),
            include_str!("../../../../contact/problem/src/operators/work.rs"),
        ],
    )
}

/// The forms module `name` of `file`, whose imports come from the modules of `library`, files whose modules import from
/// earlier ones only. The last segment but one of an import's path says from which.
fn flatten(file: &str, name: &str, library: &[&str]) -> String {
    let mut texts: Vec<(String, String)> = Vec::new();
    for mut item in library.iter().flat_map(|file| modules(file)) {
        let mut arrived = arrive(&item, &texts);
        add_declarations(&mut item, &mut arrived, &mut Diagnostics::default());
        let mut module = parse(item.clone(), &mut Diagnostics::default());
        let imported = add_functions(arrived, &item, &mut module, &mut Diagnostics::default());
        texts.push((item.ident.to_string(), write(&item, &imported, false).text));
    }
    let item = modules(file).into_iter().find(|item| item.ident == name);
    let mut item = item.unwrap_or_else(|| panic!("no module `{name}`"));
    let mut arrived = arrive(&item, &texts);
    let mut diagnostics = Diagnostics::default();
    add_declarations(&mut item, &mut arrived, &mut diagnostics);
    let mut module = parse(item.clone(), &mut diagnostics);
    let imported = add_functions(arrived, &item, &mut module, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    if let Some((_, items)) = &mut item.content {
        items.retain(|item| !matches!(item, Item::Use(_)));
        for item in items.iter_mut() {
            if let Item::Struct(item) = item {
                item.attrs.retain(|attribute| !is_first(attribute) && !attribute.path().is_ident("imported"));
                for field in &mut item.fields {
                    field.attrs = of_member(std::mem::take(&mut field.attrs));
                }
            }
        }
        items.extend(written_here(&imported).into_iter().map(|(mut function, _)| {
            function.attrs.retain(|attribute| attribute.path().is_ident("doc"));
            Item::Fn(function)
        }));
    }
    item.attrs.clear();
    quote! { #item }.to_string()
}

fn modules(file: &str) -> Vec<ItemMod> {
    let file = syn::parse_file(file).unwrap_or_else(|error| panic!("{error}"));
    let modules = file.items.into_iter().filter_map(|item| match item {
        Item::Mod(item) => Some(item),
        _ => None,
    });
    modules.collect()
}

/// The imports of a module with the texts that they ask for.
fn arrive(item: &ItemMod, texts: &[(String, String)]) -> Vec<Arrived> {
    let mut diagnostics = Diagnostics::default();
    let imports = uses::read(item.content.iter().flat_map(|(_, items)| items), &mut diagnostics);
    let text = |path: String| {
        let from = path.replace(' ', "").rsplit("::").nth(1).unwrap_or_default().to_string();
        let found = texts.iter().find(|(name, _)| *name == from);
        found.map(|(_, text)| text.clone()).unwrap_or_else(|| panic!("no module for {path}"))
    };
    let received: Vec<String> = imports.iter().map(|import| text(import.path.to_string())).collect();
    read(imports, &received, &mut diagnostics)
}

/// Included members are the module's own, with their defaults; what it declares itself wins.
#[test]
fn included_members_are_own_members() {
    let library = "mod a { struct Data { /// λ\n lambda: Param, gap: Given<Scalar> } fn law(s: Scalar) -> Scalar { lambda * s } }
        mod b { #[includes(super::a::Data)] struct Data { #[default(1)] share: Param, mu: Param }
            pub fn both(s: Scalar) -> Scalar { lambda * share * s } }";
    let text = flatten(
        "mod c { use super::b::both;
            #[includes(super::b::Data, super::a::Data)] struct Data { load: Param, mu: Given<Scalar> }
            #[cells] struct Omega;
            pub fn work(u: State<Scalar>) -> Functional { integral(Omega, load * mu * both(u)) } }",
        "c",
        &[library],
    );
    let item: ItemMod = syn::parse_str(&text).expect("a module");
    let mut diagnostics = Diagnostics::default();
    let module = parse(item, &mut diagnostics);
    let members: Vec<_> = module.members().map(|member| (member.name.to_string(), member.default)).collect();
    let expected = [("lambda", None), ("gap", None), ("share", Some(1.0)), ("load", None), ("mu", None)];
    assert_eq!(members, expected.map(|(name, default)| (name.to_string(), default)));
    crate::check::check(&module, 2, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
}

/// Members of included data, and of those that they include, are as if they were declared in the module.
#[test]
fn what_included_data_include_is_written_out() {
    let library = "mod a { struct Data { /// λ\n lambda: Param } fn law(s: Scalar) -> Scalar { lambda * s } }
        mod b { #[includes(super::a::Data)] struct Data { #[default(1)] gap: Given<Scalar> }
            #[facets] struct Wall; pub fn both(s: Scalar) -> Scalar { lambda * gap * s } }";
    let text = flatten(
        "mod c { use super::b::{Wall, both};
            #[includes(super::b::Data)] struct Data { load: Param }
            pub fn work(u: State<Scalar>) -> Functional { integral(Wall, load * both(u)) } }",
        "c",
        &[library],
    );
    let item: ItemMod = syn::parse_str(&text).expect("a module");
    let mut diagnostics = Diagnostics::default();
    let module = parse(item, &mut diagnostics);
    let names: Vec<String> = module.members().map(|member| member.name.to_string()).collect();
    assert_eq!(names, ["lambda", "gap", "load"]);
    assert_eq!(module.regions.len(), 1);
    crate::check::check(&module, 2, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
}
