//! Limits of simplification: nodes that may be no number where all fields are finite are kept, and factors 1 + 0/x are kept
//! for a divisor x that has cancelled. So no NaN is hidden: u/u is NaN where u is zero.

use std::ops::RangeInclusive;

use super::{Graph, Node, Scalar};
use crate::tensor::Function;

/// Known properties of a node's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Behaviour {
    /// It may be no number, or infinite, where all fields are finite: it holds a quotient, a logarithm or the like of what
    /// varies. Zero times this is kept, as is what is left where it cancels.
    pub singular: bool,
    /// It may be no number, or infinite, where all fields are finite and moderate and parameters are whatever they may be: a branch
    /// that is not taken may hold such a thing, and it must stay inside.
    pub wild: bool,
    /// It holds a field, a position or a parameter, and is no size of a cell or facet.
    pub given: bool,
    /// It holds a field or a position. Parameters and the sizes of cells and facets do not vary: a form divides by those that
    /// are not zero.
    pub varies: bool,
}

impl Graph {
    /// Known properties of a node's values.
    pub fn behaviour(&self, scalar: Scalar) -> Behaviour {
        self.behaviours[scalar.0 as usize]
    }

    /// Of a node that is about to be added.
    pub(super) fn behaviour_of(&self, node: &Node) -> Behaviour {
        let mut found = Behaviour::default();
        self.each_operand_of(node, |operand| {
            let Behaviour { singular, wild, given, varies } = self.behaviour(operand);
            found.singular |= singular;
            found.wild |= wild;
            found.given |= given;
            found.varies |= varies;
        });
        match node {
            Node::Number(bits) => {
                found.singular = !f64::from_bits(*bits).is_finite();
                found.wild = found.singular;
            }
            Node::Parameter(_) => found.given = true,
            Node::Field { .. } => (found.varies, found.given) = (true, true),
            Node::Geometry(geometry, _) => {
                found.varies = geometry.varies();
                found.given = found.varies;
            }
            Node::Product(factors) => {
                for (factor, exponent) in factors {
                    let factor = self.behaviour(*factor);
                    found.singular |= *exponent < 0 && factor.varies;
                    found.wild |= factor.given && !MODERATE.contains(exponent);
                }
            }
            Node::Apply(function, _) => {
                found.singular |= found.varies && has_bounds(*function);
                found.wild |= found.given && (has_bounds(*function) || grows_fast(*function));
            }
            Node::Power(_, exponent) => {
                let whole = self.value(*exponent).is_some_and(|value| value >= 0.0 && value == value.trunc());
                found.singular |= found.varies && !whole;
                found.wild |= found.given;
            }
            Node::External { .. } => {
                found.singular |= found.varies;
                found.wild |= found.given;
            }
            // `normalize` and the derivative of `norm`: what is chosen does not divide where the divisor is zero.
            Node::Select(truth, zero, quotient) => {
                if let Node::LessEqual(divisor, bound) = *self.node(*truth)
                    && self.is_zero(*zero)
                    && self.value(bound).is_some_and(|bound| bound >= 0.0)
                    && *self.node(*quotient) == Node::Product(vec![(divisor, -1)])
                {
                    found.singular = self.behaviour(divisor).singular;
                    found.wild = self.behaviour(divisor).wild;
                }
            }
            _ => {}
        }
        found
    }

    /// Removes terms with a zero coefficient, except for those with a singularity that no other term has.
    pub(super) fn drop_what_cancels(&self, terms: &mut Vec<(f64, Scalar)>) {
        let mut seen: Vec<Scalar> = Vec::new();
        for (_, term) in terms.iter().filter(|(coefficient, _)| *coefficient != 0.0) {
            self.singularities(*term, &mut seen);
        }
        terms.retain(|(coefficient, term)| {
            if *coefficient != 0.0 {
                return true;
            }
            let mut own = Vec::new();
            self.singularities(*term, &mut own);
            let alone = own.iter().any(|one| !seen.contains(one));
            seen.extend(own);
            alone
        });
    }

    /// Removes the factors 1 + 0/x of terms next to another term that divides by x.
    pub(super) fn drop_guards(&mut self, terms: &mut [(f64, Scalar)]) {
        if self.guards.is_empty() || terms.len() < 2 {
            return;
        }
        for index in 0..terms.len() {
            let Node::Product(factors) = self.node(terms[index].1) else { continue };
            if !factors.iter().any(|(factor, _)| self.guards.contains_key(factor)) {
                continue;
            }
            let factors = factors.clone();
            let mut others = Vec::new();
            for (other, (_, term)) in terms.iter().enumerate() {
                if other != index {
                    self.singularities(*term, &mut others);
                }
            }
            let kept = |(factor, _): &&(Scalar, i32)| {
                self.guards.get(factor).is_none_or(|divisor| !others.contains(divisor))
            };
            let kept: Vec<(Scalar, i32)> = factors.iter().filter(kept).copied().collect();
            // What is left stays one term: a number or a multiple would not.
            if kept.len() < factors.len() && !kept.is_empty() {
                let product = self.product(&kept);
                if !matches!(self.node(product), Node::Number(_) | Node::Sum { .. }) {
                    terms[index].1 = product;
                }
            }
        }
    }

    /// Singular parts of a term: the varying divisors, and its other singular factors. Not its guards.
    fn singularities(&self, term: Scalar, found: &mut Vec<Scalar>) {
        let Node::Product(factors) = self.node(term) else {
            if self.behaviour(term).singular {
                found.push(term);
            }
            return;
        };
        for (factor, exponent) in factors.iter().filter(|(factor, _)| !self.guards.contains_key(factor)) {
            let Behaviour { singular, varies, .. } = self.behaviour(*factor);
            if singular || (*exponent < 0 && varies) {
                found.push(*factor);
            }
        }
    }

    /// a b as it is written: where a divisor of one is a factor of the other, that the divisor must not be zero stays.
    pub fn multiply(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.guarded([(a, 1), (b, 1)])
    }

    /// a / b, likewise.
    pub fn divide(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.guarded([(a, 1), (b, -1)])
    }

    /// The product of two, and a factor 1 + 0/x for each x by which one of them divides and their product does not: one, and
    /// NaN where x is zero. u/u is such a factor, u²/u is u times it.
    fn guarded(&mut self, factors: [(Scalar, i32); 2]) -> Scalar {
        let product = self.product(&factors);
        let mut lost: Vec<Scalar> = Vec::new();
        for (factor, sign) in factors {
            for divisor in self.divisors(factor, sign) {
                if self.behaviour(divisor).varies && !lost.contains(&divisor) {
                    lost.push(divisor);
                }
            }
        }
        if lost.is_empty() {
            return product;
        }
        let kept = self.divisors(product, 1);
        lost.retain(|divisor| !kept.contains(divisor));
        let mut all = vec![(product, 1)];
        for divisor in lost {
            let (one, inverse) = (self.number(1.0), self.product(&[(divisor, -1)]));
            let nothing = self.scale(0.0, inverse);
            let guard = self.add(one, nothing);
            self.guards.insert(guard, divisor);
            all.push((guard, 1));
        }
        if all.len() > 1 { self.product(&all) } else { product }
    }

    /// By what factor^sign divides, where that shows without expanding a sum.
    fn divisors(&mut self, factor: Scalar, sign: i32) -> Vec<Scalar> {
        // As products hold it.
        let (_, primitive) = self.primitive(factor);
        match self.node(primitive) {
            Node::Number(_) => vec![],
            Node::Product(factors) => {
                let below = factors.iter().filter(|(_, exponent)| (*exponent < 0) == (sign > 0));
                below.map(|(factor, _)| *factor).collect()
            }
            _ if sign < 0 => vec![primitive],
            _ => vec![],
        }
    }
}

/// Exponents with which no number that anyone computes with is infinite.
const MODERATE: RangeInclusive<i32> = 0..=4;

/// Has a function values that are too large for a number at moderate arguments?
fn grows_fast(function: Function) -> bool {
    use Function::*;
    matches!(function, Exp | Sinh | Cosh | Tan)
}

/// Does a function have arguments without a value, or with an infinite one?
fn has_bounds(function: Function) -> bool {
    use Function::*;
    matches!(function, Sqrt | Ln | Log10 | Asin | Acos | Acosh | Atanh)
}
