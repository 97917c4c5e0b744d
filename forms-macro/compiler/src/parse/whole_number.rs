//! Whole numbers known at compile time: literals, the dimension `D`, and arithmetic of them.

use syn::{BinOp, Expr, Lit, UnOp};

/// The number in two and in three dimensions; `None` where it is none (`D / 2` in three) or exceeds 64 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WholeNumber([Option<i64>; 2]);

impl WholeNumber {
    /// `None` for what is no such expression.
    pub fn read(expression: &Expr) -> Option<Self> {
        Some(match expression {
            Expr::Paren(inner) => Self::read(&inner.expr)?,
            Expr::Group(inner) => Self::read(&inner.expr)?,
            Expr::Path(path) if path.path.is_ident("D") || path.path.is_ident("dimension") => {
                WholeNumber([Some(2), Some(3)])
            }
            Expr::Lit(literal) => match &literal.lit {
                Lit::Int(integer) => WholeNumber([Some(integer.base10_parse::<i64>().ok()?); 2]),
                _ => return None,
            },
            Expr::Unary(unary) => match unary.op {
                UnOp::Neg(_) => WholeNumber([Some(0); 2]).with(Self::read(&unary.expr)?, i64::checked_sub),
                _ => return None,
            },
            Expr::Binary(binary) => {
                let operation = match binary.op {
                    BinOp::Add(_) => i64::checked_add,
                    BinOp::Sub(_) => i64::checked_sub,
                    BinOp::Mul(_) => i64::checked_mul,
                    BinOp::Div(_) => exact_quotient,
                    _ => return None,
                };
                Self::read(&binary.left)?.with(Self::read(&binary.right)?, operation)
            }
            _ => return None,
        })
    }

    fn with(self, other: Self, operation: fn(i64, i64) -> Option<i64>) -> Self {
        WholeNumber([0, 1].map(|index| operation(self.0[index]?, other.0[index]?)))
    }

    /// The next larger one.
    pub fn successor(self) -> Self {
        self.with(WholeNumber([Some(1); 2]), i64::checked_add)
    }

    /// The number in a dimension, 2 or 3.
    pub fn at(self, dimension: usize) -> Option<i64> {
        self.0.get(dimension.checked_sub(2)?).copied().flatten()
    }
}

fn exact_quotient(numerator: i64, denominator: i64) -> Option<i64> {
    let quotient = numerator.checked_div(denominator)?;
    (quotient.checked_mul(denominator)? == numerator).then_some(quotient)
}
