//! Memory that one problem leaves to the next on the same spaces.

use crate::linear_algebra::{BlockMatrix, Restriction};

/// Memory that one step of a history leaves to the next, or a problem to the next with its solver, and the map from its matrix to the reduced
/// one: nothing that a result depends on.
#[derive(Debug, Default)]
#[doc(hidden)]
pub struct StepMemory {
    pub(in crate::solve) matrix: Option<BlockMatrix>,
    pub(in crate::solve) restriction: Option<Restriction>,
}
