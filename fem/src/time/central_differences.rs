//! Central differences: explicit steps for second order in time.

use super::scheme::{Combination, Formulas, Scheme, SolvedFor};

/// u₁ = u₀ + Δt u̇₀ + Δt²/2 ü₀, then the acceleration ü₁ from the forces there, and u̇₁ = u̇₀ + Δt (ü₀ + ü₁)/2. Forces that
/// depend on velocities see u̇₀ + Δt ü₀. Second order; stable for Δt ≤ 2/ω with the largest angular frequency ω of the mesh,
/// about the time that a wave takes through the smallest cell.
///
/// The matrix of each step is the mass; with [`Mass::Lumped`](super::Mass::Lumped) it is diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CentralDifferences;

impl Scheme for CentralDifferences {
    fn reads_second_rates(&self) -> bool {
        true
    }

    fn solved_for(&self) -> SolvedFor {
        SolvedFor::SecondRate
    }

    fn formulas(&self, steps: &[f64]) -> Formulas {
        let step = steps[0];
        let value = Combination::new(0.0, [1.0, step, step * step / 2.0]);
        let rate = Combination::new(step / 2.0, [0.0, 1.0, step / 2.0]);
        let second_rate = Combination::new(1.0, [0.0; 3]);
        Formulas {
            evaluated: [value.clone(), Combination::new(0.0, [0.0, 1.0, step]), second_rate.clone()],
            end: [value, rate, second_rate],
            load_at: 1.0,
        }
    }
}
