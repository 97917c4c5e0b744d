//! Contact laws with friction, one per file. They read one [`Data`](frictional_nitsche::Data), so that a
//! program changes the formulation by the module's name; those with an obstacle that moves
//! extend [`moving_obstacle`]'s, and those between bodies have their own.
//!
//! | module | formulation | strains |
//! | --- | --- | --- |
//! | [`frictional_nitsche`] | Nitsche's method, every θ, with adjoints | small |
//! | [`frictional_penalty`] | penalty | small |
//! | [`augmented_lagrangian`] | Alart and Curnier's augmented Lagrangian, multipliers on facets | small |
//! | [`finite_nitsche`] | Nitsche's method, θ = 0 | finite, neo-Hooke |
//! | [`mixed_nitsche`] | Nitsche's method, θ = 0, and an energy without friction: nearly incompressible, (u, p) and (u, p, J − 1) | finite, neo-Hooke |
//! | [`averaged_nitsche`] | Nitsche's method, θ = 0: nearly incompressible, F-bar | finite, neo-Hooke |
//! | [`mixed_bodies`], [`averaged_bodies`] | the same between bodies, at points that slide | finite, neo-Hooke |
//! | [`sealed_cavity`] | an energy with a round tool and the pressure of a closed cavity | finite, neo-Hooke |
//! | [`third_medium`] | bodies in a soft medium that is crushed between them | finite, neo-Hooke |
//! | [`two_bodies`] | Nitsche's method, every θ, between two bodies, at pairs of fixed points | small |
//! | [`sliding_bodies`] | Nitsche's method, θ = 0, between bodies or of one with itself, at points that slide | finite, neo-Hooke |
//! | [`mean_two_bodies`] | the same with one traction per own facet | small |
//! | [`mean_sliding_bodies`], [`mean_penalty_bodies`] | Nitsche's method, θ = 0, and penalty, at points that slide, with one traction per own facet or per vertex of it | finite, neo-Hooke |
//! | [`friction_with_memory`] | Nitsche's method, θ = 0, or penalty, with Coulomb's law by springs that remember, at points that slide | finite, neo-Hooke |
//! | [`sliding_wear`] | the law of `sliding_bodies` with Archard's wear | finite, neo-Hooke |
//! | [`mortar_bodies`] | multipliers on own facets, a condition per node, without friction; with friction in the plane; at points that slide | finite, neo-Hooke |
//! | [`capsule`] | Nitsche's method, θ = 0, with a round obstacle that moves and turns | finite, neo-Hooke |
//! | [`analytic_obstacle`] | Nitsche's method, every θ, or penalty, with an obstacle given by its signed distance, that moves and turns | small |
//! | [`cohesive`] | two bodies that are glued together and separate, at pairs of fixed points | small |
//! | [`cut_nitsche`] | Nitsche's method, every θ, without friction, on a body that is cut by a level set function | small |
//! | [`wear`] | Nitsche's method, every θ, on a flat, with Archard's wear | small |
//! | [`contact_heat`] | heat across two bodies' contact and from their friction, for a known displacement | small |
//! | [`proximal_obstacle`], [`proximal_bodies`], [`proximal_membrane`] | proximal Galerkin, without friction | small |
//! | [`barrier_obstacle`], [`barrier_bodies`] | a log barrier in the gap, an energy without friction: gaps stay positive | small |
//! | [`exponential_obstacle`], [`tabulated_obstacle`] | pressure as an exponential of the gap, or by data points, without friction | small |
//! | [`axial_nitsche`] | Nitsche's method, every θ, on a flat, bodies of revolution in (r, z) | small |
//! | [`uzawa`] | multipliers at points of Γ_C, updated by [`solve_by_uzawa`](crate::uzawa::solve_by_uzawa) | small |
//!
//! The bound of friction is s = `slip_stress` + `friction` · pressure: Tresca's law is `friction` = 0, Coulomb's law
//! `slip_stress` = 0, and both together are Coulomb's law with adhesion. Tresca's bound acts on all of Γ_C.

pub mod analytic_obstacle;
pub mod augmented_lagrangian;
pub mod averaged_bodies;
pub mod averaged_nitsche;
pub mod axial_nitsche;
pub mod barrier_bodies;
pub mod barrier_obstacle;
pub mod capsule;
pub mod cohesive;
pub mod contact_heat;
pub mod cut_nitsche;
pub mod exponential_obstacle;
pub mod finite_nitsche;
pub mod friction_with_memory;
pub mod frictional_penalty;
pub mod mean_penalty_bodies;
pub mod mean_sliding_bodies;
pub mod mean_two_bodies;
pub mod mixed_bodies;
pub mod mixed_nitsche;
pub mod mortar_bodies;
pub mod moving_obstacle;
pub mod proximal_bodies;
pub mod proximal_membrane;
pub mod proximal_obstacle;
pub mod sealed_cavity;
pub mod sliding_bodies;
pub mod sliding_wear;
pub mod tabulated_obstacle;
pub mod third_medium;
pub mod two_bodies;
pub mod uzawa;
pub mod wear;

#[doc(inline)]
pub use forms_contact_problem::frictional_nitsche;
