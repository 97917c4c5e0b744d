//! An import and the text that came for it → the functions that it needs, added to the importing module.

use proc_macro2::{Delimiter, Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Item, ItemFn, ItemMod, Visibility};

use super::names::{Asked, Import, Imported};
use super::payload::{Payload, origin_of, rename_calls};
use super::{inclusion, needs};
use crate::check::builtins::nearest;
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::syntax::{Foreign, Mistaken, Module};
use crate::parse::{raw, read_function};
use crate::sorted::SortedMap;

/// An import with what came for it.
pub struct Arrived {
    import: Import,
    payload: Payload,
}

/// Reads the texts that came. `None`, after a report, for what is no forms module's.
pub fn read(imports: Vec<Import>, received: &[String], diagnostics: &mut Diagnostics) -> Vec<Arrived> {
    let mut arrived = Vec::new();
    for (import, text) in imports.into_iter().zip(received) {
        match Payload::read(text, import.name.span()) {
            Some(payload) => arrived.push(Arrived { import, payload }),
            None => diagnostics.error(
                SourceSpan::of(&import.name),
                format!("`{}` does not come from a forms module", import.name),
            ),
        }
    }
    arrived
}

/// Adds the imported data struct and regions to the module's own, marked by `#[imported(path)]`, and the members of included data to those of the
/// data struct.
pub fn add_declarations(item: &mut ItemMod, arrived: &mut Vec<Arrived>, diagnostics: &mut Diagnostics) {
    let Some((_, items)) = &mut item.content else { return };
    // Those of a module are in the order in which it declares them, whatever that of the imports.
    let mut modules: Vec<String> = Vec::new();
    let mut declarations = Vec::new();
    arrived.retain(|Arrived { import, payload }| {
        match import.asked {
            Asked::Item => {}
            Asked::Members => {
                inclusion::add(items, import, payload, diagnostics);
                return false;
            }
        }
        let found = payload.items().enumerate().find_map(|(place, item)| match item {
            Item::Struct(item) if item.ident == import.name => Some((place, item)),
            _ => None,
        });
        let Some((place, found)) = found else { return true };
        let mut declaration = found.clone();
        let path = &import.path;
        declaration.ident = import.local.clone();
        declaration.vis = import.visibility.clone();
        declaration.attrs.push(syn::parse_quote! { #[imported(#path)] });
        for field in &mut declaration.fields {
            // The setters of the struct that is imported know them.
            field.attrs.retain(|attribute| !attribute.path().is_ident("default"));
        }
        let module = modules.iter().position(|identity| *identity == payload.identity);
        let module = module.unwrap_or_else(|| {
            modules.push(payload.identity.clone());
            modules.len() - 1
        });
        declarations.push((module, place, Item::Struct(declaration)));
        false
    });
    declarations.sort_by_key(|(module, place, _)| (*module, *place));
    items.extend(declarations.into_iter().map(|(_, _, declaration)| declaration));
}

/// Adds the imported functions to the module that `item` was read to; what is wrong is reported on the import's name.
pub fn add_functions(
    arrived: Vec<Arrived>,
    item: &ItemMod,
    module: &mut Module,
    diagnostics: &mut Diagnostics,
) -> Vec<Imported> {
    let mut found: Vec<Imported> = Vec::new();
    for Arrived { import, payload } in arrived {
        let Some(key) = find(&import, &payload, diagnostics) else {
            module.mistaken.push(Mistaken::Import(import.local));
            continue;
        };
        let functions = closure(&key, &payload);
        let canonical = canonical_name(&key, &payload);
        if found.iter().any(|one| one.local == import.local && one.canonical == canonical) {
            continue;
        }
        let complete = needs::check(&import, &payload, &functions, item, diagnostics);
        let silent = payload.broken || !complete;
        let Import { local, visibility, .. } = import;
        found.push(Imported { local, visibility, canonical, functions, silent });
    }
    for (item, foreign) in written_here(&found) {
        // What is wrong in its declaration was reported in its place.
        if let Some(mut function) = read_function(item, &mut Diagnostics::default()) {
            function.attributes.retain(|attribute| attribute.path().is_ident("doc"));
            function.foreign = Some(foreign);
            module.functions.push(function);
        }
    }
    found
}

/// The imported functions as they would be in the importing module: those that were asked for under their local names,
/// the others, each once, under their canonical ones.
pub fn written_here(found: &[Imported]) -> Vec<(ItemFn, Foreign)> {
    let mut locals = SortedMap::new();
    for one in found {
        locals.get_or_insert_with(one.canonical.clone(), || one.local.to_string());
    }
    let here = |function: &ItemFn| {
        let mut function = function.clone();
        if let Ok(block) = syn::parse2(rename_calls(function.block.to_token_stream(), &locals)) {
            *function.block = block;
        }
        function
    };
    let foreign = |function: &ItemFn, emitted: bool, silent: bool| {
        let origin = origin_of(&function.attrs).unwrap_or_default();
        Foreign { origin, emitted, silent }
    };
    let mut written = SortedMap::new();
    let mut named = Vec::new();
    for one in found {
        for (name, function) in &one.functions {
            if *name == one.canonical {
                let mut function = here(function);
                function.sig.ident = one.local.clone();
                function.vis = one.visibility.clone();
                let emitted = !matches!(one.visibility, Visibility::Inherited);
                let foreign = foreign(&function, emitted, one.silent);
                named.push((function, foreign));
            } else if !locals.contains_key(name) && !written.contains_key(name) {
                let function = with_sign(&here(function));
                let foreign = foreign(&function, false, one.silent);
                written.insert(name.clone(), (function, foreign));
            }
        }
    }
    written.into_values().chain(named).collect()
}

/// The function with its sign in formulas, which must not be its canonical name.
fn with_sign(function: &ItemFn) -> ItemFn {
    let mut function = function.clone();
    let is_sign = |doc: &syn::Attribute| doc.path().is_ident("doc") && matches!(doc.meta, syn::Meta::List(_));
    if !function.attrs.iter().any(is_sign) {
        let name = function.sig.ident.to_string();
        let name = name.rsplit_once("__").map_or(name.as_str(), |(name, _)| name);
        function.attrs.push(syn::parse_quote! { #[doc(alias = #name)] });
    }
    function
}

/// The path of an imported declaration, from its `#[imported(path)]`.
pub fn imported_path(attributes: &[syn::Attribute]) -> Option<&proc_macro2::TokenStream> {
    let found = attributes.iter().find(|attribute| attribute.path().is_ident("imported"))?;
    match &found.meta {
        syn::Meta::List(list) => Some(&list.tokens),
        _ => None,
    }
}

/// The name in the payload of the function that is asked for.
fn find(import: &Import, payload: &Payload, diagnostics: &mut Diagnostics) -> Option<String> {
    let (name, module) = (&import.name, &payload.item.ident);
    let span = SourceSpan::of(name);
    for item in payload.items() {
        match item {
            Item::Fn(item) if item.sig.ident == *name => {
                if matches!(item.vis, Visibility::Inherited) {
                    let origin = origin_of(&item.attrs).unwrap_or_default();
                    let message = format!("{origin} is private in the forms module `{module}`");
                    diagnostics.error_with_help(span, message, format!("declare it `pub fn {name}`"));
                    return None;
                }
                return Some(name.to_string());
            }
            Item::Use(item) => {
                if let syn::UseTree::Rename(renamed) = &item.tree
                    && renamed.rename == *name
                {
                    return Some(renamed.ident.to_string());
                }
            }
            _ => {}
        }
    }
    let public: Vec<String> = payload
        .functions()
        .filter(|item| !matches!(item.vis, Visibility::Inherited))
        .map(|item| item.sig.ident.to_string())
        .collect();
    let message = format!("the forms module `{module}` has no function `{name}`");
    match nearest(&name.to_string(), public.iter().map(String::as_str)) {
        Some(near) => diagnostics.error_with_help(span, message, format!("did you mean `{near}`?")),
        None => diagnostics.error_with_help(span, message, format!("it has `{}`", public.join("`, `"))),
    }
    None
}

/// The function named `key` and all that it calls, under their canonical names.
fn closure(key: &str, payload: &Payload) -> SortedMap<String, ItemFn> {
    let names: SortedMap<String, String> = payload
        .functions()
        .map(|item| item.sig.ident.to_string())
        .map(|name| (name.clone(), canonical_name(&name, payload)))
        .collect();
    let mut found = SortedMap::new();
    let mut pending = vec![key.to_string()];
    while let Some(name) = pending.pop() {
        let canonical = canonical_name(&name, payload);
        let Some(item) = payload.functions().find(|item| item.sig.ident == name) else { continue };
        if found.contains_key(&canonical) {
            continue;
        }
        let body = item.block.to_token_stream();
        calls(body.clone(), &mut |called| {
            if names.contains_key(called) {
                pending.push(called.to_string());
            }
        });
        let mut item = item.clone();
        item.vis = Visibility::Inherited;
        item.sig.ident = raw::name(&canonical, item.sig.ident.span());
        if let Ok(block) = syn::parse2(rename_calls(body, &names)) {
            *item.block = block;
        }
        found.insert(canonical, item);
    }
    found
}

/// `stress__a1b2c3d4`; what the other module itself imported has such a name already.
fn canonical_name(name: &str, payload: &Payload) -> String {
    // What the module declared itself names itself as its origin.
    let own = payload.functions().any(|item| {
        item.sig.ident == name
            && origin_of(&item.attrs).is_some_and(|origin| origin.starts_with(&format!("`{name}`")))
    });
    // `r#type` has a name that is no keyword.
    let plain = name.strip_prefix("r#").unwrap_or(name);
    if own { format!("{plain}__{}", payload.identity) } else { name.to_string() }
}

/// Tells `visit` each name before parentheses.
fn calls(tokens: TokenStream, visit: &mut impl FnMut(&str)) {
    let mut before: Option<Ident> = None;
    for token in tokens {
        match token {
            TokenTree::Ident(name) => before = Some(name),
            TokenTree::Group(group) => {
                if let (Some(name), Delimiter::Parenthesis) = (before.take(), group.delimiter()) {
                    visit(&name.to_string());
                }
                calls(group.stream(), visit);
            }
            _ => before = None,
        }
    }
}
