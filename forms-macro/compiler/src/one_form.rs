//! `form!(|u: Unknown<Scalar>, v: Test<Scalar>| ..)`: one function without a module. It is turned into a module of one
//! function, which goes the usual way, and an expression that calls its constructor with the data.
//!
//! ```text
//! use path::name;                           imports, any number
//! |arguments| expression                    or |arguments| -> Functional { .. }
//! , name: Param = value                     data; without value, the variable of that name
//! , Name: Cells = "region of the mesh"      regions; or, in place, integral(cells("region of the mesh"), ..)
//! , dimension = 2, crate = path             options
//! ```

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote};
use syn::parse::{Parse, ParseStream};
use syn::{Expr, ExprClosure, ItemMod, ItemUse, Pat, ReturnType, Token, Type};

use crate::check::builtins::is_built_in;
use crate::emit::names::allow;
use crate::parse::declared_type::word;

/// A form without a module.
pub struct OneForm {
    /// The module of one function, `form`.
    pub item: ItemMod,
    /// The options, as of `#[forms(..)]`.
    pub options: TokenStream,
    members: Vec<Entry>,
    regions: Vec<RegionEntry>,
    /// The number of arguments that are neither unknowns nor test functions.
    known_fields: usize,
    /// The type of the value, as the closure says it.
    value: Ident,
}

/// `k: Param = 2.0`
struct Entry {
    name: Ident,
    ty: Type,
    value: Expr,
}

/// `Omega: Cells = "all"`
struct RegionEntry {
    name: Ident,
    marker: &'static str,
    value: TokenStream,
}

/// The words for regions: as a type, as a function in `integral`, as the marker of a declaration.
const REGIONS: &[(&str, &str)] = &[
    ("Cells", "cells"),
    ("Facets", "facets"),
    ("InteriorFacets", "interior_facets"),
    ("Pairs", "pairs"),
    ("Interface", "interface"),
];

impl Parse for OneForm {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let mut uses: Vec<ItemUse> = Vec::new();
        while input.peek(Token![use]) {
            uses.push(input.parse()?);
        }
        if !input.peek(Token![|]) {
            let message = "`form!` takes a closure\nhelp: write `form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(..))`";
            return Err(input.error(message));
        }
        let closure: ExprClosure = input.parse()?;
        let (mut members, mut regions, mut options) = (Vec::new(), Vec::new(), TokenStream::new());
        while !input.is_empty() {
            input.parse::<Token![,]>()?;
            if input.is_empty() {
                break;
            }
            if input.peek(Token![crate]) || input.peek2(Token![=]) {
                let name: TokenTree = input.parse()?;
                let equals: Token![=] = input.parse()?;
                let value: Expr = input.parse()?;
                options.extend(quote! { #name #equals #value, });
                continue;
            }
            let name: Ident = input.parse()?;
            if (name == "matrix_free" || name == "level_set_derivatives") && !input.peek(Token![:]) {
                options.extend(quote! { #name, });
                continue;
            }
            input.parse::<Token![:]>()?;
            let ty: Type = input.parse()?;
            let value: Option<Expr> = match input.parse::<Option<Token![=]>>()? {
                Some(_) => Some(input.parse()?),
                None => None,
            };
            let text = ty.to_token_stream().to_string();
            match (REGIONS.iter().find(|(word, _)| text == *word), value) {
                (Some((_, marker)), Some(value)) => {
                    regions.push(RegionEntry { name, marker, value: value.into_token_stream() });
                }
                (Some(_), None) => {
                    let message = format!(
                        "the region `{name}` has no name in the mesh\nhelp: write `{name}: {text} = \"name in the mesh\"`"
                    );
                    return Err(syn::Error::new(name.span(), message));
                }
                (None, value) => {
                    let value = value.unwrap_or_else(|| syn::parse_quote! { #name });
                    members.push(Entry { name, ty, value });
                }
            }
        }
        let known_fields = closure.inputs.iter().filter(|input| !is_unknown_or_test(input)).count();
        let value = value(&closure.output);
        let item = module(&uses, &closure, &members, &mut regions)?;
        Ok(OneForm { item, options, members, regions, known_fields, value })
    }
}

/// The type of the value of a closure with this output.
fn value(output: &ReturnType) -> Ident {
    let name = match output {
        ReturnType::Type(_, ty) => match word(ty) {
            Some((word, None)) if ["Form", "Energy", "Functional"].iter().any(|name| word == name) => {
                return word.clone();
            }
            _ => "Expression",
        },
        ReturnType::Default => "Form",
    };
    Ident::new(name, Span::call_site())
}

fn is_unknown_or_test(input: &Pat) -> bool {
    match input {
        Pat::Type(typed) => {
            matches!(word(&typed.ty), Some((role, Some(_))) if role == "Unknown" || role == "Test")
        }
        _ => false,
    }
}

/// The module that says the same. Regions named in place join those that were declared.
fn module(
    uses: &[ItemUse],
    closure: &ExprClosure,
    members: &[Entry],
    regions: &mut Vec<RegionEntry>,
) -> syn::Result<ItemMod> {
    let inputs = &closure.inputs;
    if let Some(untyped) = inputs.iter().find(|input| !matches!(input, Pat::Type(_))) {
        let text = untyped.to_token_stream();
        let message =
            format!("the argument `{text}` has no type\nhelp: write `{text}: Unknown<Scalar>` or what it is");
        return Err(syn::Error::new_spanned(untyped, message));
    }
    let body = name_regions(closure.body.to_token_stream(), regions);
    let output = match &closure.output {
        ReturnType::Default => quote! { -> Form },
        output => output.to_token_stream(),
    };
    let data = members.iter().map(|Entry { name, ty, .. }| quote! { pub #name: #ty });
    let data = (!members.is_empty()).then(|| quote! { pub struct Data { #(#data),* } });
    let regions = regions.iter().map(|RegionEntry { name, marker, .. }| {
        let marker = format_ident!("{marker}");
        quote! { #[#marker] pub struct #name; }
    });
    let body = match &*closure.body {
        Expr::Block(_) => body,
        _ => quote! { { #body } },
    };
    syn::parse2(quote! {
        mod __form {
            #(#uses)*
            #data
            #(#regions)*
            pub fn form(#inputs) #output #body
        }
    })
}

/// `integral(cells("all"), ..)` → `integral(CellsAll, ..)`; the region is noted.
fn name_regions(tokens: TokenStream, regions: &mut Vec<RegionEntry>) -> TokenStream {
    let mut out: Vec<TokenTree> = Vec::new();
    for token in tokens {
        let TokenTree::Group(group) = &token else {
            out.push(token);
            continue;
        };
        let mut content: Vec<TokenTree> = group.stream().into_iter().collect();
        let of_integral = matches!(out.last(), Some(TokenTree::Ident(name)) if name == "integral" || name == "means")
            && group.delimiter() == Delimiter::Parenthesis;
        if of_integral
            && let [TokenTree::Ident(kind), TokenTree::Group(argument), ..] = &content[..]
            && let Some((word, marker)) = REGIONS.iter().find(|(_, function)| kind == function)
        {
            let name = region_name(word, &argument.stream(), regions, kind.span());
            if regions.iter().all(|region| region.name != name) {
                regions.push(RegionEntry { name: name.clone(), marker, value: argument.stream() });
            }
            content.splice(..2, [TokenTree::Ident(name)]);
        }
        let mut changed = Group::new(group.delimiter(), name_regions(content.into_iter().collect(), regions));
        changed.set_span(group.span());
        out.push(TokenTree::Group(changed));
    }
    out.into_iter().collect()
}

/// `Cells`, `"wall 2"` → `CellsWall2`; the same text gives the same name, another text another.
fn region_name(word: &str, argument: &TokenStream, regions: &[RegionEntry], span: Span) -> Ident {
    let text = argument.to_string();
    let mut name = word.to_string();
    for part in text.split(|character: char| !character.is_alphanumeric()).filter(|part| !part.is_empty()) {
        let mut characters = part.chars();
        name.extend(characters.next().into_iter().flat_map(char::to_uppercase));
        name.extend(characters);
    }
    let taken = |name: &str| {
        is_built_in(name)
            || regions.iter().any(|region| region.name == name && region.value.to_string() != text)
    };
    while taken(&name) {
        name.push('_');
    }
    Ident::new(&name, span)
}

impl OneForm {
    /// The expression: the module that `content` is the inside of, and the call of its constructor. `used` are the
    /// regions that the constructor asks for; `None`: the form has a mistake.
    pub fn expression(
        &self,
        content: TokenStream,
        used: Option<&[Ident]>,
        backend: &syn::Path,
    ) -> TokenStream {
        let own = |name: &str| Ident::new(name, Span::mixed_site());
        let known: Vec<Ident> = (0..self.known_fields).map(|index| own(&format!("field_{index}"))).collect();
        let closure = (!known.is_empty()).then(|| quote! { move |#(#known),*| });
        let call = match used {
            Some(used) => {
                let data = own("data");
                let members = self.members.iter().map(|entry| entry.assignment(backend));
                let define = (!self.members.is_empty()).then(|| {
                    quote! { let #data = __form::Data { #(#members),* }; }
                });
                let data = (!self.members.is_empty()).then(|| quote! { &#data, });
                let used = self.regions.iter().filter(|region| used.contains(&region.name));
                let (names, bindings): (Vec<Ident>, Vec<TokenStream>) = used
                    .enumerate()
                    .map(|(index, RegionEntry { name, value, .. })| {
                        let local = own(&format!("region_{index}"));
                        (local.clone(), quote! { let #local = __form::#name::on(#value); })
                    })
                    .unzip();
                quote! { #define #(#bindings)* #closure __form::form(#data #(&#names,)* #(#known),*) }
            }
            None => {
                let value = &self.value;
                quote! {
                    #[allow(unused_variables)]
                    fn absent<const D: usize>(#(#known: impl Into<#backend::contract::Source<D>>),*) -> #backend::contract::#value<D> {
                        loop {}
                    }
                    #closure absent(#(#known),*)
                }
            }
        };
        let allow = allow();
        quote! {
            {
                #allow
                mod __form { #content }
                #call
            }
        }
    }
}

impl Entry {
    /// `name: value`, as the data struct wants it: a number or a closure has its meaning there.
    fn assignment(&self, backend: &syn::Path) -> TokenStream {
        let Entry { name, ty, value } = self;
        let given = matches!(word(ty), Some((kind, _)) if kind == "Given" || kind == "Carried");
        let value = match (written(value), given) {
            (Some(value), true) => quote! { #backend::contract::Given::constant(#value) },
            (Some(value), false) => value,
            (None, true) if matches!(value, Expr::Closure(_)) => {
                quote! { #backend::contract::Given::function(#value) }
            }
            (None, _) => value.to_token_stream(),
        };
        quote! { #name: #value }
    }
}

/// A number, or an array of such, in the text: as everywhere in a form, it is real.
fn written(value: &Expr) -> Option<TokenStream> {
    match value {
        Expr::Lit(literal) => match &literal.lit {
            syn::Lit::Int(_) => Some(quote! { (#literal as f64) }),
            syn::Lit::Float(_) => Some(literal.to_token_stream()),
            _ => None,
        },
        Expr::Unary(unary) if matches!(unary.op, syn::UnOp::Neg(_)) => {
            let inner = written(&unary.expr)?;
            Some(quote! { (-#inner) })
        }
        Expr::Array(array) => {
            let entries: Option<Vec<TokenStream>> = array.elems.iter().map(written).collect();
            let entries = entries?;
            Some(quote! { [#(#entries),*] })
        }
        _ => None,
    }
}
