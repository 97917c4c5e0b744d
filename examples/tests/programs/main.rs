//! The programs of `examples` as a user runs them: one test program, so that the long ones run in parallel with the others.

mod adaptive;
mod bounds;
mod closing_c;
mod convergence;
mod half_ring;
mod interrupted;
mod level_set_bridge;
mod level_set_cantilever;
mod level_set_wheel;
mod pressed_knot;
mod printed;
mod readme;
mod rolling_ring;
mod rolling_wheel;
mod shape_optimisation;
mod tutorials;
