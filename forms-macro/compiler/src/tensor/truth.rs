//! Conditions on scalars, with the connectives of logic.

use super::Tensor;
use crate::parse::syntax::Comparison;

/// A truth value at a point.
#[derive(Clone, Debug)]
pub enum Truth {
    Compare(Comparison, Tensor, Tensor),
    And(Box<Truth>, Box<Truth>),
    Or(Box<Truth>, Box<Truth>),
    Not(Box<Truth>),
}

impl Truth {
    /// The scalars that are compared.
    pub fn operands(&self) -> Vec<Tensor> {
        match self {
            Truth::Compare(_, left, right) => vec![*left, *right],
            Truth::And(first, second) | Truth::Or(first, second) => {
                let mut all = first.operands();
                all.extend(second.operands());
                all
            }
            Truth::Not(inner) => inner.operands(),
        }
    }

    /// The connectives of comparisons, without what is compared.
    pub(super) fn structure(&self) -> String {
        match self {
            Truth::Compare(comparison, ..) => format!("{comparison:?} "),
            Truth::And(first, second) => format!("({}& {})", first.structure(), second.structure()),
            Truth::Or(first, second) => format!("({}| {})", first.structure(), second.structure()),
            Truth::Not(inner) => format!("!{}", inner.structure()),
        }
    }

    /// The same truth value of other scalars.
    pub fn map(&self, change: &mut impl FnMut(Tensor) -> Tensor) -> Truth {
        match self {
            Truth::Compare(comparison, left, right) => {
                Truth::Compare(*comparison, change(*left), change(*right))
            }
            Truth::And(first, second) => {
                Truth::And(Box::new(first.map(change)), Box::new(second.map(change)))
            }
            Truth::Or(first, second) => Truth::Or(Box::new(first.map(change)), Box::new(second.map(change))),
            Truth::Not(inner) => Truth::Not(Box::new(inner.map(change))),
        }
    }
}
