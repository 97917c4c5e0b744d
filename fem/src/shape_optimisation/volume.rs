//! The volume of a body and its derivative by the shape: the usual constraint.

use std::sync::Arc;

use crate::assemble::{Assembler, AssemblyError};
use crate::dimension::{Dim, Dimension};
use crate::forms;
use crate::mesh::Mesh;
use crate::quadrature::Quadrature;
use crate::space::Space;

/// Forms of the volume.
#[forms(crate = crate)]
pub mod volume_form {
    /// The body.
    #[cells]
    pub struct Omega;

    /// ∫ 1.
    pub fn measure() -> Functional {
        integral(Omega, 1)
    }
    /// The derivative of the volume by the shape.
    pub fn gradient(Theta: Test<Vector>) -> Form {
        derivative(measure(), shape, Theta)
    }
}

/// |Ω| \[length^D\], exact for the mesh's cells, curved ones too.
///
/// # Errors
/// As [`Assembler::functional`].
pub fn measured_volume<const D: usize>(mesh: &Mesh<D>) -> Result<f64, AssemblyError>
where
    Dim: Dimension<D>,
{
    exact(mesh).functional(&volume_form::Model::default().measure())
}

/// det J of cells of degree k has degree k D in each direction, at most.
fn exact<const D: usize>(mesh: &Mesh<D>) -> Assembler<D> {
    Assembler::new(mesh).with_quadrature(Quadrature::Degree(D * mesh.degree()))
}

/// The constraint (V − V₀)/V₀ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// V₀ \[length^D\].
    pub target: f64,
}

impl Volume {
    /// (V − V₀)/V₀.
    ///
    /// # Errors
    /// As [`measured_volume`].
    pub fn value<const D: usize>(&self, mesh: &Mesh<D>) -> Result<f64, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        Ok((measured_volume(mesh)? - self.target) / self.target)
    }

    /// The derivative of the volume by the movement of each node \[1/length\].
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    pub fn derivative<const D: usize>(&self, movements: &Arc<Space<D>>) -> Result<Vec<f64>, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        let form = volume_form::Model::default().gradient();
        let values = exact(movements.mesh()).linear_form(&form, movements)?;
        Ok(values.into_iter().map(|value| value / self.target).collect())
    }
}
