//! Functions written in Rust, as kernels call them: a type per function and dimension that takes flattened
//! arguments apart. The user's own declaration carries the places of mistakes that rustc finds in it.

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use quote::{format_ident, quote, quote_spanned};

use crate::parse::syntax::{External, MemberKind, Module};

/// Names in emitted code of things outside the module.
pub struct ExternalNames {
    /// The type of each function in this dimension.
    pub functions: Vec<Ident>,
    /// By data member: its index among the tables.
    pub tables: Vec<usize>,
}

impl ExternalNames {
    pub fn new(module: &Module, dimension: usize) -> Self {
        let mut next = 0;
        let tables = module.members().map(|member| {
            let index = next;
            next += usize::from(member.kind == MemberKind::Table);
            index
        });
        let tables = tables.collect();
        let functions = module.externals.iter().map(|external| type_name(external, dimension)).collect();
        ExternalNames { functions, tables }
    }
}

fn type_name(external: &External, dimension: usize) -> Ident {
    format_ident!("__external_{}_{dimension}", external.name, span = Span::call_site())
}

/// The types of a function, one per dimension.
pub fn emit_external(external: &External, dimensions: &[usize]) -> TokenStream {
    dimensions.iter().map(|dimension| in_dimension(external, *dimension)).collect()
}

fn in_dimension(external: &External, dimension: usize) -> TokenStream {
    let name = type_name(external, dimension);
    let mut start = 0;
    let mut arguments = Vec::new();
    for argument in &external.arguments {
        let shape = argument.rank.shape(dimension);
        let value = nested(&shape, &mut start);
        // Mistakes in an argument's type are at the argument.
        arguments.push(at(argument.name.span(), value));
    }
    let shape = external.output.shape(dimension);
    let ty = shape.iter().rev().fold(quote! { R }, |entry, extent| quote! { [#entry; #extent] });
    let entries = (0..shape.iter().product::<usize>()).map(|entry| {
        let (indices, _) = shape.iter().rev().fold((quote! {}, entry), |(text, rest), extent| {
            let index = rest % extent;
            (quote! { [#index] #text }, rest / extent)
        });
        quote! { outputs[#entry] = value #indices; }
    });
    let path = &external.path;
    let ty = at(external.output_span, ty);
    let span = external.name.span();
    let mut call = Group::new(Delimiter::Parenthesis, quote_spanned! { span => #(#arguments),* });
    call.set_span(span);
    quote! {
        pub enum #name {}
        impl contract::External for #name {
            fn evaluate<R: contract::Real>(inputs: &[R], outputs: &mut [R]) {
                let value: #ty = #path #call;
                #(#entries)*
            }
        }
    }
}

/// `[[inputs[0], inputs[1]], ..]`, from the next input on.
fn nested(shape: &[usize], next: &mut usize) -> TokenStream {
    let Some((extent, rest)) = shape.split_first() else {
        let index = *next;
        *next += 1;
        return quote! { inputs[#index] };
    };
    let entries: Vec<_> = (0..*extent).map(|_| nested(rest, next)).collect();
    quote! { [#(#entries),*] }
}

/// The same tokens at another place.
fn at(span: Span, tokens: TokenStream) -> TokenStream {
    let moved = tokens.into_iter().map(|token| match token {
        TokenTree::Group(group) => {
            let mut moved = Group::new(group.delimiter(), at(span, group.stream()));
            moved.set_span(span);
            TokenTree::Group(moved)
        }
        mut other => {
            other.set_span(span);
            other
        }
    });
    moved.collect()
}
