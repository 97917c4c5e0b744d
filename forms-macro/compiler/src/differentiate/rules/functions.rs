//! The rules of functions: the scalar ones, and those from outside.

use super::Differentiation;
use crate::differentiate::multi_indices;
use crate::tensor::{External, Function, Operator, Tensor};

impl Differentiation<'_> {
    /// f′(a); `None` where it is zero.
    pub(super) fn slope(&mut self, function: Function, a: Tensor, tensor: Tensor) -> Option<Tensor> {
        use Operator::{Add, Apply, Divide, Negate, Number, Scale};
        let mut push = |operator| self.push(operator, vec![], tensor);
        /// `constant + factor a²`
        macro_rules! quadratic {
            ($constant:expr, $factor:expr) => {{
                let (constant, factor) = (push(Number($constant)), push(Number($factor)));
                let square = push(Scale(a, a));
                let scaled = push(Scale(factor, square));
                push(Add(constant, scaled))
            }};
        }
        /// `numerator / √(constant + factor a²)`
        macro_rules! inverse_root {
            ($numerator:expr, $constant:expr, $factor:expr) => {{
                let quadratic = quadratic!($constant, $factor);
                let (numerator, root) = (push(Number($numerator)), push(Apply(Function::Sqrt, quadratic)));
                push(Divide(numerator, root))
            }};
        }
        Some(match function {
            Function::Sqrt => {
                let half = push(Number(0.5));
                push(Divide(half, tensor))
            }
            Function::Exp => tensor,
            Function::Ln => {
                let one = push(Number(1.0));
                push(Divide(one, a))
            }
            Function::Sin => push(Apply(Function::Cos, a)),
            Function::Cos => {
                let sine = push(Apply(Function::Sin, a));
                push(Negate(sine))
            }
            // tan′ = 1 + tan²
            Function::Tan => {
                let (one, square) = (push(Number(1.0)), push(Scale(tensor, tensor)));
                push(Add(one, square))
            }
            // tanh′ = 1 − tanh²
            Function::Tanh => {
                let (one, square) = (push(Number(1.0)), push(Scale(tensor, tensor)));
                let minus = push(Negate(square));
                push(Add(one, minus))
            }
            Function::Sinh => push(Apply(Function::Cosh, a)),
            Function::Cosh => push(Apply(Function::Sinh, a)),
            Function::Asin => inverse_root!(1.0, 1.0, -1.0),
            Function::Acos => inverse_root!(-1.0, 1.0, -1.0),
            Function::Asinh => inverse_root!(1.0, 1.0, 1.0),
            Function::Acosh => inverse_root!(1.0, -1.0, 1.0),
            Function::Atan | Function::Atanh => {
                let sign = if function == Function::Atan { 1.0 } else { -1.0 };
                let (one, quadratic) = (push(Number(1.0)), quadratic!(1.0, sign));
                push(Divide(one, quadratic))
            }
            Function::Log10 => {
                let one = push(Number(std::f64::consts::LOG10_E));
                push(Divide(one, a))
            }
            // erf′ = 2/√π exp(−a²)
            Function::Erf | Function::Erfc => {
                let sign = if function == Function::Erf { 1.0 } else { -1.0 };
                let (factor, exponent) =
                    (push(Number(sign * std::f64::consts::FRAC_2_SQRT_PI)), quadratic!(0.0, -1.0));
                let bell = push(Apply(Function::Exp, exponent));
                push(Scale(factor, bell))
            }
            Function::Abs => push(Apply(Function::Sign, a)),
            Function::PositivePart => push(Apply(Function::Heaviside, a)),
            // [a]₋′ = −H(−a)
            Function::NegativePart => {
                let minus = push(Negate(a));
                let on = push(Apply(Function::Heaviside, minus));
                push(Negate(on))
            }
            Function::Sign | Function::Heaviside => return None,
        })
    }

    pub(super) fn power(&mut self, tensor: Tensor, a: Tensor, b: Tensor) -> Option<Tensor> {
        use Operator::{Add, Apply, Number, Power, Scale};
        let (da, db) = (self.derive(a), self.derive(b));
        // ∂aᵇ/∂a = b aᵇ⁻¹, which holds at a = 0 where aᵇ b / a does not.
        // a⁰ is one, also where a is zero.
        let constant = self.constant(b);
        let first = da.filter(|_| constant != Some(0.0)).map(|da| {
            let less = match self.arena.node(b).operator {
                Number(value) => self.push(Number(value - 1.0), vec![], tensor),
                _ => {
                    let minus = self.push(Number(-1.0), vec![], tensor);
                    self.push(Add(b, minus), vec![], tensor)
                }
            };
            let power = self.push(Power(a, less), vec![], tensor);
            let slope = self.push(Scale(b, power), vec![], tensor);
            self.push(Scale(slope, da), vec![], tensor)
        });
        // ∂aᵇ/∂b = aᵇ ln a
        let second = db.map(|db| {
            let logarithm = self.push(Apply(Function::Ln, a), vec![], tensor);
            let slope = self.push(Scale(tensor, logarithm), vec![], tensor);
            self.push(Scale(slope, db), vec![], tensor)
        });
        self.sum(first, second)
    }

    /// The value of a scalar that is computed of numbers alone.
    fn constant(&self, tensor: Tensor) -> Option<f64> {
        use Operator::{Add, Divide, Negate, Number, Scale};
        Some(match self.arena.node(tensor).operator {
            Number(value) => value,
            Negate(a) => -self.constant(a)?,
            Add(a, b) => self.constant(a)? + self.constant(b)?,
            Scale(a, b) => self.constant(a)? * self.constant(b)?,
            Divide(a, b) => self.constant(a)? / self.constant(b)?,
            _ => return None,
        })
    }

    /// d atan2(y, x) = (x dy − y dx) / (x² + y²), and 0 at the origin.
    pub(super) fn angle(&mut self, tensor: Tensor, y: Tensor, x: Tensor) -> Option<Tensor> {
        use Operator::{Add, DivideOrZero, Negate, Scale};
        let (dy, dx) = (self.derive(y), self.derive(x));
        let first = dy.map(|dy| self.push(Scale(x, dy), vec![], tensor));
        let second = dx.map(|dx| {
            let product = self.push(Scale(y, dx), vec![], tensor);
            self.push(Negate(product), vec![], tensor)
        });
        let numerator = self.sum(first, second)?;
        let (square_of_x, square_of_y) =
            (self.push(Scale(x, x), vec![], tensor), self.push(Scale(y, y), vec![], tensor));
        let radius = self.push(Add(square_of_x, square_of_y), vec![], tensor);
        Some(self.push(DivideOrZero(numerator, radius), vec![], tensor))
    }

    /// d f⁽ⁿ⁾(a, b, …) = f⁽ⁿ⁺¹⁾(a, b, …) · (da, db, …), all arguments flattened to one list.
    pub(super) fn external(
        &mut self,
        tensor: Tensor,
        function: External,
        arguments: Vec<Tensor>,
        order: usize,
    ) -> Option<Tensor> {
        let derived: Vec<_> = arguments.iter().map(|argument| self.derive(*argument)).collect();
        if derived.iter().all(Option::is_none) {
            return None;
        }
        let mut changes = Vec::new();
        for (argument, change) in arguments.iter().zip(derived) {
            for index in multi_indices(self.arena.shape(*argument)) {
                changes.push(match change {
                    Some(change) => self.push(Operator::Component(change, index), vec![], tensor),
                    None => self.push(Operator::Zero, vec![], tensor),
                });
            }
        }
        let shape = self.arena.shape(tensor).to_vec();
        let count = changes.len();
        let slope = Operator::External { function, arguments, order: order + 1 };
        let slope = self.push(slope, [&shape[..], &[count]].concat(), tensor);
        let changes = self.push(Operator::Stack(changes), vec![count], tensor);
        Some(self.push(Operator::Contract(slope, changes), shape, tensor))
    }
}
