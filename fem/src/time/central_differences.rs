//! Central differences: explicit steps for second order in time.

use super::error::StepFailure;
use super::scheme::{Combination, Formulas, Scheme, SolvedFor};
use crate::constraints::Constraints;
use crate::field::Field;

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

/// Whether prescribed values are those that an explicit step takes: it does so before it knows forces, and nothing can move a support
/// then.
pub(crate) fn supports_stand<const D: usize>(
    value: &Field<D>,
    constraints: &Constraints<D>,
) -> Result<(), StepFailure> {
    let mut held = value.values().to_vec();
    constraints.apply(&mut held);
    let scale = held.iter().fold(0.0_f64, |scale, value| scale.max(value.abs()));
    for (unknown, (&from, &to)) in value.values().iter().zip(&held).enumerate() {
        if (from - to).abs() > 1e-12 * scale {
            return Err(StepFailure::MovingSupport { unknown, from, to });
        }
    }
    Ok(())
}
