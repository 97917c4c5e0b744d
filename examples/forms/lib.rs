//! Forms as a user writes them, one file each, none longer than 40 lines of code. Each is compared with scikit-fem entry by
//! entry (`tests/tests/against_scikit_fem_*.rs`), and the cost of compiling it is measured (`tests/compile_cost`).
//! Contact by Nitsche's method is in the package `forms-contact`. The rest is what the programs share.

#[path = "../die_forces.rs"]
pub mod die_forces;
#[path = "../level_set/mod.rs"]
pub mod level_set;

pub use forms_program::{command_line, memory};

pub mod anisotropic_elasticity;
pub mod density_filter;
pub mod ghost_penalty;
pub mod interior_penalty;
pub mod mooney_rivlin;
pub mod neo_hookean;
pub mod p_laplacian;
pub mod stokes;
