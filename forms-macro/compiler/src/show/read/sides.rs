//! Jumps and averages across a facet, recognised in what they are made of.

use super::Reader;
use crate::show::formula::{Fence, Formula};
use crate::show::same::same;
use crate::tensor::{Operator, Side, Tensor};

impl Reader<'_> {
    /// Operand of a restriction to the other side.
    fn opposite(&self, tensor: Tensor) -> Option<Tensor> {
        match self.arena.node(tensor).operator {
            Operator::Restrict(Side::Other, a) | Operator::Opposite(a, _) => Some(a),
            _ => None,
        }
    }

    /// a⁺ − a⁻ is ⟦a⟧.
    pub(super) fn jump(&self, a: Tensor, b: Tensor) -> Option<Formula> {
        let Operator::Restrict(Side::This, this) = self.arena.node(a).operator else { return None };
        let Operator::Negate(b) = self.arena.node(b).operator else { return None };
        let other = self.opposite(b)?;
        same(self.arena, this, other).then(|| Formula::Fence(Fence::Jump, Box::new(self.read(this))))
    }

    /// ½ (a⁺ + a⁻) is {a}.
    pub(super) fn average(&self, half: Tensor, sum: Tensor) -> Option<Formula> {
        let Operator::Number(0.5) = self.arena.node(half).operator else { return None };
        let Operator::Add(a, b) = self.arena.node(sum).operator else { return None };
        let Operator::Restrict(Side::This, this) = self.arena.node(a).operator else { return None };
        let other = self.opposite(b)?;
        same(self.arena, this, other).then(|| self.read(this))
    }
}
