//! Additive parts of densities.

use std::collections::HashMap;

use super::lowering::Lowering;
use crate::tensor::{Operator, Tensor};

impl Lowering<'_> {
    /// The additive parts of a density, or the density as one part if they are too many: a sum of shared sums
    /// doubles with each level.
    pub(super) fn parts(&mut self, density: Tensor) -> Vec<Tensor> {
        const MOST: usize = 1000;
        match self.count_parts(density, &mut HashMap::new()) {
            0..=MOST => self.additive_parts(density),
            _ => vec![density],
        }
    }

    fn count_parts(&self, density: Tensor, known: &mut HashMap<Tensor, usize>) -> usize {
        if let Some(count) = known.get(&density) {
            return *count;
        }
        let count = match self.arena.node(density).operator {
            Operator::Add(a, b) => self.count_parts(a, known).saturating_add(self.count_parts(b, known)),
            Operator::Negate(a) | Operator::Divide(a, _) | Operator::Restrict(_, a) => {
                self.count_parts(a, known)
            }
            Operator::Scale(a, b) => self.count_parts(a, known).max(self.count_parts(b, known)),
            _ => 1,
        };
        known.insert(density, count);
        count
    }

    /// Splits a scalar density at `+`, `-` and factors that are parameters only.
    fn additive_parts(&mut self, density: Tensor) -> Vec<Tensor> {
        let span = self.arena.span(density);
        match self.arena.node(density).operator.clone() {
            Operator::Add(a, b) => {
                let mut parts = self.additive_parts(a);
                parts.extend(self.additive_parts(b));
                parts
            }
            Operator::Negate(a) => {
                let parts = self.additive_parts(a);
                parts.into_iter().map(|part| self.arena.push(Operator::Negate(part), vec![], span)).collect()
            }
            Operator::Scale(a, factor) | Operator::Scale(factor, a) if self.is_parameter(factor) => {
                let parts = self.additive_parts(a);
                parts
                    .into_iter()
                    .map(|part| self.arena.push(Operator::Scale(factor, part), vec![], span))
                    .collect()
            }
            Operator::Divide(a, divisor) if self.is_parameter(divisor) => {
                let parts = self.additive_parts(a);
                parts
                    .into_iter()
                    .map(|part| self.arena.push(Operator::Divide(part, divisor), vec![], span))
                    .collect()
            }
            Operator::Restrict(side, a) => {
                let parts = self.additive_parts(a);
                let operators = parts.into_iter().map(|part| Operator::Restrict(side, part));
                operators.map(|operator| self.arena.push(operator, vec![], span)).collect()
            }
            _ => vec![density],
        }
    }

    pub(super) fn is_parameter(&self, tensor: Tensor) -> bool {
        let varies = |node: &Tensor| {
            matches!(self.arena.node(*node).operator, Operator::Field { .. } | Operator::Geometry(_))
        };
        !self.arena.reachable(&[tensor]).iter().any(varies)
    }
}
