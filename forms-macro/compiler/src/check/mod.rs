//! Stage 2: [`Module`] → [`Checked`]: names resolved, calls inlined, shapes and linearity verified, in
//! one dimension. Every mistake is reported on its tokens; what is wrong is left out.

pub mod builtins;
mod calls;
pub mod elsewhere;
mod evaluate;
mod externals;
mod indices;
mod integrals;
mod linearity;
mod means;
mod names;
mod operators;
mod outline;
pub mod regions;
mod sides;
mod sliding;
mod tensor_algebra;

use std::collections::HashMap;

use proc_macro2::Ident;

use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::syntax::*;
use crate::tensor::{Arena, FieldInfo, FieldRole, Tensor};

/// The functions of a module that become kernels, in one dimension.
pub struct Checked {
    pub functions: Vec<CheckedFunction>,
}

/// One function with its calls inlined.
pub struct CheckedFunction {
    /// Index in [`Module::functions`].
    pub function: usize,
    pub dimension: usize,
    pub arena: Arena,
    /// Arguments in their order, then the module's `Given` and `History` members in theirs.
    pub fields: Vec<FieldInfo>,
    pub content: Content,
}

/// Kinds of checked functions.
pub enum Content {
    /// Linear in its test functions.
    Form(Vec<Term>),
    Energy(Vec<Term>),
    Functional(Vec<Term>),
    Value(Tensor),
}

/// One integral: a scalar density on a region.
#[derive(Clone)]
pub struct Term {
    /// Index in [`Module::regions`].
    pub region: usize,
    /// The fields whose sum displaces the surfaces of sliding pairs; `None` for other regions and for pairs of fixed points.
    pub displacement: Option<Vec<usize>>,
    /// Of `means(..)`.
    pub means: Option<Means>,
    pub density: Tensor,
}

/// Means over own facets: `forms_core::contract::Means`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Means {
    /// The list of means that an integral makes; 0 in others.
    pub number: usize,
    /// Degree of the weights.
    pub degree: usize,
}

impl Term {
    /// Another density on the same region.
    pub fn with(&self, density: Tensor) -> Term {
        Term { density, ..self.clone() }
    }
}

/// Checks all functions of a module.
pub fn check(module: &Module, dimension: usize, diagnostics: &mut Diagnostics) -> Checked {
    check_declarations(module, diagnostics);
    let mut exhausted = false;
    let functions = (0..module.functions.len())
        .filter_map(|index| match exhausted {
            // A function that unfolds without end ends the check: most likely the others do, too.
            true => None,
            false => check_function(module, index, dimension, &mut exhausted, diagnostics),
        })
        .collect();
    Checked { functions }
}

pub use outline::outline;

/// Is this function one that others call, and nothing to assemble by itself?
/// A `Form`, `Energy` or `Functional` whose arguments have no roles is a building block.
/// So is what was imported to be called, and a value that is private: outside of the module nobody can name it, and each
/// of a chain of functions would hold the kernels of all below it.
pub fn is_building_block(function: &Function) -> bool {
    if function.foreign.as_ref().is_some_and(|foreign| !foreign.emitted) {
        return true;
    }
    let plain = function.arguments.iter().all(|argument| argument.role == ArgumentRole::Plain);
    match function.output {
        Output::Form | Output::Energy => plain,
        Output::Functional => plain && !function.arguments.is_empty(),
        Output::Value(_) => matches!(function.visibility, syn::Visibility::Inherited),
    }
}

/// The fields of a function: see [`CheckedFunction::fields`].
pub fn fields_of(module: &Module, function: &Function, dimension: usize) -> Vec<FieldInfo> {
    let (mut unknowns, mut tests) = (0.., 0..);
    let next = |numbers: &mut std::ops::RangeFrom<usize>| numbers.next().unwrap_or_default();
    let mut fields = Vec::new();
    for argument in &function.arguments {
        let role = match argument.role {
            ArgumentRole::Unknown => FieldRole::Unknown(next(&mut unknowns)),
            ArgumentRole::Test => FieldRole::Test(next(&mut tests)),
            ArgumentRole::State | ArgumentRole::Plain => FieldRole::State,
        };
        fields.push(FieldInfo {
            name: argument.name.to_string(),
            role,
            shape: argument.rank.shape(dimension),
        });
    }
    for member in field_members(module) {
        let shape = member.rank.shape(dimension);
        let role = match member.kind {
            MemberKind::History => FieldRole::History,
            MemberKind::Carried => FieldRole::Carried,
            _ => FieldRole::Given,
        };
        fields.push(FieldInfo { name: member.name.to_string(), role, shape });
    }
    fields
}

/// The members of the data struct that are fields.
pub fn field_members(module: &Module) -> impl Iterator<Item = &Member> {
    let members = module.members();
    members
        .filter(|member| matches!(member.kind, MemberKind::Given | MemberKind::Carried | MemberKind::History))
}

fn check_function(
    module: &Module,
    index: usize,
    dimension: usize,
    exhausted: &mut bool,
    diagnostics: &mut Diagnostics,
) -> Option<CheckedFunction> {
    let function = &module.functions[index];
    if function.foreign.as_ref().is_some_and(|foreign| !foreign.emitted) {
        return None;
    }
    let fields = fields_of(module, function, dimension);
    let mut evaluator = evaluate::Evaluator::new(module, dimension, diagnostics);
    let value = evaluator.enter(index, &fields);
    *exhausted = evaluator.exhausted;
    let arena = evaluator.arena;
    let content = match (value?, function.output) {
        (evaluate::Value::Tensor(value), Output::Value(_)) => Content::Value(value),
        (evaluate::Value::Form(terms), Output::Form) => Content::Form(terms),
        (evaluate::Value::Form(terms), Output::Energy) => Content::Energy(terms),
        (evaluate::Value::Form(terms), Output::Functional) => Content::Functional(terms),
        _ => return None,
    };
    if is_building_block(function) {
        return None;
    }
    let linear = match &content {
        Content::Form(terms) => linearity::check_form(function, &arena, &fields, terms, diagnostics),
        Content::Energy(_) | Content::Functional(_) => linearity::check_functional(function, diagnostics),
        Content::Value(_) => check_value(function, diagnostics),
    };
    linear.then_some(CheckedFunction { function: index, dimension, arena, fields, content })
}

/// A derived field has known fields only: nothing else has values where it is evaluated.
fn check_value(function: &Function, diagnostics: &mut Diagnostics) -> bool {
    let wrong = |argument: &&Argument| matches!(argument.role, ArgumentRole::Unknown | ArgumentRole::Test);
    let mut right = true;
    for argument in function.arguments.iter().filter(wrong) {
        let message = format!(
            "`{}` gives a value, so `{}` can be neither an unknown nor a test function",
            function.name, argument.name
        );
        let help = "give the rank alone, `Scalar`, `Vector` or `Tensor`: forms may pass what they like";
        diagnostics.error_with_help(SourceSpan::of(&argument.name), message, help);
        right = false;
    }
    right
}

/// Names declared twice, or declared though they are built in.
fn check_declarations(module: &Module, diagnostics: &mut Diagnostics) {
    let members = module.members().filter(|member| member.included.is_none()).map(|member| &member.name);
    let regions = module.regions.iter().map(|region| &region.name);
    let functions = module.functions.iter().map(|function| &function.name);
    let data = module.data.iter().map(|data| &data.name);
    let externals = module.externals.iter().map(|external| &external.name);
    for name in data.clone().chain(regions.clone()).chain(functions.clone()) {
        let text = name.to_string();
        if module.data.iter().any(|data| data.emits(&text)) || is_reserved(&text) {
            let message = format!("the name `{name}` is used by the compiled module itself");
            diagnostics.error_with_help(SourceSpan::of(name), message, "choose another name");
        }
    }
    check_inclusion(module, diagnostics);
    check_names(members.chain(data).chain(regions).chain(functions).chain(externals), diagnostics);
    check_not_of_pairs(module, diagnostics);
    for function in &module.functions {
        check_names(function.arguments.iter().map(|argument| &argument.name), diagnostics);
        for Argument { name, .. } in &function.arguments {
            // Rust takes it for the region's pattern, too.
            if module.regions.iter().any(|region| region.name == *name) {
                let message = format!("`{name}` is a region of this module, and no argument");
                diagnostics.error_with_help(SourceSpan::of(name), message, "choose another name");
            }
        }
    }
}

/// Names of included members, declared again as what is no member.
fn check_inclusion(module: &Module, diagnostics: &mut Diagnostics) {
    let regions = module.regions.iter().map(|region| &region.name);
    let functions = module.functions.iter().map(|function| &function.name);
    let externals = module.externals.iter().map(|external| &external.name);
    for name in regions.chain(functions).chain(externals) {
        let member = module.members().find(|member| member.name == *name);
        if let Some(path) = member.and_then(|member| member.included.as_ref()) {
            let message = format!("`{name}` is a member of `{path}`, which the data of this module include");
            diagnostics.error_with_help(SourceSpan::of(name), message, "choose another name");
        }
    }
}

fn check_names<'a>(names: impl Iterator<Item = &'a Ident>, diagnostics: &mut Diagnostics) {
    let mut seen = HashMap::new();
    for name in names {
        let text = name.to_string();
        check_not_built_in(name, diagnostics);
        if seen.insert(text, ()).is_some() {
            diagnostics.error(SourceSpan::of(name), format!("the name `{name}` is declared twice"));
        }
    }
}

/// In a module with contact pairs what belongs to them has one meaning.
fn check_not_of_pairs(module: &Module, diagnostics: &mut Diagnostics) {
    if !module.has_pairs() {
        return;
    }
    for member in module.members().filter(|member| builtins::of_pairs(&member.name.to_string()).is_some()) {
        let name = &member.name;
        diagnostics.error_with_help(
            SourceSpan::of(name),
            format!("`{name}` belongs to the contact pairs of this module and cannot be declared again"),
            format!("call this member by another name, `initial_{name}` for one"),
        );
    }
}

/// Does emitted code declare it where the module's own names are?
pub fn is_reserved(name: &str) -> bool {
    matches!(name, "contract" | "Model" | "Regions") || name.starts_with("__")
}

/// A built-in name cannot be declared again.
fn check_not_built_in(name: &Ident, diagnostics: &mut Diagnostics) {
    let text = name.to_string();
    if builtins::is_built_in(&text) {
        diagnostics.error_with_help(
            SourceSpan::of(name),
            format!("`{name}` is built in and cannot be declared again"),
            format!("call this one `{name}_`, or `{name}` with a word that says which"),
        );
    }
}
