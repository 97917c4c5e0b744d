//! Linear combinations of compiled functions, which are compiled functions themselves.
//!
//! A combination has the terms of all its addends, one after the other, with their factors in the kernels. Unknowns, test functions
//! and directions are one by their numbers. All other fields, regions and parameters stay those of the addend that brought them.

mod operators;
mod shown;

use std::any::TypeId;
use std::borrow::Cow;
use std::fmt;

pub(super) use self::shown::formula_of;
use super::Function;
use crate::adaptation::Adaptation;
use crate::form::{FieldDescription, Formula, Inputs, Role};
use crate::integrals::{CombiningBackend, Term};

/// A reason for which compiled functions have no sum or multiple.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CombinationError {
    /// Other numbers of unknowns or of test functions.
    Count {
        /// The two functions.
        forms: [&'static str; 2],
        /// The counted fields: unknowns or test functions.
        what: &'static str,
        /// The names of these fields in each of the two functions.
        fields: [Vec<&'static str>; 2],
    },
    /// Unknowns or test functions with the same number and other shapes.
    Shape {
        /// The two functions.
        forms: [&'static str; 2],
        /// The field of each.
        fields: [&'static str; 2],
        /// Their shapes.
        shapes: [&'static [usize]; 2],
    },
    /// A factor that is not finite.
    Factor {
        /// The function.
        form: &'static str,
        /// Its factor.
        factor: f64,
    },
    /// The sum of an empty list of forms, where unknowns and test functions are asked for.
    Empty,
}

impl fmt::Display for CombinationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CombinationError::Count { forms: [one, other], what, fields: [own, others] } => {
                let list = |names: &[&str]| match names {
                    [] => "none".to_owned(),
                    names => format!("`{}`", names.join("`, `")),
                };
                let (own, others) = (list(own), list(others));
                write!(f, "`{one}` and `{other}` cannot be added: the {what} are {own} and {others}")
            }
            CombinationError::Shape { forms: [one, other], fields, shapes } => {
                let of = |k: usize| format!("`{}` of shape {:?}", fields[k], shapes[k]);
                let (own, others) = (of(0), of(1));
                write!(f, "`{one}` and `{other}` cannot be added: one has {own} where the other has {others}")
            }
            CombinationError::Factor { form, factor } => write!(f, "the factor of `{form}` is {factor}"),
            CombinationError::Empty => {
                write!(f, "a sum of no forms has no unknowns and test functions; add it to a form")
            }
        }
    }
}

impl std::error::Error for CombinationError {}

/// A function of a combination, as it was compiled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Addend {
    pub factor: f64,
    pub name: &'static str,
    pub formula: &'static Formula,
}

/// The type in place of the integrals' for what was combined.
struct Combined;

/// The use of what is combined.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    /// As a residual with its tangent: it has no value.
    Form,
    /// As a value, and perhaps its variations.
    Value,
}

/// Σ factor × function.
fn combine<'a, const D: usize, B: CombiningBackend<D>>(
    addends: impl IntoIterator<Item = (f64, &'a Function<D, B>)>,
    usage: Use,
) -> Function<D, B> {
    let mut sum = Combination::new();
    addends.into_iter().for_each(|(factor, function)| sum.add(factor, function));
    let Combination { mut function, fields, has_action } = sum;
    if function.addends.is_empty() && usage == Use::Form {
        function.fault = Some(CombinationError::Empty);
    }
    if usage == Use::Form {
        function.density.clear();
    }
    if !has_action {
        function.action.clear();
    }
    function.fields = fields.into();
    function
}

struct Combination<const D: usize, B: CombiningBackend<D>> {
    /// All but the fields.
    function: Function<D, B>,
    fields: Vec<FieldDescription>,
    /// Whether each of the addends that has a tangent has its action.
    has_action: bool,
}

impl<const D: usize, B: CombiningBackend<D>> Combination<D, B> {
    fn new() -> Self {
        let function = Function {
            name: shown::name_of(&[]),
            addends: vec![],
            fault: None,
            fields: Cow::Borrowed(&[]),
            shape: &[],
            inputs: Inputs::empty(),
            residual: vec![],
            joined_residual: vec![],
            tangent: vec![],
            switches: vec![],
            density: vec![],
            action: vec![],
            motion: vec![],
            means: vec![],
            means_by_unknowns: vec![],
            residual_by_means: vec![],
            integrals: TypeId::of::<Combined>(),
        };
        Combination { function, fields: vec![], has_action: true }
    }

    fn add(&mut self, factor: f64, addend: &Function<D, B>) {
        if addend.addends.is_empty() {
            return;
        }
        let refused =
            || (!factor.is_finite()).then_some(CombinationError::Factor { form: addend.name, factor });
        let known = self.function.fault.take().or_else(|| addend.fault.clone());
        self.function.fault = known.or_else(refused).or_else(|| self.mismatch(addend));

        let means = self.fields.iter().filter(|field| matches!(field.role, Role::Mean(_))).count();
        let mut numbers = Vec::with_capacity(addend.fields.len());
        for (field, source) in addend.fields.iter().zip(&addend.inputs.sources) {
            let known =
                self.fields.iter().position(|known| is_shared(field.role) && known.role == field.role);
            numbers.push(known.unwrap_or(self.fields.len()));
            if known.is_none() {
                self.fields.push(FieldDescription { role: renumbered(field.role, means), ..*field });
                self.function.inputs.sources.push(source.clone());
            }
        }

        let own = &mut self.function;
        let adaptation = Adaptation::new(factor, &numbers, own.inputs.regions.len(), means);
        let linear = |term: &Term<B::Linear>| Term {
            integral: adaptation.integral(term.integral),
            kernel: B::adapt_linear(&term.kernel, adaptation),
        };
        own.residual.extend(addend.residual.iter().map(linear));
        own.joined_residual.extend(addend.joined_residual.iter().map(linear));
        own.action.extend(addend.action.iter().map(linear));
        own.motion.extend(addend.motion.iter().map(linear));
        let bilinear = |term: &Term<B::Bilinear>, adaptation: Adaptation| Term {
            integral: adaptation.integral(term.integral),
            kernel: B::adapt_bilinear(&term.kernel, adaptation),
        };
        own.tangent.extend(addend.tangent.iter().map(|term| bilinear(term, adaptation)));
        let by_means = addend.residual_by_means.iter();
        own.residual_by_means.extend(by_means.map(|term| bilinear(term, adaptation)));
        let expression = |term: &Term<B::Expression>, adaptation: Adaptation| Term {
            integral: adaptation.integral(term.integral),
            kernel: B::adapt_expression(&term.kernel, adaptation),
        };
        own.density.extend(addend.density.iter().map(|term| expression(term, adaptation)));
        // A factor does not change where a kink is on.
        let unscaled = adaptation.without_factor();
        // Nor does it change the means.
        own.means.extend(addend.means.iter().map(|term| Term {
            integral: unscaled.integral(term.integral),
            kernel: B::adapt_linear(&term.kernel, unscaled),
        }));
        own.means_by_unknowns.extend(addend.means_by_unknowns.iter().map(|term| bilinear(term, unscaled)));
        own.switches.extend(addend.switches.iter().map(|term| expression(term, unscaled)));
        let has_tangent = !addend.tangent.is_empty() || !addend.residual_by_means.is_empty();
        self.has_action &= !has_tangent || !addend.action.is_empty();

        let (inputs, added) = (&mut own.inputs, &addend.inputs);
        inputs.regions.extend(added.regions.iter().cloned());
        inputs.parameters.extend(&added.parameters);
        inputs.parameter_names.extend(added.parameter_names.iter().cloned());
        inputs.tables.extend(added.tables.iter().cloned());
        inputs.optimised &= added.optimised;
        own.addends.extend(addend.addends.iter().map(|one| Addend { factor: factor * one.factor, ..*one }));
        own.name = shown::name_of(&own.addends);
    }

    /// The reason for which a function cannot be added. One without unknowns is a load, or a functional of data.
    fn mismatch(&self, addend: &Function<D, B>) -> Option<CombinationError> {
        if self.function.addends.is_empty() {
            return None;
        }
        let forms = [self.function.name, addend.name];
        let select = |fields: &[FieldDescription], is: fn(Role) -> bool| -> Vec<FieldDescription> {
            fields.iter().filter(|field| is(field.role)).copied().collect()
        };
        for (what, is, may_lack) in [
            ("unknowns", (|role| matches!(role, Role::Unknown(_))) as fn(Role) -> bool, true),
            ("test functions", |role| matches!(role, Role::Test(_)), false),
        ] {
            let (own, others) = (select(&self.fields, is), select(&addend.fields, is));
            if may_lack && (own.is_empty() || others.is_empty()) {
                continue;
            }
            if own.len() != others.len() {
                let names = |fields: &[FieldDescription]| fields.iter().map(|field| field.name).collect();
                return Some(CombinationError::Count { forms, what, fields: [names(&own), names(&others)] });
            }
            for one in &own {
                let other = others.iter().find(|other| other.role == one.role);
                if let Some(other) = other.filter(|other| other.shape != one.shape) {
                    let (fields, shapes) = ([one.name, other.name], [one.shape, other.shape]);
                    return Some(CombinationError::Shape { forms, fields, shapes });
                }
            }
        }
        None
    }
}

/// The role of a field that is not shared, after some lists of means.
fn renumbered(role: Role, means: usize) -> Role {
    match role {
        Role::Mean(number) => Role::Mean(means + number),
        Role::MeanTest(number) => Role::MeanTest(means + number),
        other => other,
    }
}

/// Whether addends share the field with a role.
fn is_shared(role: Role) -> bool {
    matches!(role, Role::Unknown(_) | Role::Test(_) | Role::Direction(_))
}
