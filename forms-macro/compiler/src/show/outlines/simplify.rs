//! Simplification of derivatives before they are shown: zeros and ones vanish, signs and numbers come to
//! the front, equal terms join, and the derivative of a linear function is the function itself.

mod calls;

use std::collections::HashMap;

use super::{Outlines, gradient};
use crate::differentiate::map_operands;
use crate::show::same::Comparison;
use crate::tensor::{Arena, FieldInfo, Function, Named, Operator, Tensor, Variable};

/// Rewrites the nodes of one arena, each once.
pub struct Simplifier<'o, 'm> {
    outlines: &'o mut Outlines<'m>,
    arena: &'o mut Arena,
    /// The fields of the arena.
    fields: &'o [FieldInfo],
    known: HashMap<Tensor, Tensor>,
    comparison: Comparison,
}

impl<'o, 'm> Simplifier<'o, 'm> {
    pub fn new(outlines: &'o mut Outlines<'m>, arena: &'o mut Arena, fields: &'o [FieldInfo]) -> Self {
        Simplifier { outlines, arena, fields, known: HashMap::new(), comparison: Comparison::default() }
    }

    /// An equal expression, shorter.
    pub fn simplify(&mut self, tensor: Tensor) -> Tensor {
        if let Some(known) = self.known.get(&tensor) {
            return *known;
        }
        let node = self.arena.node(tensor).clone();
        // A name stays, with what was written for it, unless it is nothing.
        if let Operator::Named(Named::Value { value, .. }) = node.operator {
            let value = self.simplify(value);
            let simplified = if self.arena.is_zero(value) { value } else { tensor };
            self.known.insert(tensor, simplified);
            return simplified;
        }
        let mut changed = false;
        let mut change = |operand: Tensor| {
            let new = self.simplify(operand);
            changed |= new != operand;
            new
        };
        let mut operator = map_operands(&node.operator, &mut change);
        match &mut operator {
            Operator::Partial(_, Variable::Node(variable))
            | Operator::Gateaux { variable: Variable::Node(variable), .. } => *variable = change(*variable),
            _ => {}
        }
        let simplified = match self.rewrite(&operator, &node.shape, tensor) {
            Some(rewritten) => rewritten,
            None if changed => self.push(operator, node.shape, tensor),
            None => tensor,
        };
        self.known.insert(tensor, simplified);
        simplified
    }

    /// The rewritten node; `None` if it stays as it is.
    fn rewrite(&mut self, operator: &Operator, shape: &[usize], origin: Tensor) -> Option<Tensor> {
        use Operator::*;
        let is_zero = |this: &Self, one: Tensor| this.arena.is_zero(one);
        let zero = |this: &mut Self| Some(this.zero(shape, origin));
        match operator {
            Add(a, b) => self.add(*a, *b, shape, origin),
            Negate(a) if is_zero(self, *a) => zero(self),
            Negate(a) => match self.arena.node(*a).operator {
                Negate(inner) => Some(inner),
                Number(value) => Some(self.push(Number(-value), vec![], origin)),
                _ => None,
            },
            Scale(a, b) => self.product(*a, *b, shape, origin),
            Divide(a, _) if is_zero(self, *a) => zero(self),
            Divide(a, b) => match (self.arena.node(*a).operator.clone(), self.number(*b)) {
                (_, Some(1.0)) => Some(*a),
                (Divide(inner, first), None) => {
                    let under = match self.comparison.are_same(self.arena, first, *b) {
                        true => {
                            let two = self.push(Number(2.0), vec![], origin);
                            self.push(Power(first, two), vec![], origin)
                        }
                        false => self.push(Scale(first, *b), vec![], origin),
                    };
                    Some(self.push(Divide(inner, under), shape.to_vec(), origin))
                }
                (_, Some(under)) if self.coefficient(*a).0 != 1.0 => {
                    let (over, rest) = self.coefficient(*a);
                    self.times_number(over / under, rest, shape, origin)
                }
                (Number(over), Some(under)) => {
                    let value = over / under;
                    (value == value.trunc()).then(|| self.push(Number(value), vec![], origin))
                }
                (Negate(inner), _) => {
                    let divided = self.simpler(Divide(inner, *b), shape, origin);
                    Some(self.simpler(Negate(divided), shape, origin))
                }
                _ => None,
            },
            Contract(a, b) | Inner(a, b) | Outer(a, b) => {
                if is_zero(self, *a) || is_zero(self, *b) {
                    return zero(self);
                }
                let make = |a, b| match operator {
                    Contract(..) => Contract(a, b),
                    Inner(..) => Inner(a, b),
                    _ => Outer(a, b),
                };
                let (left, right) =
                    (self.arena.node(*a).operator.clone(), self.arena.node(*b).operator.clone());
                match (left, right) {
                    (Negate(inner), _) => self.negated(make(inner, *b), shape, origin),
                    (_, Negate(inner)) => self.negated(make(*a, inner), shape, origin),
                    (Scale(s, inner), _) if self.number(s).is_some_and(|s| s == s.trunc()) => {
                        self.scaled(s, make(inner, *b), shape, origin)
                    }
                    (_, Scale(s, inner)) if self.number(s).is_some_and(|s| s == s.trunc()) => {
                        self.scaled(s, make(*a, inner), shape, origin)
                    }
                    _ => self.derivative_of_partial(operator, origin),
                }
            }
            Map(map, a) => match self.arena.node(*a).operator {
                _ if is_zero(self, *a) => zero(self),
                Negate(inner) => self.negated(Map(*map, inner), shape, origin),
                _ => None,
            },
            Restrict(side, a) => match self.arena.node(*a).operator {
                _ if is_zero(self, *a) => zero(self),
                Negate(inner) => self.negated(Restrict(*side, inner), shape, origin),
                _ => None,
            },
            CellMean(a) => match self.arena.node(*a).operator {
                _ if is_zero(self, *a) => zero(self),
                Negate(inner) => self.negated(CellMean(inner), shape, origin),
                _ => None,
            },
            FacetMean(a) => match self.arena.node(*a).operator {
                _ if is_zero(self, *a) => zero(self),
                Negate(inner) => self.negated(FacetMean(inner), shape, origin),
                _ => None,
            },
            Gradient(a) => match self.arena.node(*a).operator {
                _ if is_zero(self, *a) => zero(self),
                Field { .. } => {
                    let operator = gradient(self.arena, *a);
                    let changes = !matches!(operator, Gradient(_));
                    changes.then(|| self.push(operator, shape.to_vec(), origin))
                }
                Negate(inner) => self.negated(Gradient(inner), shape, origin),
                _ => None,
            },
            Component(a, _) | Partial(a, _) if is_zero(self, *a) => zero(self),
            Gateaux { expression: a, direction: b, .. } if is_zero(self, *a) || is_zero(self, *b) => {
                zero(self)
            }
            Stack(entries) if entries.iter().all(|entry| is_zero(self, *entry)) => zero(self),
            Select(_, a, b) | Minimum(a, b) | Maximum(a, b) if is_zero(self, *a) && is_zero(self, *b) => {
                zero(self)
            }
            Power(base, exponent) => match self.number(*exponent) {
                Some(0.0) => Some(self.push(Number(1.0), vec![], origin)),
                Some(1.0) => Some(*base),
                Some(value) if value > 0.0 && is_zero(self, *base) => zero(self),
                _ => None,
            },
            Apply(function, a) if is_zero(self, *a) => {
                let odd = !matches!(function, Function::Exp | Function::Ln | Function::Cos);
                if odd { zero(self) } else { None }
            }
            Named(self::Named::Call { function, arguments, directions }) => {
                self.call(*function, arguments, directions, shape, origin)
            }
            _ => None,
        }
    }

    fn add(&mut self, a: Tensor, b: Tensor, shape: &[usize], origin: Tensor) -> Option<Tensor> {
        if self.arena.is_zero(a) {
            return Some(b);
        }
        if self.arena.is_zero(b) {
            return Some(a);
        }
        if let (Some(a), Some(b)) = (self.number(a), self.number(b)) {
            return Some(self.push(Operator::Number(a + b), vec![], origin));
        }
        // m e + n e = (m + n) e
        let ((m, first), (n, second)) = (self.coefficient(a), self.coefficient(b));
        if !self.comparison.are_same(self.arena, first, second) {
            return None;
        }
        match m + n {
            0.0 => Some(self.zero(shape, origin)),
            1.0 => Some(first),
            -1.0 => Some(self.push(Operator::Negate(first), shape.to_vec(), origin)),
            sum => {
                let number = self.push(Operator::Number(sum), vec![], origin);
                Some(self.push(Operator::Scale(number, first), shape.to_vec(), origin))
            }
        }
    }

    /// Scalar times tensor.
    fn product(&mut self, a: Tensor, b: Tensor, shape: &[usize], origin: Tensor) -> Option<Tensor> {
        use Operator::*;
        if self.arena.is_zero(a) || self.arena.is_zero(b) {
            return Some(self.zero(shape, origin));
        }
        match (self.number(a), self.number(b)) {
            (Some(a), Some(b)) => return Some(self.push(Number(a * b), vec![], origin)),
            (Some(1.0), None) => return Some(b),
            (None, Some(1.0)) => return Some(a),
            (Some(value), None) if value < 0.0 => {
                let positive = self.push(Number(-value), vec![], origin);
                return self.negated(Scale(positive, b), shape, origin);
            }
            (None, Some(_)) => return Some(self.simpler(Scale(b, a), shape, origin)),
            _ => {}
        }
        match (self.arena.node(a).operator.clone(), self.arena.node(b).operator.clone()) {
            (Negate(inner), _) => return self.negated(Scale(inner, b), shape, origin),
            (_, Negate(inner)) => return self.negated(Scale(a, inner), shape, origin),
            _ => {}
        }
        // (1/e) f = f/e
        for (inverse, other) in [(a, b), (b, a)] {
            if let Divide(one, under) = self.arena.node(inverse).operator
                && self.number(one) == Some(1.0)
                && self.number(under).is_none()
            {
                return Some(self.simpler(Divide(other, under), shape, origin));
            }
        }
        let ((m, first), (n, second)) = (self.coefficient(a), self.coefficient(b));
        let number = self.number(a).is_some();
        if number && n != 1.0 {
            let m = self.number(a).unwrap_or(1.0);
            return self.times_number(m * n, second, shape, origin);
        }
        let whole = |one: f64| one != 1.0 && one == one.trunc();
        if !number && (whole(n) || whole(m) || (m != 1.0 && n != 1.0)) {
            let shape = shape.to_vec();
            let product = self.simpler(Scale(first, second), &shape, origin);
            return self.times_number(m * n, product, &shape, origin);
        }
        None
    }

    fn times_number(
        &mut self,
        factor: f64,
        tensor: Tensor,
        shape: &[usize],
        origin: Tensor,
    ) -> Option<Tensor> {
        use Operator::*;
        let inverse = 1.0 / factor;
        if factor == 1.0 {
            return Some(tensor);
        }
        // n ((a/m) e)
        if let Scale(first, second) = self.arena.node(tensor).operator
            && let (n, first) = self.coefficient(first)
            && n != 1.0
        {
            let product = self.push(Scale(first, second), shape.to_vec(), origin);
            return self.times_number(factor * n, product, shape, origin);
        }
        if factor != factor.trunc() && inverse == inverse.trunc() {
            let divisor = self.push(Number(inverse), vec![], origin);
            return Some(self.push(Divide(tensor, divisor), shape.to_vec(), origin));
        }
        let number = self.push(Number(factor), vec![], origin);
        Some(self.push(Scale(number, tensor), shape.to_vec(), origin))
    }

    fn negated(&mut self, operator: Operator, shape: &[usize], origin: Tensor) -> Option<Tensor> {
        let inner = self.simpler(operator, shape, origin);
        Some(self.simpler(Operator::Negate(inner), shape, origin))
    }

    fn scaled(
        &mut self,
        factor: Tensor,
        operator: Operator,
        shape: &[usize],
        origin: Tensor,
    ) -> Option<Tensor> {
        let inner = self.simpler(operator, shape, origin);
        Some(self.simpler(Operator::Scale(factor, inner), shape, origin))
    }

    /// A new node, simplified; its operands are already.
    fn simpler(&mut self, operator: Operator, shape: &[usize], origin: Tensor) -> Tensor {
        match self.rewrite(&operator, shape, origin) {
            Some(rewritten) => rewritten,
            None => self.push(operator, shape.to_vec(), origin),
        }
    }

    fn number(&self, tensor: Tensor) -> Option<f64> {
        match self.arena.node(tensor).operator {
            Operator::Number(value) => Some(value),
            _ => None,
        }
    }

    /// A number before a term, and the rest.
    fn coefficient(&self, tensor: Tensor) -> (f64, Tensor) {
        match self.arena.node(tensor).operator {
            Operator::Negate(inner) => {
                let (factor, rest) = self.coefficient(inner);
                (-factor, rest)
            }
            Operator::Scale(a, b) => match self.number(a) {
                Some(value) => (value, b),
                None => (1.0, tensor),
            },
            Operator::Divide(a, b) => match self.number(b) {
                Some(value) if value != 0.0 => (1.0 / value, a),
                _ => (1.0, tensor),
            },
            _ => (1.0, tensor),
        }
    }

    fn zero(&mut self, shape: &[usize], origin: Tensor) -> Tensor {
        self.push(Operator::Zero, shape.to_vec(), origin)
    }

    fn push(&mut self, operator: Operator, shape: Vec<usize>, origin: Tensor) -> Tensor {
        let span = self.arena.span(origin);
        self.arena.share(operator, shape, span)
    }
}
