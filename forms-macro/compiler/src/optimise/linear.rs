//! Coefficients of a linear expression: the factor of each slot of a field.

use std::rc::Rc;

use super::hashing::Map;
use super::reach::Marks;
use super::scalar::{Derivative, Graph, Node, Scalar};
use crate::sorted::SortedMap;
use crate::tensor::Side;

/// A test or trial function (by field index) in the cell on one side: what kernels are linear in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SidedField {
    pub field: usize,
    pub side: Side,
}

impl SidedField {
    /// A field on both sides of an interior facet; elsewhere only on this side.
    pub fn on_sides(field: usize) -> [SidedField; 2] {
        [Side::This, Side::Other].map(|side| SidedField { field, side })
    }

    /// Is the node a component of this function, or a derivative of one?
    pub fn owns(self, node: &Node) -> bool {
        matches!(node, Node::Field { field, side, .. } if *field == self.field && *side == self.side)
    }
}

/// The factor next to a coefficient: a component, and which derivative of it.
pub type Slot = (usize, Derivative);

/// Slot → coefficient.
pub type Coefficients = SortedMap<Slot, Scalar>;

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
    known: Map<Scalar, Option<Rc<Coefficients>>>,
    /// The nodes that contain the function, be it with coefficients that cancel.
    mentioned: Marks,
}

impl<'a> Linear<'a> {
    /// Of these expressions, and of what they are made of.
    pub fn new(graph: &'a mut Graph, function: SidedField, roots: &[Scalar]) -> Self {
        let mentioned = graph.mark(roots, |node| function.owns(node));
        Linear { graph, function, known: Map::default(), mentioned }
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

    fn mentions(&self, scalar: Scalar) -> bool {
        self.mentioned.holds(scalar)
    }

    fn read(&mut self, scalar: Scalar) -> Option<Coefficients> {
        let mut result = Coefficients::new();
        if !self.mentions(scalar) {
            return Some(result);
        }
        match self.graph.node(scalar).clone() {
            Node::Field { field, side, component, derivative }
                if (SidedField { field, side }) == self.function =>
            {
                result.insert((component, derivative), self.graph.number(1.0));
            }
            Node::Sum { constant, terms } => {
                let mut gathered: SortedMap<Slot, Vec<Scalar>> = SortedMap::new();
                let mut every = f64::from_bits(constant) == 0.0;
                for (coefficient, term) in terms {
                    let inner = self.coefficients(term)?;
                    // A term in which the function cancels is zero, and no term without it.
                    every &= !inner.is_empty() || self.mentions(term);
                    for (slot, value) in inner.iter() {
                        let scaled = self.graph.scale(f64::from_bits(coefficient), *value);
                        gathered.get_or_default(*slot).push(scaled);
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

/// The expression with some functions set to zero. It is linear in these, if it contains them.
pub fn without(graph: &mut Graph, scalar: Scalar, functions: &[SidedField]) -> Scalar {
    if functions.is_empty() {
        return scalar;
    }
    let marks = graph.mark(&[scalar], |node| functions.iter().any(|function| function.owns(node)));
    let zero = graph.number(0.0);
    with(graph, scalar, &marks, &mut |_| None, zero)
}

/// An expression as node × partner + rest, for a node in which it is linear.
pub fn split(graph: &mut Graph, scalar: Scalar, node: Scalar) -> (Scalar, Scalar) {
    let marks = graph.mark_above(scalar, node);
    let zero = graph.number(0.0);
    let mut partners: Map<Scalar, Scalar> = Map::default();
    for &inner in marks.nodes().iter().filter(|inner| marks.holds(**inner)) {
        let of = |scalar: &Scalar| partners.get(scalar).copied();
        let partner = match graph.node(inner).clone() {
            _ if inner == node => graph.number(1.0),
            Node::Sum { terms, .. } => {
                let terms = terms.iter().filter_map(|(coefficient, term)| Some((*coefficient, of(term)?)));
                let terms: Vec<Scalar> = terms
                    .map(|(coefficient, partner)| graph.scale(f64::from_bits(coefficient), partner))
                    .collect();
                graph.sum(&terms)
            }
            Node::Product(factors) => {
                let factors: Vec<_> = factors
                    .iter()
                    .map(|(factor, exponent)| (of(factor).unwrap_or(*factor), *exponent))
                    .collect();
                graph.product(&factors)
            }
            Node::Select(truth, a, b) => graph.select(truth, of(&a).unwrap_or(zero), of(&b).unwrap_or(zero)),
            _ => zero,
        };
        partners.insert(inner, partner);
    }
    let partner = partners.get(&scalar).copied().unwrap_or(zero);
    let rest = with(graph, scalar, &marks, &mut |scalar| (scalar == node).then_some(zero), zero);
    (partner, rest)
}

/// A node of an expression as it may be a factor outside of it: inside the branches of `if`s that contain it, and zero where
/// these are not taken, unless it is a number there, too. A NaN would come through a partner that is zero. `None` where
/// several branches contain it.
pub fn guarded(graph: &mut Graph, scalar: Scalar, node: Scalar) -> Option<Scalar> {
    if !graph.behaviour(node).wild {
        return Some(node);
    }
    let marks = graph.mark_above(scalar, node);
    let mut factor = node;
    let zero = graph.number(0.0);
    // Inner ones first: operands are older than what is made of them.
    for &choice in marks.nodes().iter().filter(|choice| marks.holds(**choice)) {
        let Node::Select(truth, a, b) = *graph.node(choice) else { continue };
        let (in_a, in_b) = (marks.holds(a), marks.holds(b));
        if choice == node || in_a == in_b {
            continue;
        }
        if graph.reaches(scalar, node, choice) {
            return None;
        }
        factor = if in_a { graph.select(truth, factor, zero) } else { graph.select(truth, zero, factor) };
    }
    Some(factor)
}

/// The expression with its marked nodes made anew; `other` replaces terminals and what is not linear.
fn with(
    graph: &mut Graph,
    scalar: Scalar,
    marks: &Marks,
    replace: &mut dyn FnMut(Scalar) -> Option<Scalar>,
    other: Scalar,
) -> Scalar {
    let mut known: Map<Scalar, Scalar> = Map::default();
    for &node in marks.nodes().iter().filter(|node| marks.holds(**node)) {
        let now = |scalar: &Scalar| known.get(scalar).copied().unwrap_or(*scalar);
        let changed = match (replace(node), graph.node(node).clone()) {
            (Some(changed), _) => changed,
            (None, Node::Sum { constant, terms }) => {
                let mut parts = vec![graph.number(f64::from_bits(constant))];
                for (coefficient, term) in terms {
                    parts.push(graph.scale(f64::from_bits(coefficient), now(&term)));
                }
                graph.sum(&parts)
            }
            (None, Node::Product(factors)) => {
                let factors: Vec<_> =
                    factors.iter().map(|(factor, exponent)| (now(factor), *exponent)).collect();
                graph.product(&factors)
            }
            (None, Node::Select(truth, a, b)) => graph.select(truth, now(&a), now(&b)),
            _ => other,
        };
        known.insert(node, changed);
    }
    known.get(&scalar).copied().unwrap_or(scalar)
}
