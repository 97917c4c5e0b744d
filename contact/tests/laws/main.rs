//! The laws of friction: layers with known answers in the plane and in space, Taylor tests of the tangents, adjoints against
//! differences, Newton's method from zero and from random starts, bad input.

mod analytic_obstacle;
mod augmented_lagrangian;
mod bad_input;
mod bad_parameters;
mod block;
mod capsule;
mod cattaneo;
mod cohesive;
mod contact_heat;
mod cylinder;
mod energy_laws;
mod far_field;
mod finite_nitsche;
mod frictional_nitsche;
mod frictional_penalty;
mod gradients;
mod hertz_of_bodies;
mod layer;
mod mindlin;
mod nearly_incompressible;
mod random_loads;
mod rigid_layers;
mod rigid_tools;
mod rolling;
mod self_contact;
mod setting;
mod shape;
mod sliding_patch;
mod sloped_interface;
mod thresholds;
mod tunnelling;
mod two_bodies;
mod uzawa;
mod wear;
