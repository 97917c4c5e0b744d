//! The syntax tree of a function's body: blocks, expressions, conditions.

use proc_macro2::Ident;

use super::Rank;
use crate::diagnostics::SourceSpan;
use crate::parse::whole_number::WholeNumber;

/// `{ let a = ..; let b = ..; result }`
pub struct Block {
    pub lets: Vec<(Ident, Expression)>,
    pub result: Box<Expression>,
}

pub struct Expression {
    pub span: SourceSpan,
    pub kind: ExpressionKind,
}

pub enum ExpressionKind {
    /// An expression that could not be read, and has been reported.
    Mistake,
    /// `let name: Vector = value`
    Declared(Rank, Box<Expression>),
    Number(f64),
    Name(Ident),
    Call(Ident, Vec<Expression>),
    Negate(Box<Expression>),
    Binary(BinaryOperator, Box<Expression>, Box<Expression>),
    Index(Box<Expression>, Vec<Index>),
    Array(Vec<Expression>),
    /// `[entry; 3]`, with the span of the count.
    Repeat(Box<Expression>, WholeNumber, SourceSpan),
    If(Box<Condition>, Block, Block),
    Block(Block),
}

impl Expression {
    /// The expressions that this one is written with.
    pub fn parts(&self) -> Vec<&Expression> {
        use ExpressionKind::*;
        match &self.kind {
            Mistake | Number(_) | Name(_) => vec![],
            Declared(_, a) | Negate(a) | Index(a, _) | Repeat(a, ..) => vec![a],
            Binary(_, a, b) => vec![a, b],
            Call(_, parts) | Array(parts) => parts.iter().collect(),
            Block(block) => block.parts(),
            If(condition, taken, otherwise) => {
                let mut all = condition.parts();
                all.extend(taken.parts());
                all.extend(otherwise.parts());
                all
            }
        }
    }
}

impl Block {
    fn parts(&self) -> Vec<&Expression> {
        self.lets.iter().map(|(_, value)| value).chain([&*self.result]).collect()
    }
}

impl Condition {
    fn parts(&self) -> Vec<&Expression> {
        match self {
            Condition::Compare(_, left, right) => vec![left, right],
            Condition::And(first, second) | Condition::Or(first, second) => {
                [first.parts(), second.parts()].concat()
            }
            Condition::Not(inner) => inner.parts(),
        }
    }
}

/// The part of one axis.
pub struct Index {
    pub span: SourceSpan,
    pub kind: IndexKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexKind {
    One(WholeNumber),
    /// `start..end`, either of them left out for the axis's own.
    Range {
        start: Option<WholeNumber>,
        end: Option<WholeNumber>,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinaryOperator {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// The condition between `if` and `{`.
pub enum Condition {
    Compare(Comparison, Expression, Expression),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
    Not(Box<Condition>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}
