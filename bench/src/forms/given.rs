//! The forms with the basket's data: constants λ, μ, γ₀ in this order, and fields.

use std::marker::PhantomData;

use forms_fem::contract;
use forms_fem::prelude::*;

use super::*;

/// The region to which cell integrals are bound.
const CELLS: &str = "all";
/// The region to which facet integrals are bound.
const FACETS: &str = "boundary";
/// Replaces a field that the kernel reads from a list.
const UNREAD: f64 = 0.0;

/// [`fn@diffusion::stiffness`].
pub fn poisson<const D: usize>() -> Form<D>
where
    Dim: Dimension<D>,
{
    diffusion::stiffness(&diffusion::data(), &diffusion::Omega::on(CELLS))
}

/// [`fn@inertia::vector`].
pub fn mass<const D: usize>() -> Form<D>
where
    Dim: Dimension<D>,
{
    inertia::vector(&inertia::data(), &inertia::Omega::on(CELLS))
}

/// [`fn@linear_elastic::stiffness`].
pub fn elasticity<const D: usize>(c: &[f64]) -> Form<D>
where
    Dim: Dimension<D>,
{
    let data = linear_elastic::data().lambda(c[0]).mu(c[1]);
    linear_elastic::stiffness(&data, &linear_elastic::Omega::on(CELLS))
}

/// [`fn@rubber::energy`].
pub fn neo_hookean<const D: usize>(c: &[f64]) -> Energy<D>
where
    Dim: Dimension<D>,
{
    rubber::energy(&rubber::data().lambda(c[0]).mu(c[1]), &rubber::Omega::on(CELLS))
}

/// [`fn@small_strain_contact::nitsche`] for a kernel that reads the gap from a list.
pub fn contact<const D: usize>(c: &[f64]) -> Form<D>
where
    Dim: Dimension<D>,
{
    let data = small_strain_contact::data().lambda(c[0]).mu(c[1]).gamma0(c[2]).gap(UNREAD);
    small_strain_contact::nitsche(&data, &small_strain_contact::GammaC::on(FACETS))
}

/// [`fn@small_strain_contact::body`] with one gap \[length\] everywhere on a facet region.
pub fn body_in_contact<const D: usize>(c: &[f64], region: &str, gap: f64) -> Form<D>
where
    Dim: Dimension<D>,
{
    let data = small_strain_contact::data().lambda(c[0]).mu(c[1]).gamma0(c[2]).gap(gap);
    let (omega, contact) = (small_strain_contact::Omega::on(CELLS), small_strain_contact::GammaC::on(region));
    small_strain_contact::body(&data, &omega, &contact)
}

/// [`fn@finite_strain_contact::nitsche`] for a kernel that reads the gap from a list.
pub fn finite_contact<const D: usize>(c: &[f64]) -> Form<D>
where
    Dim: Dimension<D>,
{
    let data = finite_strain_contact::data().lambda(c[0]).mu(c[1]).gamma0(c[2]).gap(UNREAD);
    finite_strain_contact::nitsche(&data, &finite_strain_contact::GammaC::on(FACETS))
}

/// A form with the type of its integrals, which element kernels are compiled from.
pub trait WithIntegrals<const D: usize> {
    /// The type of the integrals.
    type Integrals: contract::Integrals<D>;

    /// The form.
    fn form(&self) -> &Form<D>;
}

/// A form whose integrals are those of `I`.
pub struct Typed<I, const D: usize> {
    form: Form<D>,
    integrals: PhantomData<I>,
}

impl<I: contract::Integrals<2> + contract::Integrals<3>, const D: usize> WithIntegrals<D> for Typed<I, D>
where
    Dim: Dimension<D>,
{
    type Integrals = <Dim as contract::Dimension<D>>::Of<I>;

    fn form(&self) -> &Form<D> {
        &self.form
    }
}

/// The same forms with the types of their integrals.
macro_rules! typed {
    ($($name:ident($($constants:ident)?): $integrals:ty;)*) => {
        /// The forms with the types of their integrals.
        pub mod typed {
            use super::*;

            $(
                /// The form of this name.
                pub fn $name<const D: usize>($($constants: &[f64])?) -> Typed<$integrals, D>
                where
                    Dim: Dimension<D>,
                {
                    Typed { form: super::$name($($constants)?).into(), integrals: PhantomData }
                }
            )*
        }
    };
}
typed! {
    poisson(): diffusion::stiffness::Kernels;
    mass(): inertia::vector::Kernels;
    elasticity(c): linear_elastic::stiffness::Kernels;
    neo_hookean(c): rubber::energy::Kernels;
    contact(c): small_strain_contact::nitsche::Kernels;
    finite_contact(c): finite_strain_contact::nitsche::Kernels;
}
