//! Cells that a pattern comes from, for orderings that go by places.

use std::sync::Arc;

use super::Coupled;
use crate::linear_algebra::Cells;
use crate::space::Space;
use crate::threads::Threads;

/// The cells whose nodes are coupled, along the walk through the mesh, with the unknowns of all spaces on each; none where there are
/// no such cells, or rows and columns are numbered differently.
pub(super) fn coupled_cells<const D: usize>(
    tests: &[&Arc<Space<D>>],
    trials: &[&Arc<Space<D>>],
    coupled: &[Vec<Coupled>],
    threads: Threads,
) -> Option<Cells> {
    let alike =
        tests.len() == trials.len() && tests.iter().zip(trials).all(|(test, trial)| test.numbers_as(trial));
    let lists = || coupled.iter().flatten().map(|coupled| &coupled.cells).filter(|list| !list.is_empty());
    if !alike || lists().next().is_none() {
        return None;
    }
    let takes_part = |cell: &u32| lists().any(|list| list[*cell as usize]);
    let walk = tests[0].mesh().cell_order().cells();
    let nodes: usize = tests.iter().map(|space| space.all_cell_nodes().len()).sum();
    let parts = threads.for_work(nodes);
    let runs = walk.chunks(walk.len().div_ceil(parts).max(1)).collect();
    let found = threads.run(runs, |run: &[u32]| cells_with_unknowns(tests, run, takes_part));
    found.into_iter().reduce(|mut cells, later| {
        cells.append(&later);
        cells
    })
}

/// Those of some cells that take part.
fn cells_with_unknowns<const D: usize>(
    spaces: &[&Arc<Space<D>>],
    run: &[u32],
    takes_part: impl Fn(&u32) -> bool,
) -> Cells {
    let mut cells = Cells::default();
    let mesh = spaces[0].mesh();
    mesh.visit_centres(run.iter().copied().filter(takes_part), |cell, place| {
        let mut centre = [0.0; 3];
        centre[..D].copy_from_slice(place);
        let mut offset = 0;
        cells.add_by(centre, |unknowns| {
            for space in spaces {
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
