//! Places of points in a mesh, found by several threads.

use std::ops::Range;

use crate::element::CellShape;
use crate::locate::{AffineInverse, INSIDE, Locator};
use crate::mesh::Mesh;
use crate::threads::Threads;

/// The distance from a mesh up to which points count as its own: a tenth of the diameter of its largest cell. The gap between a
/// chord-like quadratic and the circle is far below.
pub(crate) fn usual_reach<const D: usize>(mesh: &Mesh<D>) -> f64 {
    0.1 * mesh.body_cells().map(|cell| mesh.diameter(cell)).fold(0.0, f64::max)
}

/// Cell and reference coordinates of a point, which may lie outside within a distance; `None` further away.
pub(crate) fn place<const D: usize>(
    locator: &Locator<D>,
    point: &[f64; D],
    reach: f64,
) -> Option<(u32, [f64; D])> {
    // Nearly all lie inside, where no distance has to be measured.
    locator.find(point).map(|(cell, reference)| (cell as u32, reference)).or_else(|| {
        let nearest = locator.find_nearest(point, reach)?;
        Some((nearest.cell as u32, nearest.reference))
    })
}

/// Cells that are tried before all others.
const TRIED: usize = 8;

/// Cells in which the last points were found, the latest first, the others in any order: the points of a cell lie in few cells of the other mesh.
pub(crate) struct Lately<'a, const D: usize> {
    locator: &'a Locator<D>,
    cells: Vec<(u32, CellShape, Option<AffineInverse<D>>)>,
}

impl<'a, const D: usize> Lately<'a, D> {
    /// None yet.
    pub(crate) fn new(locator: &'a Locator<D>) -> Self {
        Lately { locator, cells: Vec::with_capacity(TRIED) }
    }

    /// [`place`] of a point that is likely to lie in one of the cells of those before it; the same answer.
    pub(crate) fn place(&mut self, point: &[f64; D], reach: f64) -> Option<(u32, [f64; D])> {
        for tried in 0..self.cells.len() {
            let (cell, shape, affine) = &self.cells[tried];
            let reference = match affine {
                Some(inverse) => inverse.place(point),
                None => self.locator.reference_in(*cell as usize, point),
            };
            // On a boundary between cells the lowest has to be looked for.
            if let Some(reference) = reference.filter(|reference| shape.contains(reference, -INSIDE)) {
                let cell = *cell;
                self.cells.swap(0, tried);
                return Some((cell, reference));
            }
        }
        let found = place(self.locator, point, reach)?;
        let cell = found.0 as usize;
        self.cells.truncate(TRIED - 1);
        let shape = self.locator.mesh().cell_shape(cell);
        self.cells.push((found.0, shape, self.locator.affine_inverse(cell)));
        let last = self.cells.len() - 1;
        self.cells.swap(0, last);
        Some(found)
    }
}

/// Cuts a loop into one part per thread, with results in the order of the loop.
pub(crate) fn in_parts<R: Send>(
    threads: Threads,
    length: usize,
    work: impl Fn(Range<usize>) -> R + Send + Sync,
) -> Vec<R> {
    let count = threads.count();
    let ranges = (0..count).map(|part| part * length / count..(part + 1) * length / count);
    threads.run(ranges.collect(), work)
}
