//! The forms with the basket's data: constants λ, μ, γ₀ in this order, and fields.

use super::*;

/// The region to which cell integrals are bound.
const CELLS: &str = "all";
/// The region to which facet integrals are bound.
const FACETS: &str = "boundary";
/// Replaces a field that the kernel reads from a list.
const UNREAD: f64 = 0.0;

/// [`fn@diffusion::stiffness`].
pub fn poisson<const D: usize>() -> diffusion::stiffness::Compiled<D> {
    diffusion::stiffness(&diffusion::Data {}, &diffusion::Omega::on(CELLS))
}

/// [`fn@inertia::vector`].
pub fn mass<const D: usize>() -> inertia::vector::Compiled<D> {
    inertia::vector(&inertia::Data {}, &inertia::Omega::on(CELLS))
}

/// [`fn@linear_elastic::stiffness`].
pub fn elasticity<const D: usize>(c: &[f64]) -> linear_elastic::stiffness::Compiled<D> {
    let data = linear_elastic::Data { lambda: c[0], mu: c[1] };
    linear_elastic::stiffness(&data, &linear_elastic::Omega::on(CELLS))
}

/// [`fn@rubber::energy`].
pub fn neo_hookean<const D: usize>(c: &[f64]) -> rubber::energy::Compiled<D> {
    rubber::energy(&rubber::Data { lambda: c[0], mu: c[1] }, &rubber::Omega::on(CELLS))
}

/// [`fn@small_strain_contact::nitsche`] for a kernel that reads the gap from a list.
pub fn contact<const D: usize>(c: &[f64]) -> small_strain_contact::nitsche::Compiled<D> {
    let data = small_strain_contact::Data { lambda: c[0], mu: c[1], gamma0: c[2], gap: UNREAD.into() };
    small_strain_contact::nitsche(&data, &small_strain_contact::GammaC::on(FACETS))
}

/// [`fn@small_strain_contact::body`] with one gap \[length\] everywhere on a facet region.
pub fn body_in_contact<const D: usize>(
    c: &[f64],
    region: &str,
    gap: f64,
) -> small_strain_contact::body::Compiled<D> {
    let data = small_strain_contact::Data { lambda: c[0], mu: c[1], gamma0: c[2], gap: gap.into() };
    let (omega, contact) = (small_strain_contact::Omega::on(CELLS), small_strain_contact::GammaC::on(region));
    small_strain_contact::body(&data, &omega, &contact)
}

/// [`fn@finite_strain_contact::nitsche`] for a kernel that reads the gap from a list.
pub fn finite_contact<const D: usize>(c: &[f64]) -> finite_strain_contact::nitsche::Compiled<D> {
    let data = finite_strain_contact::Data { lambda: c[0], mu: c[1], gamma0: c[2], gap: UNREAD.into() };
    finite_strain_contact::nitsche(&data, &finite_strain_contact::GammaC::on(FACETS))
}
