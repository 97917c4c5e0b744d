//! Shape rules of the products and maps of tensors beyond `operators`: from operands to node.

use super::evaluate::Evaluator;
use super::operators::LARGEST_RANK;
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::{BinaryOperator, Expression, ExpressionKind};
use crate::tensor::{LinearMap, Operator, Tensor};

impl Evaluator<'_> {
    /// Reports a result of more axes than the language has.
    pub(super) fn limit_rank(&mut self, shape: &[usize], name: &str, span: SourceSpan) -> Option<()> {
        if shape.len() > LARGEST_RANK {
            let message = format!("`{name}` would give a tensor of rank {}", shape.len());
            let help = format!("the largest rank is {LARGEST_RANK}: contract first");
            self.diagnostics.error_with_help(span, message, help);
            return None;
        }
        Some(())
    }

    /// Last two axes of the first with first two axes of the second.
    pub(super) fn double_dot(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        let (left, right) = (self.arena.shape(a).to_vec(), self.arena.shape(b).to_vec());
        if left.len() < 2 || right.len() < 2 {
            let low = if left.len() < 2 { a } else { b };
            let message = format!(
                "`ddot` contracts two axes of each argument: {} and {}",
                self.describe(a),
                self.describe(b)
            );
            let help = "`dot` contracts one axis of each, `inner` all axes of two values of one shape";
            self.diagnostics.error_with_help(self.place_of(low), message, help);
            return None;
        }
        if left[left.len() - 2..] != right[..2] {
            let message = format!(
                "`ddot` contracts axes of equal lengths: {} × {} in the first and {} × {} in the second",
                left[left.len() - 2],
                left[left.len() - 1],
                right[0],
                right[1]
            );
            self.diagnostics.error(span, message);
            return None;
        }
        if left.len() == 2 && right.len() == 2 {
            return Some(self.arena.push(Operator::Inner(a, b), vec![], span));
        }
        let shape = [&left[..left.len() - 2], &right[2..]].concat();
        self.limit_rank(&shape, "ddot", span)?;
        Some(self.arena.push(Operator::DoubleContract(a, b), shape, span))
    }

    /// a × b of two vectors; in the plane also of a vector and a scalar, which means s e_z.
    pub(super) fn cross(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        let (left, right) = (self.arena.shape(a).to_vec(), self.arena.shape(b).to_vec());
        match (&left[..], &right[..]) {
            ([3], [3]) => Some(self.arena.push(Operator::Cross(a, b), vec![3], span)),
            ([2], [2]) => Some(self.arena.push(Operator::Cross(a, b), vec![], span)),
            // s e_z × b
            ([], [2]) => {
                let turned = self.arena.push(Operator::Map(LinearMap::Perpendicular, b), right, span);
                Some(self.arena.push(Operator::Scale(a, turned), vec![2], span))
            }
            ([2], []) => {
                let turned = self.arena.push(Operator::Map(LinearMap::Perpendicular, a), left, span);
                let product = self.arena.push(Operator::Scale(b, turned), vec![2], span);
                Some(self.arena.push(Operator::Negate(product), vec![2], span))
            }
            _ => {
                let message = format!(
                    "`cross` takes two vectors of three components, or two of two: this is {} and {}",
                    self.describe(a),
                    self.describe(b)
                );
                let help = "in the plane one of the two may be a scalar, which stands for s e_z";
                self.diagnostics.error_with_help(span, message, help);
                None
            }
        }
    }

    /// |a| of any rank.
    pub(super) fn norm(&mut self, a: Tensor, span: SourceSpan) -> Tensor {
        self.arena.push(Operator::Norm(a), vec![], span)
    }

    /// a / |a|, and zero where a is.
    pub(super) fn normalize(&mut self, a: Tensor, span: SourceSpan) -> Tensor {
        let shape = self.arena.shape(a).to_vec();
        let norm = self.norm(a, span);
        self.arena.push(Operator::DivideOrZero(a, norm), shape, span)
    }

    /// √(a² + b²)
    pub(super) fn hypotenuse(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Tensor {
        let both = self.arena.push(Operator::Stack(vec![a, b]), vec![2], span);
        self.norm(both, span)
    }

    /// curl: of a vector in three dimensions a vector; in two of a vector a scalar, of a scalar a vector.
    pub(super) fn curl(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let shape = self.arena.shape(a).to_vec();
        let result = match (self.dimension, &shape[..]) {
            (3, [3]) => vec![3],
            (2, [2]) => vec![],
            // (∂_1 s, −∂_0 s), a quarter turn of the gradient to the right
            (2, []) => {
                let gradient = self.gradient(a, span)?;
                let turned = Operator::Map(LinearMap::Perpendicular, gradient);
                let turned = self.arena.push(turned, vec![2], span);
                return Some(self.arena.push(Operator::Negate(turned), vec![2], span));
            }
            _ => {
                let message =
                    format!("`curl` in dimension {} does not take {}", self.dimension, self.describe(a));
                let help = "it takes a vector; in two dimensions, where that gives a scalar, also a scalar, which gives a vector";
                self.diagnostics.error_with_help(self.place_of(a), message, help);
                return None;
            }
        };
        let gradient = self.gradient(a, span)?;
        Some(self.arena.push(Operator::Map(LinearMap::Curl, gradient), result, span))
    }

    /// (a_0, a_1) → (−a_1, a_0)
    pub(super) fn perpendicular(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        if self.arena.shape(a) != [2] {
            let message = format!("`perp` needs a vector of two components, this is {}", self.describe(a));
            let help = "in three dimensions a vector perpendicular to two others is `cross(a, b)`";
            self.diagnostics.error_with_help(self.place_of(a), message, help);
            return None;
        }
        Some(self.arena.push(Operator::Map(LinearMap::Perpendicular, a), vec![2], span))
    }

    /// The diagonal of a square tensor, or the tensor of a diagonal.
    pub(super) fn diagonal(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let (map, shape) = match self.arena.shape(a)[..] {
            [n, m] if n == m => (LinearMap::Diagonal, vec![n]),
            [n] => (LinearMap::DiagonalTensor, vec![n, n]),
            _ => {
                let message =
                    format!("`diag` needs a square tensor or a vector, this is {}", self.describe(a));
                self.diagnostics.error(self.place_of(a), message);
                return None;
            }
        };
        Some(self.arena.push(Operator::Map(map, a), shape, span))
    }

    /// `identity(3)`
    pub(super) fn identity_of_size(&mut self, size: &Expression, span: SourceSpan) -> Option<Tensor> {
        let extent = match self.written_number(size) {
            Some(value) if (1.0..=16.0).contains(&value) && value.fract() == 0.0 => value as usize,
            _ => {
                let message = "`identity` takes a whole number from 1 to 16 that is written down";
                let help = "write `identity(3)`, or `I` for the identity of the dimension";
                self.diagnostics.error_with_help(size.span, message, help);
                return None;
            }
        };
        Some(self.arena.push(Operator::Identity, vec![extent; 2], span))
    }

    /// The value of an expression of numbers and `D`.
    fn written_number(&self, expression: &Expression) -> Option<f64> {
        Some(match &expression.kind {
            ExpressionKind::Number(value) => *value,
            ExpressionKind::Name(name) if name == "D" || name == "dimension" => self.dimension as f64,
            ExpressionKind::Negate(inner) => -self.written_number(inner)?,
            ExpressionKind::Binary(operator, left, right) => {
                let (left, right) = (self.written_number(left)?, self.written_number(right)?);
                match operator {
                    BinaryOperator::Add => left + right,
                    BinaryOperator::Subtract => left - right,
                    BinaryOperator::Multiply => left * right,
                    BinaryOperator::Divide => left / right,
                }
            }
            _ => return None,
        })
    }
}
