//! Frictionless contact by Nitsche's method, after Bretin, Chapelat, Douanla-Lontsi, Homolle and Renard
//! (2023): the direct problem, its adjoint states and criteria as declared forms, and the drivers that
//! solve them.
//!
//! | module | what | equations |
//! | --- | --- | --- |
//! | [`nitsche`] | the paper's forms | (14), (21), (22), (41) |
//! | [`operators`] | stresses, gap, γ, Nitsche's terms, to be imported into forms | (15) |
//! | [`contact_problem`] | a law on a space, and its drivers: direct → adjoint | |
//! | [`law`] | what the drivers ask of a law; [`contact_law!`] makes one of your own module | |
//! | [`laws`] | laws with friction: Nitsche's method, penalty, augmented Lagrangian; small and finite strains | |
//! | [`mod@parameter_ranges`] | which parameters of a law have to be positive, or not negative | |
//! | [`paper_law`] | the paper's law with its three adjoint states | |
//! | [`theta_path`] | the way to a solution through other values of θ | |
//! | [`shape_gradient`] | the derivative by the shape, as the volume form of the discrete problem | |
//! | [`boundary_form`] | the paper's derivative on the boundary | (11), (20) |
//! | [`load_and_pressure`], [`shape_problem`] | further criteria, and contact for a descent of shapes | |
//! | [`rolling`] | a wheel in several positions on flat ground, with one factor and one criterion | |
//! | [`residual_estimator`] | the error of the displacement, cell by cell | |
//! | [`impact`] | motion with impact, by schemes that keep or never gain energy | |
//! | [`finite_impact`] | the same for rubber with friction at large displacements | |
//! | [`threshold`] | when γ₀ is too small, and what it is as a rule | |
//! | [`material_threshold`](mod@material_threshold) | the same of any law on isotropic bodies | |
//! | [`multiplier_nodes`] | nodes where multipliers of contact are not determined | |
//! | [`proximal`] | proximal point iteration: constraints by a sequence of smooth problems |
//! | [`uzawa`] | Uzawa's iteration: multipliers updated outside of Newton's method | |
//! | [`hollow_cylinder`], [`hertz`] | the paper's experiment, and contacts with closed forms | |
//! | [`half_spaces`] | two bodies with closed forms: Hertz, Cattaneo | |
//!
//! Nothing here knows an element or loops over cells.

pub mod boundary_form;
pub mod finite_impact;
pub mod half_spaces;
pub mod hertz;
pub mod impact;
pub mod laws;
pub mod load_and_pressure;
pub mod material_threshold;
pub mod multiplier_nodes;
pub mod proximal;
pub mod residual_estimator;
pub mod rolling;
pub mod shape_problem;
pub mod uzawa;

pub use forms_contact_problem::{Adjoint, ContactProblem, FromStick, forms};
#[doc(inline)]
pub use forms_contact_problem::{
    contact_law, contact_problem, hollow_cylinder, law, nitsche, operators, paper_law, parameter_ranges,
    shape_gradient, theta_path, threshold,
};
