//! Coefficients of a linear expression: what stands before each slot of a field.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use super::scalar::{Derivative, Graph, Node, Scalar};
use crate::tensor::Side;

/// A test or trial function (by field index) in the cell on one side: what kernels are linear in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SidedField {
    pub field: usize,
    pub side: Side,
}

impl SidedField {
    /// Is the node a component of this function, or a derivative of one?
    pub fn owns(self, node: &Node) -> bool {
        matches!(node, Node::Field { field, side, .. } if *field == self.field && *side == self.side)
    }
}

/// What a coefficient stands before: a component, and which derivative of it.
pub type Slot = (usize, Derivative);

/// Slot → coefficient.
pub type Coefficients = BTreeMap<Slot, Scalar>;

/// The coefficients that belong to one component.
pub fn of_component(
    coefficients: &Coefficients,
    component: usize,
) -> impl Iterator<Item = (Derivative, Scalar)> {
    let own = coefficients.iter().filter(move |(slot, _)| slot.0 == component);
    own.map(|(slot, coefficient)| (slot.1, *coefficient))
}

/// Reads off coefficients with respect to one function.
pub struct Linear<'a> {
    pub graph: &'a mut Graph,
    pub function: SidedField,
    known: HashMap<Scalar, Option<Rc<Coefficients>>>,
}

impl<'a> Linear<'a> {
    pub fn new(graph: &'a mut Graph, function: SidedField) -> Self {
        Linear { graph, function, known: HashMap::new() }
    }

    /// The coefficients (empty: free of the function); `None` if the expression is not linear in it.
    pub fn coefficients(&mut self, scalar: Scalar) -> Option<Rc<Coefficients>> {
        if let Some(known) = self.known.get(&scalar) {
            return known.clone();
        }
        let found = self.read(scalar).map(Rc::new);
        self.known.insert(scalar, found.clone());
        found
    }

    /// Does the function stand in the expression, be it with coefficients that cancel?
    fn mentions(&self, scalar: Scalar) -> bool {
        let function = self.function;
        self.graph.depends(
            scalar,
            |node| matches!(node, Node::Field { field, side, .. } if (SidedField { field: *field, side: *side }) == function),
        )
    }

    fn read(&mut self, scalar: Scalar) -> Option<Coefficients> {
        let mut result = Coefficients::new();
        match self.graph.node(scalar).clone() {
            Node::Field { field, side, component, derivative }
                if (SidedField { field, side }) == self.function =>
            {
                result.insert((component, derivative), self.graph.number(1.0));
            }
            Node::Sum { constant, terms } => {
                let mut gathered: BTreeMap<Slot, Vec<Scalar>> = BTreeMap::new();
                let mut every = f64::from_bits(constant) == 0.0;
                for (coefficient, term) in terms {
                    let inner = self.coefficients(term)?;
                    // A term in which the function cancels is zero, and no term without it.
                    every &= !inner.is_empty() || self.mentions(term);
                    for (slot, value) in inner.iter() {
                        let scaled = self.graph.scale(f64::from_bits(coefficient), *value);
                        gathered.entry(*slot).or_default().push(scaled);
                    }
                }
                if !gathered.is_empty() && !every {
                    return None;
                }
                for (slot, parts) in gathered {
                    let sum = self.graph.sum(&parts);
                    result.insert(slot, sum);
                }
            }
            Node::Product(factors) => {
                let mut linear: Option<Rc<Coefficients>> = None;
                let mut others = Vec::new();
                for (factor, exponent) in factors {
                    let inner = self.coefficients(factor)?;
                    if inner.is_empty() && self.mentions(factor) {
                        // The function cancels in a factor: the product is zero.
                        return Some(Coefficients::new());
                    }
                    match (inner.is_empty(), &linear) {
                        (true, _) => others.push((factor, exponent)),
                        (false, None) if exponent == 1 => linear = Some(inner),
                        _ => return None,
                    }
                }
                if let Some(linear) = linear {
                    let scale = self.graph.product(&others);
                    for (slot, value) in linear.iter() {
                        let scaled = self.graph.multiply(scale, *value);
                        result.insert(*slot, scaled);
                    }
                }
            }
            Node::Select(truth, a, b) => {
                if !self.coefficients(truth)?.is_empty() {
                    return None;
                }
                let (first, second) = (self.coefficients(a)?, self.coefficients(b)?);
                let zero = self.graph.number(0.0);
                let slots: Vec<Slot> = first.keys().chain(second.keys()).copied().collect();
                for slot in slots {
                    let (a, b) = (
                        first.get(&slot).copied().unwrap_or(zero),
                        second.get(&slot).copied().unwrap_or(zero),
                    );
                    let chosen = self.graph.select(truth, a, b);
                    result.insert(slot, chosen);
                }
            }
            _ => {
                for operand in self.graph.operands(scalar) {
                    if !self.coefficients(operand)?.is_empty() {
                        return None;
                    }
                }
            }
        }
        result.retain(|_, value| !self.graph.is_zero(*value));
        Some(result)
    }
}

/// The expression with some functions set to zero. These stand in it linearly, if at all.
pub fn without(graph: &mut Graph, scalar: Scalar, functions: &[SidedField]) -> Scalar {
    if functions.is_empty() {
        return scalar;
    }
    without_shared(graph, scalar, functions, &mut HashMap::new())
}

/// Shared nodes are changed once.
fn without_shared(
    graph: &mut Graph,
    scalar: Scalar,
    functions: &[SidedField],
    known: &mut HashMap<Scalar, Scalar>,
) -> Scalar {
    if let Some(known) = known.get(&scalar) {
        return *known;
    }
    let has = |node: &Node| functions.iter().any(|function| function.owns(node));
    let changed = if !graph.depends(scalar, has) {
        scalar
    } else {
        match graph.node(scalar).clone() {
            Node::Sum { constant, terms } => {
                let mut parts = vec![graph.number(f64::from_bits(constant))];
                for (coefficient, term) in terms {
                    let term = without_shared(graph, term, functions, known);
                    parts.push(graph.scale(f64::from_bits(coefficient), term));
                }
                graph.sum(&parts)
            }
            Node::Product(factors) => {
                let factors: Vec<_> = factors
                    .iter()
                    .map(|(factor, exponent)| (without_shared(graph, *factor, functions, known), *exponent))
                    .collect();
                graph.product(&factors)
            }
            Node::Select(truth, a, b) => {
                let a = without_shared(graph, a, functions, known);
                let b = without_shared(graph, b, functions, known);
                graph.select(truth, a, b)
            }
            _ => graph.number(0.0),
        }
    };
    known.insert(scalar, changed);
    changed
}

/// Past this many products a factored plan is out of the question.
const MOST_PRODUCTS: usize = 4096;

/// The expression as a sum of products (test factor, trial factor), each factor linear in its field;
/// `None` where it has not that structure.
pub fn factors(
    graph: &mut Graph,
    scalar: Scalar,
    scale: Scalar,
    is_test: &dyn Fn(&Node) -> bool,
    is_trial: &dyn Fn(&Node) -> bool,
) -> Option<Vec<(Scalar, Scalar)>> {
    match graph.node(scalar).clone() {
        Node::Sum { constant, terms } if f64::from_bits(constant) == 0.0 => {
            let mut all = Vec::new();
            for (coefficient, term) in terms {
                let scale = graph.scale(f64::from_bits(coefficient), scale);
                all.extend(factors(graph, term, scale, is_test, is_trial)?);
                if all.len() > MOST_PRODUCTS {
                    return None;
                }
            }
            Some(all)
        }
        Node::Product(parts) => {
            let (mut test, mut trial, mut both) = (None, None, None);
            let mut others = vec![(scale, 1)];
            for (factor, exponent) in parts {
                let place = match (graph.depends(factor, is_test), graph.depends(factor, is_trial)) {
                    (false, false) => {
                        others.push((factor, exponent));
                        continue;
                    }
                    (true, false) => &mut test,
                    (false, true) => &mut trial,
                    (true, true) => &mut both,
                };
                if exponent != 1 || place.replace(factor).is_some() {
                    return None;
                }
            }
            let scale = graph.product(&others);
            match (test, trial, both) {
                (Some(test), Some(trial), None) => Some(vec![(test, graph.multiply(scale, trial))]),
                (None, None, Some(both)) => factors(graph, both, scale, is_test, is_trial),
                _ => None,
            }
        }
        _ => None,
    }
}
