//! Mistakes found in a module: collected, deduplicated, and turned into compiler errors on their tokens.

use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};
use quote::ToTokens;

/// A contiguous run of source tokens: the span of the first and of the last.
#[derive(Clone, Copy, Debug)]
pub struct SourceSpan {
    start: Span,
    end: Span,
    /// The imported function that is called here, if the contents came from its body: an index, counted from one.
    origin: usize,
}

impl SourceSpan {
    /// The span of some tokens.
    pub fn of(tokens: &impl ToTokens) -> Self {
        let mut tokens = tokens.to_token_stream().into_iter();
        let start = tokens.next().map_or_else(Span::call_site, |token| token.span());
        let end = tokens.last().map_or(start, |token| token.span());
        SourceSpan { start, end, origin: 0 }
    }
}

/// One mistake.
#[derive(Debug)]
struct Diagnostic {
    span: SourceSpan,
    message: String,
}

/// All mistakes of a module.
#[derive(Debug, Default)]
pub struct Diagnostics {
    found: Vec<Diagnostic>,
    /// Number found in earlier dimensions.
    settled: usize,
    /// Number of reports of mistakes, the same one again included.
    reports: usize,
    /// The imported functions that have mistakes inside: each with its file and line.
    origins: Vec<String>,
    /// The imported function that is being read, if any.
    inside: Option<Inside>,
}

/// The place at which mistakes inside an imported function are reported: its own tokens are in another module.
#[derive(Clone, Copy, Debug)]
struct Inside {
    /// The call.
    span: SourceSpan,
    /// Consequences of a reported mistake are not reported.
    silent: bool,
}

impl Diagnostics {
    /// Records a mistake; the same message on the same tokens is recorded once (a function is checked
    /// in each dimension and at each call).
    pub fn error(&mut self, span: SourceSpan, message: impl Into<String>) {
        self.reports += 1;
        let mut message = message.into();
        let span = match self.inside {
            Some(Inside { silent: true, .. }) => return,
            Some(Inside { span, .. }) => span,
            None => span,
        };
        if let Some(origin) = span.origin.checked_sub(1).and_then(|index| self.origins.get(index)) {
            message = format!("{message}\nnote: inside the imported function {origin}");
        }
        let same_span = |other: &Diagnostic| format!("{:?}", other.span) == format!("{span:?}");
        let told = |(index, other): (usize, &Diagnostic)| {
            same_span(other) && (index < self.settled || other.message == message)
        };
        if !self.found.iter().enumerate().any(told) {
            self.found.push(Diagnostic { span, message });
        }
    }

    /// Grows with every report: a function for which it has grown is mistaken.
    pub fn reports(&self) -> usize {
        self.reports
    }

    /// Are we inside an imported function?
    pub fn is_inside(&self) -> bool {
        self.inside.is_some()
    }

    /// From here on mistakes belong to an imported function, and are reported at its call. Gives the span for its nodes.
    pub fn enter(&mut self, call: SourceSpan, origin: &str, silent: bool) -> SourceSpan {
        let known = self.origins.iter().position(|known| known == origin);
        let index = known.unwrap_or_else(|| {
            self.origins.push(origin.into());
            self.origins.len() - 1
        });
        let span = SourceSpan { origin: index + 1, ..call };
        self.inside = Some(Inside { span, silent });
        span
    }

    /// The imported function ends.
    pub fn leave(&mut self) {
        self.inside = None;
    }

    /// Was a mistake found?
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// The next dimension begins: what it says of a span that has a mistake already is the same mistake
    /// in other words ("a vector of length 3", "a vector").
    pub fn next_dimension(&mut self) {
        self.settled = self.found.len();
    }

    /// Records a mistake with advice on how to mend it.
    pub fn error_with_help(&mut self, span: SourceSpan, message: impl Into<String>, help: impl AsRef<str>) {
        self.error(span, format!("{}\nhelp: {}", message.into(), help.as_ref()));
    }

    /// One `compile_error!` per mistake.
    pub fn into_tokens(self) -> TokenStream {
        self.found.iter().map(compile_error).collect()
    }
}

/// `::core::compile_error! { "message" }`, whose first and last tokens carry the span.
fn compile_error(diagnostic: &Diagnostic) -> TokenStream {
    let SourceSpan { start, end, .. } = diagnostic.span;
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
