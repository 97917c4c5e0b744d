//! Halves of cells, of nearly equal numbers, with few blocks in common.

use std::ops::Range;

use super::Part;
use super::axes::{Axis, axes_of, is_coordinate};
use super::smoothing::Smoothing;
use crate::cell_blocks::CellBlocks;
use crate::threads::Threads;

/// In parts of so few cells one cut is tried alone.
const SMALL: usize = 30;
/// A cut has at least this part of the cells on each side.
const LEAST: f64 = 0.4;

/// The cost of a cut that slants, compared with one across a coordinate: its halves are wedges, and what separates a wedge's own halves is
/// larger than what separates those of a block.
const SLANTED: f64 = 1.2;

/// Cells from which on halves are halved on two threads.
const SHARED: usize = 1 << 12;
/// Halvings that are shared beyond one part for each thread, since parts differ in work.
const FURTHER: u32 = 2;

/// The halving of some cells.
pub(super) struct Halves<'a, 'c> {
    cells: &'a CellBlocks<'c>,
    /// The cells, those of each part next to each other.
    order: &'a mut [u32],
    /// The smallest part that each of them is in, in the same order.
    parts: &'a mut [Part],
    marks: Marks,
}

/// Marks of all blocks. Halves on two threads have their own, because both read blocks that are separated already; others are in one half only.
struct Marks {
    /// Blocks that the halves of some larger part have in common.
    separated: Vec<bool>,
    /// The last count that met a block.
    seen: Vec<u32>,
    counts: u32,
    smoothing: Smoothing,
}

impl Marks {
    fn new(separated: Vec<bool>) -> Self {
        let blocks = separated.len();
        Marks { separated, seen: vec![0; blocks], counts: 0, smoothing: Smoothing::new(blocks) }
    }
}

/// A way to halve a part.
struct Cut {
    /// The cells with their places along an axis, the lower half first.
    along: Vec<(f64, u32)>,
    /// Number of cells of the lower half.
    lower: usize,
    /// The lower, the better.
    cost: f64,
}

impl<'a, 'c> Halves<'a, 'c> {
    /// The smallest part of each cell, the same on any number of threads.
    pub(super) fn of_all(cells: &CellBlocks, blocks: usize, threads: Threads) -> Vec<Part> {
        let count = cells.count();
        let (mut order, mut found): (Vec<u32>, _) = ((0..count as u32).collect(), vec![Part::ALL; count]);
        let marks = Marks::new(vec![false; blocks]);
        let shared = if threads == Threads::ONE { 0 } else { threads.count().ilog2() + FURTHER };
        let mut all = Halves { cells, order: &mut order, parts: &mut found, marks };
        all.halve(0..count, Part::ALL, shared);
        let mut parts = vec![Part::ALL; count];
        order.iter().zip(found).for_each(|(cell, part)| parts[*cell as usize] = part);
        parts
    }

    /// Halves a part until parts have one cell, down to the depth `shared` on several threads.
    fn halve(&mut self, range: Range<usize>, part: Part, shared: u32) {
        if range.len() < 2 || part.depth() == Part::DEEPEST {
            self.parts[range].fill(part);
            return;
        }
        let middle = range.start + self.cut(&range);
        let (lower, upper) = (range.start..middle, middle..range.end);
        self.common(lower.clone(), upper.clone(), |separated| {
            *separated = true;
            true
        });
        let parts = part.halves();
        if part.depth() >= shared || range.len() < SHARED {
            self.halve(lower, parts[0], shared);
            self.halve(upper, parts[1], shared);
            return;
        }
        let separated = self.marks.separated.clone();
        let marks = [std::mem::replace(&mut self.marks, Marks::new(vec![])), Marks::new(separated)];
        let order = self.order[range.clone()].split_at_mut(lower.len());
        let found = self.parts[range].split_at_mut(lower.len());
        let tasks = [order.0, order.1].into_iter().zip([found.0, found.1]).zip(marks).zip(parts);
        let tasks = tasks
            .map(|(((order, parts), marks), part)| (Halves { cells: self.cells, order, parts, marks }, part));
        Threads::new(2).run(tasks.collect(), |(mut half, part)| {
            half.halve(0..half.order.len(), part, shared);
        });
    }

    /// Puts the cells of the lower half first, and gives their number.
    fn cut(&mut self, range: &Range<usize>) -> usize {
        let cells = &self.order[range.clone()];
        let axes = axes_of(cells.iter().map(|cell| &self.cells.centres[*cell as usize]));
        let mut best: Option<Cut> = None;
        for axis in axes {
            let mut along = self.along(range, &axis);
            let [middle, gap] = cuts(&mut along);
            if range.len() <= SMALL {
                best = Some(Cut { along, lower: gap, cost: 0.0 });
                break;
            }
            for (place, (_, cell)) in along.iter().enumerate() {
                self.order[range.start + place] = *cell;
            }
            let slant = if is_coordinate(&axis) { 1.0 } else { SLANTED };
            let mut least = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
            let mut found = None;
            for lower in [Some(middle), Some(gap).filter(|gap| *gap != middle)].into_iter().flatten() {
                if let Some(cost) = self.cost_below(least, range, (lower, slant)) {
                    (least, found) = (cost, Some(lower));
                }
            }
            if let Some(lower) = found {
                best = Some(Cut { along, lower, cost: least });
            }
        }
        let Some(Cut { along, lower, .. }) = best else { return range.len() / 2 };
        for (place, (_, cell)) in along.iter().enumerate() {
            self.order[range.start + place] = *cell;
        }
        let part = &mut self.order[range.clone()];
        self.marks.smoothing.smooth(self.cells, &self.marks.separated, part, lower)
    }

    /// Cells with their places along an axis.
    fn along(&self, range: &Range<usize>, axis: &Axis) -> Vec<(f64, u32)> {
        let place = |cell: &u32| {
            let centre = &self.cells.centres[*cell as usize];
            (0..3).map(|i| axis[i] * centre[i]).sum()
        };
        self.order[range.clone()].iter().map(|cell| (place(cell), *cell)).collect()
    }

    /// The number of blocks in common, more where the halves differ in size or the cut slants; none if it is not below a bound.
    fn cost_below(&mut self, bound: f64, range: &Range<usize>, (lower, slant): (usize, f64)) -> Option<f64> {
        let middle = range.start + lower;
        let weight = slant * (1.0 + 2.0 * (lower as f64 / range.len() as f64 - 0.5).abs());
        let mut cost = 0.0;
        let is_below = self.common(range.start..middle, middle..range.end, |_| {
            cost += weight;
            cost < bound
        });
        is_below.then_some(cost)
    }

    /// Visits the marks of the blocks that two sets of cells have in common and no larger part's halves have, as long as `visit` asks to go
    /// on: whether it was to the end.
    fn common(
        &mut self,
        lower: Range<usize>,
        upper: Range<usize>,
        mut visit: impl FnMut(&mut bool) -> bool,
    ) -> bool {
        let Marks { separated, seen, counts, .. } = &mut self.marks;
        let (one, both) = (*counts + 1, *counts + 2);
        *counts = both;
        for cell in &self.order[lower] {
            for block in self.cells.of(*cell) {
                seen[*block as usize] = one;
            }
        }
        for cell in &self.order[upper] {
            for block in self.cells.of(*cell) {
                let (seen, separated) = (&mut seen[*block as usize], &mut separated[*block as usize]);
                if *seen == one && !*separated {
                    *seen = both;
                    if !visit(separated) {
                        return false;
                    }
                }
            }
        }
        true
    }
}

/// Numbers of cells of the lower half, for a cut in the middle and for one in the widest gap near it. The cells are put in an order
/// that serves both.
fn cuts(along: &mut [(f64, u32)]) -> [usize; 2] {
    let count = along.len();
    let by_place = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    let first = ((LEAST * count as f64) as usize).max(1) - 1;
    let last = count - first;
    along.select_nth_unstable_by(first, by_place);
    if last < count {
        along[first..].select_nth_unstable_by(last - first, by_place);
    }
    let window = &mut along[first..last];
    window.sort_unstable_by(by_place);
    let middle = count / 2;
    let (mut gap, mut widest) = (middle, 0.0);
    for place in first + 1..last {
        let width = along[place].0 - along[place - 1].0;
        // Of gaps of one width, up to rounding, the one nearest to the middle.
        let nearer = place.abs_diff(middle) < gap.abs_diff(middle);
        if width > widest * (1.0 + 1e-6) || width > widest * (1.0 - 1e-6) && nearer {
            (gap, widest) = (place, width);
        }
    }
    [middle, gap]
}
