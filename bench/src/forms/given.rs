//! The forms with the basket's data: constants λ, μ, γ₀ in this order, and fields.

use forms_fem::prelude::*;

use super::*;
use crate::element_batch::{CELLS, FACETS};

/// [`diffusion::stiffness`].
pub fn poisson<const D: usize>() -> diffusion::stiffness::Form<D> {
    diffusion::stiffness(&diffusion::Data {}, &diffusion::Omega::on(CELLS))
}

/// [`inertia::vector`].
pub fn mass<const D: usize>() -> inertia::vector::Form<D> {
    inertia::vector(&inertia::Data {}, &inertia::Omega::on(CELLS))
}

/// [`linear_elastic::stiffness`].
pub fn elasticity<const D: usize>(c: &[f64]) -> linear_elastic::stiffness::Form<D> {
    let data = linear_elastic::Data { lambda: c[0], mu: c[1] };
    linear_elastic::stiffness(&data, &linear_elastic::Omega::on(CELLS))
}

/// [`rubber::energy`].
pub fn neo_hookean<const D: usize>(c: &[f64]) -> rubber::energy::Form<D> {
    rubber::energy(&rubber::Data { lambda: c[0], mu: c[1] }, &rubber::Omega::on(CELLS))
}

/// [`small_strain_contact::nitsche`].
pub fn contact<const D: usize>(c: &[f64], gap: Given<f64, D>) -> small_strain_contact::nitsche::Form<D> {
    let data = small_strain_contact::Data { lambda: c[0], mu: c[1], gamma0: c[2], gap };
    small_strain_contact::nitsche(&data, &small_strain_contact::GammaC::on(FACETS))
}

/// [`finite_strain_contact::nitsche`].
pub fn finite_contact<const D: usize>(
    c: &[f64],
    gap: Given<f64, D>,
) -> finite_strain_contact::nitsche::Form<D> {
    let data = finite_strain_contact::Data { lambda: c[0], mu: c[1], gamma0: c[2], gap };
    finite_strain_contact::nitsche(&data, &finite_strain_contact::GammaC::on(FACETS))
}
