//! What a name stands for: a local, a datum, geometry; and what to say of one that is not known.

use proc_macro2::Ident;

use super::builtins::{self, Constant};
use super::evaluate::{Evaluator, Scope, Value};
use crate::diagnostics::Place;
use crate::parse::syntax::MemberKind;
use crate::tensor::{Geometry, Operator};

impl Evaluator<'_> {
    pub(super) fn name(&mut self, name: &Ident, place: Place, scope: &Scope) -> Option<Value> {
        let text = name.to_string();
        if let Some(value) = scope.get(&text) {
            // A field is a field wherever it is named: mistakes are told where it is used.
            if let Some(Value::Tensor(tensor)) = value {
                let node = self.arena.node(*tensor).clone();
                if matches!(node.operator, Operator::Field { order: 0, .. } | Operator::Parameter(_)) {
                    return Some(Value::Tensor(self.arena.push(node.operator, node.shape, place)));
                }
            }
            return value.clone();
        }
        if let Some((field, shape)) = self.given.get(&text).cloned() {
            let operator = Operator::Field { field, order: 0 };
            return Some(Value::Tensor(self.arena.push(operator, shape, place)));
        }
        let members = self.module.data.iter().flat_map(|data| &data.members);
        if let Some((index, member)) = members.enumerate().find(|(_, member)| member.name == *name) {
            if member.kind == MemberKind::Table {
                let help = format!("write `{text}(s)`, with a scalar s");
                self.diagnostics.error_with_help(place, format!("`{text}` is a table, not a value"), help);
                return None;
            }
            let shape = member.rank.shape(self.dimension);
            return Some(Value::Tensor(self.arena.push(Operator::Parameter(index), shape, place)));
        }
        if let Some(constant) = builtins::constant(&text) {
            let d = self.dimension;
            let (operator, shape) = match constant {
                Constant::Shape => {
                    self.diagnostics.error_with_help(
                        place,
                        "`shape` is the shape of the domain, not a value",
                        "write `derivative(form, shape, direction)` with a vector field as direction",
                    );
                    return None;
                }
                Constant::Geometry(geometry) => {
                    let vector = matches!(geometry, Geometry::Normal | Geometry::Position);
                    (Operator::Geometry(geometry), if vector { vec![d] } else { vec![] })
                }
                Constant::Identity => (Operator::Identity, vec![d, d]),
                Constant::TensorIdentity => (Operator::Identity, vec![d; 4]),
                Constant::SymmetricIdentity => (Operator::SymmetricIdentity, vec![d; 4]),
                Constant::Dimension => (Operator::Number(d as f64), vec![]),
                Constant::Pi => (Operator::Number(std::f64::consts::PI), vec![]),
            };
            let value = self.arena.push(operator, shape, place);
            return Some(Value::Tensor(self.name_constant(constant, value)));
        }
        if !self.module.is_mistaken(name) {
            self.unknown_name(name, place, scope);
        }
        None
    }

    pub(super) fn unknown_name(&mut self, name: &Ident, place: Place, scope: &Scope) {
        let text = name.to_string();
        if text.contains('·') {
            let help = format!("write `dot({})`", text.replace('·', ", "));
            self.diagnostics.error_with_help(
                place,
                format!("`{text}` is one identifier to Rust, not a product"),
                help,
            );
        } else if self.module.regions.iter().any(|region| region.name == *name) {
            let help = format!("write `integral({text}, density)`");
            self.diagnostics.error_with_help(place, format!("`{text}` is a region, not a value"), help);
        } else if builtins::builtin(&text).is_some()
            || self.function(name).is_some()
            || self.module.externals.iter().any(|external| external.name == *name)
        {
            self.diagnostics.error_with_help(
                place,
                format!("`{text}` is a function, not a value"),
                format!("write `{text}(..)`"),
            );
        } else {
            let members =
                self.module.data.iter().flat_map(|data| &data.members).map(|member| member.name.to_string());
            let known: Vec<String> = scope
                .keys()
                .cloned()
                .chain(members)
                .chain(builtins::CONSTANTS.iter().map(|entry| entry.0.to_string()))
                .collect();
            let message = format!("the name `{text}` is not known here");
            match builtins::nearest(&text, known.iter().map(String::as_str)) {
                Some(near) => {
                    self.diagnostics.error_with_help(place, message, format!("did you mean `{near}`?"))
                }
                None => {
                    let help =
                        "arguments, `let` names, members of the data struct and built-in names are known";
                    self.diagnostics.error_with_help(place, message, help);
                }
            }
        }
    }

    pub(super) fn function(&self, name: &Ident) -> Option<usize> {
        self.module.functions.iter().position(|function| function.name == *name)
    }

    pub(super) fn unknown_function(&mut self, name: &Ident) {
        let tables = self.module.data.iter().flat_map(|data| &data.members);
        let tables = tables.filter(|member| member.kind == MemberKind::Table).map(|member| &member.name);
        let externals = self.module.externals.iter().map(|external| &external.name);
        let functions = self.module.functions.iter().map(|function| &function.name);
        let functions: Vec<String> =
            functions.chain(externals).chain(tables).map(ToString::to_string).collect();
        let known =
            functions.iter().map(String::as_str).chain(builtins::BUILTINS.iter().map(|entry| entry.0));
        let message = format!("the function `{name}` is not known here");
        match builtins::nearest(&name.to_string(), known) {
            Some(near) => {
                self.diagnostics.error_with_help(Place::of(name), message, format!("did you mean `{near}`?"))
            }
            None => {
                let help = format!("declare `fn {name}(..)` in this module");
                self.diagnostics.error_with_help(Place::of(name), message, help);
            }
        }
    }
}
