//! Limits from the two cells of an interior facet: `this`, `other`, `jump`, `avg`.

use super::evaluate::Evaluator;
use crate::diagnostics::SourceSpan;
use crate::tensor::{Operator, Side, Tensor};

impl Evaluator<'_> {
    /// this(e), other(e).
    pub(super) fn restrict(&mut self, side: Side, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let restricted = |node: &Tensor| {
            matches!(self.arena.node(*node).operator, Operator::Restrict(..) | Operator::Opposite(..))
        };
        if self.arena.reachable(&[a]).iter().any(restricted) {
            self.diagnostics.error_with_help(
                self.place_of(a),
                "this has a side of the facet already, and takes no second one",
                "restrict the whole, `jump(a * b)`, or each part, `jump(a) * avg(b)`",
            );
            return None;
        }
        let shape = self.arena.shape(a).to_vec();
        Some(self.arena.push(Operator::Restrict(side, a), shape, span))
    }

    /// Both limits.
    fn both_sides(&mut self, a: Tensor, span: SourceSpan) -> Option<[Tensor; 2]> {
        let this = self.restrict(Side::This, a, span)?;
        Some([this, self.restrict(Side::Other, a, span)?])
    }

    /// jump(e) = this(e) − other(e).
    pub(super) fn jump(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let [this, other] = self.both_sides(a, span)?;
        let shape = self.arena.shape(a).to_vec();
        let minus = self.arena.push(Operator::Negate(other), shape.clone(), span);
        Some(self.arena.push(Operator::Add(this, minus), shape, span))
    }

    /// jump(a, n) as in UFL: this(a n) + other(a n), with n outward on both sides. It is a vector for a
    /// scalar a; of a vector or tensor the last axis is contracted with n.
    pub(super) fn jump_along(&mut self, a: Tensor, n: Tensor, span: SourceSpan) -> Option<Tensor> {
        if self.arena.shape(n) != [self.dimension] {
            let message =
                format!("`jump(a, n)` takes a vector along which it jumps, this is {}", self.describe(n));
            self.diagnostics.error_with_help(
                self.place_of(n),
                message,
                "write `jump(a, n)` with the normal `n`",
            );
            return None;
        }
        let product = match self.arena.shape(a).len() {
            0 => self.arena.push(Operator::Scale(a, n), vec![self.dimension], span),
            _ => self.dot(a, n, span)?,
        };
        let [this, other] = self.both_sides(product, span)?;
        let shape = self.arena.shape(product).to_vec();
        Some(self.arena.push(Operator::Add(this, other), shape, span))
    }

    /// avg(e) = ½ (this(e) + other(e)).
    pub(super) fn average(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let [this, other] = self.both_sides(a, span)?;
        let shape = self.arena.shape(a).to_vec();
        let sum = self.arena.push(Operator::Add(this, other), shape.clone(), span);
        let half = self.arena.push(Operator::Number(0.5), vec![], span);
        Some(self.arena.push(Operator::Scale(half, sum), shape, span))
    }
}
