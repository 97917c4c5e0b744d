//! The perimeter: length (area) of a boundary, and its derivative by the shape. As a penalty it regularises the boundary;
//! without it a minimiser need not exist.

use std::sync::Arc;

use crate::assemble::{Assembler, AssemblyError};
use crate::dimension::{Dim, Dimension};
use crate::forms;
use crate::mesh::Mesh;
use crate::quadrature::Quadrature;
use crate::space::Space;

/// Forms of the measure.
#[forms(crate = crate)]
pub mod perimeter_form {
    /// The boundary.
    #[facets]
    pub struct Boundary;

    /// ∫ 1.
    pub fn measure() -> Functional {
        integral(Boundary, 1)
    }
    /// The derivative of the perimeter by the shape.
    pub fn gradient(Theta: Test<Vector>) -> Form {
        derivative(measure(), shape, Theta)
    }
}

/// On curved facets the integrand is a root of a polynomial; both integrals take the same points, so that the second is the
/// derivative of the first.
fn assembler<const D: usize>(mesh: &Mesh<D>) -> Assembler<D> {
    Assembler::new(mesh).with_quadrature(Quadrature::Degree(4 * mesh.degree()))
}

fn on(region: &str) -> perimeter_form::Model {
    perimeter_form::Model { regions: perimeter_form::Regions::default().boundary(region) }
}

/// The measure of a region of facets \[length^(D−1)\].
///
/// # Errors
/// A region that does not exist.
pub fn perimeter<const D: usize>(mesh: &Mesh<D>, region: &str) -> Result<f64, AssemblyError>
where
    Dim: Dimension<D>,
{
    assembler(mesh).functional(&on(region).measure())
}

/// The derivative of the perimeter by the movement of each node \[length^(D−2)\].
///
/// # Errors
/// A region that does not exist.
pub fn perimeter_derivative<const D: usize>(
    movements: &Arc<Space<D>>,
    region: &str,
) -> Result<Vec<f64>, AssemblyError>
where
    Dim: Dimension<D>,
{
    assembler(movements.mesh()).linear_form(&on(region).gradient(), movements)
}
