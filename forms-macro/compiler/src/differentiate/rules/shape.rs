//! The rules of the shape of the domain: points move along Θ at fixed reference coordinates, x → x + ε Θ(x).
//!
//! Fields that are unknown, tested or states, and data that are carried along, keep what they are at reference
//! coordinates (their nodal values): only their gradients move. Given data are fixed in space. The sizes of cells and
//! facets do not move; `derivative(form, h, rate)` adds what they contribute.

use super::{Differentiation, Seed};
use crate::parse::syntax::Entity;
use crate::tensor::{FieldRole, Geometry, LinearMap, Operator, Side, Tensor, Variable};

impl Differentiation<'_> {
    /// The derivative of what is integrated over an entity of a shape that moves: (e dx)′ / dx = e′ + e div Θ. Without a
    /// measure, and by anything but the shape, it is e′.
    pub fn derive_with_measure(&mut self, tensor: Tensor) -> Option<Tensor> {
        let change = self.derive(tensor);
        let Seed::Toward { variable: Variable::Shape(Some(entity)), .. } = self.seed else { return change };
        if self.arena.is_zero(tensor) {
            return change;
        }
        let rate = match self.holds_facet_means(tensor) {
            true => self.mean_rate_of_measure(entity, tensor),
            false => self.rate_of_measure(entity, tensor),
        };
        let shape = self.arena.shape(tensor).to_vec();
        let second = self.push(Operator::Scale(rate, tensor), shape, tensor);
        self.sum(change, Some(second))
    }

    /// Whether a density is one of `means`, with one number per own facet.
    fn holds_facet_means(&self, tensor: Tensor) -> bool {
        let nodes = self.arena.reachable(&[tensor]);
        nodes.into_iter().any(|node| matches!(self.arena.node(node).operator, Operator::FacetMean(_)))
    }

    /// The mean over the own facet of the rate of its measure: the rate of D = ∫ ψ, divided by D.
    pub(super) fn mean_rate_of_measure(&mut self, entity: Entity, origin: Tensor) -> Tensor {
        let rate = self.rate_of_measure(entity, origin);
        self.push(Operator::FacetMean(rate), vec![], origin)
    }

    /// div Θ of dx; div Θ − n·∇Θ n, the divergence along the surface, of ds.
    fn rate_of_measure(&mut self, entity: Entity, origin: Tensor) -> Tensor {
        let gradient = self.movement(1, origin);
        let divergence = self.push(Operator::Map(LinearMap::Trace, gradient), vec![], origin);
        if entity == Entity::Cells {
            return divergence;
        }
        let normal = self.push(Operator::Geometry(Geometry::Normal), vec![self.dimension], origin);
        let (_, across) = self.along_normal(normal, origin);
        let across = self.push(Operator::Negate(across), vec![], origin);
        self.push(Operator::Add(divergence, across), vec![], origin)
    }

    /// ∇Θᵀ n and n·∇Θ n.
    fn along_normal(&mut self, normal: Tensor, origin: Tensor) -> (Tensor, Tensor) {
        let gradient = self.movement(1, origin);
        let pulled = self.push(Operator::Contract(normal, gradient), vec![self.dimension], origin);
        (pulled, self.push(Operator::Inner(normal, pulled), vec![], origin))
    }

    /// Θ, ∇Θ, ∇²Θ. On an interior facet, what has no side is seen from the cell that owns it, and so is Θ there.
    fn movement(&mut self, order: usize, origin: Tensor) -> Tensor {
        let direction = self.directions[order];
        let two_sided = matches!(self.seed, Seed::Toward { variable: Variable::Shape(Some(entity)), .. } if entity.is_two_sided());
        if !two_sided || self.restricted {
            return direction;
        }
        let shape = self.arena.shape(direction).to_vec();
        self.push(Operator::Restrict(Side::This, direction), shape, origin)
    }

    /// A field's derivative of an order as the points move.
    pub(super) fn field_as_points_move(
        &mut self,
        tensor: Tensor,
        field: usize,
        order: usize,
    ) -> Option<Tensor> {
        let shape = self.arena.shape(tensor).to_vec();
        let fixed_in_space = self.fields.get(field).is_some_and(|field| field.role == FieldRole::Given);
        if fixed_in_space {
            if order == 2 {
                self.no_third_derivative(tensor);
                return None;
            }
            let full = [&shape[..], &[self.dimension]].concat();
            let gradient = self.push(Operator::Field { field, order: order + 1 }, full, tensor);
            let movement = self.movement(0, tensor);
            return Some(self.push(Operator::Contract(gradient, movement), shape, tensor));
        }
        match order {
            0 => None,
            // (∇w)′ = −∇w ∇Θ
            1 => {
                let movement = self.movement(1, tensor);
                let product = self.push(Operator::Contract(tensor, movement), shape.clone(), tensor);
                Some(self.push(Operator::Negate(product), shape, tensor))
            }
            // (∂_jl w)′ = −∂_kl w ∂_j Θ_k − ∂_jk w ∂_l Θ_k − ∂_k w ∂_jl Θ_k
            _ => {
                let (first, second) = (self.movement(1, tensor), self.movement(2, tensor));
                let last = self.push(Operator::Contract(tensor, first), shape.clone(), tensor);
                let one_before = self.with_last_axes_swapped(last, tensor);
                let lower = shape[..shape.len() - 1].to_vec();
                let gradient = self.push(Operator::Field { field, order: 1 }, lower, tensor);
                let bent = self.push(Operator::Contract(gradient, second), shape.clone(), tensor);
                let sum = self.push(Operator::Add(last, one_before), shape.clone(), tensor);
                let sum = self.push(Operator::Add(sum, bent), shape.clone(), tensor);
                Some(self.push(Operator::Negate(sum), shape, tensor))
            }
        }
    }

    fn with_last_axes_swapped(&mut self, tensor: Tensor, origin: Tensor) -> Tensor {
        let shape = self.arena.shape(tensor).to_vec();
        if shape.len() == 2 {
            return self.push(Operator::Map(LinearMap::Transpose, tensor), shape, origin);
        }
        let mut rows = Vec::new();
        for row in 0..shape[0] {
            let row = self.push(Operator::Component(tensor, vec![row]), shape[1..].to_vec(), origin);
            rows.push(self.with_last_axes_swapped(row, origin));
        }
        self.push(Operator::Stack(rows), shape, origin)
    }

    /// x′ = Θ, n′ = −(I − n ⊗ n) ∇Θᵀ n.
    pub(super) fn geometry_as_points_move(&mut self, tensor: Tensor, geometry: Geometry) -> Option<Tensor> {
        match geometry {
            Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea => None,
            Geometry::Position => Some(self.movement(0, tensor)),
            Geometry::Normal => {
                let shape = vec![self.dimension];
                let (pulled, across) = self.along_normal(tensor, tensor);
                let kept = self.push(Operator::Scale(across, tensor), shape.clone(), tensor);
                let turned = self.push(Operator::Negate(pulled), shape.clone(), tensor);
                Some(self.push(Operator::Add(kept, turned), shape, tensor))
            }
            Geometry::Gap
            | Geometry::Toward
            | Geometry::OppositePosition
            | Geometry::OppositeNormal
            | Geometry::ShapeOperator => {
                self.diagnostics.error_with_help(
                    self.arena.span(tensor),
                    "the derivative of contact pairs by the shape is not available",
                    "leave what belongs to `#[pairs]` out of what is differentiated by `shape`",
                );
                None
            }
            Geometry::Curvature => {
                self.diagnostics.error_with_help(
                    self.arena.span(tensor),
                    "the derivative of the curvature by the shape is not available",
                    "leave the terms with `curvature` out of what is differentiated by `shape`",
                );
                None
            }
        }
    }

    /// ∇ of an expression, where it has not been carried out: (∇e)′ = ∇e′ − ∇e ∇Θ.
    pub(super) fn gradient_as_points_move(
        &mut self,
        tensor: Tensor,
        change: Option<Tensor>,
    ) -> Option<Tensor> {
        let shape = self.arena.shape(tensor).to_vec();
        let movement = self.movement(1, tensor);
        let product = self.push(Operator::Contract(tensor, movement), shape.clone(), tensor);
        let product = self.push(Operator::Negate(product), shape.clone(), tensor);
        let change = change.map(|change| self.push(Operator::Gradient(change), shape, tensor));
        self.sum(change, Some(product))
    }
}
