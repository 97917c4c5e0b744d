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
//!     #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::obstacle::Data)]
//!     pub struct Data {}
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
//! An operator reads the importing module's data by name: each module's `Data` says which, and `#[includes(..)]` takes them in.
//! A material that varies declares `lambda: Given<Scalar>` itself; that wins.

mod cavities;
mod closures;
mod cut_bodies;
mod interfaces;
mod materials;
mod mean_gaps;
mod memory;
mod mortar;
mod nearly_incompressible;
mod parameters;
mod revolution;
mod secants;
mod two_sides;
mod work;

pub use cavities::cavity;
pub use closures::{barrier, exponential_closure};
pub use cut_bodies::{ghost_penalty, topological_derivative, weak_dirichlet};
pub use interfaces::{cohesion, flat_obstacle, friction, obstacle, rigid_flat, signed_distance};
pub use materials::{linear_elastic, neo_hookean, st_venant_kirchhoff, strains};
pub use mean_gaps::mean_sliding;
pub use memory::elastic_slip;
pub use mortar::multipliers;
pub use nearly_incompressible::rubber;
pub use parameters::{penalty, variant};
pub use revolution::axial;
pub use secants::neo_hookean_secant;
pub use two_sides::{bodies, sliding};
pub use work::{body_load, linear_criterion, loads, resultant};
