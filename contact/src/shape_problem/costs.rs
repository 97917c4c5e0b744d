//! Costs of a shape besides its criterion: volume and perimeter.

use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Failure, Volume, measured_volume, perimeter, perimeter_derivative};

/// Control of the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VolumeRule {
    /// V = V₀.
    Constraint(Volume),
    /// λ V is added to the criterion \[criterion/volume\].
    Penalty(f64),
}

/// Penalties of a shape.
pub(crate) struct Costs<'a> {
    pub volume: VolumeRule,
    /// Γ_m.
    pub moving: &'a str,
    pub perimeter_penalty: f64,
}

impl Costs<'_> {
    /// The sum added to the criterion, and the constraint's value.
    ///
    /// # Errors
    /// Those of the perimeter and of the volume.
    pub fn values<const D: usize>(&self, mesh: &Mesh<D>) -> Result<(f64, Option<f64>), Failure>
    where
        Dim: Dimension<D>,
    {
        let boundary = self.perimeter_penalty * perimeter(mesh, self.moving)?;
        Ok(match self.volume {
            VolumeRule::Constraint(volume) => (boundary, Some(volume.value(mesh)?)),
            VolumeRule::Penalty(weight) => (boundary + weight * measured_volume(mesh)?, None),
        })
    }

    /// The derivative of the constraint. The derivatives of the added costs are added to that of the criterion.
    ///
    /// # Errors
    /// Those of the derivatives of the perimeter and of the volume.
    pub fn add_derivatives<const D: usize>(
        &self,
        movements: &Arc<Space<D>>,
        criterion: &mut [f64],
    ) -> Result<Option<Vec<f64>>, Failure>
    where
        Dim: Dimension<D>,
    {
        add(criterion, self.perimeter_penalty, &perimeter_derivative(movements, self.moving)?);
        Ok(match self.volume {
            VolumeRule::Constraint(volume) => Some(volume.derivative(movements)?),
            VolumeRule::Penalty(weight) => {
                let by_volume = Volume { target: 1.0 }.derivative(movements)?;
                add(criterion, weight, &by_volume);
                None
            }
        })
    }
}

/// Holds these boundaries where they are.
pub(crate) fn fix_regions<const D: usize>(
    regions: &[String],
    movements: &mut Constraints<D>,
) -> Result<(), Failure>
where
    Dim: Dimension<D>,
{
    for region in regions {
        movements.fix(region, |_| [0.0; D])?;
    }
    Ok(())
}

/// Adds a multiple of a vector.
pub(crate) fn add(sum: &mut [f64], factor: f64, other: &[f64]) {
    sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += factor * other);
}
