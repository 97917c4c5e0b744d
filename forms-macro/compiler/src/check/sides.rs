//! Limits from the two cells of an interior facet: `this`, `other`, `jump`, `avg`.

use super::evaluate::Evaluator;
use crate::diagnostics::Place;
use crate::tensor::{Operator, Side, Tensor};

impl Evaluator<'_> {
    /// this(e), other(e).
    pub(super) fn restrict(&mut self, side: Side, a: Tensor, place: Place) -> Option<Tensor> {
        let restricted = |node: &Tensor| matches!(self.arena.node(*node).operator, Operator::Restrict(..));
        if self.arena.reachable(&[a]).iter().any(restricted) {
            self.diagnostics.error_with_help(
                self.place_of(a),
                "this has a side of the facet already, and takes no second one",
                "restrict the whole, `jump(a * b)`, or each part, `jump(a) * avg(b)`",
            );
            return None;
        }
        let shape = self.arena.shape(a).to_vec();
        Some(self.arena.push(Operator::Restrict(side, a), shape, place))
    }

    /// Both limits.
    fn both_sides(&mut self, a: Tensor, place: Place) -> Option<[Tensor; 2]> {
        let this = self.restrict(Side::This, a, place)?;
        Some([this, self.restrict(Side::Other, a, place)?])
    }

    /// jump(e) = this(e) − other(e).
    pub(super) fn jump(&mut self, a: Tensor, place: Place) -> Option<Tensor> {
        let [this, other] = self.both_sides(a, place)?;
        let shape = self.arena.shape(a).to_vec();
        let minus = self.arena.push(Operator::Negate(other), shape.clone(), place);
        Some(self.arena.push(Operator::Add(this, minus), shape, place))
    }

    /// jump(a, n) as in UFL: this(a n) + other(a n), with n outward on both sides. It is a vector for a
    /// scalar a; of a vector or tensor the last axis is contracted with n.
    pub(super) fn jump_along(&mut self, a: Tensor, n: Tensor, place: Place) -> Option<Tensor> {
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
            0 => self.arena.push(Operator::Scale(a, n), vec![self.dimension], place),
            _ => self.dot(a, n, place)?,
        };
        let [this, other] = self.both_sides(product, place)?;
        let shape = self.arena.shape(product).to_vec();
        Some(self.arena.push(Operator::Add(this, other), shape, place))
    }

    /// avg(e) = ½ (this(e) + other(e)).
    pub(super) fn average(&mut self, a: Tensor, place: Place) -> Option<Tensor> {
        let [this, other] = self.both_sides(a, place)?;
        let shape = self.arena.shape(a).to_vec();
        let sum = self.arena.push(Operator::Add(this, other), shape.clone(), place);
        let half = self.arena.push(Operator::Number(0.5), vec![], place);
        Some(self.arena.push(Operator::Scale(half, sum), shape, place))
    }
}
