//! A function as its author wrote it: calls of the module's functions and `let`s stay names. Formulas are
//! made of this; kernels are not.

use proc_macro2::Ident;

use super::builtins::Constant;
use super::evaluate::{Evaluator, Value};
use super::{CheckedFunction, Content, fields_of};
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::syntax::*;
use crate::tensor::{Named, Operator, Tensor};

/// Evaluates a function that has been checked, with names in place of their values. Integrals are
/// those of the forms called, too. `None` if it has a mistake.
pub fn outline(module: &Module, index: usize, dimension: usize) -> Option<CheckedFunction> {
    let function = &module.functions[index];
    let fields = fields_of(module, function, dimension);
    // The mistakes have been reported.
    let mut diagnostics = Diagnostics::default();
    let mut evaluator = Evaluator::new(module, dimension, &mut diagnostics);
    evaluator.outlined = true;
    let value = evaluator.enter(index, &fields);
    let arena = evaluator.arena;
    let content = match (value?, function.output) {
        (Value::Tensor(value), Output::Value(_)) => Content::Value(value),
        (Value::Form(terms), Output::Form) => Content::Form(terms),
        (Value::Form(terms), Output::Energy) => Content::Energy(terms),
        (Value::Form(terms), Output::Functional) => Content::Functional(terms),
        _ => return None,
    };
    Some(CheckedFunction { function: index, dimension, arena, fields, content })
}

impl Evaluator<'_> {
    pub(super) fn name_call(
        &mut self,
        function: usize,
        rank: Rank,
        values: Vec<Option<Value>>,
        span: SourceSpan,
    ) -> Value {
        let arguments = values.into_iter().filter_map(|value| match value {
            Some(Value::Tensor(tensor)) => Some(tensor),
            _ => None,
        });
        let named = Named::Call { function, arguments: arguments.collect(), directions: vec![] };
        Value::Tensor(self.arena.push(Operator::Named(named), rank.shape(self.dimension), span))
    }

    /// Names the value of a `let`; another name or a number stays as it is.
    pub(super) fn name_value(&mut self, name: &Ident, value: Value) -> Value {
        let Value::Tensor(tensor) = value else { return value };
        let name = name.to_string();
        // A form called twice has two values under one name, and a name may hide another.
        if !self.outlined || self.is_leaf(tensor) || self.is_taken(&name) {
            return value;
        }
        Value::Tensor(self.label(name, tensor))
    }

    /// D and π, which are more than numbers to a reader.
    pub(super) fn name_constant(&mut self, constant: Constant, value: Tensor) -> Tensor {
        match constant {
            Constant::Dimension if self.outlined => self.label("D".into(), value),
            Constant::Pi if self.outlined => self.label("PI".into(), value),
            _ => value,
        }
    }

    fn label(&mut self, name: String, value: Tensor) -> Tensor {
        let (shape, span) = (self.arena.shape(value).to_vec(), self.arena.span(value));
        self.arena.push(Operator::Named(Named::Value { name, value }), shape, span)
    }

    fn is_leaf(&self, tensor: Tensor) -> bool {
        self.arena.node(tensor).operator.operands().is_empty()
            || matches!(self.arena.node(tensor).operator, Operator::Named(Named::Value { .. }))
    }

    fn is_taken(&self, name: &str) -> bool {
        let arguments = self.calls.iter().flat_map(|call| &self.module.functions[*call].arguments);
        let members = self.module.members();
        arguments
            .map(|argument| &argument.name)
            .chain(members.map(|member| &member.name))
            .any(|other| other == name)
            || self.arena.names().any(|other| other == name)
    }
}
