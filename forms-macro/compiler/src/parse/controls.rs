//! `#[controls(..)]` before the form of a history's steps: the forms of its sensitivities, written out as a user would write them, before the
//! module is read.
//!
//! ```text
//! #[controls(conductivity)]
//! pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form { .. }
//! ```
//!
//! becomes the same function followed by
//!
//! ```text
//! pub fn step_sensitivities(u: State<Scalar>, before: State<Scalar>, v_adjoint: State<Scalar>,
//!                           by_before: Test<Scalar>, by_conductivity: Test<Scalar>) -> Form {
//!     let work = step(u, v_adjoint, before);
//!     derivative(work, before, by_before) + derivative(work, conductivity, by_conductivity)
//! }
//! ```
//!
//! With a criterion, derivatives by controls are those of work and criterion together.

use proc_macro2::{Ident, TokenStream};
use quote::{ToTokens, format_ident, quote, quote_spanned};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::{
    Attribute, Error, Expr, FnArg, GenericArgument, Item, ItemFn, ItemMod, Lit, Meta, Pat, PathArguments,
    Token, Type,
};

/// The shape of an option's mistake.
const OPTIONS: &str = "write `#[controls(first, second)]` with members of the data, and after them, where they are wanted, \
     `criterion = energy`, `motion(value, rate, second_rate)`, `order = 2`";

/// The shape of a mistake in the operators of time.
const OPERATORS: &str = "`motion(..)` takes `value`, `rate` and `second_rate`, of several unknowns those of each: \
     `motion(u(value, rate), p(value))`";

/// Writes out the sensitivities of all functions with the attribute, and takes the attributes away. The result is the errors.
pub fn expand(item: &mut ItemMod) -> TokenStream {
    let Some((_, items)) = &mut item.content else { return TokenStream::new() };
    let mut errors = TokenStream::new();
    let mut written = Vec::new();
    for place in 0..items.len() {
        let Item::Fn(function) = &mut items[place] else { continue };
        let is_controls = |attribute: &Attribute| attribute.path().is_ident("controls");
        let (own, others): (Vec<_>, Vec<_>) =
            std::mem::take(&mut function.attrs).into_iter().partition(is_controls);
        function.attrs = others;
        let function = function.clone();
        for attribute in own {
            match Choices::read(&attribute).and_then(|choices| History::new(&function, choices, items)) {
                Ok(history) => written.push((place, history)),
                Err(error) => errors.extend(error.into_compile_error()),
            }
        }
    }
    for (place, history) in written.into_iter().rev() {
        let mut more = vec![history.sensitivities()];
        if history.choices.is_twice {
            history.add_directions(items);
            more.push(history.second_sensitivities());
        }
        for tokens in more.into_iter().rev() {
            match syn::parse2::<ItemFn>(tokens) {
                Ok(function) => items.insert(place + 1, Item::Fn(function)),
                Err(error) => errors.extend(error.into_compile_error()),
            }
        }
    }
    errors
}

/// The attribute's content.
struct Choices {
    controls: Vec<Ident>,
    /// An energy that reads controls.
    criterion: Option<Ident>,
    /// Operators of time that the form reads.
    operators: Vec<Operator>,
    /// Whether second derivatives are wanted, too.
    is_twice: bool,
}

/// An operator of time: `value`, `rate` or `second_rate`, and of several unknowns the one that it reads.
struct Operator {
    name: Ident,
    unknown: Option<Ident>,
}

impl Operator {
    /// The operators in `motion(value, rate)` or `motion(u(value, rate), p(value))`.
    fn read(parts: Punctuated<Meta, Token![,]>) -> syn::Result<Vec<Self>> {
        let mut operators = vec![];
        for part in parts {
            match &part {
                Meta::List(list) => {
                    let unknown = list.path.get_ident().ok_or_else(|| Error::new(list.span(), OPERATORS))?;
                    let names = list.parse_args_with(Punctuated::<Ident, Token![,]>::parse_terminated)?;
                    operators.extend(
                        names.into_iter().map(|name| Operator { name, unknown: Some(unknown.clone()) }),
                    );
                }
                Meta::Path(path) if path.get_ident().is_some() => operators
                    .extend(path.get_ident().map(|name| Operator { name: name.clone(), unknown: None })),
                _ => return Err(Error::new(part.span(), OPERATORS)),
            }
        }
        match operators.iter().find(|one| !["value", "rate", "second_rate"].contains(&&*one.name.to_string()))
        {
            Some(other) => Err(Error::new(other.name.span(), OPERATORS)),
            None => Ok(operators),
        }
    }
}

impl Choices {
    fn read(attribute: &Attribute) -> syn::Result<Self> {
        let parts = attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated);
        let parts = parts.map_err(|error| Error::new(error.span(), OPTIONS))?;
        let mut choices = Choices { controls: vec![], criterion: None, operators: vec![], is_twice: false };
        for part in parts {
            let unknown = || Error::new(part.span(), OPTIONS);
            match &part {
                Meta::Path(path) => choices.controls.push(path.get_ident().ok_or_else(unknown)?.clone()),
                Meta::List(list) if list.path.is_ident("motion") => {
                    choices
                        .operators
                        .extend(Operator::read(list.parse_args_with(Punctuated::parse_terminated)?)?);
                }
                Meta::NameValue(pair) => match &pair.value {
                    Expr::Path(value) if pair.path.is_ident("criterion") => {
                        choices.criterion = Some(value.path.get_ident().ok_or_else(unknown)?.clone());
                    }
                    Expr::Lit(value) if pair.path.is_ident("order") => match &value.lit {
                        Lit::Int(order) if order.base10_digits() == "2" => choices.is_twice = true,
                        Lit::Int(order) if order.base10_digits() == "1" => {}
                        _ => return Err(Error::new(value.span(), "derivatives are of order 1 or 2")),
                    },
                    _ => return Err(unknown()),
                },
                Meta::List(_) => return Err(unknown()),
            }
        }
        match choices.controls.is_empty() {
            true => Err(Error::new(attribute.span(), OPTIONS)),
            false => Ok(choices),
        }
    }
}

/// An argument of a function: its name, and the shape in its type.
#[derive(Clone)]
struct Argument {
    name: Ident,
    shape: TokenStream,
}

/// A control: its name, and the type of its member.
struct Control {
    name: Ident,
    shape: TokenStream,
    member: TokenStream,
}

/// The form of a step with what its derivatives are by.
struct History {
    function: ItemFn,
    choices: Choices,
    unknowns: Vec<Argument>,
    tests: Vec<Argument>,
    before: Vec<Argument>,
    controls: Vec<Control>,
    /// The number of unknowns of the criterion.
    read_by_criterion: usize,
}

impl History {
    fn new(function: &ItemFn, choices: Choices, items: &[Item]) -> syn::Result<Self> {
        let [mut unknowns, mut tests, mut before] = [const { Vec::new() }; 3];
        for input in &function.sig.inputs {
            let Some((kind, argument)) = argument(input) else { continue };
            match &*kind.to_string() {
                "Unknown" => unknowns.push(argument),
                "Test" => tests.push(argument),
                "State" => before.push(argument),
                _ => {}
            }
        }
        let error = |message: &str| Err(Error::new(function.sig.ident.span(), message));
        if unknowns.is_empty() || tests.len() != unknowns.len() {
            return error("`#[controls(..)]` is for the form of a step: as many test functions as unknowns");
        }
        if !before.is_empty() && before.len() != unknowns.len() {
            return error(
                "the form of a step reads the states before as `State`s: one for each unknown, in their order, or none",
            );
        }
        for operator in &choices.operators {
            let known = |name: &Ident| unknowns.iter().any(|unknown| unknown.name == *name);
            match &operator.unknown {
                Some(name) if !known(name) => {
                    return Err(Error::new(name.span(), "no unknown of the form has this name"));
                }
                None if unknowns.len() > 1 => return Err(Error::new(operator.name.span(), OPERATORS)),
                _ => {}
            }
        }
        if let (Some(name), false) = (&choices.criterion, choices.operators.is_empty()) {
            return Err(Error::new(name.span(), "the criterion of a motion depends on no control"));
        }
        let criterion = choices.criterion.as_ref().map(|name| {
            let found = items.iter().find_map(|item| match item {
                Item::Fn(item) if item.sig.ident == *name => Some(item),
                _ => None,
            });
            let message = "`criterion = ..` names an energy of this module";
            let found = found.ok_or_else(|| Error::new(name.span(), message))?;
            let all = found.sig.inputs.iter().filter_map(argument);
            Ok::<_, Error>(all.filter(|(kind, _)| kind == "Unknown").count().min(unknowns.len()))
        });
        let controls = choices.controls.iter().map(|name| control(name, items)).collect();
        let read_by_criterion = criterion.transpose()?.unwrap_or(0);
        let function = function.clone();
        Ok(History { function, choices, unknowns, tests, before, controls, read_by_criterion })
    }

    /// The name of what is made of the step's form.
    fn named(&self, of: &str) -> Ident {
        let name = &self.function.sig.ident;
        Ident::new(&format!("{name}_{of}"), name.span())
    }

    fn adjoints(&self) -> Vec<Argument> {
        let adjoint =
            |test: &Argument| Argument { name: format_ident!("{}_adjoint", test.name), ..test.clone() };
        self.tests.iter().map(adjoint).collect()
    }

    /// The work of the residual in the adjoint states, and with the criterion.
    fn work(&self) -> TokenStream {
        let (name, adjoints) = (&self.function.sig.ident, self.adjoints());
        let inputs = self.function.sig.inputs.iter().filter_map(argument);
        let (mut number, mut arguments) = (0, Vec::new());
        for (kind, argument) in inputs {
            match kind == "Test" {
                true => {
                    arguments.push(adjoints[number].name.clone());
                    number += 1;
                }
                false => arguments.push(argument.name),
            }
        }
        // Controls may be read by the criterion only.
        let criterion = self.criterion().map(|energy| quote! { + #energy });
        quote! {
            let work = #name(#(#arguments),*);
            let lagrangian = work #criterion;
        }
    }

    /// The tests of the derivatives by the states before: the variable, the test function, its shape.
    fn tested_before(&self) -> Vec<(Ident, Ident, TokenStream)> {
        let before = self.before.iter().zip(&self.unknowns).map(|(before, unknown)| {
            (before.name.clone(), self.test_of("before", &unknown.name), before.shape.clone())
        });
        let operators = self.choices.operators.iter().filter_map(|Operator { name, unknown }| {
            let named = |one: &&Argument| unknown.as_ref().is_none_or(|name| one.name == *name);
            let Argument { name: unknown, shape } = self.unknowns.iter().find(named)?;
            // What is known of a scalar next to a vector has this word in its name.
            let known = match self.unknowns.len() > 1 && shape.to_string() == "Scalar" {
                true => format_ident!("known_scalar_{name}"),
                false => format_ident!("known_{name}"),
            };
            Some((known, self.test_of(&name.to_string(), unknown), shape.clone()))
        });
        operators.chain(before).collect()
    }

    /// The test function of the derivative by a quantity of an unknown.
    fn test_of(&self, quantity: &str, unknown: &Ident) -> Ident {
        match self.unknowns.len() {
            1 => format_ident!("by_{quantity}"),
            _ => format_ident!("by_{quantity}_{unknown}"),
        }
    }

    /// The criterion at the states.
    fn criterion(&self) -> Option<TokenStream> {
        let name = self.choices.criterion.as_ref()?;
        let read = self.unknowns[..self.read_by_criterion].iter().map(|unknown| &unknown.name);
        Some(quote! { #name(#(#read),*) })
    }

    fn sensitivities(&self) -> TokenStream {
        let (visibility, name, work) = (&self.function.vis, self.named("sensitivities"), self.work());
        let states = self.unknowns.iter().chain(&self.before).cloned().chain(self.adjoints());
        let states = states.map(|Argument { name, shape }| quote! { #name: State<#shape> });
        let mut tests = Vec::new();
        let mut terms = Vec::new();
        for (variable, test, shape) in self.tested_before() {
            tests.push(quote! { #test: Test<#shape> });
            terms.push(quote! { derivative(work, #variable, #test) });
        }
        for Control { name, shape, .. } in &self.controls {
            let test = Ident::new(&format!("by_{name}"), name.span());
            tests.push(quote! { #test: Test<#shape> });
            terms.push(quote! { derivative(lagrangian, #name, #test) });
        }
        let text = format!(
            " The sensitivities of `{}`: the derivatives of its work by the states before and by each control.",
            self.function.sig.ident
        );
        quote_spanned! { name.span() =>
            #[doc = #text]
            #visibility fn #name(#(#states,)* #(#tests),*) -> Form { #work #(#terms)+* }
        }
    }

    fn second_sensitivities(&self) -> TokenStream {
        let (visibility, name, work) = (&self.function.vis, self.named("second_sensitivities"), self.work());
        let changed: Vec<Argument> = match self.choices.operators.is_empty() {
            true => self.unknowns.iter().chain(&self.before).cloned().collect(),
            false => {
                self.tested_before().into_iter().map(|(name, _, shape)| Argument { name, shape }).collect()
            }
        };
        let adjoints = self.adjoints();
        let directions: Vec<(&Argument, Ident)> = changed
            .iter()
            .chain(&adjoints)
            .map(|argument| (argument, format_ident!("d_{}", argument.name)))
            .collect();
        let states = self.unknowns.iter().chain(&self.before).chain(&adjoints);
        let mut arguments: Vec<TokenStream> =
            states.map(|Argument { name, shape }| quote! { #name: State<#shape> }).collect();
        arguments.extend(
            directions.iter().map(|(Argument { shape, .. }, change)| quote! { #change: State<#shape> }),
        );
        let mut slopes = Vec::new();
        let mut slope = |of: TokenStream, variable: &Ident, test: Ident, shape: &TokenStream| {
            arguments.push(quote! { #test: Test<#shape> });
            slopes.push(quote! { derivative(#of, #variable, #test) });
        };
        let work_only = || quote! { work };
        if self.choices.operators.is_empty() {
            for Argument { name, shape } in &self.unknowns {
                slope(work_only(), name, self.test_of("state", name), shape);
            }
        }
        for (variable, test, shape) in self.tested_before() {
            slope(work_only(), &variable, test, &shape);
        }
        for (adjoint, unknown) in adjoints.iter().zip(&self.unknowns) {
            slope(work_only(), &adjoint.name, self.test_of("adjoint", &unknown.name), &adjoint.shape);
        }
        for Control { name, shape, .. } in &self.controls {
            slope(quote! { lagrangian }, name, Ident::new(&format!("by_{name}"), name.span()), shape);
        }
        // The second derivative of the criterion by the states is the library's; the mixed ones are not.
        let of_criterion = self.criterion().map(|energy| {
            let read = self.unknowns[..self.read_by_criterion].iter().map(|unknown| &unknown.name);
            let terms = read.map(|unknown| {
                let test = self.test_of("state", unknown);
                quote! { + derivative(#energy, #unknown, #test) }
            });
            quote! { #(#terms)* }
        });
        let mut terms: Vec<TokenStream> = Vec::new();
        for (Argument { name, .. }, change) in &directions {
            terms.push(quote! { derivative(slope, #name, #change) });
        }
        for Control { name, .. } in &self.controls {
            let change = format_ident!("d_{name}");
            terms.push(quote! { derivative(whole, #name, #change) });
        }
        let text = format!(
            " The change of the sensitivities of `{}` along changes of its states and of the controls, the members `d_..`.",
            self.function.sig.ident
        );
        quote_spanned! { name.span() =>
            #[doc = #text]
            #[allow(clippy::too_many_arguments)]
            #visibility fn #name(#(#arguments),*) -> Form {
                #work
                let slope = #(#slopes)+*;
                let whole = slope #of_criterion;
                #(#terms)+*
            }
        }
    }

    /// Adds the directions of the controls to the data: `d_name`, zero where they are not given.
    fn add_directions(&self, items: &mut [Item]) {
        let Some(fields) = items.iter_mut().find_map(data_members) else { return };
        for Control { name, member, .. } in &self.controls {
            let direction = Ident::new(&format!("d_{name}"), name.span());
            if fields.named.iter().any(|field| field.ident.as_ref() == Some(&direction)) {
                continue;
            }
            let text = format!(" The direction of the control `{name}`.");
            fields.named.push(syn::parse_quote! { #[doc = #text] #[default(0)] pub #direction: #member });
        }
    }
}

/// The name of an argument with the word of its type, as `Unknown`, and the shape in it.
fn argument(input: &FnArg) -> Option<(Ident, Argument)> {
    let FnArg::Typed(input) = input else { return None };
    let Pat::Ident(name) = &*input.pat else { return None };
    let (kind, shape) = word_and_shape(&input.ty)?;
    Some((kind, Argument { name: name.ident.clone(), shape }))
}

/// `Unknown` and `Vector` of `Unknown<Vector>`.
fn word_and_shape(ty: &Type) -> Option<(Ident, TokenStream)> {
    let Type::Path(path) = ty else { return None };
    let last = path.path.segments.last()?;
    let shape = match &last.arguments {
        PathArguments::AngleBracketed(inner) => match inner.args.first()? {
            GenericArgument::Type(shape) => shape.to_token_stream(),
            _ => return None,
        },
        _ => TokenStream::new(),
    };
    Some((last.ident.clone(), shape))
}

fn data_members(item: &mut Item) -> Option<&mut syn::FieldsNamed> {
    match item {
        Item::Struct(item) => match &mut item.fields {
            syn::Fields::Named(fields) => Some(fields),
            _ => None,
        },
        _ => None,
    }
}

/// A control with the type of its member, a number where this module's data only include it.
fn control(name: &Ident, items: &[Item]) -> Control {
    let members = items.iter().find_map(|item| match item {
        Item::Struct(item) => match &item.fields {
            syn::Fields::Named(fields) => Some(fields),
            _ => None,
        },
        _ => None,
    });
    let member =
        members.and_then(|fields| fields.named.iter().find(|field| field.ident.as_ref() == Some(name)));
    let given = member.and_then(|member| {
        let (word, shape) = word_and_shape(&member.ty)?;
        (word == "Given").then(|| (shape, member.ty.to_token_stream()))
    });
    let (shape, member) = given.unwrap_or_else(|| (quote! { Scalar }, quote! { Param }));
    Control { name: name.clone(), shape, member }
}
