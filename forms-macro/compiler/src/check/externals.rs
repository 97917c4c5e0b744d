//! Calls of what lies outside the module: functions written in Rust, tabulated laws; and histories, which have
//! no gradient.

use proc_macro2::Ident;

use super::evaluate::{Evaluator, Scope};
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::{Expression, MemberKind};
use crate::tensor::{External, Operator, Tensor};

impl Evaluator<'_> {
    /// A function declared in an `extern` block.
    pub(super) fn call_external(
        &mut self,
        index: usize,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Tensor> {
        let external = &self.module.externals[index];
        self.counted(&external.name, &external.arguments, arguments.len(), span)?;
        let values = self.shaped(&external.name, &external.arguments, arguments, scope);
        let arguments = values.into_iter().collect::<Option<Vec<_>>>()?;
        let shape = external.output.shape(self.dimension);
        let operator = Operator::External { function: External::Function(index), arguments, order: 0 };
        Some(self.arena.push(operator, shape, span))
    }

    /// The data member of this name that is a table.
    pub(super) fn table(&self, name: &Ident) -> Option<usize> {
        let mut members = self.module.members();
        members.position(|member| member.name == *name && member.kind == MemberKind::Table)
    }

    /// `law(s)`
    pub(super) fn call_table(
        &mut self,
        member: usize,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Tensor> {
        let name = self.module.members().nth(member)?.name.to_string();
        let [argument] = arguments else {
            let message = format!("the table `{name}` takes 1 argument, not {}", arguments.len());
            self.diagnostics.error_with_help(span, message, format!("write `{name}(s)`, with a scalar s"));
            return None;
        };
        let value = self.tensor(argument, scope, &format!("`{name}`"))?;
        if !self.arena.shape(value).is_empty() {
            let message =
                format!("the argument of the table `{name}` is a scalar, this is {}", self.describe(value));
            self.diagnostics.error(argument.span, message);
            return None;
        }
        let operator =
            Operator::External { function: External::Table(member), arguments: vec![value], order: 0 };
        Some(self.arena.push(operator, vec![], span))
    }

    /// A function of a square tensor that gives one of the same shape.
    pub(super) fn of_square(
        &mut self,
        a: Tensor,
        span: SourceSpan,
        name: &str,
        function: External,
    ) -> Option<Tensor> {
        let shape = self.arena.shape(a).to_vec();
        match shape[..] {
            [rows, columns] if rows == columns && rows <= LARGEST => {
                let operator = Operator::External { function, arguments: vec![a], order: 0 };
                Some(self.arena.push(operator, shape, span))
            }
            _ => {
                let message = format!("`{name}` needs a symmetric tensor, this is {}", self.describe(a));
                self.diagnostics.error(span, message);
                None
            }
        }
    }

    /// Reports the parts without a gradient of an expression whose gradient is taken.
    pub(super) fn check_gradient(&mut self, expression: Tensor, span: SourceSpan) -> Option<()> {
        if self.histories.is_empty() {
            return Some(());
        }
        let read = self.arena.reachable(&[expression]).into_iter().find_map(|node| {
            match self.arena.node(node).operator {
                Operator::Field { field, .. } if self.histories.contains(&field) => Some(field),
                _ => None,
            }
        });
        let Some(field) = read else { return Some(()) };
        let name = self.given.iter().find(|(_, (index, _))| *index == field).map(|(name, _)| name.clone());
        let message = format!(
            "the history `{}` has no gradient: it is known at quadrature points only",
            name.unwrap_or_default()
        );
        let help = "where a gradient is needed, project to a space and pass a `Given` field";
        self.diagnostics.error_with_help(span, message, help);
        None
    }
}

/// The largest tensor with spectral functions.
const LARGEST: usize = 4;
