//! Norms of fields, errors against exact solutions and between meshes; each stated as a form.
//!
//! Norms are integrated with the assembler's quadrature. The estimated degree is exact for fields on straight cells; a function that is no
//! polynomial takes a rule of one's own, of a degree some steps above twice the field's.
//!
//! ```
//! use std::f64::consts::PI;
//!
//! use forms_fem::prelude::*;
//!
//! let exact = |x: &[f64; 2]| (PI * x[0]).sin() * x[1];
//! let slope = |x: &[f64; 2]| [PI * (PI * x[0]).cos() * x[1], (PI * x[0]).sin()];
//!
//! let mut fields = vec![];
//! for cells in [4, 8] {
//!     let mesh = rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Quadrilateral, 1)?;
//!     let space = Space::scalar(&mesh, 2)?;
//!     fields.push((Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8)), Field::interpolate(&space, exact)?));
//! }
//! let [(_, coarse), (assembler, fine)] = &fields[..] else { unreachable!() };
//!
//! // ‖u‖, ‖∇u‖ and √(‖u‖² + ‖∇u‖²); the mean of each component. ∫ sin²(πx) y² = 1/6.
//! let size = norms::norms(assembler, fine)?;
//! assert!((size.l2 - (1.0_f64 / 6.0).sqrt()).abs() < 1e-4 && size.h1 > size.seminorm);
//! assert!((norms::mean(assembler, fine)?[0] - 1.0 / PI).abs() < 1e-4);
//!
//! // Errors against a function and its gradient (component before direction) fall by 2³ and 2² where cells are halved.
//! let error = |(assembler, field): &(Assembler<2>, Field<2>)| {
//!     let gradient = move |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&slope(x));
//!     norms::errors(assembler, field, move |x, out| out[0] = exact(x), gradient)
//! };
//! let (before, after) = (error(&fields[0])?, error(&fields[1])?);
//! assert!((7.0..9.0).contains(&(before.l2 / after.l2)) && (3.5..4.5).contains(&(before.seminorm / after.seminorm)));
//!
//! // Between meshes that need not be nested, integrated on the finer one.
//! let between = norms::errors_between(assembler, fine, coarse)?;
//! assert!((between.l2 / before.l2 - 1.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod between_meshes;

use std::sync::Arc;

use forms_core::contract::Source;

use crate::assemble::{Assembler, AssemblyError};
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::forms;
use crate::instantiate::instantiate;
use crate::linear_algebra::CsrMatrix;
use crate::quadrature::Quadrature;
use crate::space::Space;

pub use between_meshes::{Comparison, errors_between};

#[forms(crate = crate)]
mod squared {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    /// ∫_Ω φ_i
    pub fn basis_over_cells(v: Test<Scalar>) -> Form {
        integral(Omega, v)
    }
    /// ∫_Γ φ_i
    pub fn basis_over_facets(v: Test<Scalar>) -> Form {
        integral(Gamma, v)
    }

    /// ∫ |w|²
    pub fn scalar_l2(w: State<Scalar>) -> Functional {
        integral(Omega, w * w)
    }
    /// ∫ |∇w|²
    pub fn scalar_seminorm(w: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(w), grad(w)))
    }
    pub fn vector_l2(w: State<Vector>) -> Functional {
        integral(Omega, dot(w, w))
    }
    pub fn vector_seminorm(w: State<Vector>) -> Functional {
        integral(Omega, inner(grad(w), grad(w)))
    }
    pub fn tensor_l2(w: State<Tensor>) -> Functional {
        integral(Omega, inner(w, w))
    }

    /// ∫ |w − exact|²
    pub fn scalar_l2_error(w: State<Scalar>, exact: State<Scalar>) -> Functional {
        integral(Omega, pow(w - exact, 2))
    }
    /// ∫ |∇w − slope|²
    pub fn scalar_seminorm_error(w: State<Scalar>, slope: State<Vector>) -> Functional {
        integral(Omega, dot(grad(w) - slope, grad(w) - slope))
    }
    pub fn vector_l2_error(w: State<Vector>, exact: State<Vector>) -> Functional {
        integral(Omega, dot(w - exact, w - exact))
    }
    pub fn vector_seminorm_error(w: State<Vector>, slope: State<Tensor>) -> Functional {
        integral(Omega, inner(grad(w) - slope, grad(w) - slope))
    }

    pub fn scalar_integral(w: State<Scalar>) -> Functional {
        integral(Omega, w)
    }

    /// The mass matrix.
    pub fn mass(w: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, w * v)
    }
}

/// L² norm, H¹ seminorm ‖∇·‖ and full H¹ norm (‖·‖²_H¹ = ‖·‖²_L² + ‖∇·‖²_L²), over all cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Norms {
    /// ‖w‖_L².
    pub l2: f64,
    /// ‖∇w‖_L².
    pub seminorm: f64,
    /// ‖w‖_H¹.
    pub h1: f64,
}

impl Norms {
    fn from_squares(l2: f64, seminorm: f64) -> Self {
        // Rounding may leave a tiny negative sum for a zero field on a signed rule.
        Norms {
            l2: l2.max(0.0).sqrt(),
            seminorm: seminorm.max(0.0).sqrt(),
            h1: (l2 + seminorm).max(0.0).sqrt(),
        }
    }
}

fn everywhere() -> squared::Omega {
    squared::Omega::on(crate::mesh::EVERYWHERE)
}

/// The norms of a scalar or vector field.
///
/// # Errors
/// A tensor field (only its L² norm is defined here: [`l2_norm`]), a value that is not finite, or a field
/// on another mesh than the assembler's.
#[inline(never)]
pub fn norms<const D: usize>(assembler: &Assembler<D>, field: &Field<D>) -> Result<Norms, AssemblyError>
where
    Dim: Dimension<D>,
{
    let seminorm = match field.space().components() {
        1 => assembler.functional(&squared::scalar_seminorm(&everywhere(), field))?,
        _ => assembler.functional(&squared::vector_seminorm(&everywhere(), field))?,
    };
    Ok(Norms::from_squares(l2_squared(assembler, field)?, seminorm))
}

/// The L² norm of a field of any rank.
///
/// # Errors
/// A value that is not finite, or a field on another mesh than the assembler's.
pub fn l2_norm<const D: usize>(assembler: &Assembler<D>, field: &Field<D>) -> Result<f64, AssemblyError>
where
    Dim: Dimension<D>,
{
    l2_squared(assembler, field).map(f64::sqrt)
}

#[inline(never)]
fn l2_squared<const D: usize>(assembler: &Assembler<D>, field: &Field<D>) -> Result<f64, AssemblyError>
where
    Dim: Dimension<D>,
{
    let shape = field.space().shape();
    if shape.is_empty() {
        assembler.functional(&squared::scalar_l2(&everywhere(), field))
    } else if shape == [D] {
        assembler.functional(&squared::vector_l2(&everywhere(), field))
    } else if shape == [D, D] {
        assembler.functional(&squared::tensor_l2(&everywhere(), field))
    } else {
        component_fields(field).iter().map(|part| l2_squared(assembler, part)).sum()
    }
}

/// The mean of each component of a field over the mesh.
///
/// # Errors
/// A value that is not finite, or a field on another mesh than the assembler's.
#[inline(never)]
pub fn mean<const D: usize>(assembler: &Assembler<D>, field: &Field<D>) -> Result<Vec<f64>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let integral = |field: &Field<D>| assembler.functional(&squared::scalar_integral(&everywhere(), field));
    let one = Field::of_known(&field.space().scalar_nodes(), vec![1.0; field.space().node_count()]);
    let volume = integral(&one)?;
    component_fields(field).iter().map(|part| Ok(integral(part)? / volume)).collect()
}

/// Each component as a scalar field.
fn component_fields<const D: usize>(field: &Field<D>) -> Vec<Field<D>> {
    let (space, count) = (field.space().scalar_nodes(), field.space().components());
    let part = |component| field.values().iter().skip(component).step_by(count).copied().collect();
    (0..count).map(|component| Field::of_known(&space, part(component))).collect()
}

/// The norms of field − exact, for a scalar or vector field; `gradient` writes component × direction.
///
/// # Errors
/// A value that is not finite, a wrong number of components, or a field on another mesh.
pub fn errors<const D: usize>(
    assembler: &Assembler<D>,
    field: &Field<D>,
    exact: impl Fn(&[f64; D], &mut [f64]) + Send + Sync + 'static,
    gradient: impl Fn(&[f64; D], &mut [f64]) + Send + Sync + 'static,
) -> Result<Norms, AssemblyError>
where
    Dim: Dimension<D>,
{
    let components = field.space().components();
    let exact = Source::Function { components, function: Arc::new(exact), gradient: None };
    let gradient =
        Source::Function { components: components * D, function: Arc::new(gradient), gradient: None };
    errors_against(assembler, field, exact, gradient)
}

/// The norms of field − exact, whose gradient is given, too.
#[inline(never)]
fn errors_against<const D: usize>(
    assembler: &Assembler<D>,
    field: &Field<D>,
    exact: Source<D>,
    gradient: Source<D>,
) -> Result<Norms, AssemblyError>
where
    Dim: Dimension<D>,
{
    let omega = everywhere();
    let (l2, seminorm) = match field.space().components() {
        1 => (
            assembler.functional(&squared::scalar_l2_error(&omega, field, exact))?,
            assembler.functional(&squared::scalar_seminorm_error(&omega, field, gradient))?,
        ),
        _ => (
            assembler.functional(&squared::vector_l2_error(&omega, field, exact))?,
            assembler.functional(&squared::vector_seminorm_error(&omega, field, gradient))?,
        ),
    };
    Ok(Norms::from_squares(l2, seminorm))
}

/// The integral of each scalar basis function of a space over a region of cells, or else of facets.
///
/// # Errors
/// An unknown region.
#[inline(never)]
pub(crate) fn basis_integrals<const D: usize>(
    space: &Arc<Space<D>>,
    region: &str,
) -> Result<Vec<f64>, AssemblyError>
where
    Dim: Dimension<D>,
{
    let (nodes, assembler) = (space.scalar_nodes(), Assembler::new(space.mesh()));
    if space.mesh().cell_region(region).is_ok() {
        assembler.linear_form(&squared::basis_over_cells(&squared::Omega::on(region)), &nodes)
    } else {
        assembler.linear_form(&squared::basis_over_facets(&squared::Gamma::on(region)), &nodes)
    }
}

/// The scalar mass matrix of a space's element (one unknown per node).
///
/// # Errors
/// Data that do not fit.
#[inline(never)]
pub(crate) fn mass_matrix<const D: usize>(
    assembler: &Assembler<D>,
    space: &Arc<Space<D>>,
    degree: usize,
) -> Result<CsrMatrix, AssemblyError>
where
    Dim: Dimension<D>,
{
    let nodes = space.scalar_nodes();
    let assembler = Assembler::new(assembler.mesh()).with_quadrature(Quadrature::Degree(degree));
    assembler.tangent(&squared::mass(&everywhere()), &[&Field::zero(&nodes)], &[&nodes])
}

instantiate!(
    norms of forms: norms::<D>,
    l2_squared::<D>,
    mean::<D>,
    errors_against::<D>,
    basis_integrals::<D>,
    mass_matrix::<D>,
);
