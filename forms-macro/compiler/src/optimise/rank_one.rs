//! Parts of rank one of a matrix of coefficients: terms c_kl = r_k s_l, found where products of powers agree.

use crate::sorted::SortedMap;

use super::scalar::{Derivative, Graph, Node, Scalar};

/// Coefficients by derivative of the test and of the trial basis function: one entry of the block.
pub type Entry = SortedMap<(Derivative, Derivative), Scalar>;

/// coefficient × Π factor^exponent.
#[derive(Clone, Debug, PartialEq)]
struct Monomial {
    coefficient: f64,
    powers: SortedMap<Scalar, i32>,
}

impl Monomial {
    fn times(&self, other: &Monomial, sign: i32) -> Monomial {
        let mut powers = self.powers.clone();
        for (factor, exponent) in &other.powers {
            *powers.get_or_default(*factor) += sign * exponent;
        }
        powers.retain(|_, exponent| *exponent != 0);
        let coefficient = self.coefficient * other.coefficient.powi(sign);
        Monomial { coefficient, powers }
    }

    fn scalar(&self, graph: &mut Graph) -> Scalar {
        let factors: Vec<(Scalar, i32)> =
            self.powers.iter().map(|(factor, power)| (*factor, *power)).collect();
        let product = graph.product(&factors);
        graph.scale(self.coefficient, product)
    }
}

/// Coefficients by derivative.
type Side = Vec<(Derivative, Scalar)>;

/// Σ products + rest.
pub struct RankOne {
    pub products: Vec<(Side, Side)>,
    pub rest: Entry,
}

/// The terms at each place that are not taken yet.
type Terms = SortedMap<(Derivative, Derivative), Vec<Monomial>>;

/// Splits a matrix. Terms are compared as they are: a sum that is a factor is not expanded.
pub fn rank_one(graph: &mut Graph, entry: &Entry) -> RankOne {
    let mut terms: Terms = entry.iter().map(|(key, value)| (*key, monomials(graph, *value))).collect();
    let mut products = Vec::new();
    let mut rest: Terms = Terms::new();
    while let Some((place, term)) = terms.iter().find_map(|(key, list)| Some((*key, list.first()?.clone()))) {
        match family(&terms, place, &term) {
            Some((rows, columns)) => {
                for (row, first) in &rows {
                    for (column, second) in &columns {
                        let wanted = corner(&term, first, second);
                        let Some(list) = terms.get_mut(&(*row, *column)) else { continue };
                        if let Some(index) = list.iter().position(|known| *known == wanted) {
                            list.remove(index);
                        }
                    }
                }
                products.push(split(graph, rows, columns, &term));
            }
            None => {
                if let Some(list) = terms.get_mut(&place) {
                    list.remove(0);
                }
                rest.get_or_default(place).push(term);
            }
        }
    }
    let rest = rest.into_iter().map(|(key, list)| {
        let parts: Vec<Scalar> = list.iter().map(|term| term.scalar(graph)).collect();
        (key, graph.sum(&parts))
    });
    let rest = rest.collect();
    RankOne { products: joined(graph, products), rest }
}

/// Products with one test side, or with one trial side, are one product.
fn joined(graph: &mut Graph, products: Vec<(Side, Side)>) -> Vec<(Side, Side)> {
    let mut by_test: Vec<(Side, Side)> = Vec::new();
    for (test, trial) in products {
        match by_test.iter_mut().find(|(known, _)| *known == test) {
            Some((_, sum)) => add(graph, sum, trial),
            None => by_test.push((test, trial)),
        }
    }
    let mut joined: Vec<(Side, Side)> = Vec::new();
    for (test, trial) in by_test {
        match joined.iter_mut().find(|(_, known)| *known == trial) {
            Some((sum, _)) => add(graph, sum, test),
            None => joined.push((test, trial)),
        }
    }
    joined
}

fn add(graph: &mut Graph, sum: &mut Side, other: Side) {
    for (derivative, coefficient) in other {
        match sum.iter_mut().find(|(known, _)| *known == derivative) {
            Some((_, known)) => *known = graph.add(*known, coefficient),
            None => sum.push((derivative, coefficient)),
        }
    }
}

fn monomials(graph: &Graph, scalar: Scalar) -> Vec<Monomial> {
    let powers = |scalar: Scalar| match graph.node(scalar) {
        Node::Product(factors) => factors.iter().copied().collect(),
        _ => SortedMap::from([(scalar, 1)]),
    };
    match graph.node(scalar) {
        Node::Number(bits) => vec![Monomial { coefficient: f64::from_bits(*bits), powers: SortedMap::new() }],
        Node::Sum { constant, terms } => {
            let constant = f64::from_bits(*constant);
            let number =
                (constant != 0.0).then(|| Monomial { coefficient: constant, powers: SortedMap::new() });
            let terms = terms.iter().map(|(coefficient, term)| Monomial {
                coefficient: f64::from_bits(*coefficient),
                powers: powers(*term),
            });
            number.into_iter().chain(terms).collect()
        }
        _ => vec![Monomial { coefficient: 1.0, powers: powers(scalar) }],
    }
}

/// The corner opposite `term` in a matrix of rank one, given the other two corners of the rectangle.
fn corner(term: &Monomial, first: &Monomial, second: &Monomial) -> Monomial {
    // Not by a quotient where there is none, which would round.
    match (first == term, second == term) {
        (true, _) => second.clone(),
        (_, true) => first.clone(),
        _ => second.times(&first.times(term, -1), 1),
    }
}

/// The first column and the first row of a product that the term at `place` belongs to: at least two of each.
type Family = (Vec<(Derivative, Monomial)>, Vec<(Derivative, Monomial)>);

/// With more terms to compare than this, none are: ten derivatives (in space, to the second order) with one term each are
/// fewer, and the search grows with the fourth power.
const MOST_RECTANGLES: usize = 100;

fn family(terms: &Terms, place: (Derivative, Derivative), term: &Monomial) -> Option<Family> {
    if term.coefficient == 0.0 {
        return None;
    }
    let has = |row: Derivative, column: Derivative, wanted: &Monomial| {
        terms.get(&(row, column)).is_some_and(|list| list.contains(wanted))
    };
    let in_row: Vec<(Derivative, &Monomial)> = terms
        .iter()
        .filter(|(key, _)| key.0 == place.0 && key.1 != place.1)
        .flat_map(|(key, list)| list.iter().map(|term| (key.1, term)))
        .collect();
    let in_column: Vec<(Derivative, &Monomial)> = terms
        .iter()
        .filter(|(key, _)| key.1 == place.1 && key.0 != place.0)
        .flat_map(|(key, list)| list.iter().map(|term| (key.0, term)))
        .collect();
    if in_row.len() * in_column.len() > MOST_RECTANGLES {
        return None;
    }
    let mut best: Option<Family> = None;
    for (row, first) in &in_column {
        let mut columns = vec![(place.1, term.clone())];
        for (column, second) in &in_row {
            let taken = columns.iter().any(|(known, _)| known == column);
            if !taken && has(*row, *column, &corner(term, first, second)) {
                columns.push((*column, (*second).clone()));
            }
        }
        if columns.len() < 2 {
            continue;
        }
        let mut rows = vec![(place.0, term.clone()), (*row, (*first).clone())];
        for (other, candidate) in &in_column {
            let taken = rows.iter().any(|(known, _)| known == other);
            let fits = |(column, second): &(Derivative, Monomial)| {
                has(*other, *column, &corner(term, candidate, second))
            };
            if !taken && columns.iter().all(fits) {
                rows.push((*other, (*candidate).clone()));
            }
        }
        let size = |(rows, columns): &Family| rows.len() * columns.len();
        let found = (rows, columns);
        if best.as_ref().is_none_or(|known| size(known) < size(&found)) {
            best = Some(found);
        }
    }
    best
}

/// r_k without what its entries have in common, and s_l with it.
fn split(
    graph: &mut Graph,
    rows: Vec<(Derivative, Monomial)>,
    columns: Vec<(Derivative, Monomial)>,
    term: &Monomial,
) -> (Side, Side) {
    let mut common = rows[0].1.clone();
    for (_, other) in &rows[1..] {
        common.powers.retain(|factor, exponent| match other.powers.get(factor) {
            Some(power) if power.signum() == exponent.signum() => {
                *exponent = exponent.signum() * exponent.abs().min(power.abs());
                true
            }
            _ => false,
        });
    }
    let rows = rows.iter().map(|(row, first)| (*row, first.times(&common, -1).scalar(graph))).collect();
    let scale = common.times(term, -1);
    let columns = columns.iter().map(|(column, second)| (*column, second.times(&scale, 1).scalar(graph)));
    (rows, columns.collect())
}
