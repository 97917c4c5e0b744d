//! Resolution of names: a local, a datum, geometry; and the message for one that is not known.

use proc_macro2::Ident;

use super::builtins::{self, Constant};
use super::elsewhere;
use super::evaluate::{Evaluator, Scope, Value};
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::{Expression, ExpressionKind, MemberKind};
use crate::tensor::{Geometry, Operator, Tensor};

impl Evaluator<'_> {
    pub(super) fn name(&mut self, name: &Ident, span: SourceSpan, scope: &Scope) -> Option<Value> {
        let text = name.to_string();
        if let Some(value) = scope.get(&text) {
            // A field is a field wherever it is named: mistakes are reported where it is used.
            if let Some(Value::Tensor(tensor)) = value {
                let node = self.arena.node(*tensor).clone();
                if matches!(node.operator, Operator::Field { order: 0, .. } | Operator::Parameter(_)) {
                    return Some(Value::Tensor(self.arena.push(node.operator, node.shape, span)));
                }
            }
            return value.clone();
        }
        // A member of that name in a module with pairs is a mistake, which has been reported.
        let of_pairs = builtins::of_pairs(&text);
        if let (Some(of_pairs), true) = (of_pairs, self.module.has_pairs()) {
            return Some(Value::Tensor(self.of_pairs(of_pairs, span)));
        }
        if let Some((field, shape)) = self.given.get(&text).cloned() {
            let operator = Operator::Field { field, order: 0 };
            return Some(Value::Tensor(self.arena.push(operator, shape, span)));
        }
        let members = self.module.members();
        if let Some((index, member)) = members.enumerate().find(|(_, member)| member.name == *name) {
            if member.kind == MemberKind::Table {
                let help = format!("write `{text}(s)`, with a scalar s");
                self.diagnostics.error_with_help(span, format!("`{text}` is a table, not a value"), help);
                return None;
            }
            let shape = member.rank.shape(self.dimension);
            return Some(Value::Tensor(self.arena.push(Operator::Parameter(index), shape, span)));
        }
        if let Some(of_pairs) = of_pairs {
            return Some(Value::Tensor(self.of_pairs(of_pairs, span)));
        }
        if let Some(constant) = builtins::constant(&text) {
            let d = self.dimension;
            let (operator, shape) = match constant {
                Constant::Shape => {
                    self.diagnostics.error_with_help(
                        span,
                        "`shape` is the shape of the domain, not a value",
                        "write `derivative(form, shape, direction)` with a vector field as direction",
                    );
                    return None;
                }
                Constant::Geometry(geometry) => (Operator::Geometry(geometry), geometry.shape(d)),
                Constant::Identity => (Operator::Identity, vec![d, d]),
                Constant::TensorIdentity => (Operator::Identity, vec![d; 4]),
                Constant::SymmetricIdentity => (Operator::SymmetricIdentity, vec![d; 4]),
                Constant::Dimension => (Operator::Number(d as f64), vec![]),
                Constant::Pi => (Operator::Number(std::f64::consts::PI), vec![]),
            };
            let value = self.arena.push(operator, shape, span);
            return Some(Value::Tensor(self.name_constant(constant, value)));
        }
        if !self.module.is_mistaken(name) {
            self.unknown_name(name, span, scope);
        }
        None
    }

    /// A quantity of a contact pair as a tensor.
    fn of_pairs(&mut self, geometry: Geometry, span: SourceSpan) -> Tensor {
        let shape = geometry.shape(self.dimension);
        self.arena.push(Operator::Geometry(geometry), shape, span)
    }

    pub(super) fn unknown_name(&mut self, name: &Ident, span: SourceSpan, scope: &Scope) {
        let text = name.to_string();
        if text.contains('·') {
            let help = format!("write `dot({})`", text.replace('·', ", "));
            self.diagnostics.error_with_help(
                span,
                format!("`{text}` is one identifier to Rust, not a product"),
                help,
            );
        } else if self.module.regions.iter().any(|region| region.name == *name) {
            let help = format!("write `integral({text}, density)`");
            self.diagnostics.error_with_help(span, format!("`{text}` is a region, not a value"), help);
        } else if builtins::builtin(&text).is_some()
            || self.function(name).is_some()
            || self.module.externals.iter().any(|external| external.name == *name)
        {
            self.diagnostics.error_with_help(
                span,
                format!("`{text}` is a function, not a value"),
                format!("write `{text}(..)`"),
            );
        } else {
            let members = self.module.members().map(|member| member.name.to_string());
            let own: Vec<String> = scope.keys().cloned().chain(members).collect();
            let of_pairs = builtins::OF_PAIRS.iter().map(|entry| entry.0);
            let built_in = builtins::CONSTANTS.iter().map(|entry| entry.0).chain(of_pairs);
            let message = format!("the name `{text}` is not known here");
            let help = suggestion(&text, &own, built_in).unwrap_or_else(|| {
                "arguments, `let` names, members of the data struct and built-in names are known".into()
            });
            self.diagnostics.error_with_help(span, message, help);
        }
    }

    pub(super) fn function(&self, name: &Ident) -> Option<usize> {
        self.module.functions.iter().position(|function| function.name == *name)
    }

    pub(super) fn unknown_function(
        &mut self,
        name: &Ident,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) {
        let text = name.to_string();
        let member = self.module.members().find(|one| one.name == *name);
        if scope.contains_key(&text) || member.is_some() || builtins::constant(&text).is_some() {
            // The contents of the parentheses may be the mistake, which has been reported.
            if !arguments.iter().any(|argument| matches!(argument.kind, ExpressionKind::Mistake)) {
                let member = member.filter(|_| !scope.contains_key(&text)).map(|member| member.kind);
                self.called_value(name, member, arguments, scope);
            }
            return;
        }
        if self.module.regions.iter().any(|region| region.name == *name) {
            let help = format!("write `integral({text}, density)`");
            self.diagnostics.error_with_help(span, format!("`{text}` is a region, not a function"), help);
            return;
        }
        let tables = self.module.members();
        let tables = tables.filter(|member| member.kind == MemberKind::Table).map(|member| &member.name);
        let externals = self.module.externals.iter().map(|external| &external.name);
        let functions = self.module.functions.iter().map(|function| &function.name);
        let own: Vec<String> = functions.chain(externals).chain(tables).map(ToString::to_string).collect();
        let built_in = builtins::BUILTINS.iter().map(|entry| entry.0);
        let message = format!("the function `{name}` is not known here");
        let help = suggestion(&text, &own, built_in)
            .unwrap_or_else(|| format!("declare `fn {name}(..)` in this module"));
        self.diagnostics.error_with_help(SourceSpan::of(name), message, help);
    }

    /// Reports parentheses after what is a value: `gap(x + u)`, `u(0)`, `k (a + b)`.
    fn called_value(
        &mut self,
        name: &Ident,
        member: Option<MemberKind>,
        arguments: &[Expression],
        scope: &Scope,
    ) {
        let number = |argument: &Expression| match argument.kind {
            ExpressionKind::Number(value) => Some(value),
            _ => None,
        };
        let numbers: Option<Vec<f64>> = arguments.iter().map(number).collect();
        let axes = match self.name(name, SourceSpan::of(name), scope) {
            Some(Value::Tensor(value)) => self.arena.shape(value).len(),
            Some(Value::Form(_)) => 0,
            // Its own mistake has been reported.
            None => return,
        };
        let help = match (numbers, member) {
            (Some(numbers), _) if !numbers.is_empty() && numbers.len() <= axes => {
                let indices: String = numbers.iter().map(|number| format!("[{number}]")).collect();
                format!("a component is `{name}{indices}`, and components are counted from 0")
            }
            (None, Some(MemberKind::Given | MemberKind::Carried | MemberKind::History)) => format!(
                "the data are read where the integral is: write `{name}`; what is to be evaluated elsewhere is a function written in Rust, `extern \"Rust\" {{ fn {name}(y: Vector) -> Scalar; }}`"
            ),
            _ if arguments.is_empty() => format!("write `{name}`"),
            _ => format!("write `{name} * (..)` for a product"),
        };
        self.diagnostics.error_with_help(
            SourceSpan::of(name),
            format!("`{name}` is a value, not a function"),
            help,
        );
    }
}

/// The help line for a name that is not known: a name that was meant, or what another language calls so.
fn suggestion<'a>(
    text: &str,
    own: &'a [String],
    built_in: impl Iterator<Item = &'a str> + Clone,
) -> Option<String> {
    let own = || own.iter().map(String::as_str);
    let did_you_mean = |name: &str| format!("did you mean `{name}`?");
    let folded = text.to_lowercase();
    let in_other_case = own().chain(built_in.clone()).find(|known| known.to_lowercase() == folded);
    // Short words are close to every other word.
    let near_own = || builtins::nearest(text, own());
    in_other_case
        .or_else(|| near_own().filter(|_| text.chars().count() > SHORT))
        .map(did_you_mean)
        .or_else(|| elsewhere::help(text).map(str::to_string))
        .or_else(|| builtins::nearest(text, own().chain(built_in)).map(did_you_mean))
}

/// Words of other languages that are no longer than this are taken at their word.
const SHORT: usize = 3;
