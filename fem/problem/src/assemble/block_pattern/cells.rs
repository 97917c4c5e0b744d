//! Cells that a pattern comes from, for orderings that go by places.

use std::sync::Arc;

use super::Coupled;
use crate::linear_algebra::Cells;
use crate::space::Space;

/// Cells whose nodes are coupled, with the spaces whose unknowns they have. They are listed when somebody wants an ordering, which
/// takes much longer; who solves without one does not wait for them.
pub(super) struct CoupledCells<const D: usize> {
    spaces: Vec<Arc<Space<D>>>,
    /// Of each cell of the mesh, whether it takes part.
    taking_part: Vec<bool>,
}

/// The cells whose nodes are coupled; none where there are no such cells, or rows and columns are numbered differently.
pub(super) fn coupled_cells<const D: usize>(
    tests: &[&Arc<Space<D>>],
    trials: &[&Arc<Space<D>>],
    coupled: &[Vec<Coupled>],
) -> Option<CoupledCells<D>> {
    let alike =
        tests.len() == trials.len() && tests.iter().zip(trials).all(|(test, trial)| test.numbers_as(trial));
    let mut lists = coupled.iter().flatten().map(|coupled| &coupled.cells).filter(|list| !list.is_empty());
    let mut taking_part = lists.next().filter(|_| alike)?.clone();
    for list in lists {
        taking_part.iter_mut().zip(list).for_each(|(part, own)| *part |= own);
    }
    let spaces = tests.iter().map(|space| Arc::clone(space)).collect();
    Some(CoupledCells { spaces, taking_part })
}

impl<const D: usize> CoupledCells<D> {
    /// The cells along the walk through the mesh, with the unknowns of all spaces on each. On the calling thread: threads that share
    /// a pattern wait here for one another, and must not wait for tasks besides.
    pub(super) fn make(&self) -> Cells {
        let mesh = self.spaces[0].mesh();
        let walk = mesh.cell_order().cells().iter().copied();
        let unknowns = |space: &Arc<Space<D>>| space.all_cell_nodes().len() * space.components();
        let mut cells = Cells::with_room(walk.len(), self.spaces.iter().map(unknowns).sum());
        mesh.visit_centres(walk.filter(|cell| self.taking_part[*cell as usize]), |cell, place| {
            let mut centre = [0.0; 3];
            centre[..D].copy_from_slice(place);
            let mut offset = 0;
            cells.add_by(centre, |unknowns| {
                for space in &self.spaces {
                    let components = space.components();
                    for &node in space.cell_nodes(cell as usize) {
                        let first = offset + node as usize * components;
                        unknowns.extend((first..first + components).map(|unknown| unknown as u32));
                    }
                    offset += space.unknowns();
                }
            });
        });
        cells
    }
}
