//! Volume and perimeter of a cut body, with their derivatives by φ.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::assemble::{Assembler, AssemblyError};
use crate::cut::Cut;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::forms;
use crate::shape_optimisation::Failure;
use crate::space::Space;

/// Forms of the measures, times a test function.
#[forms(crate = crate, level_set_derivatives)]
pub mod measure_forms {
    /// The body.
    #[cells]
    pub struct Omega;
    /// Γ, the boundary of the body inside cells.
    #[interface]
    pub struct Gamma;

    /// ∫ t.
    pub fn volume(t: Test<Scalar>) -> Form {
        integral(Omega, t)
    }
    /// ∫_Γ t.
    pub fn perimeter(t: Test<Scalar>) -> Form {
        integral(Gamma, t)
    }
}

/// A form's value for t = 1, and its derivative by φ.
fn of_form<const D: usize>(
    body: &Arc<Cut<D>>,
    form: &crate::contract::Form<D>,
) -> Result<(f64, Vec<f64>), Failure> {
    let constants = Space::discontinuous_scalar(body.mesh(), 0)?;
    let one = Field::from_values(&constants, vec![1.0; constants.unknowns()])?;
    let assembler = Assembler::new(body.mesh()).with_cut(body)?;
    let value = assembler.linear_form(form, &constants)?.iter().sum();
    let slopes: Result<Vec<f64>, AssemblyError> = assembler.derivative_by_level_set(form, &[], &[&one]);
    Ok((value, slopes?))
}

/// A quantity as means around the nodes of a space, zero where nothing of the body is: ∫ q t / ∫ t with the form's test function t. The form
/// is ∫ q t.
///
/// # Errors
/// Those of [`Assembler::linear_form`].
pub fn means_at_nodes<const D: usize>(
    assembler: &Assembler<D>,
    form: &crate::contract::Form<D>,
    space: &Arc<Space<D>>,
) -> Result<Vec<f64>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let volumes = assembler.linear_form(&measure_forms::Model::default().volume(), space)?;
    let sums = assembler.linear_form(form, space)?;
    Ok(sums.iter().zip(volumes).map(|(sum, volume)| if volume > 0.0 { sum / volume } else { 0.0 }).collect())
}

/// |Γ| \[length^(D−1)\] without the parts of the body's boundary on exterior facets, and its derivative by the nodal values of φ.
///
/// # Errors
/// Those of [`Assembler::derivative_by_level_set`].
pub fn interface_measure<const D: usize>(body: &Arc<Cut<D>>) -> Result<(f64, Vec<f64>), Failure>
where
    Dim: Dimension<D>,
{
    of_form(body, &measure_forms::Model::default().perimeter())
}

/// The constraint (V − V₀)/V₀ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSetVolume {
    /// V₀ \[length^D\].
    pub target: f64,
}

impl LevelSetVolume {
    /// (V − V₀)/V₀ and its derivative by the nodal values of φ.
    ///
    /// # Errors
    /// Those of [`Assembler::derivative_by_level_set`].
    pub fn value<const D: usize>(&self, body: &Arc<Cut<D>>) -> Result<(f64, Vec<f64>), Failure>
    where
        Dim: Dimension<D>,
    {
        let (value, slopes) = of_form(body, &measure_forms::Model::default().volume())?;
        let slopes = slopes.into_iter().map(|slope| slope / self.target).collect();
        Ok(((value - self.target) / self.target, slopes))
    }

    /// The topological derivative −|B|/V₀ with the unit ball B \[1/length^D\], the same everywhere.
    pub fn by_hole<const D: usize>(&self) -> f64 {
        let ball = if D == 2 { PI } else { 4.0 / 3.0 * PI };
        -ball / self.target
    }
}
