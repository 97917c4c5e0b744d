//! The dimensions that forms are compiled for, as one bound for code that is generic over the dimension.
//!
//! A form of `#[forms]` has kernels for two and three dimensions. Code that is generic over D states that D is one of
//! them, once, whatever the number of its forms:
//!
//! ```
//! use forms_core::contract::{Dim, Dimension, Form};
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

use crate::form::{BilinearVisitor, ExpressionVisitor, FieldDescription, LinearVisitor};
use crate::table::Table;

/// The numbers that a form's kernels read: parameters and tables, in the order of [`crate::form::Inputs`].
#[derive(Clone, Copy, Debug)]
pub struct Constants<'a> {
    /// All parameters, flattened.
    pub parameters: &'a [f64],
    /// The tabulated laws.
    pub tables: &'a [Table],
}

/// The integrals of one compiled function in one dimension, with their kernels. `#[forms]` implements it; users meet it as
/// [`Form`](crate::form::Form), [`Functional`](crate::form::Functional) and [`Expression`](crate::form::Expression), which
/// say what each walk visits. What a function does not have is not visited.
pub trait Integrals<const D: usize> {
    /// The fields, by index.
    fn fields() -> &'static [FieldDescription];
    /// Shape of the value of a derived field.
    fn shape() -> &'static [usize] {
        &[]
    }
    /// The residual, one integral per region and dependence.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn residual<V: LinearVisitor<D>>(_: Constants<'_>, _: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
    /// The residual, joined on each region.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn whole_residual<V: LinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error> {
        Self::residual(constants, visitor)
    }
    /// The tangent, one integral per region and dependence.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn tangent<V: BilinearVisitor<D>>(_: Constants<'_>, _: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
    /// The tangent, joined on each region.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn whole_tangent<V: BilinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error> {
        Self::tangent(constants, visitor)
    }
    /// The tangent applied to a direction.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn action<V: LinearVisitor<D>>(_: Constants<'_>, _: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
    /// The switches of integrals that have kinks.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn switches<V: ExpressionVisitor<D>>(_: Constants<'_>, _: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
    /// The densities of a functional.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn density<V: ExpressionVisitor<D>>(_: Constants<'_>, _: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
    /// The value of a derived field.
    ///
    /// # Errors
    /// The visitor's.
    #[inline]
    fn expression<V: ExpressionVisitor<D>>(_: Constants<'_>, _: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
}

/// The dimensions of space: `Dim: Dimension<D>` holds for D = 2 and D = 3.
#[derive(Clone, Copy, Debug)]
pub struct Dim;

/// A dimension that forms are compiled for. Sealed: implemented for [`Dim`] with two and three.
pub trait Dimension<const D: usize>: sealed::Sealed {
    /// See [`Integrals::fields`].
    fn fields<I: Integrals<2> + Integrals<3>>() -> &'static [FieldDescription];
    /// See [`Integrals::shape`].
    fn shape<I: Integrals<2> + Integrals<3>>() -> &'static [usize];
    /// See [`Integrals::residual`].
    ///
    /// # Errors
    /// The visitor's.
    fn residual<I: Integrals<2> + Integrals<3>, V: LinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::whole_residual`].
    ///
    /// # Errors
    /// The visitor's.
    fn whole_residual<I: Integrals<2> + Integrals<3>, V: LinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::tangent`].
    ///
    /// # Errors
    /// The visitor's.
    fn tangent<I: Integrals<2> + Integrals<3>, V: BilinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::whole_tangent`].
    ///
    /// # Errors
    /// The visitor's.
    fn whole_tangent<I: Integrals<2> + Integrals<3>, V: BilinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::action`].
    ///
    /// # Errors
    /// The visitor's.
    fn action<I: Integrals<2> + Integrals<3>, V: LinearVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::switches`].
    ///
    /// # Errors
    /// The visitor's.
    fn switches<I: Integrals<2> + Integrals<3>, V: ExpressionVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::density`].
    ///
    /// # Errors
    /// The visitor's.
    fn density<I: Integrals<2> + Integrals<3>, V: ExpressionVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
    /// See [`Integrals::expression`].
    ///
    /// # Errors
    /// The visitor's.
    fn expression<I: Integrals<2> + Integrals<3>, V: ExpressionVisitor<D>>(
        constants: Constants<'_>,
        visitor: &mut V,
    ) -> Result<(), V::Error>;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Dim {}
}

/// Each walk goes to the integrals of the dimension.
macro_rules! dimension {
    ($number:literal: $($walk:ident by $visitor:ident),*) => {
        impl Dimension<$number> for Dim {
            #[inline]
            fn fields<I: Integrals<2> + Integrals<3>>() -> &'static [FieldDescription] {
                <I as Integrals<$number>>::fields()
            }
            #[inline]
            fn shape<I: Integrals<2> + Integrals<3>>() -> &'static [usize] {
                <I as Integrals<$number>>::shape()
            }
            $(
                #[inline]
                fn $walk<I: Integrals<2> + Integrals<3>, V: $visitor<$number>>(
                    constants: Constants<'_>,
                    visitor: &mut V,
                ) -> Result<(), V::Error> {
                    <I as Integrals<$number>>::$walk(constants, visitor)
                }
            )*
        }
    };
}

/// The walks and their visitors.
macro_rules! dimensions {
    ($($number:literal),*) => {$(
        dimension! {
            $number: residual by LinearVisitor, whole_residual by LinearVisitor, tangent by BilinearVisitor,
            whole_tangent by BilinearVisitor, action by LinearVisitor, switches by ExpressionVisitor,
            density by ExpressionVisitor, expression by ExpressionVisitor
        }
    )*};
}

dimensions!(2, 3);
