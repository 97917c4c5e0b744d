//! A proof that two scalars are equal: both are expanded to polynomials in their atoms (what is neither
//! a sum nor a product), and compared monomial by monomial.

use std::rc::Rc;

use crate::sorted::SortedMap;

use super::hashing::Map;
use super::scalar::{Graph, Node, Scalar};

type Monomial = Vec<(Scalar, i32)>;
type Polynomial = SortedMap<Monomial, f64>;

/// Past this many monomials no proof is attempted.
const LARGEST: usize = 20_000;

/// True if the difference expands to zero; false if it does not, or is too large to expand.
#[cfg(test)]
pub fn equal(graph: &Graph, a: Scalar, b: Scalar) -> bool {
    Expansion::new(graph).are_equal(a, b)
}

/// Expansions that several proofs use: shared nodes are expanded once.
pub struct Expansion<'g> {
    graph: &'g Graph,
    known: Map<Scalar, Option<Rc<Polynomial>>>,
    /// Monomials that may still be made.
    budget: usize,
}

impl<'g> Expansion<'g> {
    pub fn new(graph: &'g Graph) -> Self {
        Expansion { graph, known: Map::default(), budget: 100 * LARGEST }
    }

    /// As [`equal`]; all proofs of an expansion share its budget.
    pub fn are_equal(&mut self, a: Scalar, b: Scalar) -> bool {
        if a == b {
            return true;
        }
        let (Some(first), Some(second)) = (self.expand(a), self.expand(b)) else { return false };
        let largest =
            first.values().chain(second.values()).fold(0.0_f64, |largest, value| largest.max(value.abs()));
        // Only rounding in sums of literals may differ.
        let same = |value: Option<&f64>, other: f64| {
            (value.copied().unwrap_or(0.0) - other).abs() <= 1e-14 * largest
        };
        first.iter().all(|(monomial, value)| same(second.get(monomial), *value))
            && second.iter().all(|(monomial, value)| same(first.get(monomial), *value))
    }

    fn expand(&mut self, scalar: Scalar) -> Option<Rc<Polynomial>> {
        if let Some(known) = self.known.get(&scalar) {
            return known.clone();
        }
        let expanded = self.expand_node(scalar).map(Rc::new);
        self.known.insert(scalar, expanded.clone());
        expanded
    }

    fn expand_node(&mut self, scalar: Scalar) -> Option<Polynomial> {
        let mut result = Polynomial::new();
        match self.graph.node(scalar) {
            Node::Number(bits) => {
                result.insert(vec![], f64::from_bits(*bits));
            }
            Node::Sum { constant, terms } => {
                result.insert(vec![], f64::from_bits(*constant));
                for (coefficient, term) in terms {
                    let inner = self.expand(*term)?;
                    self.spend(inner.len())?;
                    for (monomial, value) in inner.iter() {
                        *result.get_or_default(monomial.clone()) += f64::from_bits(*coefficient) * value;
                    }
                    if result.len() > LARGEST {
                        return None;
                    }
                }
            }
            Node::Product(factors) => {
                result.insert(vec![], 1.0);
                for (factor, exponent) in factors {
                    let expandable = *exponent > 0 && matches!(self.graph.node(*factor), Node::Sum { .. });
                    if expandable {
                        let inner = self.expand(*factor)?;
                        for _ in 0..*exponent {
                            result = self.multiply(&result, &inner)?;
                        }
                    } else {
                        let one = Polynomial::from([(vec![(*factor, *exponent)], 1.0)]);
                        result = self.multiply(&result, &one)?;
                    }
                }
            }
            _ => {
                result.insert(vec![(scalar, 1)], 1.0);
            }
        }
        Some(result)
    }

    fn spend(&mut self, monomials: usize) -> Option<()> {
        self.budget = self.budget.checked_sub(monomials)?;
        Some(())
    }

    fn multiply(&mut self, a: &Polynomial, b: &Polynomial) -> Option<Polynomial> {
        if a.len() * b.len() > LARGEST {
            return None;
        }
        self.spend(a.len() * b.len())?;
        let mut result = Polynomial::new();
        for (first, x) in a {
            for (second, y) in b {
                let mut powers: SortedMap<Scalar, i32> = first.iter().copied().collect();
                for (atom, exponent) in second {
                    let power = powers.get_or_default(*atom);
                    *power = power.checked_add(*exponent)?;
                }
                powers.retain(|_, exponent| *exponent != 0);
                *result.get_or_default(powers.into_iter().collect()) += x * y;
            }
        }
        Some(result)
    }
}
