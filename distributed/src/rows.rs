//! Which rows of vectors and matrices a process keeps.

use std::ops::Range;

use crate::error::PetscError;
use crate::petsc::Index;
use crate::world::World;

/// The rows of all processes in a row, whole nodes on each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    /// Of all processes.
    pub count: usize,
    /// Components of a node.
    pub block: usize,
    /// Those of this process.
    pub own: Range<usize>,
}

impl Rows {
    /// `nodes` with the given number of components each.
    pub fn of_nodes(world: &World, nodes: usize, block: usize) -> Result<Self, PetscError> {
        let (own, count) = (world.part(nodes), nodes * block);
        if Index::try_from(count).is_err() {
            return Err(PetscError::TooMany { what: "rows", count });
        }
        Ok(Rows { count, block, own: own.start * block..own.end * block })
    }
}
