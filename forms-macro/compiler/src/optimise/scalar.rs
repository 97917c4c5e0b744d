//! Scalar expressions in normal form: sums of coefficients times products of powers, hash-consed, so
//! that equal expressions are one node (common subexpressions) and zeros vanish as they are built.

mod behaviour;
mod node;

use std::cell::Cell;

use super::hashing::Map;
use crate::tensor::Function;
use behaviour::Behaviour;
pub use node::{Argument, Derivative, Kind, Node, Scalar};

/// All scalars of one function in one dimension.
#[derive(Default)]
pub struct Graph {
    nodes: Vec<Node>,
    /// The behaviour of each node: see [`Behaviour`].
    behaviours: Vec<Behaviour>,
    /// The factors 1 + 0/x, each with its x.
    guards: Map<Scalar, Scalar>,
    known: Map<Node, Scalar>,
    /// Nodes and their operands.
    size: usize,
    /// Larger than can be handled: what has been built since means nothing.
    pub exhausted: bool,
    /// Taking out common factors took too much work: it is not tried again.
    pub tangled: bool,
    /// Nodes and operands that were looked at so far.
    work: Cell<usize>,
}

/// Three times as many nodes and operands as the largest law of any test has, and few enough for some seconds and a hundred
/// megabytes.
const LARGEST: usize = 1_500_000;

/// constant + Σ coefficient × term.
struct Combination {
    constant: f64,
    terms: Vec<(f64, Scalar)>,
}

impl Graph {
    pub fn node(&self, scalar: Scalar) -> &Node {
        &self.nodes[scalar.0 as usize]
    }

    /// The node as it is, shared with an equal one.
    pub fn intern(&mut self, node: Node) -> Scalar {
        self.count_work(node.size());
        if let Some(known) = self.known.get(&node) {
            return *known;
        }
        self.size += node.size();
        if self.size > LARGEST {
            self.exhausted = true;
            return Scalar(0);
        }
        let behaviour = self.behaviour_of(&node);
        self.behaviours.push(behaviour);
        self.nodes.push(node.clone());
        let scalar = Scalar(self.nodes.len() as u32 - 1);
        self.known.insert(node, scalar);
        scalar
    }

    /// Nodes and operands that were looked at so far, given up or not: what has been done, as a number that does not depend
    /// on the machine.
    pub fn work(&self) -> usize {
        self.work.get()
    }

    pub fn count_work(&self, work: usize) {
        self.work.set(self.work.get() + work);
    }

    /// Is it so large that trying several ways would most likely make it too large?
    pub fn is_crowded(&self) -> bool {
        self.size > LARGEST / 2
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Forgets all nodes but the first `length`: those of an attempt that is given up.
    pub fn truncate(&mut self, length: usize) {
        for node in self.nodes.drain(length..) {
            self.size -= node.size();
            self.known.remove(&node);
        }
        self.behaviours.truncate(length);
        self.guards.retain(|guard, _| (guard.0 as usize) < length);
    }

    /// The first coefficient of a sum that is not zero; what else is there is one.
    pub fn leading(&self, scalar: Scalar) -> f64 {
        let terms = self.combination(scalar).terms;
        let leading = terms.iter().map(|(coefficient, _)| *coefficient).find(|one| *one != 0.0);
        leading.or(self.value(scalar)).unwrap_or(1.0)
    }

    pub fn number(&mut self, value: f64) -> Scalar {
        // One zero, not two.
        self.intern(Node::Number((value + 0.0).to_bits()))
    }

    pub fn value(&self, scalar: Scalar) -> Option<f64> {
        match self.node(scalar) {
            Node::Number(bits) => Some(f64::from_bits(*bits)),
            _ => None,
        }
    }

    pub fn is_zero(&self, scalar: Scalar) -> bool {
        self.value(scalar) == Some(0.0)
    }

    fn combination(&self, scalar: Scalar) -> Combination {
        match self.node(scalar) {
            Node::Number(bits) => Combination { constant: f64::from_bits(*bits), terms: vec![] },
            Node::Sum { constant, terms } => Combination {
                constant: f64::from_bits(*constant),
                terms: terms
                    .iter()
                    .map(|(coefficient, term)| (f64::from_bits(*coefficient), *term))
                    .collect(),
            },
            _ => Combination { constant: 0.0, terms: vec![(1.0, scalar)] },
        }
    }

    fn gather(&mut self, mut combination: Combination) -> Scalar {
        self.drop_guards(&mut combination.terms);
        combination.terms.sort_by_key(|(_, term)| *term);
        let mut terms: Vec<(f64, Scalar)> = Vec::new();
        for (coefficient, term) in combination.terms {
            match terms.last_mut() {
                Some(last) if last.1 == term => last.0 += coefficient,
                _ => terms.push((coefficient, term)),
            }
        }
        // Nothing is left of what cancels, but of what may be no number where no other term is none.
        if terms.iter().any(|(coefficient, _)| *coefficient == 0.0) {
            self.drop_what_cancels(&mut terms);
        }
        match terms[..] {
            [] => self.number(combination.constant),
            [(1.0, term)] if combination.constant == 0.0 => term,
            _ => {
                let constant = (combination.constant + 0.0).to_bits();
                let terms = terms
                    .into_iter()
                    .map(|(coefficient, term)| ((coefficient + 0.0).to_bits(), term))
                    .collect();
                self.intern(Node::Sum { constant, terms })
            }
        }
    }

    pub fn add(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.sum(&[a, b])
    }

    pub fn sum(&mut self, parts: &[Scalar]) -> Scalar {
        let mut all = Combination { constant: 0.0, terms: vec![] };
        for part in parts {
            let one = self.combination(*part);
            all.constant += one.constant;
            all.terms.extend(one.terms);
        }
        self.gather(all)
    }

    pub fn scale(&mut self, factor: f64, a: Scalar) -> Scalar {
        let mut combination = self.combination(a);
        // 0 × ∞ would make a NaN of what is infinite.
        if combination.constant != 0.0 {
            combination.constant *= factor;
        }
        for (coefficient, _) in &mut combination.terms {
            *coefficient *= factor;
        }
        self.gather(combination)
    }

    pub fn negate(&mut self, a: Scalar) -> Scalar {
        self.scale(-1.0, a)
    }

    /// Coefficient times something whose first coefficient is one: exactly, so that what is primitive stays as it is and cancels
    /// against itself.
    fn primitive(&mut self, a: Scalar) -> (f64, Scalar) {
        let mut combination = self.combination(a);
        if combination.terms.is_empty() {
            return (combination.constant, self.number(1.0));
        }
        let Some(first) = combination.terms.iter().position(|(coefficient, _)| *coefficient != 0.0) else {
            return (1.0, a);
        };
        let leading = combination.terms[first].0;
        if leading == 1.0 {
            return (1.0, a);
        }
        combination.constant /= leading;
        combination.terms.iter_mut().for_each(|(coefficient, _)| *coefficient /= leading);
        (leading, self.gather(combination))
    }

    /// Π factor^exponent.
    pub fn product(&mut self, factors: &[(Scalar, i32)]) -> Scalar {
        let mut coefficient = 1.0;
        let mut all: Vec<(Scalar, i32)> = Vec::new();
        for (factor, exponent) in factors {
            let (leading, rest) = self.primitive(*factor);
            coefficient *= leading.powi(*exponent);
            match self.node(rest) {
                Node::Number(_) => {}
                Node::Product(inner)
                    if inner.iter().all(|(_, inner)| is_moderate(inner.saturating_mul(*exponent))) =>
                {
                    all.extend(inner.iter().map(|(factor, inner)| (*factor, inner * exponent)))
                }
                // A power of a power past all reason stays one factor.
                Node::Product(_) => {
                    let (one, exponent) = (self.number(1.0), *exponent);
                    let whole = self.intern(Node::Power(rest, one));
                    all.push((whole, exponent));
                }
                _ => all.push((rest, *exponent)),
            }
        }
        // Division by a literal zero stays visible at run time as a non-finite number.
        if coefficient == 0.0 {
            return self.number(0.0);
        }
        all.sort_by_key(|(factor, _)| *factor);
        let mut merged: Vec<(Scalar, i32)> = Vec::new();
        for (factor, exponent) in all {
            match merged.last_mut() {
                Some(last) if last.0 == factor => last.1 = last.1.saturating_add(exponent),
                _ => merged.push((factor, exponent)),
            }
        }
        merged.retain(|(_, exponent)| *exponent != 0);
        let product = match merged[..] {
            [] => return self.number(coefficient),
            [(factor, 1)] => factor,
            _ => self.intern(Node::Product(merged)),
        };
        self.scale(coefficient, product)
    }

    /// The largest exponent of a product, by amount; one for what is no product.
    fn largest_exponent(&self, a: Scalar) -> f64 {
        let inner = match self.node(a) {
            Node::Sum { terms, .. } if terms.len() == 1 => terms[0].1,
            _ => a,
        };
        let Node::Product(factors) = self.node(inner) else { return 1.0 };
        factors.iter().map(|(_, exponent)| f64::from(exponent.unsigned_abs())).fold(1.0, f64::max)
    }

    pub fn power(&mut self, a: Scalar, b: Scalar) -> Scalar {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.number(a.powf(b)),
            (_, Some(exponent))
                if exponent == exponent.trunc()
                    && exponent.abs() <= 16.0
                    && self.largest_exponent(a) * exponent.abs() <= 4096.0 =>
            {
                if exponent == 0.0 {
                    self.number(1.0)
                } else {
                    self.product(&[(a, exponent as i32)])
                }
            }
            (_, Some(0.5)) => self.apply(Function::Sqrt, a),
            _ => self.intern(Node::Power(a, b)),
        }
    }

    pub fn apply(&mut self, function: Function, a: Scalar) -> Scalar {
        let zero = self.number(0.0);
        match function {
            // Kinks are selects: nothing else needs to know them.
            // Written so that a NaN takes the second branch and stays visible.
            Function::Heaviside => {
                let (off, one) = (self.intern(Node::LessEqual(a, zero)), self.number(1.0));
                self.select(off, zero, one)
            }
            Function::PositivePart => {
                let off = self.intern(Node::LessEqual(a, zero));
                self.select(off, zero, a)
            }
            Function::NegativePart => {
                let (off, minus) = (self.intern(Node::LessEqual(zero, a)), self.negate(a));
                self.select(off, zero, minus)
            }
            Function::Sign => {
                let (above, below) = (self.less(zero, a), self.less(a, zero));
                let (one, minus) = (self.number(1.0), self.number(-1.0));
                let other = self.select(below, minus, zero);
                self.select(above, one, other)
            }
            _ => match self.value(a).and_then(|value| value_of(function, value)) {
                Some(value) => self.number(value),
                None => self.intern(Node::Apply(function, a)),
            },
        }
    }

    pub fn less(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.intern(Node::Less(a, b))
    }

    pub fn select(&mut self, truth: Scalar, a: Scalar, b: Scalar) -> Scalar {
        if a == b {
            return a;
        }
        let known = match self.node(truth) {
            Node::Less(left, right) => self.value(*left).zip(self.value(*right)).map(|(l, r)| l < r),
            Node::LessEqual(left, right) => self.value(*left).zip(self.value(*right)).map(|(l, r)| l <= r),
            Node::Equal(left, right) => self.value(*left).zip(self.value(*right)).map(|(l, r)| l == r),
            _ => None,
        };
        match known {
            Some(true) => a,
            Some(false) => b,
            None => self.intern(Node::Select(truth, a, b)),
        }
    }
}

/// Is this an exponent that a product may have? Repeated squaring would run out of them.
fn is_moderate(exponent: i32) -> bool {
    exponent.unsigned_abs() <= 1 << 20
}

/// The value of a function where it is known here; the error function is computed at run time only.
fn value_of(function: Function, value: f64) -> Option<f64> {
    Some(match function {
        Function::Sqrt => value.sqrt(),
        Function::Exp => value.exp(),
        Function::Ln => value.ln(),
        Function::Log10 => value.log10(),
        Function::Sin => value.sin(),
        Function::Cos => value.cos(),
        Function::Tan => value.tan(),
        Function::Asin => value.asin(),
        Function::Acos => value.acos(),
        Function::Atan => value.atan(),
        Function::Sinh => value.sinh(),
        Function::Cosh => value.cosh(),
        Function::Tanh => value.tanh(),
        Function::Asinh => value.asinh(),
        Function::Acosh => value.acosh(),
        Function::Atanh => value.atanh(),
        Function::Abs => value.abs(),
        Function::Erf
        | Function::Erfc
        | Function::Sign
        | Function::Heaviside
        | Function::PositivePart
        | Function::NegativePart => return None,
    })
}
