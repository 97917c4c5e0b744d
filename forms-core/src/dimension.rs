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

use crate::integrals::Integrals;

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
