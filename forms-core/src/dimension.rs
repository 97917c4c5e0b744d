//! The dimensions that forms are compiled for, as one bound for code that is generic over the dimension.
//!
//! A form of `#[forms]` has kernels for two and three dimensions. Code that is generic over D states that D is one of
//! them, once, whatever the number of its forms:
//!
//! ```
//! use forms_core::contract::{Dim, Dimension};
//! # #[forms_core::forms(crate = ::forms_core)]
//! # mod diffusion {
//! #     #[cells]
//! #     pub struct Omega;
//! #     pub fn stiffness(u: Unknown<Scalar>, v: Test<Scalar>) -> Form { integral(Omega, dot(grad(u), grad(v))) }
//! #     pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form { integral(Omega, u * v) }
//! # }
//! fn names<const D: usize>() -> [&'static str; 2]
//! where
//!     Dim: Dimension<D>,
//! {
//!     let omega = diffusion::Omega::on("all");
//!     [diffusion::stiffness::<D>(&omega).name(), diffusion::mass::<D>(&omega).name()]
//! }
//! assert_eq!(names::<3>(), ["stiffness", "mass"]);
//! ```

use crate::form::FieldDescription;
use crate::function::{Backend, Term};
use crate::table::Table;

/// The numbers that a form's kernels read: parameters and tables, in the order of [`crate::form::Inputs`].
#[derive(Clone, Copy, Debug)]
pub struct Constants<'a> {
    /// All parameters, flattened.
    pub parameters: &'a [f64],
    /// The tabulated laws.
    pub tables: &'a [Table],
}

/// The integrals of one compiled function in one dimension, with their kernels. `#[forms]` implements it; users meet values that
/// hold them, as [`Form`](crate::function::Form). What a function does not have is an empty list.
pub trait Integrals<const D: usize>: 'static {
    /// The fields, by index.
    fn fields() -> &'static [FieldDescription];
    /// Shape of the value of a derived field.
    fn shape() -> &'static [usize] {
        &[]
    }
    /// The residual, one term per region and dependence.
    fn residual<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// One term for all of a region, where several depend on the unknowns.
    fn joined_residual<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// The tangent, one term per region and dependence.
    fn tangent<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Bilinear>> {
        vec![]
    }
    /// The tangent, one term for all of a region, where the residual is joined. Only element kernels compile it.
    fn joined_tangent<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Bilinear>> {
        vec![]
    }
    /// The tangent applied to a direction.
    fn action<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// The switches of integrals that have kinks.
    fn switches<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Expression>> {
        vec![]
    }
    /// The densities of a functional, or the value of a derived field, whose region has no meaning.
    fn density<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Expression>> {
        vec![]
    }
}

/// The dimensions of space: `Dim: Dimension<D>` holds for D = 2 and D = 3.
#[derive(Clone, Copy, Debug)]
pub struct Dim;

/// A dimension that forms are compiled for. Sealed: implemented for [`Dim`] with two and three.
pub trait Dimension<const D: usize>: sealed::Sealed {
    /// A function that is compiled for all dimensions, in this one.
    type Of<I: Integrals<2> + Integrals<3>>: Integrals<D>;
}

impl Dimension<2> for Dim {
    type Of<I: Integrals<2> + Integrals<3>> = I;
}

impl Dimension<3> for Dim {
    type Of<I: Integrals<2> + Integrals<3>> = I;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Dim {}
}
