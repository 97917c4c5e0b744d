//! Shape optimisation: gradient descent on nodal positions with one constraint, Armijo line search, mesh-quality checks and
//! checkpoints. It knows no physics: a [`ShapeProblem`] gives a criterion and its derivative as a vector over the movements
//! of the nodes, as the residual of `derivative(form, shape, Theta)` is.
//!
//! A step: an [`InnerProduct`] turns derivatives into movements of the whole body, with parts of the boundary fixed;
//! [`Rotations`] keep a pattern of cells the same around a ring; a `Direction` adds the return to the constraint to the
//! descent of the criterion; [`Descent`] takes a step of Armijo's length on an augmented Lagrangian. A [`Wall`] keeps boundaries
//! apart, [`Remesh`] goes on with other cells where these have suffered. A [`DescentState`] is
//! all that a run needs to resume: a [`Checkpoint`] writes it to the last bit, with a checksum and the version, in the
//! directory of a [`Logbook`] next to the history and every n-th shape. [`level_set`] has descents on level set functions, which change
//! the topology.

mod checkpoint;
mod descent;
mod descent_direction;
mod descent_options;
mod direction;
mod distance;
mod error;
mod history;
mod inner_product;
pub mod level_set;
mod logbook;
mod perimeter;
#[cfg(feature = "pictures")]
mod pictures;
mod problem;
mod rotations;
mod smoothing;
mod stored_mesh;
#[cfg(test)]
mod tests;
mod volume;
mod wall;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use descent::{Descent, Optimised, Remesh, Remesher, Report};
pub use descent_options::DescentOptions;
pub use distance::{BoundaryDistance, boundary_distance};
pub use error::{Failure, ShapeOptimisationError};
pub use history::{DescentState, Remeshed, Row, Step, StopReason};
pub use inner_product::{InnerProduct, movement_product};
pub use logbook::Logbook;
pub use perimeter::{perimeter, perimeter_derivative, perimeter_form};
#[cfg(feature = "pictures")]
pub use pictures::{history_picture, strip};
pub use problem::{Derivatives, ShapeProblem, Values};
pub use rotations::Rotations;
pub use smoothing::smoothed;
pub use stored_mesh::StoredMesh;
pub use volume::{Volume, measured_volume, volume_form};
pub use wall::{Clearance, Wall};
