//! Counted work of loops over cells, by the runs of cells that threads get.

use std::sync::Arc;

use super::Assembler;
use super::functional::entities_of_parts;
use super::projection::{Pieces, cells_of_parts};
use super::scatter::partition::runs;
use crate::linear_algebra::SharedWork;
use crate::space::Space;

impl<const D: usize> Assembler<D> {
    /// Counted work of the assembly of an integral over all cells, in cells, and how far threads can share it.
    pub fn assembly_work(&self) -> SharedWork {
        let count = self.mesh().body_cells().len();
        SharedWork::of_parts(|threads| runs(count, threads).into_iter().map(|run| run.len() as f64).collect())
    }

    /// Counted work of a functional over all cells, such as a norm, or of a derived field's values at quadrature points, in cells, and how far
    /// threads can share it.
    pub fn evaluation_work(&self) -> SharedWork {
        let count = self.mesh().body_cells().len();
        SharedWork::of_parts(|threads| entities_of_parts(count, threads))
    }

    /// Counted work of the projection of a derived field to a space, in cells for each component, and how far threads can share it.
    pub fn projection_work(&self, space: &Arc<Space<D>>) -> SharedWork {
        let pieces = Pieces::new(space);
        SharedWork::of_parts(|threads| cells_of_parts(&pieces, space.components(), threads))
    }
}
