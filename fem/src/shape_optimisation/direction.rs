//! The descent direction: down the criterion along the constraint, and back to the constraint.

use super::error::ShapeOptimisationError;
use crate::linear_algebra::vector::{add_scaled, dot};

/// The descent of the augmented Lagrangian L = J + λ c + r c²/2 from a shape. λ is the first-order estimate
/// −⟨∇J, ∇c⟩/⟨∇c, ∇c⟩, so that the derivative of J + λ c has no part along ∇c. In the inner product with r Dc ⊗ Dc added,
/// which a step of factor τ sees as 1/τ ⟨·,·⟩ + r Dc ⊗ Dc, steepest descent is
///
/// ```text
/// −τ (∇J + λ ∇c) − ϱ c ∇c/⟨∇c, ∇c⟩,   ϱ = r τ s/(1 + r τ s),   s = ⟨∇c, ∇c⟩,
/// ```
///
/// and a large r, which would ask for tiny steps, does no harm: what it restores is restored by a step of Newton's method.
#[derive(Clone, Debug)]
pub(super) struct Direction {
    /// ∇J + λ ∇c.
    along: Vec<f64>,
    /// −c ∇c/s, shortened to the longest move that is allowed.
    back: Vec<f64>,
    /// λ.
    pub multiplier: f64,
    /// ‖∇J + λ ∇c‖.
    pub norm: f64,
    /// r.
    penalty: f64,
    /// s.
    square: f64,
    /// The fraction of the way back that `back` covers, times c².
    restored: f64,
}

/// The constraint: its value, its derivative, and the movement that represents it.
pub(super) struct Constrained<'a> {
    pub value: f64,
    pub derivative: &'a [f64],
    pub movement: &'a [f64],
}

impl Direction {
    /// From the criterion's derivative and the movement that represents it; `dimension` numbers per node.
    pub fn new(
        derivative: &[f64],
        movement: Vec<f64>,
        constraint: Option<Constrained>,
        penalty: f64,
        longest_move: f64,
        dimension: usize,
    ) -> Self {
        let mut along = movement;
        let mut total = derivative.to_vec();
        let mut back = vec![0.0; along.len()];
        let (mut multiplier, mut square, mut restored) = (0.0, 0.0, 0.0);
        if let Some(Constrained { value, derivative: by, movement: gradient }) = constraint {
            square = dot(by, gradient);
            if square > 0.0 {
                multiplier = -dot(derivative, gradient) / square;
                add_scaled(&mut along, multiplier, gradient);
                add_scaled(&mut total, multiplier, by);
                add_scaled(&mut back, -value / square, gradient);
                let length = longest(&back, dimension);
                let fraction = if length > longest_move { longest_move / length } else { 1.0 };
                back.iter_mut().for_each(|x| *x *= fraction);
                restored = fraction * value * value;
            }
        }
        let norm = dot(&total, &along).max(0.0).sqrt();
        Direction { along, back, multiplier, norm, penalty, square, restored }
    }

    /// The movement of a step of factor τ.
    pub fn movement(&self, factor: f64) -> Vec<f64> {
        let mut movement: Vec<f64> = self.along.iter().map(|x| -factor * x).collect();
        add_scaled(&mut movement, self.step_fraction(factor), &self.back);
        movement
    }

    /// The derivative of L along that movement: negative, but at a stationary point.
    pub fn slope(&self, factor: f64) -> f64 {
        -factor * self.norm * self.norm - self.step_fraction(factor) * self.penalty * self.restored
    }

    /// J + λ c + r c²/2.
    pub fn lagrangian(&self, criterion: f64, constraint: Option<f64>) -> f64 {
        let value = constraint.unwrap_or(0.0);
        criterion + self.multiplier * value + 0.5 * self.penalty * value * value
    }

    /// λ + r c, the derivative of L by the constraint.
    pub fn price(&self, constraint: f64) -> f64 {
        self.multiplier + self.penalty * constraint
    }

    /// The factor with which the part along the constraint moves a node by a length, at most; none if it moves nothing.
    pub fn factor_for(&self, length: f64, dimension: usize) -> Option<f64> {
        let largest = longest(&self.along, dimension);
        (largest > 0.0).then(|| length / largest)
    }

    /// ϱ.
    fn step_fraction(&self, factor: f64) -> f64 {
        let product = self.penalty * factor * self.square;
        product / (1.0 + product)
    }
}

/// The longest way of a node.
pub(super) fn longest(movement: &[f64], dimension: usize) -> f64 {
    let length = |by: &[f64]| by.iter().map(|x| x * x).sum::<f64>().sqrt();
    movement.chunks(dimension).map(length).fold(0.0, f64::max)
}

/// Whether a derivative has an entry per unknown.
pub(super) fn check_length(
    what: &'static str,
    derivative: &[f64],
    expected: usize,
) -> Result<(), ShapeOptimisationError> {
    match derivative.len() == expected {
        true => Ok(()),
        false => Err(ShapeOptimisationError::Length { what, expected, found: derivative.len() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the plane, with the usual inner product: J = x + 2y, c = y − 1 at (0, 1.5).
    #[test]
    fn it_is_steepest_descent_in_the_enlarged_product() {
        let (derivative, by) = ([1.0, 2.0], [0.0, 1.0]);
        for (penalty, factor) in [(1.0, 0.5), (1e6, 0.5), (3.0, 10.0)] {
            let constrained = Constrained { value: 0.5, derivative: &by, movement: &by };
            let direction =
                Direction::new(&derivative, derivative.to_vec(), Some(constrained), penalty, 9.0, 2);
            assert_eq!((direction.multiplier, direction.norm), (-2.0, 1.0));
            // (1/τ + r b bᵀ) d = −(derivative of L).
            let of_lagrangian = [1.0, 2.0 - 2.0 + penalty * 0.5];
            let expected = [-factor * of_lagrangian[0], -of_lagrangian[1] / (1.0 / factor + penalty)];
            let movement = direction.movement(factor);
            assert!(movement.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14 * b.abs()));
            let slope: f64 = movement.iter().zip(of_lagrangian).map(|(a, b)| a * b).sum();
            assert!((direction.slope(factor) / slope - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn moves_are_no_longer_than_asked() {
        let by = [3.0, 4.0];
        let constrained = Constrained { value: 50.0, derivative: &by, movement: &by };
        let direction = Direction::new(&[1.0, 0.0], vec![1.0, 0.0], Some(constrained), 1e12, 0.1, 2);
        assert!((longest(&direction.movement(0.0), 2)).abs() < 1e-15);
        let factor = direction.factor_for(0.2, 2).unwrap();
        let along = longest(&direction.movement(factor), 2);
        assert!(along < 0.3 + 1e-12, "{along}");
        let slope = direction.movement(factor)[0] * (1.0 + direction.multiplier * 3.0 + 1e12 * 50.0 * 3.0)
            + direction.movement(factor)[1] * (direction.multiplier * 4.0 + 1e12 * 50.0 * 4.0);
        assert!((direction.slope(factor) / slope - 1.0).abs() < 1e-9);
    }
}
