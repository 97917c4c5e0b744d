//! Walks a function's body with its arguments bound, inlining the functions that it calls.

use std::collections::HashMap;

use proc_macro2::Ident;

use super::{Term, builtins};
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::declared_type::{LARGEST, report_extent};
use crate::parse::syntax::*;
use crate::tensor::{Arena, FieldInfo, FieldRole, Operator, Shape, Tensor, Truth};

/// The value of an expression.
#[derive(Clone)]
pub enum Value {
    Tensor(Tensor),
    /// Integrals.
    Form(Vec<Term>),
}

/// More nodes than any form has, and few enough to be walked in a second by a macro that is not optimised.
const MOST_NODES: usize = 100_000;
/// More integrals than any form has.
const MOST_TERMS: usize = 10_000;
/// More functions one inside the other than any form calls, and fewer than the stack has room for.
const MOST_CALLS: usize = 550;
/// More operations one inside the other than any form has, likewise.
const MOST_DEPTH: u32 = 2_000;

/// A call, to be distinguished from others: `diff(e, w)` by an argument relies on the identity of its node.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Call {
    function: usize,
    passed: Vec<Passed>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Passed {
    Node(Tensor),
    /// A field is a new node wherever it is named; so is a parameter.
    Field(usize, usize),
    Parameter(usize),
    Nothing,
}

/// The state of a walk. Methods return `None` after a report.
pub struct Evaluator<'a> {
    pub(super) module: &'a Module,
    pub(super) dimension: usize,
    pub(super) arena: Arena,
    pub(super) diagnostics: &'a mut Diagnostics,
    /// Functions being inlined, outermost first.
    pub(super) calls: Vec<usize>,
    /// Results of calls by their arguments, so that an equal call is not unfolded again.
    pub(super) given_calls: HashMap<Call, Option<Value>>,
    /// Too large to go on, which has been reported.
    pub(super) exhausted: bool,
    /// Places of the operands of the current operation (a `let` name's value is elsewhere).
    pub(super) uses: HashMap<Tensor, SourceSpan>,
    /// Functions of the module and `let`s stay names, as a formula shows them.
    pub(super) outlined: bool,
    /// Field index of each `Given` or `History` member.
    pub(super) given: HashMap<String, (usize, Shape)>,
    /// Field indices of the `History` members.
    pub(super) histories: Vec<usize>,
}

/// Names of one function: arguments and `let`s. `None`: its value had a mistake, which was reported.
pub(super) type Scope = HashMap<String, Option<Value>>;

impl<'a> Evaluator<'a> {
    pub fn new(module: &'a Module, dimension: usize, diagnostics: &'a mut Diagnostics) -> Self {
        Evaluator {
            module,
            dimension,
            arena: Arena::default(),
            diagnostics,
            calls: vec![],
            given_calls: HashMap::new(),
            exhausted: false,
            uses: HashMap::new(),
            outlined: false,
            given: HashMap::new(),
            histories: vec![],
        }
    }

    /// The function by itself: its arguments are the leading `fields`.
    pub fn enter(&mut self, function: usize, fields: &[FieldInfo]) -> Option<Value> {
        let arguments = &self.module.functions[function].arguments;
        let mut values = Vec::new();
        for (index, argument) in arguments.iter().enumerate() {
            let operator = Operator::Field { field: index, order: 0 };
            let node = self.arena.push(operator, fields[index].shape.clone(), SourceSpan::of(&argument.name));
            values.push(Some(Value::Tensor(node)));
        }
        for (index, field) in fields.iter().enumerate().skip(arguments.len()) {
            self.given.insert(field.name.clone(), (index, field.shape.clone()));
            if field.role == FieldRole::History {
                self.histories.push(index);
            }
        }
        match &self.module.functions[function].foreign {
            Some(foreign) => {
                let span = SourceSpan::of(&self.module.functions[function].name);
                self.inline_foreign(function, foreign, values, span)
            }
            None => self.inline(function, values),
        }
    }

    pub(super) fn inline(&mut self, index: usize, values: Vec<Option<Value>>) -> Option<Value> {
        let function = &self.module.functions[index];
        let body = function.body.as_ref()?;
        if self.calls.len() >= MOST_CALLS {
            self.report_deep(index);
            return None;
        }
        let call = self.call_of(index, &values);
        if let Some(known) = self.given_calls.get(&call) {
            return known.clone();
        }
        let value = self.inline_body(index, body, values);
        let terms = match &value {
            Some(Value::Form(terms)) => terms.len(),
            _ => 0,
        };
        if self.arena.len() > MOST_NODES || terms > MOST_TERMS {
            let outermost = self.calls.first().copied().unwrap_or(index);
            self.report_exhausted(&self.module.functions[outermost].name);
            return None;
        }
        let depth = match &value {
            Some(Value::Tensor(tensor)) => self.arena.depth(*tensor),
            Some(Value::Form(terms)) => {
                terms.iter().map(|term| self.arena.depth(term.density)).max().unwrap_or(0)
            }
            None => 0,
        };
        if depth > MOST_DEPTH {
            self.report_deep(index);
            return None;
        }
        self.given_calls.insert(call, value.clone());
        value
    }

    /// Reports, once, that functions or operations are nested too deeply.
    fn report_deep(&mut self, function: usize) {
        if !std::mem::replace(&mut self.exhausted, true) {
            let name = &self.module.functions[function].name;
            let message = format!(
                "in `{name}` more than {MOST_CALLS} calls or {MOST_DEPTH} operations stand one inside the other"
            );
            let help = "compute it in fewer steps, or in a function written in Rust";
            self.diagnostics.error_with_help(SourceSpan::of(name), message, help);
        }
    }

    fn inline_body(&mut self, index: usize, body: &Block, values: Vec<Option<Value>>) -> Option<Value> {
        let function = &self.module.functions[index];
        let names = function.arguments.iter().map(|argument| argument.name.to_string());
        let scope: Scope = names.zip(values).collect();
        self.calls.push(index);
        let value = self.block(body, &scope);
        self.calls.pop();
        let value = value?;
        match (&value, function.output) {
            (Value::Tensor(tensor), Output::Value(rank)) => {
                if self.arena.shape(*tensor) != rank.shape(self.dimension) {
                    let message = format!(
                        "`{}` is declared to give a `{}`, its body gives {}",
                        function.name,
                        rank,
                        self.describe(*tensor)
                    );
                    self.diagnostics.error(body.result.span, message);
                    return None;
                }
            }
            (Value::Form(_), Output::Form | Output::Energy | Output::Functional) => {}
            (Value::Tensor(_), _) => {
                self.diagnostics.error_with_help(
                    body.result.span,
                    format!("`{}` is declared to give integrals, its body gives a density", function.name),
                    "write `integral(Region, density)`",
                );
                return None;
            }
            (Value::Form(_), Output::Value(rank)) => {
                let message =
                    format!("`{}` is declared to give a `{}`, its body gives integrals", function.name, rank);
                self.diagnostics.error(body.result.span, message);
                return None;
            }
        }
        Some(value)
    }

    /// Reports, once, that a function unfolds to more than can be handled.
    fn report_exhausted(&mut self, name: &Ident) {
        if !std::mem::replace(&mut self.exhausted, true) {
            let (nodes, terms) = (MOST_NODES / 1_000, MOST_TERMS / 1_000);
            self.diagnostics.error_with_help(
                SourceSpan::of(name),
                format!(
                    "`{name}` unfolds to more than {nodes} thousand operations or {terms} thousand integrals: functions are inlined at each call"
                ),
                "compute what is used several times once, `let w = ..;`, and pass the name",
            );
        }
    }

    fn call_of(&self, index: usize, values: &[Option<Value>]) -> Call {
        let passed = |value: &Option<Value>| match value {
            Some(Value::Tensor(tensor)) => match self.arena.node(*tensor).operator {
                Operator::Field { field, order } => Passed::Field(field, order),
                Operator::Parameter(index) => Passed::Parameter(index),
                _ => Passed::Node(*tensor),
            },
            // Arguments are neither mistakes nor integrals.
            Some(Value::Form(_)) | None => Passed::Nothing,
        };
        Call { function: index, passed: values.iter().map(passed).collect() }
    }

    pub(super) fn block(&mut self, block: &Block, outer: &Scope) -> Option<Value> {
        let mut scope = outer.clone();
        for (name, expression) in &block.lets {
            // A value named as an operator, `let norm = norm(u)`, hides nothing: operators are called.
            if builtins::constant(&name.to_string()).is_some() {
                super::check_not_built_in(name, self.diagnostics);
            }
            let value = self.evaluate(expression, &scope).map(|value| self.name_value(name, value));
            scope.insert(name.to_string(), value);
        }
        self.evaluate(&block.result, &scope)
    }

    pub(super) fn evaluate(&mut self, expression: &Expression, scope: &Scope) -> Option<Value> {
        let span = expression.span;
        let tensor = match &expression.kind {
            ExpressionKind::Mistake => return None,
            ExpressionKind::Number(value) => self.arena.push(Operator::Number(*value), vec![], span),
            ExpressionKind::Name(name) => return self.name(name, span, scope),
            ExpressionKind::Call(name, arguments) => return self.call(name, arguments, span, scope),
            ExpressionKind::Block(block) => return self.block(block, scope),
            ExpressionKind::Negate(inner) => match self.evaluate(inner, scope)? {
                Value::Form(terms) => return Some(Value::Form(self.scale_terms(terms, None))),
                Value::Tensor(inner) => {
                    let shape = self.arena.shape(inner).to_vec();
                    self.arena.push(Operator::Negate(inner), shape, span)
                }
            },
            ExpressionKind::Declared(rank, inner) => {
                let tensor = self.tensor(inner, scope, "`let`")?;
                if self.arena.shape(tensor) != rank.shape(self.dimension) {
                    let message = format!("declared to be a `{}`, this is {}", rank, self.describe(tensor));
                    self.diagnostics.error(inner.span, message);
                    return None;
                }
                tensor
            }
            ExpressionKind::Binary(operator, left, right) => {
                let places = [left.span, right.span];
                let (left, right) = (self.evaluate(left, scope), self.evaluate(right, scope));
                match (left?, right?) {
                    (Value::Tensor(left), Value::Tensor(right)) => {
                        self.uses = [left, right].into_iter().zip(places).collect();
                        self.binary(*operator, left, right, span)?
                    }
                    (left, right) => return self.binary_form(*operator, left, right, span),
                }
            }
            ExpressionKind::Index(base, indices) => {
                let base = self.tensor(base, scope, "an index")?;
                self.index(base, indices, span)?
            }
            ExpressionKind::Array(entries) => {
                let places = entries.iter().map(|entry| entry.span);
                let values: Vec<_> =
                    entries.iter().map(|entry| self.tensor(entry, scope, "an array")).collect();
                let values = values.into_iter().collect::<Option<Vec<_>>>()?;
                self.uses = values.iter().copied().zip(places).collect();
                self.stack(values, span)?
            }
            ExpressionKind::Repeat(entry, count, counted) => {
                let value = self.tensor(entry, scope, "an array");
                let count = count.at(self.dimension).and_then(|count| usize::try_from(count).ok());
                let Some(count @ 1..=LARGEST) = count else {
                    report_extent(*counted, self.diagnostics);
                    return None;
                };
                self.stack(vec![value?; count], span)?
            }
            ExpressionKind::If(condition, taken, otherwise) => {
                let truth = self.condition(condition, scope);
                let (taken, otherwise) = (self.block(taken, scope), self.block(otherwise, scope));
                match (truth?, taken?, otherwise?) {
                    (truth, Value::Tensor(taken), Value::Tensor(otherwise)) => {
                        self.select(truth, taken, otherwise, span)?
                    }
                    _ => {
                        let help =
                            "put the `if` into the density: `integral(Region, if .. { .. } else { .. })`";
                        self.diagnostics.error_with_help(
                            span,
                            "an `if` cannot choose between integrals",
                            help,
                        );
                        return None;
                    }
                }
            }
        };
        Some(Value::Tensor(tensor))
    }

    /// An expression that must not be an integral.
    pub(super) fn tensor(&mut self, expression: &Expression, scope: &Scope, user: &str) -> Option<Tensor> {
        match self.evaluate(expression, scope)? {
            Value::Tensor(tensor) => Some(tensor),
            Value::Form(_) => {
                self.diagnostics
                    .error(expression.span, format!("{user} takes a value, this is a sum of integrals"));
                None
            }
        }
    }

    /// `if c { 0 } else { A }`: a literal zero takes the other branch's shape.
    pub(super) fn select(
        &mut self,
        truth: Truth,
        taken: Tensor,
        otherwise: Tensor,
        span: SourceSpan,
    ) -> Option<Tensor> {
        let (first, second) = (self.arena.shape(taken).to_vec(), self.arena.shape(otherwise).to_vec());
        let shape = match (self.arena.is_zero(taken), self.arena.is_zero(otherwise)) {
            _ if first == second => first,
            (true, _) => second,
            (_, true) => first,
            _ => {
                let message = format!(
                    "the two branches of `if` differ: {} and {}",
                    self.describe(taken),
                    self.describe(otherwise)
                );
                self.diagnostics.error(span, message);
                return None;
            }
        };
        let mut fit = |branch: Tensor| match self.arena.shape(branch) == shape {
            true => branch,
            false => self.arena.push(Operator::Zero, shape.clone(), span),
        };
        let (taken, otherwise) = (fit(taken), fit(otherwise));
        Some(self.arena.push(Operator::Select(truth, taken, otherwise), shape, span))
    }

    pub(super) fn condition(&mut self, condition: &Condition, scope: &Scope) -> Option<Truth> {
        Some(match condition {
            Condition::Compare(comparison, left, right) => {
                let left = self.tensor(left, scope, "a comparison");
                let right = self.tensor(right, scope, "a comparison");
                let left = left.and_then(|left| self.expect_scalar(left, "a comparison"));
                let right = right.and_then(|right| self.expect_scalar(right, "a comparison"));
                Truth::Compare(*comparison, left?, right?)
            }
            Condition::And(first, second) => {
                let (first, second) = (self.condition(first, scope), self.condition(second, scope));
                Truth::And(Box::new(first?), Box::new(second?))
            }
            Condition::Or(first, second) => {
                let (first, second) = (self.condition(first, scope), self.condition(second, scope));
                Truth::Or(Box::new(first?), Box::new(second?))
            }
            Condition::Not(inner) => Truth::Not(Box::new(self.condition(inner, scope)?)),
        })
    }
}
