//! Products and a matrix of coefficients → a plan with factors: entries of the block that are multiples of each other
//! share one sum, and what is of rank one in an entry is one product.

use crate::sorted::{SortedMap, SortedSet};

use super::linear::Coefficients;
use super::plan::{BilinearPlan, on_basis};
use super::rank_one::{Entry, RankOne, rank_one};
use super::scalar::{Argument, Derivative, Graph, Node, Scalar};

/// A product of two linear expressions, of the test and of the trial function.
#[derive(Clone)]
pub struct Product {
    pub test: Coefficients,
    pub trial: Coefficients,
}

/// A matrix of coefficients, entry by entry of the block.
pub type Entries = SortedMap<(usize, usize), Entry>;

/// The plan of Σ products + the bilinear expression with these coefficients. With `peel`, what is of rank one is taken
/// out of every entry before entries are compared; else where it saves products in that entry.
pub fn factored(
    graph: &mut Graph,
    products: &[Product],
    entries: &Entries,
    [rows, columns]: [usize; 2],
    peel: bool,
) -> BilinearPlan {
    let weight = graph.intern(Node::Weight);
    let one = graph.number(1.0);
    let mut plan = BilinearPlan::default();
    let mut block: Vec<Vec<(f64, usize)>> = vec![vec![]; rows * columns];
    // What belongs to one entry alone is added up in one sum.
    let mut own: Vec<Option<usize>> = vec![None; rows * columns];
    let mut own_sum = |plan: &mut BilinearPlan, entry: usize| match own[entry] {
        Some(sum) => sum,
        None => {
            let sum = plan.add_sum();
            own[entry] = Some(sum);
            sum
        }
    };
    for product in products {
        let test = on_basis(graph, &product.test, rows, Argument::Test, one);
        let trial = on_basis(graph, &product.trial, columns, Argument::Trial, weight);
        for (row, first) in test.iter().enumerate() {
            for (column, second) in trial.iter().enumerate() {
                if let (Some(first), Some(second)) = (first, second) {
                    let sum = own_sum(&mut plan, row * columns + column);
                    plan.add(sum, *first, *second);
                }
            }
        }
    }
    let mut rests = Entries::new();
    let entries = match peel {
        true => {
            for ((row, column), entry) in entries {
                let RankOne { products, rest } = rank_one(graph, entry);
                for (test, trial) in products {
                    let sum = own_sum(&mut plan, row * columns + column);
                    let test = combination(graph, &test, Argument::Test, one);
                    let trial = combination(graph, &trial, Argument::Trial, weight);
                    plan.add(sum, test, trial);
                }
                rests.insert((*row, *column), rest);
            }
            &rests
        }
        false => entries,
    };
    for (representative, members) in multiples(graph, entries) {
        let pairs = products_of(graph, &representative, [one, weight]);
        let shared = members.len() > 1;
        let common = shared.then(|| plan.add_sum());
        for ((row, column), factor) in members {
            let entry = row * columns + column;
            match common {
                Some(sum) => block[entry].push((factor, sum)),
                None => {
                    let sum = own_sum(&mut plan, entry);
                    for (test, trial) in &pairs {
                        plan.add(sum, *test, *trial);
                    }
                }
            }
        }
        if let Some(sum) = common {
            for (test, trial) in &pairs {
                plan.add(sum, *test, *trial);
            }
        }
    }
    for (entry, sum) in own.into_iter().enumerate() {
        block[entry].extend(sum.map(|sum| (1.0, sum)));
    }
    let sums = block.into_iter().map(|parts| {
        let parts = parts.into_iter().map(|(factor, sum)| {
            let sum = graph.intern(Node::Accumulated(sum));
            graph.scale(factor, sum)
        });
        let parts: Vec<Scalar> = parts.collect();
        graph.sum(&parts)
    });
    plan.block = sums.collect();
    plan
}

/// The places in the block that hold multiples of one entry, each with its factor.
type Members = Vec<((usize, usize), f64)>;

/// The entries, those that are multiples of each other by numbers together. An entry that is alone is as it was.
fn multiples(graph: &mut Graph, entries: &Entries) -> Vec<(Entry, Members)> {
    let mut found: Vec<(Entry, Members)> = Vec::new();
    for (place, entry) in entries {
        let Some(first) = entry.values().next() else { continue };
        let leading = graph.leading(*first);
        let scaled = entry.iter().map(|(key, value)| (*key, graph.scale(1.0 / leading, *value)));
        let scaled: Entry = scaled.collect();
        match found.iter_mut().find(|(known, _)| *known == scaled) {
            Some((_, members)) => members.push((*place, leading)),
            None => found.push((scaled, vec![(*place, leading)])),
        }
    }
    for (entry, members) in &mut found {
        if let [(place, factor)] = &mut members[..] {
            *entry = entries[place].clone();
            *factor = 1.0;
        }
    }
    found
}

/// The fewest products that an entry is found to be the sum of.
fn products_of(graph: &mut Graph, entry: &Entry, [one, weight]: [Scalar; 2]) -> Vec<(Scalar, Scalar)> {
    let slots =
        |of: fn(&(Derivative, Derivative)) -> Derivative| entry.keys().map(of).collect::<SortedSet<_>>();
    let (tests, trials) = (slots(|key| key.0), slots(|key| key.1));
    let plain = tests.len().min(trials.len());
    if plain > 1 {
        let RankOne { products, rest } = rank_one(graph, entry);
        let slots = |of: fn(&(Derivative, Derivative)) -> Derivative| {
            rest.keys().map(of).collect::<SortedSet<_>>().len()
        };
        let left = slots(|key| key.0).min(slots(|key| key.1));
        if products.len() + left < plain {
            let mut pairs = Vec::new();
            for (test, trial) in products {
                let test = combination(graph, &test, Argument::Test, one);
                pairs.push((test, combination(graph, &trial, Argument::Trial, weight)));
            }
            pairs.extend(by_slots(graph, &rest, [one, weight]));
            return pairs;
        }
    }
    by_slots(graph, entry, [one, weight])
}

/// One product per derivative of the test function, or of the trial function if these are fewer.
fn by_slots(graph: &mut Graph, entry: &Entry, [one, weight]: [Scalar; 2]) -> Vec<(Scalar, Scalar)> {
    let mut by_test: SortedMap<Derivative, Vec<(Derivative, Scalar)>> = SortedMap::new();
    let mut by_trial: SortedMap<Derivative, Vec<(Derivative, Scalar)>> = SortedMap::new();
    for ((test, trial), coefficient) in entry {
        by_test.get_or_default(*test).push((*trial, *coefficient));
        by_trial.get_or_default(*trial).push((*test, *coefficient));
    }
    let mut pairs = Vec::new();
    if by_test.len() <= by_trial.len() {
        for (test, row) in by_test {
            let test = graph.intern(Node::Basis(Argument::Test, test));
            pairs.push((test, combination(graph, &row, Argument::Trial, weight)));
        }
    } else {
        for (trial, column) in by_trial {
            let number = graph.number(1.0);
            let trial = combination(graph, &[(trial, number)], Argument::Trial, weight);
            pairs.push((combination(graph, &column, Argument::Test, one), trial));
        }
    }
    pairs
}

/// factor × Σ coefficient × derivative of the basis function.
fn combination(
    graph: &mut Graph,
    parts: &[(Derivative, Scalar)],
    argument: Argument,
    factor: Scalar,
) -> Scalar {
    let parts: Vec<Scalar> = parts
        .iter()
        .map(|(derivative, coefficient)| {
            let basis = graph.intern(Node::Basis(argument, *derivative));
            graph.product(&[(factor, 1), (*coefficient, 1), (basis, 1)])
        })
        .collect();
    graph.sum(&parts)
}
