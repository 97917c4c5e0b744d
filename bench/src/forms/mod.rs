//! The basket's forms, the same mathematics as `peers/basket.py`.

mod bodies;
mod contact;
mod elasticity;
mod finite_contact;
pub mod given;
mod mass;
mod neo_hookean;
mod poisson;

pub use bodies::sliding;
pub use contact::small_strain_contact;
pub use elasticity::linear_elastic;
pub use finite_contact::finite_strain_contact;
pub use mass::inertia;
pub use neo_hookean::rubber;
pub use poisson::diffusion;
