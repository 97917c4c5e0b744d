//! Common factors of the terms of a sum, taken out: a b c + a b d becomes a b (c + d). As by Horner's rule, the factor
//! that most terms have goes first.

use crate::sorted::SortedMap;

use super::hashing::Map;
use super::scalar::{Graph, Node, Scalar};
use super::straight_line::Code;

/// The expressions with the sums in them collected; sums over basis functions stay, since what precedes a basis
/// function is computed once per point. `None` where that takes too much work.
pub fn collected(graph: &mut Graph, roots: &[Scalar]) -> Option<Vec<Scalar>> {
    if graph.tangled {
        return None;
    }
    let varies = graph.mark(roots, |node| matches!(node, Node::Basis(..) | Node::Accumulated(_)));
    let (start, limit) = (graph.len(), graph.work() + MOST_WORK + MOST_WORK_PER_NODE * varies.nodes().len());
    let mut known: Map<Scalar, Scalar> = Map::default();
    for &scalar in varies.nodes() {
        let now = |scalar: &Scalar| known.get(scalar).copied().unwrap_or(*scalar);
        let changed = match graph.node(scalar).clone() {
            Node::Sum { constant, terms } => {
                let terms: Vec<Scalar> = terms
                    .iter()
                    .map(|(coefficient, term)| graph.scale(f64::from_bits(*coefficient), now(term)))
                    .collect();
                let constant = graph.number(f64::from_bits(constant));
                let parts = [&terms[..], &[constant]].concat();
                let sum = graph.sum(&parts);
                if varies.holds(scalar) { sum } else { take_out(graph, sum, MOST_FACTORS, limit) }
            }
            Node::Product(factors) => {
                let factors: Vec<_> =
                    factors.iter().map(|(factor, exponent)| (now(factor), *exponent)).collect();
                graph.product(&factors)
            }
            other => graph.intern(with_operands(other, &now)),
        };
        if graph.work() > limit {
            graph.truncate(start);
            graph.tangled = true;
            return None;
        }
        known.insert(scalar, changed);
    }
    Some(roots.iter().map(|root| known.get(root).copied().unwrap_or(*root)).collect())
}

/// The rest after factors are taken out flattens the sums below them, and where these are shared each of their users flattens
/// them anew: in products of matrices one inside the other the work grows by a factor with each. More than this is not
/// spent ([`Graph::work`]), and no form in this repository takes as much.
const MOST_WORK: usize = 100_000;
const MOST_WORK_PER_NODE: usize = 100;

/// A node that is neither a sum nor a product, on other operands.
fn with_operands(node: Node, now: &dyn Fn(&Scalar) -> Scalar) -> Node {
    match node {
        Node::Apply(function, a) => Node::Apply(function, now(&a)),
        Node::Not(a) => Node::Not(now(&a)),
        Node::Power(a, b) => Node::Power(now(&a), now(&b)),
        Node::Atan2(a, b) => Node::Atan2(now(&a), now(&b)),
        Node::Minimum(a, b) => Node::Minimum(now(&a), now(&b)),
        Node::Maximum(a, b) => Node::Maximum(now(&a), now(&b)),
        Node::Less(a, b) => Node::Less(now(&a), now(&b)),
        Node::LessEqual(a, b) => Node::LessEqual(now(&a), now(&b)),
        Node::Equal(a, b) => Node::Equal(now(&a), now(&b)),
        Node::And(a, b) => Node::And(now(&a), now(&b)),
        Node::Or(a, b) => Node::Or(now(&a), now(&b)),
        Node::Select(truth, a, b) => Node::Select(now(&truth), now(&a), now(&b)),
        Node::External { function, inputs, outputs, output, derivative } => {
            let inputs = inputs.iter().map(now).collect();
            Node::External { function, inputs, outputs, output, derivative }
        }
        terminal => terminal,
    }
}

/// Past this many terms a sum is left as it is: taking a factor out flattens what is nested below it, and a long sum of nested
/// products, as (1 + a)⁴⁰ written by repeated products, would become a sum of large terms that cancel.
const MOST_TERMS: usize = 30;

/// Past this many factors one after the other a sum is left as it is. A quotient need not be simpler than its
/// dividend: without an end a factor could be taken out that comes back.
const MOST_FACTORS: usize = 60;

/// A sum with the factor taken out that most of its terms have, and what is left of it likewise, until so much work has been
/// done on the graph.
fn take_out(graph: &mut Graph, sum: Scalar, factors_left: usize, limit: usize) -> Scalar {
    let Node::Sum { constant, terms } = graph.node(sum).clone() else { return sum };
    if terms.len() > MOST_TERMS || factors_left == 0 || graph.work() > limit {
        return sum;
    }
    // A factor and whether it divides.
    let mut counts: SortedMap<(Scalar, bool), usize> = SortedMap::new();
    // What is multiplied by zero may be NaN: it keeps its factors.
    for (_, term) in terms.iter().filter(|(coefficient, _)| f64::from_bits(*coefficient) != 0.0) {
        match graph.node(*term) {
            Node::Product(factors) => {
                for (factor, exponent) in factors {
                    *counts.get_or_default((*factor, *exponent < 0)) += 1;
                }
            }
            _ => *counts.get_or_default((*term, false)) += 1,
        }
    }
    let most = counts.into_iter().max_by_key(|(key, count)| (*count, std::cmp::Reverse(*key)));
    let Some(((factor, divides), 2..)) = most else { return sum };
    let has = |graph: &Graph, term: Scalar| match graph.node(term) {
        Node::Product(factors) => {
            factors.iter().any(|(one, power)| *one == factor && (*power < 0) == divides)
        }
        _ => term == factor && !divides,
    };
    let (mut inside, mut outside) = (Vec::new(), vec![graph.number(f64::from_bits(constant))]);
    for (coefficient, term) in terms {
        let coefficient = f64::from_bits(coefficient);
        if coefficient != 0.0 && has(graph, term) {
            let quotient = graph.product(&[(term, 1), (factor, if divides { 1 } else { -1 })]);
            inside.push(graph.scale(coefficient, quotient));
        } else {
            outside.push(graph.scale(coefficient, term));
        }
    }
    let inside = graph.sum(&inside);
    let inside = take_out(graph, inside, factors_left - 1, limit);
    let product = graph.product(&[(factor, if divides { -1 } else { 1 }), (inside, 1)]);
    let outside = graph.sum(&outside);
    let outside = take_out(graph, outside, factors_left - 1, limit);
    graph.add(product, outside)
}

/// The expressions, collected where that saves operations.
pub fn cheaper(graph: &mut Graph, roots: Vec<Scalar>) -> Vec<Scalar> {
    let Some(changed) = collected(graph, &roots) else { return roots };
    let count = |roots: &[Scalar]| {
        let mut code = Code::new(graph, roots);
        roots.iter().for_each(|root| {
            code.lower(*root);
        });
        code.all_operations()
    };
    if count(&changed) < count(&roots) { changed } else { roots }
}
