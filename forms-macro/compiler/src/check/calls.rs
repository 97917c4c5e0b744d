//! Calls: of built-in operators, and of the module's own functions, which are inlined.

use proc_macro2::Ident;

use super::builtins::{self, Builtin};
use super::evaluate::{Evaluator, Scope, Value};
use super::operators::describe;
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::*;
use crate::tensor::{Operator, Tensor};

impl Evaluator<'_> {
    pub(super) fn call(
        &mut self,
        name: &Ident,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Value> {
        let text = name.to_string();
        if let Some(index) = self.function(name) {
            return self.call_function(index, name, arguments, span, scope);
        }
        if let Some(index) = self.module.externals.iter().position(|external| external.name == *name) {
            return self.call_external(index, arguments, span, scope).map(Value::Tensor);
        }
        if let Some(index) = self.table(name) {
            return self.call_table(index, arguments, span, scope).map(Value::Tensor);
        }
        let Some((builtin, count, usage)) = builtins::builtin(&text) else {
            if !self.module.is_mistaken(name) {
                self.unknown_function(name, arguments, span, scope);
            }
            return None;
        };
        if builtin == Builtin::Integral && arguments.len() == 1 {
            let help = match self.module.regions.first() {
                Some(region) => format!("write `integral({}, density)`", region.name),
                None => "declare `#[cells] pub struct Omega;` and write `integral(Omega, density)`".into(),
            };
            self.diagnostics.error_with_help(span, "this integral has no region", help);
            return None;
        }
        let normal_jump = builtin == Builtin::Jump && arguments.len() == 2;
        if arguments.len() != count && !normal_jump {
            let expected = match (builtin, count) {
                (Builtin::Jump, _) => "1 or 2 arguments".into(),
                (_, 1) => "1 argument".into(),
                _ => format!("{count} arguments"),
            };
            let message = format!("`{text}` takes {expected}, not {}", arguments.len());
            self.diagnostics.error_with_help(span, message, format!("write `{usage}`"));
            return None;
        }
        match builtin {
            Builtin::Integral => return self.integral(&arguments[0], &arguments[1], None, scope),
            Builtin::Means => return self.means(arguments, scope),
            Builtin::Derivative => return self.derivative(arguments, span, scope),
            Builtin::Partial => return self.partial(arguments, span, scope).map(Value::Tensor),
            Builtin::Identity => return self.identity_of_size(&arguments[0], span).map(Value::Tensor),
            _ => {}
        }
        let values: Vec<_> =
            arguments.iter().map(|argument| self.tensor(argument, scope, &format!("`{text}`"))).collect();
        let values = values.into_iter().collect::<Option<Vec<_>>>()?;
        self.uses = values.iter().copied().zip(arguments.iter().map(|argument| argument.span)).collect();
        let a = values[0];
        let tensor = match builtin {
            Builtin::Dot => self.dot(a, values[1], span)?,
            Builtin::DoubleDot => self.double_dot(a, values[1], span)?,
            Builtin::Cross => self.cross(a, values[1], span)?,
            Builtin::Inner => self.inner(a, values[1], span)?,
            Builtin::Outer => self.outer(a, values[1], span)?,
            Builtin::Norm => self.norm(a, span),
            Builtin::Normalize => self.normalize(a, span),
            Builtin::Diagonal => self.diagonal(a, span)?,
            Builtin::Perpendicular => self.perpendicular(a, span)?,
            Builtin::Map(map) => self.of_tensor(a, span, &text, |a| Operator::Map(map, a))?,
            Builtin::Determinant => self.of_tensor(a, span, &text, Operator::Determinant)?,
            Builtin::Inverse => self.of_tensor(a, span, &text, Operator::Inverse)?,
            Builtin::Cofactor => self.of_tensor(a, span, &text, Operator::Cofactor)?,
            Builtin::External(function) => self.of_square(a, span, &text, function)?,
            Builtin::Gradient => self.gradient(a, span)?,
            Builtin::Hessian => self.hessian(a, span)?,
            Builtin::Restrict(side) => self.restrict(side, a, span)?,
            Builtin::Jump if normal_jump => self.jump_along(a, values[1], span)?,
            Builtin::Jump => self.jump(a, span)?,
            Builtin::Average => self.average(a, span)?,
            Builtin::CellMean => {
                let shape = self.arena.shape(a).to_vec();
                self.arena.push(Operator::CellMean(a), shape, span)
            }
            Builtin::Divergence => self.divergence(a, span)?,
            Builtin::Strain => self.strain(a, span)?,
            Builtin::Curl => self.curl(a, span)?,
            Builtin::Apply(function) => {
                let a = self.expect_scalar(a, &text)?;
                self.arena.push(Operator::Apply(function, a), vec![], span)
            }
            Builtin::Square => {
                let a = self.expect_scalar(a, &text)?;
                let two = self.arena.push(Operator::Number(2.0), vec![], span);
                self.arena.push(Operator::Power(a, two), vec![], span)
            }
            Builtin::Power | Builtin::Minimum | Builtin::Maximum | Builtin::Atan2 | Builtin::Hypotenuse => {
                let (a, b) = (self.expect_scalar(a, &text), self.expect_scalar(values[1], &text));
                let (a, b) = (a?, b?);
                let operator = match builtin {
                    Builtin::Hypotenuse => return Some(Value::Tensor(self.hypotenuse(a, b, span))),
                    Builtin::Atan2 => Operator::Atan2(a, b),
                    Builtin::Power => Operator::Power(a, b),
                    Builtin::Minimum => Operator::Minimum(a, b),
                    _ => Operator::Maximum(a, b),
                };
                self.arena.push(operator, vec![], span)
            }
            Builtin::Integral
            | Builtin::Means
            | Builtin::Derivative
            | Builtin::Partial
            | Builtin::Identity => return None,
        };
        Some(Value::Tensor(tensor))
    }

    pub(super) fn call_function(
        &mut self,
        index: usize,
        name: &Ident,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Value> {
        // One report is enough, and the rest of the walk must end.
        if self.exhausted {
            return None;
        }
        let function = &self.module.functions[index];
        if self.calls.contains(&index) {
            let message = match self.calls.last() {
                Some(last) if *last == index => {
                    format!("`{name}` calls itself: a weak form cannot be recursive")
                }
                _ => format!("`{name}` is being computed already: a weak form cannot be recursive"),
            };
            let help = "a function may only call functions that do not lead back to it";
            self.diagnostics.error_with_help(span, message, help);
            return None;
        }
        self.counted(name, &function.arguments, arguments.len(), span)?;
        let values = self.shaped(name, &function.arguments, arguments, scope);
        // A mistake in an argument has been reported; the call itself gives nothing.
        if values.iter().any(Option::is_none) {
            return None;
        }
        let values: Vec<_> = values.into_iter().map(|value| value.map(Value::Tensor)).collect();
        if let (true, Output::Value(rank)) = (self.outlined, function.output) {
            return Some(self.name_call(index, rank, values, span));
        }
        match &function.foreign {
            Some(foreign) if !self.diagnostics.is_inside() => {
                self.inline_foreign(index, foreign, values, span)
            }
            _ => self.inline(index, values),
        }
    }

    /// Reports a wrong number of arguments.
    pub(super) fn counted(
        &mut self,
        name: &Ident,
        declared: &[Argument],
        found: usize,
        span: SourceSpan,
    ) -> Option<()> {
        let expected = declared.len();
        if found == expected {
            return Some(());
        }
        let list: Vec<String> = declared.iter().map(|argument| argument.name.to_string()).collect();
        let message = format!(
            "`{name}` takes {expected} argument{}, not {found}",
            if expected == 1 { "" } else { "s" },
        );
        self.diagnostics.error_with_help(span, message, format!("write `{name}({})`", list.join(", ")));
        None
    }

    /// The arguments of a call, each of its declared shape; `None` after a report.
    pub(super) fn shaped(
        &mut self,
        name: &Ident,
        declared: &[Argument],
        arguments: &[Expression],
        scope: &Scope,
    ) -> Vec<Option<Tensor>> {
        let mut values = Vec::new();
        for (expression, argument) in arguments.iter().zip(declared) {
            let value = self.tensor(expression, scope, &format!("`{name}`"));
            values.push(value.and_then(|value| {
                let shape = argument.rank.shape(self.dimension);
                if self.arena.shape(value) == shape {
                    return Some(value);
                }
                let message = format!(
                    "the argument `{}` of `{name}` is {}, this is {}",
                    argument.name,
                    describe(&shape, self.dimension),
                    self.describe(value)
                );
                self.diagnostics.error(expression.span, message);
                None
            }));
        }
        values
    }

    /// Inlines an imported function: its own tokens are in another module, so the call is the span of all its nodes.
    pub(super) fn inline_foreign(
        &mut self,
        index: usize,
        foreign: &Foreign,
        values: Vec<Option<Value>>,
        span: SourceSpan,
    ) -> Option<Value> {
        let before = self.arena.len();
        let span = self.diagnostics.enter(span, &foreign.origin, foreign.silent);
        let value = self.inline(index, values);
        self.diagnostics.leave();
        self.arena.move_to(before, span);
        value
    }
}
