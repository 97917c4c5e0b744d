//! Shape rules: one function per operator, from operands to node; a wrong shape is reported.

use crate::check::evaluate::Evaluator;
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::BinaryOperator;
use crate::tensor::{LinearMap, Operator, Tensor};

/// No expression has more axes. Declared shapes have at most four.
pub const LARGEST_RANK: usize = 6;

/// "a vector" and the like, for messages.
pub fn describe(shape: &[usize], dimension: usize) -> String {
    match shape {
        [] => "a scalar".into(),
        [n] if *n == dimension => "a vector".into(),
        [n] => format!("a vector of length {n}"),
        [n, m] if *n == dimension && *m == dimension => "a tensor".into(),
        [n, m] => format!("a {n} × {m} matrix"),
        _ => format!("a tensor of rank {}", shape.len()),
    }
}

impl Evaluator<'_> {
    pub(super) fn describe(&self, tensor: Tensor) -> String {
        describe(self.arena.shape(tensor), self.dimension)
    }

    /// The place of an operand.
    pub(super) fn place_of(&self, tensor: Tensor) -> SourceSpan {
        self.uses.get(&tensor).copied().unwrap_or_else(|| self.arena.span(tensor))
    }

    pub(super) fn binary(
        &mut self,
        operator: BinaryOperator,
        a: Tensor,
        b: Tensor,
        span: SourceSpan,
    ) -> Option<Tensor> {
        match operator {
            BinaryOperator::Add => self.add(a, b, span, "+"),
            BinaryOperator::Subtract => {
                // Shapes first: the message must speak of `-`.
                let shape = self.arena.shape(b).to_vec();
                if self.arena.shape(a) != shape {
                    return self.add(a, b, span, "-");
                }
                let minus = self.arena.push(Operator::Negate(b), shape, self.arena.span(b));
                self.add(a, minus, span, "-")
            }
            BinaryOperator::Multiply => self.multiply(a, b, span),
            BinaryOperator::Divide => self.divide(a, b, span),
        }
    }

    fn add(&mut self, a: Tensor, b: Tensor, span: SourceSpan, sign: &str) -> Option<Tensor> {
        let shape = self.arena.shape(a).to_vec();
        if shape != self.arena.shape(b) {
            let message = format!(
                "`{sign}` needs two values of one rank: the left is {}, the right {}",
                self.describe(a),
                self.describe(b)
            );
            let help = match (shape.len(), self.arena.shape(b).len()) {
                (2, 0) => Some("a scalar times the identity, `s * I`, is a tensor"),
                (0, 2) => Some("the trace `tr(A)` of a tensor is a scalar, and `s * I` a tensor"),
                (1, 0) | (0, 1) => Some("`dot(a, b)` of two vectors is a scalar"),
                _ => None,
            };
            match help {
                Some(help) => self.diagnostics.error_with_help(span, message, help),
                None => self.diagnostics.error(span, message),
            }
            return None;
        }
        Some(self.arena.push(Operator::Add(a, b), shape, span))
    }

    fn multiply(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        let (left, right) = (self.arena.shape(a).to_vec(), self.arena.shape(b).to_vec());
        match (left.len(), right.len()) {
            (0, _) => Some(self.arena.push(Operator::Scale(a, b), right, span)),
            (_, 0) => Some(self.arena.push(Operator::Scale(b, a), left, span)),
            (2, 1) | (2, 2) if left[1] == right[0] => self.contract(a, b, span),
            (1, 1) => {
                let help = "write `dot(a, b)` for the scalar product, `outer(a, b)` for the tensor product";
                self.diagnostics.error_with_help(span, "`*` between two vectors has no meaning", help);
                None
            }
            (1, 2) => {
                let help = "write `dot(a, A)`, or `transpose(A) * a`";
                self.diagnostics.error_with_help(
                    span,
                    "`*` between a vector and a tensor has no meaning",
                    help,
                );
                None
            }
            _ => {
                let message = format!("`*` does not take {} and {}", self.describe(a), self.describe(b));
                let help = match (left.len(), right.len()) {
                    (4, 2) | (4, 4) => "`ddot(C, A)` contracts two axes of each, C_ijkl A_kl",
                    (2, 1 | 2) => "the columns of the first are as many as the rows of the second",
                    _ => "`dot` contracts one axis, `ddot` two, `inner` all axes",
                };
                self.diagnostics.error_with_help(span, message, help);
                None
            }
        }
    }

    fn divide(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        if !self.arena.shape(b).is_empty() {
            let message = format!("`/` divides by a scalar, this is {}", self.describe(b));
            self.diagnostics.error(self.place_of(b), message);
            return None;
        }
        if self.arena.is_zero(b) {
            self.diagnostics.error(self.place_of(b), "division by zero");
            return None;
        }
        let shape = self.arena.shape(a).to_vec();
        Some(self.arena.push(Operator::Divide(a, b), shape, span))
    }

    fn contract(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        let (left, right) = (self.arena.shape(a), self.arena.shape(b));
        let shape = [&left[..left.len() - 1], &right[1..]].concat();
        Some(self.arena.push(Operator::Contract(a, b), shape, span))
    }

    pub(super) fn dot(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        let (left, right) = (self.arena.shape(a).to_vec(), self.arena.shape(b).to_vec());
        if left.is_empty() || right.is_empty() {
            let scalar = if left.is_empty() { a } else { b };
            let message = format!(
                "`dot` contracts one axis of each argument: {} and {}",
                self.describe(a),
                self.describe(b)
            );
            self.diagnostics.error_with_help(
                self.place_of(scalar),
                message,
                "a product with a scalar is written `*`",
            );
            return None;
        }
        if left[left.len() - 1] != right[0] {
            let message =
                format!("`dot` contracts axes of one length: {} and {}", self.describe(a), self.describe(b));
            self.diagnostics.error(span, message);
            return None;
        }
        self.limit_rank(&[&left[1..], &right[1..]].concat(), "dot", span)?;
        self.contract(a, b, span)
    }

    pub(super) fn inner(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        if self.arena.shape(a) != self.arena.shape(b) {
            let message = format!(
                "`inner` needs two values of one shape: {} and {}",
                self.describe(a),
                self.describe(b)
            );
            let help = match (self.arena.shape(a).len(), self.arena.shape(b).len()) {
                (2, 1) if self.arena.shape(b)[0] == self.dimension => {
                    Some("if the second is a displacement, its strain is `eps(..)`, its gradient `grad(..)`")
                }
                (1, 2) if self.arena.shape(a)[0] == self.dimension => {
                    Some("if the first is a displacement, its strain is `eps(..)`, its gradient `grad(..)`")
                }
                _ => None,
            };
            match help {
                Some(help) => self.diagnostics.error_with_help(span, message, help),
                None => self.diagnostics.error(span, message),
            }
            return None;
        }
        Some(self.arena.push(Operator::Inner(a, b), vec![], span))
    }

    pub(super) fn outer(&mut self, a: Tensor, b: Tensor, span: SourceSpan) -> Option<Tensor> {
        let shape = [self.arena.shape(a), self.arena.shape(b)].concat();
        self.limit_rank(&shape, "outer", span)?;
        Some(self.arena.push(Operator::Outer(a, b), shape, span))
    }

    /// det, inv, cof, tr, transpose, ..: of a square tensor (transpose: of any).
    pub(super) fn of_tensor(
        &mut self,
        a: Tensor,
        span: SourceSpan,
        name: &str,
        make: impl Fn(Tensor) -> Operator,
    ) -> Option<Tensor> {
        let shape = self.arena.shape(a).to_vec();
        let operator = make(a);
        let transpose = matches!(operator, Operator::Map(LinearMap::Transpose, _));
        if shape.len() != 2 || (!transpose && shape[0] != shape[1]) {
            let square = if transpose || shape.len() != 2 { "" } else { "square " };
            let message = format!("`{name}` needs a {square}tensor, this is {}", self.describe(a));
            self.diagnostics.error(self.place_of(a), message);
            return None;
        }
        if matches!(operator, Operator::Determinant(_) | Operator::Inverse(_) | Operator::Cofactor(_))
            && shape[0] > 3
        {
            let message = format!("`{name}` exists up to 3 × 3, this is {}", self.describe(a));
            self.diagnostics.error(self.place_of(a), message);
            return None;
        }
        let result = match operator {
            Operator::Determinant(_) | Operator::Map(LinearMap::Trace, _) => vec![],
            _ if transpose => vec![shape[1], shape[0]],
            _ => shape,
        };
        Some(self.arena.push(operator, result, span))
    }

    /// grad: a field's own derivative, or the chain rule on an expression.
    pub(super) fn gradient(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        self.check_gradient(a, span)?;
        let shape = [self.arena.shape(a), &[self.dimension]].concat();
        let operator = match self.arena.node(a).operator {
            Operator::Field { field, order: order @ (0 | 1) } => Operator::Field { field, order: order + 1 },
            _ => Operator::Gradient(a),
        };
        Some(self.arena.push(operator, shape, span))
    }

    /// hess: grad(grad(e)).
    pub(super) fn hessian(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let gradient = self.gradient(a, span)?;
        self.gradient(gradient, span)
    }

    /// div: tr(grad u) of a vector, row by row of a tensor.
    pub(super) fn divergence(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        let dimension = self.dimension;
        match self.arena.shape(a).to_vec()[..] {
            [d] if d == dimension => {
                let gradient = self.gradient(a, span)?;
                Some(self.arena.push(Operator::Map(LinearMap::Trace, gradient), vec![], span))
            }
            [rows, d] if d == dimension => {
                let gradient = self.gradient(a, span)?;
                let mut entries = Vec::new();
                for row in 0..rows {
                    let block = self.arena.push(Operator::Component(gradient, vec![row]), vec![d, d], span);
                    entries.push(self.arena.push(Operator::Map(LinearMap::Trace, block), vec![], span));
                }
                Some(self.arena.push(Operator::Stack(entries), vec![rows], span))
            }
            _ => {
                let message = format!("`div` needs a vector or a tensor, this is {}", self.describe(a));
                self.diagnostics.error(self.place_of(a), message);
                None
            }
        }
    }

    /// eps: the symmetric gradient of a vector.
    pub(super) fn strain(&mut self, a: Tensor, span: SourceSpan) -> Option<Tensor> {
        if self.arena.shape(a) != [self.dimension] {
            let message = format!("`eps` needs a vector, this is {}", self.describe(a));
            self.diagnostics.error(self.place_of(a), message);
            return None;
        }
        let gradient = self.gradient(a, span)?;
        let shape = self.arena.shape(gradient).to_vec();
        Some(self.arena.push(Operator::Map(LinearMap::Symmetric, gradient), shape, span))
    }

    /// Reports a value that should be a scalar.
    pub(super) fn expect_scalar(&mut self, a: Tensor, name: &str) -> Option<Tensor> {
        if !self.arena.shape(a).is_empty() {
            let message = format!("`{name}` needs a scalar, this is {}", self.describe(a));
            let span = self.place_of(a);
            match self.arena.node(a).operator {
                Operator::Contract(..) if self.arena.shape(a).len() == 2 => {
                    let help = "the scalar A : B of two tensors is `inner(A, B)`; `dot(A, B)` and `A * B` are the matrix product";
                    self.diagnostics.error_with_help(span, message, help);
                }
                _ => self.diagnostics.error(span, message),
            }
            return None;
        }
        Some(a)
    }
}
