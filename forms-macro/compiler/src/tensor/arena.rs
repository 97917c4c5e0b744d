//! The arena of a function: its nodes, and the sharing of equal ones.

use std::collections::{HashMap, HashSet};
use std::mem::{Discriminant, discriminant};

use super::{
    External, Function, Geometry, LinearMap, Named, Operator, Selection, Shape, Side, Tensor, Variable,
};
use crate::diagnostics::SourceSpan;
use crate::sorted::SortedSet;

#[derive(Clone, Debug)]
pub struct Node {
    pub operator: Operator,
    pub shape: Shape,
    pub span: SourceSpan,
}

/// All nodes of one function in one dimension.
#[derive(Clone, Debug, Default)]
pub struct Arena {
    nodes: Vec<Node>,
    /// Depth of each: nodes that are one inside the other.
    depths: Vec<u32>,
    /// Nodes that [`Arena::share`] made, by their content.
    shared: HashMap<Key, Tensor>,
    /// One of all nodes that name the same field, parameter or number.
    leaves: HashMap<Key, Tensor>,
    /// The nodes by which `diff(e, w)` differentiates.
    varied: HashSet<Tensor>,
}

impl Arena {
    pub fn push(&mut self, operator: Operator, shape: Shape, span: SourceSpan) -> Tensor {
        if let Operator::Partial(_, Variable::Node(node))
        | Operator::Gateaux { variable: Variable::Node(node), .. } = operator
        {
            self.varied.insert(node);
        }
        let inside = operator.operands().into_iter().map(|operand| self.depth(operand));
        self.depths.push(inside.max().unwrap_or(0) + 1);
        self.nodes.push(Node { operator, shape, span });
        Tensor(self.nodes.len() as u32 - 1)
    }

    /// Depth: the number of nested nodes.
    pub fn depth(&self, tensor: Tensor) -> u32 {
        self.depths[tensor.0 as usize]
    }

    /// As [`Arena::push`], or an equal node that was made by this function before: derivatives of derivatives hold the
    /// same expression many times, and grow with a power of their order instead of exponentially. A node that a `diff`
    /// varies means only itself.
    pub fn share(&mut self, operator: Operator, shape: Shape, span: SourceSpan) -> Tensor {
        let key = Key::new(&operator, &shape, &mut |operand| self.representative(operand));
        match self.shared.get(&key) {
            Some(known) if !self.varied.contains(known) => *known,
            _ => {
                let new = self.push(operator, shape, span);
                self.shared.insert(key, new);
                new
            }
        }
    }

    /// Fields and numbers are a node wherever they are named: one of those that say the same.
    fn representative(&mut self, tensor: Tensor) -> Tensor {
        let node = &self.nodes[tensor.0 as usize];
        let leaf = matches!(
            node.operator,
            Operator::Number(_)
                | Operator::Zero
                | Operator::Parameter(_)
                | Operator::Field { .. }
                | Operator::Geometry(_)
        );
        if !leaf || self.varied.contains(&tensor) {
            return tensor;
        }
        let key = Key::new(&node.operator, &node.shape, &mut |operand| operand);
        *self.leaves.entry(key).or_insert(tensor)
    }

    /// The nodes by which `diff(e, w)` differentiates.
    pub fn varied_nodes(&self) -> HashSet<Tensor> {
        self.varied.clone()
    }

    pub fn node(&self, tensor: Tensor) -> &Node {
        &self.nodes[tensor.0 as usize]
    }

    pub fn shape(&self, tensor: Tensor) -> &[usize] {
        &self.node(tensor).shape
    }

    pub fn span(&self, tensor: Tensor) -> SourceSpan {
        self.node(tensor).span
    }

    /// The names of all values that have one.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.nodes.iter().filter_map(|node| match &node.operator {
            Operator::Named(Named::Value { name, .. }) => Some(name.as_str()),
            _ => None,
        })
    }

    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Gives all nodes from the index `first` on another span.
    pub fn move_to(&mut self, first: usize, span: SourceSpan) {
        for node in &mut self.nodes[first..] {
            node.span = span;
        }
    }

    /// Structurally zero.
    pub fn is_zero(&self, tensor: Tensor) -> bool {
        match self.node(tensor).operator {
            Operator::Zero => true,
            Operator::Number(value) => value == 0.0,
            _ => false,
        }
    }

    /// Every node that `roots` are made of, each once, operands first.
    pub fn reachable(&self, roots: &[Tensor]) -> Vec<Tensor> {
        let mut seen = vec![false; self.nodes.len()];
        let mut pending: Vec<Tensor> = roots.to_vec();
        while let Some(tensor) = pending.pop() {
            if !std::mem::replace(&mut seen[tensor.0 as usize], true) {
                pending.extend(self.node(tensor).operator.operands());
            }
        }
        (0..self.nodes.len() as u32).map(Tensor).filter(|tensor| seen[tensor.0 as usize]).collect()
    }

    /// Every node that `roots` are made of with each restriction that applies to it, operands first.
    pub fn restrictions(&self, roots: &[Tensor]) -> SortedSet<(Tensor, Option<Side>)> {
        let mut seen = SortedSet::new();
        let mut pending: Vec<(Tensor, Option<Side>)> = roots.iter().map(|root| (*root, None)).collect();
        while let Some((tensor, side)) = pending.pop() {
            if seen.insert((tensor, side)) {
                let operator = &self.node(tensor).operator;
                // The displacement of sliding pairs says where they are, not what is integrated.
                let (operands, inside) = match operator {
                    Operator::Restrict(restriction, a) => (vec![*a], Some(*restriction)),
                    Operator::Opposite(a, _) => (vec![*a], Some(Side::Other)),
                    Operator::Sliding(..) => (vec![], side),
                    _ => (operator.operands(), side),
                };
                pending.extend(operands.into_iter().map(|operand| (operand, inside)));
            }
        }
        seen
    }
}

/// A node's operator with all that tells it from others, operands included.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    kind: Discriminant<Operator>,
    operands: Vec<Tensor>,
    shape: Shape,
    rest: Rest,
}

/// The data of an operator besides its operands.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Rest {
    Nothing,
    Numbers(Vec<u64>),
    Geometry(Geometry),
    Map(LinearMap),
    Slice(Vec<Selection>),
    Function(Function),
    Truth(String),
    External(External, usize),
    Side(Side),
    Variable(Variable),
    Call(usize, Vec<usize>),
    Name(String),
}

impl Key {
    fn new(operator: &Operator, shape: &[usize], representative: &mut impl FnMut(Tensor) -> Tensor) -> Self {
        let rest = match operator {
            Operator::Number(value) => Rest::Numbers(vec![value.to_bits()]),
            Operator::Parameter(index) => Rest::Numbers(vec![*index as u64]),
            Operator::Field { field, order } => Rest::Numbers(vec![*field as u64, *order as u64]),
            Operator::Geometry(geometry) => Rest::Geometry(*geometry),
            Operator::Map(map, _) => Rest::Map(*map),
            Operator::Component(_, index) => Rest::Numbers(index.iter().map(|one| *one as u64).collect()),
            Operator::Slice(_, selections) => Rest::Slice(selections.clone()),
            Operator::Apply(function, _) => Rest::Function(*function),
            Operator::Select(truth, ..) => Rest::Truth(truth.structure()),
            Operator::External { function, order, .. } => Rest::External(*function, *order),
            Operator::Restrict(side, _) => Rest::Side(*side),
            Operator::Sliding(geometry, _) => Rest::Geometry(*geometry),
            Operator::Partial(_, variable) | Operator::Gateaux { variable, .. } => Rest::Variable(*variable),
            Operator::Named(Named::Call { function, directions, .. }) => {
                Rest::Call(*function, directions.iter().map(Vec::len).collect())
            }
            Operator::Named(Named::Value { name, .. }) => Rest::Name(name.clone()),
            _ => Rest::Nothing,
        };
        let operands = operator.operands().into_iter().map(representative).collect();
        Key { kind: discriminant(operator), operands, shape: shape.to_vec(), rest }
    }
}
