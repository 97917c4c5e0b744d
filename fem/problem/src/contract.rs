//! The contract between compiled forms and this backend: that of `forms-core`, with forms as values of this backend.

pub use forms_core::contract::*;
use forms_core::function;

use crate::assemble::Lanes;

/// A residual R(u; v), linear in its test functions, and its tangent ∂R/∂u by the compiler. Cheap to clone.
///
/// Forms add up and scale, whatever modules they come from. The sum is a form with the unknowns and test functions of its parts, which
/// are matched by their order and shape. A part without unknowns is a load. Regions and data stay those of each part.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?;
/// let space = Space::scalar(&mesh, 1)?;
/// let membrane = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v))));
/// let bedding = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), u * v));
/// let load = form!(|v: Test<Scalar>| -> Form { integral(cells("all"), v) });
/// let mut loads = vec![2.0 * &load, 0.5 * &load];
/// loads.push(load);
/// let form: Form<2> = membrane + 10.0 * bedding - loads.iter().sum::<Form<2>>();
/// let u = Problem::new(&form, &space).solve()?.into_field();
/// // Without a rim it sinks as one: 10 u = 3.5.
/// assert!(u.values().iter().all(|u| (u - 0.35).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Parts that do not fit each other are an error of whatever assembles the sum first ([`CombinationError`]).
pub type Form<const D: usize> = function::Form<D, Lanes>;
/// An energy W(u): a number, and the form of its first variation, which it can be used as.
pub type Energy<const D: usize> = function::Energy<D, Lanes>;
/// A number: the integral of a density without test function.
pub type Functional<const D: usize> = function::Functional<D, Lanes>;
/// A derived field: a function of a forms module, evaluated where the user asks.
pub type Expression<const D: usize> = function::Expression<D, Lanes>;
/// Compiled function of any kind: the common part of forms, energies, functionals and expressions.
pub type Function<const D: usize> = function::Function<D, Lanes>;
