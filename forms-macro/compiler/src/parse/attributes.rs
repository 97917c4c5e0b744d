//! Attributes in a forms module: some go along with what is emitted, some change nothing, and the others are reported.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{AttrStyle, Attribute, Meta};

use super::syntax::{Entity, RegionRule};
use crate::diagnostics::{Diagnostics, SourceSpan};

/// First words of attributes that change nothing about a body: lints, documentation, and what tools read.
const HARMLESS: &[&str] = &["allow", "expect", "warn", "deny", "forbid", "doc", "rustfmt", "clippy"];

/// The attributes of a declaration that go along with it; `#[cfg]` is reported, for one that does not hold would take
/// away a part of what is emitted.
pub fn of_declaration(attributes: Vec<Attribute>, diagnostics: &mut Diagnostics) -> Vec<Attribute> {
    let mut kept = Vec::new();
    for attribute in attributes {
        let conditional = match &attribute.meta {
            Meta::List(list) if attribute.path().is_ident("cfg_attr") => has_cfg(list.tokens.clone()),
            _ => attribute.path().is_ident("cfg"),
        };
        match conditional {
            true => report_cfg(SourceSpan::of(&attribute), diagnostics),
            false => kept.push(outer(attribute)),
        }
    }
    kept
}

/// The attributes that a body or a module has inside its braces, as attributes before it.
pub fn outer(mut attribute: Attribute) -> Attribute {
    attribute.style = AttrStyle::Outer;
    attribute
}

/// Does it say what a region consists of?
pub fn is_marker(attribute: &Attribute) -> bool {
    Entity::MARKERS.iter().any(|(name, _)| attribute.path().is_ident(name))
}

/// The entities of a region and its points; `None` for other attributes.
pub fn marker(attribute: &Attribute, diagnostics: &mut Diagnostics) -> Option<(Entity, RegionRule)> {
    let (name, entity) = Entity::MARKERS.iter().find(|(name, _)| attribute.path().is_ident(name))?;
    let rule = match &attribute.meta {
        Meta::Path(_) => RegionRule::OfBackend,
        Meta::List(list) if *entity == Entity::Facets && list.tokens.to_string() == "vertices" => {
            RegionRule::Vertices
        }
        _ => {
            let [more, help] = match entity {
                Entity::Facets => [" or `vertices`", " or `#[facets(vertices)]`"],
                _ => [""; 2],
            };
            let message = format!("`#[{name}]` takes nothing{more}");
            let help = format!("write `#[{name}]`{help}");
            diagnostics.error_with_help(SourceSpan::of(attribute), message, help);
            RegionRule::OfBackend
        }
    };
    Some((*entity, rule))
}

/// Reports attributes that would change the meaning of a signature, a body or a `use`.
pub fn check_inside(tokens: impl ToTokens, diagnostics: &mut Diagnostics) {
    let tokens: Vec<TokenTree> = tokens.into_token_stream().into_iter().collect();
    for (index, token) in tokens.iter().enumerate() {
        if let TokenTree::Group(group) = token {
            let sign = |back: usize, character: char| {
                let before = index.checked_sub(back).and_then(|place| tokens.get(place));
                matches!(before, Some(TokenTree::Punct(punct)) if punct.as_char() == character)
            };
            let start = match (sign(1, '#'), sign(1, '!') && sign(2, '#')) {
                (true, _) => Some(index - 1),
                (_, true) => Some(index - 2),
                _ => None,
            };
            match start {
                Some(start) if group.delimiter() == Delimiter::Bracket => {
                    let whole: TokenStream = tokens[start..=index].iter().cloned().collect();
                    check_one(group.stream(), SourceSpan::of(&whole), diagnostics);
                }
                _ => check_inside(group.stream(), diagnostics),
            }
        }
    }
}

fn check_one(content: TokenStream, span: SourceSpan, diagnostics: &mut Diagnostics) {
    let word = match content.into_iter().next() {
        Some(TokenTree::Ident(word)) => word.to_string(),
        _ => String::new(),
    };
    match word.as_str() {
        word if HARMLESS.contains(&word) => {}
        "cfg" | "cfg_attr" => report_cfg(span, diagnostics),
        _ => {
            let help = "leave it out: attributes stand before functions, structs and members";
            diagnostics.error_with_help(span, "this attribute has no meaning in a weak form", help);
        }
    }
}

fn report_cfg(span: SourceSpan, diagnostics: &mut Diagnostics) {
    diagnostics.error_with_help(
        span,
        "`#[cfg]` has no meaning inside a forms module: its compiler does not see which case holds",
        "put it before the whole module, and write one module for each case",
    );
}

fn has_cfg(tokens: TokenStream) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(name) => name == "cfg",
        TokenTree::Group(group) => has_cfg(group.stream()),
        _ => false,
    })
}
