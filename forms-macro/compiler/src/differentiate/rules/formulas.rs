//! The rules of what only formulas hold: partial derivatives, names, and derivatives that are not carried out.

use super::{Differentiation, Seed};
use crate::tensor::{Named, Operator, Tensor, Variable};

impl Differentiation<'_> {
    /// d (∂e/∂w) = ∂(de)/∂w, where dw is held fixed.
    pub(super) fn partial(
        &mut self,
        tensor: Tensor,
        expression: Tensor,
        variable: Variable,
    ) -> Option<Tensor> {
        let change = self.derive(expression)?;
        if let Variable::Node(node) = variable
            && let Some(direction) = self.derive(node)
            && self.arena.reachable(&[direction]).contains(&node)
        {
            return self.postponed(tensor);
        }
        let shape = self.arena.shape(tensor).to_vec();
        Some(self.push(Operator::Partial(change, variable), shape, tensor))
    }

    /// The derivative, not carried out.
    pub(super) fn postponed(&mut self, tensor: Tensor) -> Option<Tensor> {
        let Seed::Toward { variable, direction, .. } = self.seed else { return None };
        let varies = self.arena.reachable(&[tensor]).into_iter().any(|node| match variable {
            Variable::Field(varied) => {
                matches!(self.arena.node(node).operator, Operator::Field { field, .. } if field == varied)
            }
            Variable::Parameter(varied) => {
                matches!(self.arena.node(node).operator, Operator::Parameter(index) if index == varied)
            }
            Variable::Node(varied) => node == varied,
            Variable::Shape(_) => true,
            Variable::Size(varied) => {
                matches!(self.arena.node(node).operator, Operator::Geometry(size) if size == varied)
            }
        });
        let shape = self.arena.shape(tensor).to_vec();
        let operator = Operator::Gateaux { expression: tensor, variable, direction };
        varies.then(|| self.push(operator, shape, tensor))
    }

    /// Chain rule for the k-th derivative of a function, which is linear in each of its k directions:
    /// d (Dᵏf(a)[b, …]) = Dᵏ⁺¹f(a)[b, …, da] + Dᵏf(a)[db, …] + …
    pub(super) fn named(&mut self, tensor: Tensor, named: Named) -> Option<Tensor> {
        let (function, arguments, directions) = match named {
            Named::Value { value, .. } => return self.derive(value),
            Named::Call { function, arguments, directions } => (function, arguments, directions),
        };
        let shape = self.arena.shape(tensor).to_vec();
        let mut sum = None;
        for row in 0..=directions.len() {
            let varied = directions.get(row).unwrap_or(&arguments);
            let change: Vec<_> = varied.iter().map(|one| self.derive(*one)).collect();
            if change.iter().all(Option::is_none) {
                continue;
            }
            let varied = varied.clone();
            let change = varied.into_iter().zip(change).map(|(one, change)| {
                let shape = self.arena.shape(one).to_vec();
                change.unwrap_or_else(|| self.push(Operator::Zero, shape, one))
            });
            let change: Vec<_> = change.collect();
            let mut directions = directions.clone();
            match directions.get_mut(row) {
                Some(direction) => *direction = change,
                None => directions.push(change),
            }
            let named = Named::Call { function, arguments: arguments.clone(), directions };
            let one = self.push(Operator::Named(named), shape.clone(), tensor);
            sum = self.sum(sum, Some(one));
        }
        sum
    }
}
