//! Integrands that a derivative of integrals was taken of. They say how it is integrated: the derivative of a sum over quadrature
//! points is a sum over the same points. With points of its own, fewer or more, the adjoint of a discrete problem
//! would not be its adjoint where the integrand has a kink.

use super::facet_means::FacetMeans;
use super::lowering::Lowering;
use crate::tensor::{FieldInfo, FieldRole, Operator, Side, Tensor, Variable};

/// One integrand, free of derivatives still to be taken.
#[derive(Clone, Debug)]
pub struct Source {
    pub density: Tensor,
    /// The fields by which it was differentiated, each with the field that is the direction: its space may be richer.
    pub directions: Vec<(usize, usize)>,
    /// It was differentiated by the shape of the domain.
    pub by_shape: bool,
    /// An integral of its own has the motion of its points, where the direction moves them.
    pub moves: bool,
}

/// Whether a derivative moves the contact pairs that some fields displace.
fn displaces(variable: Variable, by: &[usize]) -> bool {
    match variable {
        Variable::Shape(_) => true,
        Variable::Field(varied) => by.contains(&varied),
        _ => false,
    }
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
                    moves: false,
                }));
                false
            }
        }
    }

    /// The density whose motion of points completes derivatives by what displaces contact pairs: of each the integrand times the first
    /// component of its direction, a test function. `None` where there is no such density.
    pub(super) fn carried(&mut self, density: Tensor, by: &[usize], fields: &[FieldInfo]) -> Option<Tensor> {
        let node = self.arena.node(density).clone();
        match node.operator {
            Operator::Add(a, b) => {
                let (a, b) = (self.carried(a, by, fields)?, self.carried(b, by, fields)?);
                Some(self.arena.push(Operator::Add(a, b), vec![], node.span))
            }
            Operator::Negate(a) => {
                let a = self.carried(a, by, fields)?;
                Some(self.arena.push(Operator::Negate(a), vec![], node.span))
            }
            Operator::Scale(a, factor) | Operator::Scale(factor, a) if self.is_parameter(factor) => {
                let a = self.carried(a, by, fields)?;
                Some(self.arena.push(Operator::Scale(factor, a), vec![], node.span))
            }
            Operator::Divide(a, divisor) if self.is_parameter(divisor) => {
                let a = self.carried(a, by, fields)?;
                Some(self.arena.push(Operator::Divide(a, divisor), vec![], node.span))
            }
            Operator::Gateaux { expression, variable, direction } if displaces(variable, by) => {
                let Operator::Field { field, order: 0 } = self.arena.node(direction).operator else {
                    return None;
                };
                let FieldInfo { role: FieldRole::Test(_), shape, .. } = &fields[field] else { return None };
                if *shape != [self.dimension] || self.moves_points(expression, by, fields) {
                    return None;
                }
                let integrand = self.lower(expression);
                let integrand = FacetMeans::at_points(self, integrand);
                Some(self.times_first_component(integrand, direction))
            }
            _ if self.moves_points(density, by, &[]) => None,
            _ => Some(self.arena.push(Operator::Zero, vec![], node.span)),
        }
    }

    /// A density times the first component of a vector at the own points.
    pub(super) fn times_first_component(&mut self, density: Tensor, vector: Tensor) -> Tensor {
        let (span, shape) = (self.arena.span(density), self.arena.shape(vector).to_vec());
        let side = self.arena.push(Operator::Restrict(Side::This, vector), shape, span);
        let first = self.arena.push(Operator::Component(side, vec![0]), vec![], span);
        self.arena.push(Operator::Scale(first, density), vec![], span)
    }

    /// Whether an expression has derivatives by what displaces pairs, or reads unknowns, on which its derivative depends once more.
    pub(super) fn moves_points(&self, expression: Tensor, by: &[usize], fields: &[FieldInfo]) -> bool {
        self.arena.reachable(&[expression]).into_iter().any(|node| match self.arena.node(node).operator {
            Operator::Gateaux { variable, .. } => displaces(variable, by),
            Operator::Field { field, .. } => {
                fields.get(field).is_some_and(|field| matches!(field.role, FieldRole::Unknown(_)))
            }
            _ => false,
        })
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
