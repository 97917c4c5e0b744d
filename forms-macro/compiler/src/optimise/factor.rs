//! Ways to compute a node pair's block, and the choice among them by counted operations.
//!
//! accumulated: the coefficients are constant on the cell. Sums S_kl of weight × test slot k × trial
//!              slot l (values or derivatives of the basis functions) are accumulated, and contracted with the coefficients once per pair.
//! dense:       a product per slot of the test function and entry of the block; entries that are multiples of each
//!              other share one sum, and what is of rank one in an entry is one product.
//! factored:    products (linear in the test function) × (linear in the trial function), as contact terms and
//!              determinants bring them, are taken out first; the rest is dense.

use crate::sorted::SortedMap;

use super::blocks::{Entries, Product, factored};
use super::elements::{StandardElement, elements};
use super::linear::{self, Coefficients, Linear, SidedField, Slot};
use super::plan::{BilinearPlan, Operations};
use super::polynomial::Expansion;
use super::scalar::{Argument, Derivative, Graph, Node, Scalar};
use super::{Description, Setting};

/// A bilinear integral's density, and what it is linear in.
#[derive(Clone, Copy)]
pub struct Bilinear {
    pub density: Scalar,
    pub test: SidedField,
    pub trial: SidedField,
    /// Components of the test and of the trial function.
    pub components: [usize; 2],
    /// Test and trial function are of one unknown, on one side.
    pub diagonal: bool,
    pub from_energy: bool,
}

/// The cheapest plan.
pub struct Planned {
    pub plan: BilinearPlan,
    /// Proved.
    pub symmetric: bool,
    /// Each plan with what its functions cost, the cheapest first; and its cost per element on the standard elements.
    pub candidates: Vec<Candidate>,
}

/// One way to compute the blocks.
#[derive(Clone)]
pub struct Candidate {
    pub name: &'static str,
    pub operations: Operations,
    /// By element: its points, and operations per element matrix.
    pub costs: Vec<(&'static StandardElement, usize, usize)>,
    plan: BilinearPlan,
}

/// `None`: not bilinear. `Some(None)`: zero.
pub fn plan(
    graph: &mut Graph,
    form: &Bilinear,
    description: &Description,
    setting: &Setting,
) -> Option<Option<Planned>> {
    let matrix = matrix(graph, form.density, form)?;
    if matrix.is_empty() {
        return Some(None);
    }
    let symmetric = form.diagonal && (form.from_energy || is_symmetric(graph, &matrix));
    let weigh = |graph: &Graph, name: &'static str, plan: BilinearPlan| {
        let operations = plan.operations(graph);
        let costs = elements(setting.dimension).map(|element| {
            let points =
                element.points(&description.degree, setting.fields, setting.entities[description.region]);
            (element, points, operations.on(element, points, symmetric))
        });
        Candidate { name, operations, costs: costs.collect(), plan }
    };
    let mut candidates = Vec::new();
    if let Some(plan) = accumulated(graph, &matrix, form.components) {
        candidates.push(weigh(graph, "accumulated", plan));
    }
    let dense = cheapest(graph, "dense", &[], &matrix, form, &weigh);
    if let Some(plan) = with_products(graph, form, &weigh) {
        candidates.push(plan);
    }
    candidates.push(dense);
    candidates.sort_by(|a, b| a.total().total_cmp(&b.total()));
    let plan = candidates[0].plan.clone();
    Some(Some(Planned { plan, symmetric, candidates }))
}

impl Candidate {
    /// The elements count alike: the logarithm of the product of all costs.
    fn total(&self) -> f64 {
        self.costs.iter().map(|(_, _, cost)| (*cost as f64).ln()).sum()
    }
}

/// Counts what a plan costs on the standard elements.
type Weigh<'a> = dyn Fn(&Graph, &'static str, BilinearPlan) -> Candidate + 'a;

/// Coefficients by slot of the test function and of the trial function.
type Matrix = SortedMap<Slot, Coefficients>;

fn matrix(graph: &mut Graph, density: Scalar, form: &Bilinear) -> Option<Matrix> {
    let flux = Linear::new(graph, form.test, &[density]).coefficients(density)?;
    let mut matrix = Matrix::new();
    let roots: Vec<Scalar> = flux.values().copied().collect();
    let mut linear = Linear::new(graph, form.trial, &roots);
    for (slot, coefficient) in flux.iter() {
        let row = linear.coefficients(*coefficient)?;
        if !row.is_empty() {
            matrix.insert(*slot, (*row).clone());
        }
    }
    Some(matrix)
}

fn entries(matrix: &Matrix) -> Entries {
    let mut entries = Entries::new();
    for ((row, test), coefficients) in matrix {
        for ((column, trial), coefficient) in coefficients {
            entries.get_or_default((*row, *column)).insert((*test, *trial), *coefficient);
        }
    }
    entries
}

fn is_symmetric(graph: &Graph, matrix: &Matrix) -> bool {
    let mut expansion = Expansion::new(graph);
    matrix.iter().all(|(row, entries)| {
        entries.iter().all(|(column, entry)| match matrix.get(column).and_then(|other| other.get(row)) {
            Some(mirrored) => expansion.are_equal(*entry, *mirrored),
            None => false,
        })
    })
}

/// The cheapest plan with some products: with rank-one parts taken out of all entries of the rest, or where they save
/// products; with common factors taken out, or not.
fn cheapest(
    graph: &mut Graph,
    name: &'static str,
    products: &[Product],
    matrix: &Matrix,
    form: &Bilinear,
    weigh: &Weigh,
) -> Candidate {
    let entries = entries(matrix);
    if graph.work() > MOST_WORK || graph.is_crowded() {
        let plan = factored(graph, products, &entries, form.components, false);
        return weigh(graph, name, plan);
    }
    let [first, second] = [true, false].map(|peel| {
        let plan = factored(graph, products, &entries, form.components, peel);
        match plan.collected(graph) {
            Some(collected) => cheaper(weigh(graph, name, collected), weigh(graph, name, plan)),
            None => weigh(graph, name, plan),
        }
    });
    cheaper(first, second)
}

fn cheaper(first: Candidate, second: Candidate) -> Candidate {
    if first.total() < second.total() { first } else { second }
}

/// The numbers of products that are taken out and that are tried for each.
const MOST_PRODUCTS: usize = 8;
const MOST_TRIED: usize = 8;

/// After this much work on a function ([`Graph::work`]), no more ways are tried: four times what the largest law of contact in
/// this repository takes, and some seconds. What is found until then is taken. Without an end, large forms take minutes.
const MOST_WORK: usize = 20_000_000;

/// Products that are taken out one by one, at each step the one that leaves the cheapest plan. A step may cost a
/// little where a later one gains more.
fn with_products(graph: &mut Graph, form: &Bilinear, weigh: &Weigh) -> Option<Candidate> {
    // In the logarithm of the product of all costs.
    const RISE: f64 = 1.2;
    // Roughly; what is taken is weighed with care.
    let roughly = |graph: &mut Graph, products: &[Product], density: Scalar| {
        let matrix = matrix(graph, density, form)?;
        let plan = factored(graph, products, &entries(&matrix), form.components, false);
        Some(weigh(graph, "factored", plan).total())
    };
    let mut products: Vec<Product> = Vec::new();
    let mut density = form.density;
    let mut best: Option<Candidate> = None;
    if graph.work() > MOST_WORK || graph.is_crowded() {
        return None;
    }
    let before = graph.work();
    let mut lowest = roughly(graph, &products, density)?;
    // What one more trial takes, about.
    let mut trial = graph.work() - before;
    while products.len() < MOST_PRODUCTS {
        let start = graph.len();
        let mut next: Option<(f64, Scalar, Argument)> = None;
        let expressions = linear_expressions(graph, density, form);
        // A step that cannot be finished is not begun: what it finds would be given up.
        if graph.work() + expressions.len() * trial > MOST_WORK {
            return best;
        }
        let before = graph.work();
        let count = expressions.len().max(1);
        for (node, argument) in expressions {
            if graph.work() > MOST_WORK {
                return best;
            }
            let total = split(graph, density, node, argument, form)
                .and_then(|(product, rest)| roughly(graph, &[&products[..], &[product]].concat(), rest));
            let exhausted = graph.exhausted;
            graph.truncate(start);
            if exhausted {
                graph.exhausted = false;
                return best;
            }
            if let Some(total) = total
                && next.is_none_or(|(known, ..)| total < known)
            {
                next = Some((total, node, argument));
            }
        }
        trial = (graph.work() - before) / count;
        let Some((total, node, argument)) = next else { break };
        if total > lowest + RISE {
            break;
        }
        lowest = lowest.min(total);
        let (product, rest) = split(graph, density, node, argument, form)?;
        products.push(product);
        density = rest;
        let matrix = matrix(graph, density, form)?;
        let candidate = cheapest(graph, "factored", &products, &matrix, form, weigh);
        best = Some(match best {
            Some(best) => cheaper(candidate, best),
            None => candidate,
        });
        if matrix.is_empty() {
            break;
        }
    }
    best
}

/// Takes expression × partner out of a density; what remains.
fn split(
    graph: &mut Graph,
    density: Scalar,
    node: Scalar,
    argument: Argument,
    form: &Bilinear,
) -> Option<(Product, Scalar)> {
    let factor = linear::guarded(graph, density, node)?;
    let (partner, rest) = linear::split(graph, density, node);
    let (test, trial) = match argument {
        Argument::Test => (factor, partner),
        Argument::Trial => (partner, factor),
    };
    let test = Linear::new(graph, form.test, &[test]).coefficients(test)?;
    let trial = Linear::new(graph, form.trial, &[trial]).coefficients(trial)?;
    // A partner of one component is a row of the matrix.
    let narrow = |coefficients: &Coefficients, components: usize| {
        let mut found: Vec<usize> = coefficients.keys().map(|slot| slot.0).collect();
        found.dedup();
        found.len() < components.min(2)
    };
    if narrow(&test, form.components[0]) || narrow(&trial, form.components[1]) {
        return None;
    }
    Some((Product { test: (*test).clone(), trial: (*trial).clone() }, rest))
}

/// Expressions in a density that are linear in one of the two functions and may be worth a factor of their own: they
/// hold two slots per component or more. The largest first.
fn linear_expressions(graph: &mut Graph, density: Scalar, form: &Bilinear) -> Vec<(Scalar, Argument)> {
    let functions = [form.test, form.trial];
    let marks = functions.map(|function| graph.mark(&[density], |node| function.owns(node)));
    let slots = functions.map(|function| graph.terminals(&[density], |node| function.owns(node)));
    let mut found = Vec::new();
    for (place, &node) in marks[0].nodes().iter().enumerate() {
        if !matches!(graph.node(node), Node::Sum { .. } | Node::Select(..)) {
            continue;
        }
        let (argument, side) = match (marks[0].holds(node), marks[1].holds(node)) {
            (true, false) => (Argument::Test, 0),
            (false, true) => (Argument::Trial, 1),
            _ => continue,
        };
        let slots = slots[side][place];
        if slots >= 2 * form.components[side] {
            found.push((slots, node, argument));
        }
    }
    found.sort_by_key(|(slots, node, _)| (std::cmp::Reverse(*slots), *node));
    found.truncate(MOST_TRIED);
    found.into_iter().map(|(_, node, argument)| (node, argument)).collect()
}

fn accumulated(graph: &mut Graph, matrix: &Matrix, [rows, columns]: [usize; 2]) -> Option<BilinearPlan> {
    let weight = graph.intern(Node::Weight);
    let mut keys: Vec<(Derivative, Derivative)> = Vec::new();
    let mut block: Vec<Vec<Scalar>> = vec![Vec::new(); rows * columns];
    let mut plan = BilinearPlan::default();
    for (row, entries) in matrix {
        for (column, coefficient) in entries {
            if graph.depends(*coefficient, varies_over_cell) {
                return None;
            }
            let key = (row.1, column.1);
            let index = keys.iter().position(|known| *known == key).unwrap_or_else(|| {
                keys.push(key);
                let test = graph.intern(Node::Basis(Argument::Test, key.0));
                let trial = graph.intern(Node::Basis(Argument::Trial, key.1));
                let trial = graph.multiply(weight, trial);
                let sum = plan.add_sum();
                plan.add(sum, test, trial);
                sum
            });
            let sum = graph.intern(Node::Accumulated(index));
            let part = graph.multiply(*coefficient, sum);
            block[row.0 * columns + column.0].push(part);
        }
    }
    plan.block = block.iter().map(|parts| graph.sum(parts)).collect();
    Some(plan)
}

/// May the terminal differ between the points of a cell, except for weight and basis functions?
pub fn varies_over_cell(node: &Node) -> bool {
    match node {
        Node::Field { .. } => true,
        Node::Geometry(geometry, _) => geometry.varies(),
        _ => false,
    }
}
