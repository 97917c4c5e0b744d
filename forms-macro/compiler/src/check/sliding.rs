//! Pairs of displaced surfaces, `integral(Touch(u), density)`: their opposite points depend on the displacement.

use std::collections::HashMap;

use proc_macro2::Ident;

use super::evaluate::{Evaluator, Scope};
use crate::diagnostics::SourceSpan;
use crate::differentiate::map_operands;
use crate::parse::syntax::{Entity, Expression, ExpressionKind, Region};
use crate::tensor::{Operator, Side, Tensor, Variable};

/// The name of a region and the displacement of its surfaces: `Touch(u)`, or a name alone.
pub(super) fn displaced(region: &Expression) -> (Option<&Ident>, Option<&Expression>) {
    match &region.kind {
        ExpressionKind::Name(name) => (Some(name), None),
        ExpressionKind::Call(name, arguments) if arguments.len() == 1 => (Some(name), Some(&arguments[0])),
        _ => (None, None),
    }
}

impl Evaluator<'_> {
    /// The displacement of sliding pairs, and the fields that it is the sum of.
    pub(super) fn displacement(
        &mut self,
        displacement: &Expression,
        region: &Region,
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<(Tensor, Vec<usize>)> {
        let tensor = self.tensor(displacement, scope, "the displacement of contact pairs")?;
        if region.entity != Entity::Pairs {
            let Region { name, entity, .. } = region;
            self.diagnostics.error_with_help(
                span,
                format!("only contact pairs are displaced, and `{name}` consists of {}", entity.plural()),
                format!("write `integral({name}, density)`, or declare `{name}` as `#[pairs]`"),
            );
            return None;
        }
        let mut fields = Vec::new();
        if !self.sum_of_fields(tensor, &mut fields) {
            self.diagnostics.error_with_help(
                displacement.span,
                "the surfaces of contact pairs are displaced by a vector field, or by a sum of different ones",
                "name unknowns, states or data: `Touch(u)`, `Touch(u + w)`",
            );
            return None;
        }
        fields.sort_unstable();
        Some((tensor, fields))
    }

    fn sum_of_fields(&self, tensor: Tensor, fields: &mut Vec<usize>) -> bool {
        let node = self.arena.node(tensor);
        match node.operator {
            Operator::Add(a, b) => self.sum_of_fields(a, fields) && self.sum_of_fields(b, fields),
            Operator::Field { field, order: 0 } if node.shape == [self.dimension] => {
                let new = !fields.contains(&field);
                fields.push(field);
                new && !self.histories.contains(&field)
            }
            _ => false,
        }
    }

    /// The density with everything that belongs to the opposite point made dependent on a displacement.
    pub(super) fn slide(&mut self, density: Tensor, displacement: Tensor) -> Tensor {
        let mut slid: HashMap<Tensor, Tensor> = HashMap::new();
        let now = |slid: &HashMap<Tensor, Tensor>, one: Tensor| slid.get(&one).copied().unwrap_or(one);
        for tensor in self.arena.reachable(&[density]) {
            let node = self.arena.node(tensor).clone();
            let mut operator = map_operands(&node.operator, &mut |operand| now(&slid, operand));
            let mut changed = node.operator.operands() != operator.operands();
            match &mut operator {
                Operator::Partial(_, Variable::Node(varied))
                | Operator::Gateaux { variable: Variable::Node(varied), .. } => *varied = now(&slid, *varied),
                _ => {}
            }
            match operator {
                Operator::Restrict(Side::Other, a) => {
                    (operator, changed) = (Operator::Opposite(a, displacement), true);
                }
                Operator::Geometry(geometry) if geometry.is_of_pairs() => {
                    (operator, changed) = (Operator::Sliding(geometry, displacement), true);
                }
                _ => {}
            }
            if changed {
                slid.insert(tensor, self.arena.push(operator, node.shape, node.span));
            }
        }
        now(&slid, density)
    }
}
