//! A formula as a tree that knows no layout: what [`Notation`](super::notation::Notation)s print.

use super::symbols::Symbol;

/// Precedence of a formula, lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// a < b, and what is chosen by cases.
    Relation,
    /// a + b, −a.
    Sum,
    /// a·b, A:B, a ⊗ b.
    Infix,
    /// a b.
    Product,
    /// ∇u.
    Prefix,
    /// aᵇ.
    Power,
    /// u, σ(u), |a|.
    Atom,
}

/// Products that have a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Infix {
    /// a·b.
    Dot,
    /// A:B.
    DoubleDot,
    /// a ⊗ b.
    Outer,
}

/// The surroundings of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fence {
    /// |a|.
    Bars,
    /// ‖a‖.
    DoubleBars,
    /// \[a\]₊.
    PositivePart,
    /// \[a\]₋.
    NegativePart,
    /// ⟦a⟧.
    Jump,
    /// {a}.
    Average,
    /// ⟨a⟩.
    Mean,
}

/// The measure of an integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Cells.
    Dx,
    /// Exterior facets.
    Ds,
    /// Interior facets.
    InteriorDs,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Formula {
    Number(f64),
    Symbol(Symbol),
    /// An upright name: `tr`, `sin`, the T of a transpose.
    Word(String),
    /// Terms, each with whether it is subtracted.
    Sum(Vec<(bool, Formula)>),
    /// Factors side by side.
    Product(Vec<Formula>),
    Infix(Infix, Box<Formula>, Box<Formula>),
    Fraction(Box<Formula>, Box<Formula>),
    Power(Box<Formula>, Box<Formula>),
    Root(Box<Formula>),
    /// A sign before its operand: ∇u, ∂ψ.
    Prefix(&'static str, Box<Formula>),
    /// D²f, D_u f: a derivative still without its directions.
    Derivative {
        order: usize,
        by: Option<Box<Formula>>,
        of: Box<Formula>,
    },
    Fence(Fence, Box<Formula>),
    /// f(a, b); without arguments only f.
    Call(Box<Formula>, Vec<Formula>),
    /// f(a)\[b, c\]: a derivative in directions.
    Directions(Box<Formula>, Vec<Formula>),
    /// (a, b).
    Tuple(Vec<Formula>),
    /// aᵢⱼ.
    Subscript(Box<Formula>, Vec<Formula>),
    Matrix(Vec<Vec<Formula>>),
    /// Values with the conditions under which they hold; the last one otherwise.
    Cases(Vec<(Formula, Option<Formula>)>),
    /// a < b, a ∧ b.
    Relation(&'static str, Box<Formula>, Box<Formula>),
    Integral {
        region: Symbol,
        density: Box<Formula>,
        measure: Measure,
    },
}

impl Formula {
    /// The strength with which it holds together where fractions are two-dimensional.
    pub fn level(&self) -> Level {
        use Formula::*;
        match self {
            Number(value) if *value < 0.0 => Level::Sum,
            Number(_) | Symbol(_) | Word(_) | Fence(..) | Call(..) | Tuple(_) | Matrix(_) | Root(_) => {
                Level::Atom
            }
            Directions(..) | Subscript(..) => Level::Atom,
            Sum(_) => Level::Sum,
            Product(_) => Level::Product,
            Infix(..) => Level::Infix,
            // A fraction needs parentheses only as a base.
            Fraction(..) => Level::Product,
            Power(..) => Level::Power,
            Prefix(..) | Derivative { .. } => Level::Prefix,
            Cases(_) | Relation(..) | Integral { .. } => Level::Relation,
        }
    }

    pub fn word(word: &str) -> Formula {
        Formula::Word(word.to_string())
    }

    pub fn name(name: &str) -> Formula {
        Formula::Symbol(Symbol::of(name))
    }

    pub fn negative(self) -> Formula {
        match self {
            Formula::Number(value) => Formula::Number(-value),
            other => Formula::Sum(vec![(true, other)]),
        }
    }

    /// Joins two sums; the second is subtracted if `minus`.
    pub fn plus(self, minus: bool, other: Formula) -> Formula {
        let mut terms = match self {
            Formula::Sum(terms) => terms,
            first => vec![(false, first)],
        };
        match other {
            Formula::Sum(more) if !minus => terms.extend(more),
            Formula::Number(value) if value < 0.0 => terms.push((!minus, Formula::Number(-value))),
            other => terms.push((minus, other)),
        }
        Formula::Sum(terms)
    }

    /// Joins two products, numbers first.
    pub fn times(self, other: Formula) -> Formula {
        let mut factors = Vec::new();
        for part in [self, other] {
            match part {
                Formula::Product(more) => factors.extend(more),
                one => factors.push(one),
            }
        }
        factors.sort_by_key(|factor| !matches!(factor, Formula::Number(value) if *value >= 0.0));
        Formula::Product(factors)
    }

    pub fn infix(infix: Infix, left: Formula, right: Formula) -> Formula {
        Formula::Infix(infix, Box::new(left), Box::new(right))
    }

    pub fn power(self, exponent: Formula) -> Formula {
        Formula::Power(Box::new(self), Box::new(exponent))
    }

    pub fn call(head: Formula, arguments: Vec<Formula>) -> Formula {
        Formula::Call(Box::new(head), arguments)
    }

    /// The number of its parts.
    pub fn size(&self) -> usize {
        use Formula::*;
        let of = |list: &[Formula]| list.iter().map(Formula::size).sum::<usize>();
        1 + match self {
            Number(_) | Symbol(_) | Word(_) => 0,
            Sum(terms) => terms.iter().map(|(_, term)| term.size()).sum(),
            Product(list) | Tuple(list) => of(list),
            Infix(_, a, b) | Fraction(a, b) | Power(a, b) | Relation(_, a, b) => a.size() + b.size(),
            Root(a) | Prefix(_, a) | Fence(_, a) | Derivative { of: a, .. } => a.size(),
            Call(head, list) | Directions(head, list) | Subscript(head, list) => head.size() + of(list),
            Matrix(rows) => rows.iter().map(|row| of(row)).sum(),
            Cases(rows) => {
                rows.iter().map(|(value, truth)| value.size() + truth.as_ref().map_or(0, Formula::size)).sum()
            }
            Integral { density, .. } => density.size(),
        }
    }

    /// Does its print begin with a digit, which must not touch a number before it?
    pub fn begins_with_digit(&self) -> bool {
        match self {
            Formula::Number(value) => *value >= 0.0,
            Formula::Power(base, _) => base.begins_with_digit(),
            Formula::Product(factors) => factors.first().is_some_and(Formula::begins_with_digit),
            _ => false,
        }
    }
}
