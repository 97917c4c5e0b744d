//! Raw identifiers that are no keywords: `r#u` is `u` to Rust, and so it is here.

use proc_macro2::{Group, Ident, Span, TokenStream, TokenTree};

/// The tokens with plain names wherever a plain name says the same.
pub fn plain(tokens: TokenStream) -> TokenStream {
    // Groups that are made again forget the positions of their brackets.
    match has_raw_names(tokens.clone()) {
        true => replace(tokens),
        false => tokens,
    }
}

/// The name that a text says, `r#type` also.
pub fn name(text: &str, span: Span) -> Ident {
    match text.strip_prefix("r#") {
        Some(word) => Ident::new_raw(word, span),
        None => Ident::new(text, span),
    }
}

fn has_raw_names(tokens: TokenStream) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(name) => name.to_string().starts_with("r#"),
        TokenTree::Group(group) => has_raw_names(group.stream()),
        _ => false,
    })
}

fn replace(tokens: TokenStream) -> TokenStream {
    let change = |token: TokenTree| match token {
        TokenTree::Ident(name) => TokenTree::Ident(plain_name(name)),
        TokenTree::Group(group) => {
            let mut changed = Group::new(group.delimiter(), replace(group.stream()));
            changed.set_span(group.span());
            TokenTree::Group(changed)
        }
        other => other,
    };
    tokens.into_iter().map(change).collect()
}

fn plain_name(name: Ident) -> Ident {
    let text = name.to_string();
    match text.strip_prefix("r#") {
        // A keyword since the edition of 2024, which `syn` takes for a name.
        Some("gen") | None => name,
        Some(word) => match syn::parse_str::<Ident>(word) {
            Ok(_) => Ident::new(word, name.span()),
            Err(_) => name,
        },
    }
}
