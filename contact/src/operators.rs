//! Operators to import into forms: strains, stresses and energies of materials, and contact with a rigid obstacle.
//!
//! ```
//! use forms_fem::forms;
//!
//! #[forms]
//! pub mod punch {
//!     use forms_contact::operators::neo_hookean::energy_density;
//!     use forms_contact::operators::obstacle::penalty_density;
//!
//!     pub struct Data {
//!         lambda: Param,
//!         mu: Param,
//!         gamma0: Param,
//!         obstacle_normal: Given<Vector>,
//!         gap: Given<Scalar>,
//!     }
//!     #[cells]
//!     pub struct Omega;
//!     #[facets]
//!     pub struct GammaC;
//!
//!     pub fn energy(u: Unknown<Vector>) -> Energy {
//!         integral(Omega, energy_density(u)) + integral(GammaC, penalty_density(u))
//!     }
//! }
//! ```
//!
//! An operator reads the importing module's data by name: each module's `Data` says which. A material that varies
//! declares `lambda: Given<Scalar>` instead of `Param`.

mod interfaces;
mod materials;

pub use interfaces::{cohesion, friction, obstacle, signed_distance};
pub use materials::{linear_elastic, neo_hookean, st_venant_kirchhoff, strains};
