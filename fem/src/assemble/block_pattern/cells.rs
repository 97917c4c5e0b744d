//! Cells that a pattern comes from, for orderings that go by places.

use std::sync::Arc;

use super::Coupled;
use crate::linear_algebra::Cells;
use crate::space::Space;

/// The cells whose nodes are coupled, along the walk through the mesh, with the unknowns of all spaces on each; none where there are
/// no such cells, or rows and columns are numbered differently.
pub(super) fn coupled_cells<const D: usize>(
    tests: &[&Arc<Space<D>>],
    trials: &[&Arc<Space<D>>],
    coupled: &[Vec<Coupled>],
) -> Option<Cells> {
    let alike =
        tests.len() == trials.len() && tests.iter().zip(trials).all(|(test, trial)| test.numbers_as(trial));
    let lists = || coupled.iter().flatten().map(|coupled| &coupled.cells);
    if !alike || lists().all(|list| list.is_empty()) {
        return None;
    }
    let mut cells = Cells::default();
    let mesh = tests[0].mesh();
    for &cell in mesh.cell_order().cells() {
        let cell = cell as usize;
        if !lists().any(|list| list.get(cell).is_some_and(|found| *found)) {
            continue;
        }
        let mut centre = [0.0; 3];
        centre[..D].copy_from_slice(&mesh.cell_centre(cell));
        let mut offset = 0;
        let unknowns = tests.iter().flat_map(|space| {
            let (first, components) = (offset, space.components());
            offset += space.unknowns();
            let of_node = move |node: &u32| {
                let start = first + *node as usize * components;
                (start..start + components).map(|unknown| unknown as u32)
            };
            space.cell_nodes(cell).iter().flat_map(of_node)
        });
        cells.add(centre, unknowns);
    }
    Some(cells)
}
