//! Derivatives in space: of an expression by dual numbers, and of the fields that it reads.

use std::collections::HashMap;

use super::environment::Environment;
use super::evaluator::Evaluator;
use super::number::Number;
use crate::tensor::{Operator, Tensor, Variable};

impl Evaluator<'_> {
    /// ∂/∂x_axis: fields move by their gradients, the position by a unit vector.
    pub(super) fn along(&self, tensor: Tensor, axis: usize, around: &Environment) -> Vec<Number> {
        self.slope(tensor, &self.shifted(axis, around), around.level)
    }

    /// The walk along a level of moves.
    pub(super) fn slope(&self, tensor: Tensor, around: &Environment, level: usize) -> Vec<Number> {
        self.walk(tensor, around).iter().map(|number| number.slope(level)).collect()
    }

    /// An expression with its derivatives in space up to an order, as [`Jet`](super::Jet).
    pub(super) fn jet(&self, tensor: Tensor, orders: usize, around: &Environment) -> Vec<Vec<Number>> {
        let (dimension, level) = (self.checked.dimension, around.level);
        let mut jet = vec![self.walk(tensor, around).to_vec()];
        if orders > 0 {
            let along: Vec<Vec<Vec<Number>>> = (0..dimension)
                .map(|axis| self.jet(tensor, orders - 1, &self.shifted(axis, around)))
                .collect();
            // One order more than along each axis: the axis is the last direction.
            for (order, first) in along[0].iter().enumerate() {
                let next = (0..first.len() * dimension)
                    .map(|entry| along[entry % dimension][order][entry / dimension].slope(level));
                jet.push(next.collect());
            }
        }
        jet
    }

    /// The highest derivative of a field that an expression reads; `None` if it reads nothing of it.
    pub(super) fn order(&self, expression: Tensor, varied: usize) -> Option<usize> {
        self.order_of(expression, &|field| field == varied)
    }

    /// The highest derivative of some fields that an expression reads.
    pub(super) fn order_of(&self, expression: Tensor, varied: &dyn Fn(usize) -> bool) -> Option<usize> {
        let mut orders: HashMap<Tensor, Option<usize>> = HashMap::new();
        // Operands come first.
        for node in self.checked.arena.reachable(&[expression]) {
            let operator = &self.checked.arena.node(node).operator;
            let order = match operator {
                Operator::Field { field, order } if varied(*field) => Some(*order),
                Operator::Gradient(a) => orders[a].map(|order| order + 1),
                Operator::Gateaux { expression, variable: Variable::Field(field), direction } => {
                    let further = self.order(*expression, *field).unwrap_or(0);
                    orders[expression].max(orders[direction].map(|order| order + further))
                }
                Operator::Gateaux { expression, variable: Variable::Shape(_), direction } => {
                    let further = self.orders_of_shape(*expression);
                    orders[expression].max(orders[direction].map(|order| order + further))
                }
                _ => operator.operands().iter().filter_map(|operand| orders[operand]).max(),
            };
            orders.insert(node, order);
        }
        orders[&expression]
    }
}
