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

/// The cells in which the last points were found, the latest first: the points of a cell lie in few cells of the other mesh.
pub(crate) type Lately = [Option<u32>; 4];

/// [`place`] of a point that is likely to lie in one of the cells of those before it; the same answer.
pub(crate) fn place_near<const D: usize>(
    locator: &Locator<D>,
    lately: &mut Lately,
    point: &[f64; D],
    reach: f64,
) -> Option<(u32, [f64; D])> {
    // On a boundary between cells the lowest has to be looked for.
    let within = |cell: u32| {
        let shape = locator.mesh().cell_shape(cell as usize);
        locator.reference_in(cell as usize, point).filter(|reference| shape.contains(reference, -INSIDE))
    };
    for place in 0..lately.len() {
        let Some(cell) = lately[place] else { break };
        if let Some(reference) = within(cell) {
            lately[..=place].rotate_right(1);
            return Some((cell, reference));
        }
    }
    let found = self::place(locator, point, reach)?;
    lately.rotate_right(1);
    lately[0] = Some(found.0);
    Some(found)
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
