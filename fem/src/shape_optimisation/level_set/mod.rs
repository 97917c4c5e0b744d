//! Shapes as level set functions: descent on the nodal values of φ, by which holes appear, merge and vanish.
//!
//! ```text
//! problem    a criterion of a cut body with its derivative by φ; as a reduced problem whose controls are the values of φ
//! measures   volume and perimeter with their derivatives, means around nodes
//! smooth_perimeter  a perimeter whose derivative is continuous
//! holes      new holes: options, and the places where they may be
//! options    options of a descent
//! history    all that a descent needs to go on
//! inner_product  what makes a derivative a change of φ
//! descent    Armijo's steps within bands, and distances in place of φ
//! ```

mod descent;
mod history;
mod holes;
mod inner_product;
mod measures;
mod options;
mod problem;
mod smooth_perimeter;

pub use descent::{LevelSetDescent, LevelSetOptimised, LevelSetReport};
pub use history::{LevelSetRow, LevelSetState};
pub use holes::{HoleOptions, NewHoles};
pub use inner_product::level_set_product;
pub use measures::{LevelSetVolume, interface_measure, means_at_nodes, measure_forms};
pub use options::LevelSetOptions;
pub use problem::{LevelSetControls, LevelSetFailure, LevelSetProblem};
pub use smooth_perimeter::{SmoothPerimeter, density_variation};
