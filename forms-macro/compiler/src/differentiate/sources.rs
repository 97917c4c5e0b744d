//! Integrands that a derivative of integrals was taken of. They say how it is integrated: the derivative of a sum over quadrature
//! points is a sum over the same points. With points of its own, fewer or more, the adjoint of a discrete problem
//! would not be its adjoint where the integrand has a kink.

use super::lowering::Lowering;
use crate::tensor::{Operator, Tensor, Variable};

/// One integrand, free of derivatives still to be taken.
#[derive(Clone, Debug)]
pub struct Source {
    pub density: Tensor,
    /// The fields by which it was differentiated, each with the field that is the direction: its space may be richer.
    pub directions: Vec<(usize, usize)>,
    /// It was differentiated by the shape of the domain.
    pub by_shape: bool,
}

impl Lowering<'_> {
    /// The integrands whose derivative a density is; none if it is an integrand as others are.
    pub(super) fn sources(&mut self, density: Tensor) -> Vec<Source> {
        let mut found = Vec::new();
        if self.collect_sources(density, &mut found) { found } else { vec![] }
    }

    /// Adds the integrands of a density; is any of it a derivative?
    fn collect_sources(&mut self, density: Tensor, found: &mut Vec<Source>) -> bool {
        match self.arena.node(density).operator.clone() {
            Operator::Add(a, b) => {
                let first = self.collect_sources(a, found);
                self.collect_sources(b, found) || first
            }
            Operator::Negate(a) | Operator::Restrict(_, a) => self.collect_sources(a, found),
            Operator::Scale(a, factor) | Operator::Scale(factor, a) if self.is_parameter(factor) => {
                self.collect_sources(a, found)
            }
            Operator::Divide(a, divisor) if self.is_parameter(divisor) => self.collect_sources(a, found),
            Operator::Gateaux { expression, variable, direction } => {
                let mut inner = Vec::new();
                self.collect_sources(expression, &mut inner);
                // What does not vary, as a dead load, has no part in the derivative.
                inner.retain(|source| self.varies(source.density, variable));
                if let (Variable::Field(varied), Operator::Field { field, order: 0 }) =
                    (variable, &self.arena.node(direction).operator)
                {
                    inner.iter_mut().for_each(|source| source.directions.push((varied, *field)));
                }
                if let Variable::Shape(_) = variable {
                    inner.iter_mut().for_each(|source| source.by_shape = true);
                }
                found.extend(inner);
                true
            }
            _ => {
                let lowered = self.lower(density);
                let parts = self.parts(lowered);
                found.extend(parts.into_iter().map(|density| Source {
                    density,
                    directions: vec![],
                    by_shape: false,
                }));
                false
            }
        }
    }

    fn varies(&self, density: Tensor, variable: Variable) -> bool {
        self.arena.reachable(&[density]).into_iter().any(|node| {
            match (&self.arena.node(node).operator, variable) {
                (_, Variable::Shape(_)) => true,
                (Operator::Field { field, .. }, Variable::Field(varied)) => *field == varied,
                (Operator::Parameter(index), Variable::Parameter(varied)) => *index == varied,
                (Operator::Geometry(geometry), Variable::Size(varied)) => *geometry == varied,
                (_, Variable::Node(varied)) => node == varied,
                _ => false,
            }
        })
    }
}
