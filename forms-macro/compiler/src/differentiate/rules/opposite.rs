//! Motion of the opposite points of sliding pairs: where a displacement d of the surfaces changes, the ray from
//! x = X + d(X) along the deformed normal n_x hits the other surface elsewhere, at another distance.
//!
//! With F = I + ∇d, g the gap, m the other deformed surface's normal at Y and r = δd(X) − δd(Y) + g δn_x:
//!
//! ```text
//! δn_x = −(I − n_x ⊗ n_x) F⁻ᵀ (∇δd)ᵀ n_x                   at X
//! δg   = −(m·r)/(m·n_x)
//! δY   = F(Y)⁻¹ (I − n_x ⊗ m/(m·n_x)) r                    tangent to the other surface
//! δ[e(Y)] = (δe)(Y) + (∇e)(Y) δY
//! ```
//!
//! Points that move by Θ with nodal values held change the pairs as δd = Θ does.

use std::mem::{replace, take};

use super::{Differentiation, Seed};
use crate::tensor::{Geometry, LinearMap, Operator, Side, Tensor, Variable};

/// The change of a pair.
#[derive(Clone, Copy)]
pub(super) struct MovedPair {
    gap: Tensor,
    toward: Tensor,
    /// δY, in the undeformed configuration.
    point: Tensor,
}

impl Differentiation<'_> {
    /// The derivative of what is seen at the opposite point.
    pub(super) fn at_opposite_point(
        &mut self,
        tensor: Tensor,
        seen: Tensor,
        displacement: Tensor,
    ) -> Option<Tensor> {
        if let Seed::Along(_) = self.seed {
            self.no_gradient_across(tensor);
            return None;
        }
        let shape = self.arena.shape(tensor).to_vec();
        let outside = replace(&mut self.restricted, true);
        let change = self.derive(seen);
        self.restricted = outside;
        let mut sum =
            change.map(|change| self.push(Operator::Opposite(change, displacement), shape.clone(), tensor));
        let Some(moved) = self.moved_pair(displacement, tensor) else { return sum };
        for axis in 0..self.dimension {
            let Some(slope) = self.slope_along_surface(seen, axis) else { continue };
            let slope = self.push(Operator::Opposite(slope, displacement), shape.clone(), tensor);
            let by = self.push(Operator::Component(moved.point, vec![axis]), vec![], tensor);
            let part = self.push(Operator::Scale(by, slope), shape.clone(), tensor);
            sum = self.sum(sum, Some(part));
        }
        sum
    }

    /// The derivative of the gap or of the direction.
    pub(super) fn sliding(
        &mut self,
        tensor: Tensor,
        geometry: Geometry,
        displacement: Tensor,
    ) -> Option<Tensor> {
        if let Seed::Along(_) = self.seed {
            self.no_gradient_across(tensor);
            return None;
        }
        let moved = self.moved_pair(displacement, tensor)?;
        if self.restricted {
            self.diagnostics.error_with_help(
                self.arena.span(tensor),
                "`gap` and `toward` are of the pair, and are not differentiated inside a side",
                "take them out of `this(..)`, `other(..)`, `jump(..)` or `avg(..)`",
            );
            return None;
        }
        Some(if geometry == Geometry::Gap { moved.gap } else { moved.toward })
    }

    pub(super) fn no_gradient_across(&mut self, tensor: Tensor) {
        self.diagnostics.error_with_help(
            self.arena.span(tensor),
            "there is no gradient across a contact pair",
            "take gradients of fields at one of its points, `this(grad(u))` or `other(grad(u))`",
        );
    }

    /// ∂e/∂x_k, where only what is tangent to the surface counts.
    fn slope_along_surface(&mut self, seen: Tensor, axis: usize) -> Option<Tensor> {
        let known = take(&mut self.slopes[axis]);
        let mut along = Differentiation::new(
            &mut *self.arena,
            self.dimension,
            Seed::Along(axis),
            vec![],
            self.fields,
            &mut *self.diagnostics,
        );
        along.along_surface = true;
        along.known = known;
        let slope = along.derive(seen);
        self.slopes[axis] = along.known;
        slope
    }

    /// The change of a pair, made once per displacement; `None` where the displacement does not change.
    fn moved_pair(&mut self, displacement: Tensor, origin: Tensor) -> Option<MovedPair> {
        if let Some(known) = self.moved_pairs.get(&displacement) {
            return *known;
        }
        let moved = self.change_of_pair(displacement, origin);
        self.moved_pairs.insert(displacement, moved);
        moved
    }

    fn change_of_pair(&mut self, displacement: Tensor, origin: Tensor) -> Option<MovedPair> {
        use Operator::{
            Add, Cofactor, Contract, Divide, Identity, Inner, Inverse, Map, Negate, Opposite, Restrict,
            Scale, Sliding,
        };
        let (vector, matrix) = (vec![self.dimension], vec![self.dimension; 2]);
        let gradient = self.gradient_of_displacement(displacement, origin);
        let identity = self.push(Identity, matrix.clone(), origin);
        let deformation = self.push(Add(identity, gradient), matrix.clone(), origin);
        let (change, slope) = match self.seed {
            Seed::Toward { variable: Variable::Shape(_), .. } => (self.directions[0], self.directions[1]),
            Seed::Toward { with_gradient: true, .. } => (self.derive(displacement)?, self.derive(gradient)?),
            // Only values vary, or a place: pairs are held.
            _ => return None,
        };
        let toward = self.push(Sliding(Geometry::Toward, displacement), vector.clone(), origin);
        let gap = self.push(Sliding(Geometry::Gap, displacement), vec![], origin);

        // δn_x = n_x (n_x·q) − q, q = F⁻ᵀ (∇δd)ᵀ n_x at X.
        let inverse = self.push(Inverse(deformation), matrix.clone(), origin);
        let turning = self.push(Contract(slope, inverse), matrix.clone(), origin);
        let turning = self.push(Map(LinearMap::Transpose, turning), matrix.clone(), origin);
        let turning = self.push(Restrict(Side::This, turning), matrix.clone(), origin);
        let pulled = self.push(Contract(turning, toward), vector.clone(), origin);
        let across = self.push(Inner(toward, pulled), vec![], origin);
        let kept = self.push(Scale(across, toward), vector.clone(), origin);
        let turned = self.difference(kept, pulled, origin);

        // r = δd(X) − δd(Y) + g δn_x
        let this = self.push(Restrict(Side::This, change), vector.clone(), origin);
        let other = self.push(Opposite(change, displacement), vector.clone(), origin);
        let apart = self.difference(this, other, origin);
        let swung = self.push(Scale(gap, turned), vector.clone(), origin);
        let rate = self.push(Add(apart, swung), vector.clone(), origin);

        // m up to its length, which cancels.
        let normal = self.push(Operator::Geometry(Geometry::Normal), vector.clone(), origin);
        let cofactor = self.push(Cofactor(deformation), matrix.clone(), origin);
        let normal = self.push(Contract(cofactor, normal), vector.clone(), origin);
        let normal = self.push(Opposite(normal, displacement), vector.clone(), origin);
        let (rate_along, facing) = (
            self.push(Inner(normal, rate), vec![], origin),
            self.push(Inner(normal, toward), vec![], origin),
        );
        let along = self.push(Divide(rate_along, facing), vec![], origin);

        let over = self.push(Scale(along, toward), vector.clone(), origin);
        let tangent = self.difference(rate, over, origin);
        let back = self.push(Opposite(inverse, displacement), matrix, origin);
        let point = self.push(Contract(back, tangent), vector, origin);
        let gap = self.push(Negate(along), vec![], origin);
        Some(MovedPair { gap, toward: turned, point })
    }

    /// ∇d of a sum of fields.
    fn gradient_of_displacement(&mut self, displacement: Tensor, origin: Tensor) -> Tensor {
        let matrix = vec![self.dimension; 2];
        match self.arena.node(displacement).operator {
            Operator::Field { field, .. } => self.push(Operator::Field { field, order: 1 }, matrix, origin),
            Operator::Add(a, b) => {
                let parts =
                    (self.gradient_of_displacement(a, origin), self.gradient_of_displacement(b, origin));
                self.push(Operator::Add(parts.0, parts.1), matrix, origin)
            }
            _ => self.push(Operator::Zero, matrix, origin),
        }
    }

    fn difference(&mut self, a: Tensor, b: Tensor, origin: Tensor) -> Tensor {
        let shape = self.arena.shape(a).to_vec();
        let minus = self.push(Operator::Negate(b), shape.clone(), origin);
        self.push(Operator::Add(a, minus), shape, origin)
    }
}
