//! Mistakes found in a module: collected, deduplicated, and turned into compiler errors on their tokens.

use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};
use quote::ToTokens;

/// A contiguous run of source tokens: the span of the first and of the last.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    start: Span,
    end: Span,
}

impl Place {
    /// The place of some tokens.
    pub fn of(tokens: &impl ToTokens) -> Self {
        let mut tokens = tokens.to_token_stream().into_iter();
        let start = tokens.next().map_or_else(Span::call_site, |token| token.span());
        let end = tokens.last().map_or(start, |token| token.span());
        Place { start, end }
    }
}

/// One mistake.
#[derive(Debug)]
struct Diagnostic {
    place: Place,
    message: String,
}

/// All mistakes of a module.
#[derive(Debug, Default)]
pub struct Diagnostics {
    found: Vec<Diagnostic>,
    /// So many were found in earlier dimensions.
    settled: usize,
}

impl Diagnostics {
    /// Records a mistake; the same message on the same tokens is recorded once (a function is checked
    /// in each dimension and at each call).
    pub fn error(&mut self, place: Place, message: impl Into<String>) {
        let message = message.into();
        let same_place = |other: &Diagnostic| format!("{:?}", other.place) == format!("{place:?}");
        let told = |(index, other): (usize, &Diagnostic)| {
            same_place(other) && (index < self.settled || other.message == message)
        };
        if !self.found.iter().enumerate().any(told) {
            self.found.push(Diagnostic { place, message });
        }
    }

    /// The next dimension begins: what it says of a place that has a mistake already is the same mistake
    /// in other words ("a vector of length 3", "a vector").
    pub fn next_dimension(&mut self) {
        self.settled = self.found.len();
    }

    /// Records a mistake with advice on how to mend it.
    pub fn error_with_help(&mut self, place: Place, message: impl Into<String>, help: impl AsRef<str>) {
        self.error(place, format!("{}\nhelp: {}", message.into(), help.as_ref()));
    }

    /// No mistake was found.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// One `compile_error!` per mistake.
    pub fn into_tokens(self) -> TokenStream {
        self.found.iter().map(compile_error).collect()
    }
}

/// `::core::compile_error! { "message" }`, whose first and last tokens carry the place.
fn compile_error(diagnostic: &Diagnostic) -> TokenStream {
    let Place { start, end } = diagnostic.place;
    let punct = |character, spacing, span| {
        let mut punct = Punct::new(character, spacing);
        punct.set_span(span);
        TokenTree::Punct(punct)
    };
    let mut message = Literal::string(&diagnostic.message);
    message.set_span(end);
    let mut body = Group::new(Delimiter::Brace, TokenTree::Literal(message).into());
    body.set_span(end);
    [
        punct(':', Spacing::Joint, start),
        punct(':', Spacing::Alone, start),
        TokenTree::Ident(Ident::new("core", start)),
        punct(':', Spacing::Joint, start),
        punct(':', Spacing::Alone, start),
        TokenTree::Ident(Ident::new("compile_error", start)),
        punct('!', Spacing::Alone, start),
        TokenTree::Group(body),
    ]
    .into_iter()
    .collect()
}
