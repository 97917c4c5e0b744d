//! Places of points in a mesh, found by several threads.

use std::ops::Range;

use crate::locate::{INSIDE, Locator};
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

/// [`place`] of a point that is likely to lie in a given cell; the same answer.
pub(crate) fn place_near<const D: usize>(
    locator: &Locator<D>,
    guess: Option<u32>,
    point: &[f64; D],
    reach: f64,
) -> Option<(u32, [f64; D])> {
    if let Some(guess) = guess {
        let cell = guess as usize;
        // On a boundary between cells the lowest has to be looked for.
        let within = |reference: &[f64; D]| locator.mesh().cell_shape(cell).contains(reference, -INSIDE);
        if let Some(reference) = locator.reference_in(cell, point).filter(within) {
            return Some((guess, reference));
        }
    }
    place(locator, point, reach)
}

/// Cuts a loop into one part per thread, whose results stand in the order of the loop.
pub(crate) fn in_parts<R: Send>(
    threads: Threads,
    length: usize,
    work: impl Fn(Range<usize>) -> R + Send + Sync,
) -> Vec<R> {
    let count = threads.count();
    let ranges = (0..count).map(|part| part * length / count..(part + 1) * length / count);
    threads.run(ranges.collect(), work)
}
