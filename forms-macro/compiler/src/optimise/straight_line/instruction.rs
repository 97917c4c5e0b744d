//! Instructions with at most three operands, and the moments from which their values are known.

use crate::optimise::scalar::Scalar;
use crate::tensor::{External, Function};

/// The moment from which a value is known: with the parameters, per cell, per point, per basis function (or pair).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    Form,
    Cell,
    Point,
    Node,
}

/// An instruction of a [`Code`](super::Code), by number, and its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Value(pub u32);

/// An operation on earlier values.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Instruction {
    Number(u64),
    Terminal(Scalar),
    Add(Value, Value),
    Subtract(Value, Value),
    Multiply(Value, Value),
    /// a * b + c
    MultiplyAdd(Value, Value, Value),
    /// c - a * b
    MultiplySubtract(Value, Value, Value),
    Divide(Value, Value),
    Negate(Value),
    Apply(Function, Value),
    Power(Value, Value),
    Atan2(Value, Value),
    Minimum(Value, Value),
    Maximum(Value, Value),
    Select(Value, Value, Value),
    Less(Value, Value),
    LessEqual(Value, Value),
    Equal(Value, Value),
    And(Value, Value),
    Or(Value, Value),
    Not(Value),
    /// Derivatives of all outputs of a function, by each of some lists of inputs.
    Call {
        function: External,
        inputs: Vec<Value>,
        outputs: usize,
        derivatives: Vec<Vec<usize>>,
    },
    /// Of a call: which list, which output.
    Entry(Value, usize, usize),
}

impl Instruction {
    pub fn operands(&self) -> Vec<Value> {
        use Instruction::*;
        match self {
            Number(_) | Terminal(_) => vec![],
            Negate(a) | Apply(_, a) | Not(a) | Entry(a, ..) => vec![*a],
            Call { inputs, .. } => inputs.clone(),
            Add(a, b)
            | Subtract(a, b)
            | Multiply(a, b)
            | Divide(a, b)
            | Power(a, b)
            | Atan2(a, b)
            | Minimum(a, b)
            | Maximum(a, b)
            | Less(a, b)
            | LessEqual(a, b)
            | Equal(a, b)
            | And(a, b)
            | Or(a, b) => vec![*a, *b],
            MultiplyAdd(a, b, c) | MultiplySubtract(a, b, c) | Select(a, b, c) => vec![*a, *b, *c],
        }
    }

    /// Does it cost anything? As `contract::Operations` counts.
    pub fn is_operation(&self) -> bool {
        use Instruction::*;
        !matches!(self, Number(_) | Terminal(_) | Negate(_) | Entry(..))
    }

    /// Truth values are not stored between functions: they are computed where they are used.
    pub fn is_truth(&self) -> bool {
        use Instruction::*;
        matches!(self, Less(..) | LessEqual(..) | Equal(..) | And(..) | Or(..) | Not(..))
    }
}
