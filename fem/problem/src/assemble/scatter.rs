//! Adding element matrices and vectors to the matrix and vector of all unknowns, from several threads.

pub(super) mod block_positions;
pub(super) mod group_nodes;
pub(super) mod motion_blocks;
mod own_rows;
pub(super) mod partition;

use std::ops::Range;

use self::block_positions::{BlockPlaces, ChosenPairs, Copied, CopiedPlaces, Finder, Known};
use self::group_nodes::GroupNodes;
use self::own_rows::{Deferred, OwnRows};
use self::partition::Partition;
use crate::assemble::block_pattern::block_index::{Slot, Slots};
use crate::lanes::{InstructionSet, LaneWork, SimdLane};
use crate::linear_algebra::BlockRows;
use crate::linear_algebra::large_pages::hand_over;
use crate::threads::Threads;

/// The least number of values that are set to zero at once, a quarter of a megabyte: small enough that they are still in the second
/// cache when they are added to, large enough that they come there as a stream and not line by line.
const CLEARED_AT_ONCE: usize = 1 << 15;

/// Number of cells by which the nodes of a cell are prefetched: the walk follows a curve, and their lists the numbers
/// of the cells.
const NODES_AHEAD: usize = 16;

/// The destination of a group's element matrices.
pub(super) struct MatrixScatter<'a> {
    pub tests: GroupNodes<'a>,
    pub trials: GroupNodes<'a>,
    pub blocks: &'a BlockRows,
    /// Values per block.
    pub block: usize,
    pub map: BlockPlaces<'a>,
    /// Test and trial nodes of an entity.
    pub nodes: [usize; 2],
    /// Places of the pairs of seen nodes among all pairs of a cell's, if not all of its nodes are seen.
    pub chosen: Option<ChosenPairs>,
}

impl MatrixScatter<'_> {
    /// The rows of each thread, as parts of the values of all rows. If these are not yet `written`, they are set to
    /// zero as the threads come to them.
    pub fn parts<'v>(
        &self,
        partition: &Partition,
        (values, mut zeros): (&'v mut [f64], &'v mut [bool]),
        written: bool,
    ) -> Vec<(Range<usize>, OwnRows<'v>)> {
        let values = self.of_rows(&partition.rows, values);
        let is_dense = self.tests.cells.len() * self.nodes[0] >= zeros.len();
        let mut parts = Vec::new();
        for ((entities, rows), values) in partition.entities.iter().zip(&partition.rows).zip(values) {
            let (own, later) = std::mem::take(&mut zeros).split_at_mut(rows.len());
            zeros = later;
            let written = if written { rows.end } else { rows.start };
            let deferred = Deferred::default();
            // Most matrices have no row of zeros, and nothing to look up.
            let own = if own.contains(&true) { own } else { &mut [] };
            let known = CopiedPlaces::default();
            let part = OwnRows { rows: rows.clone(), values, zeros: own, written, is_dense, known, deferred };
            parts.push((entities.clone(), part));
        }
        parts
    }

    /// The values of runs of rows, which begin with the first row and follow each other.
    fn of_rows<'v>(&self, runs: &[Range<usize>], values: &'v mut [f64]) -> Vec<&'v mut [f64]> {
        let mut rest = values;
        let mut parts = Vec::new();
        for rows in runs {
            let (own, later) = rest.split_at_mut(self.entries(rows.clone()).len());
            rest = later;
            parts.push(own);
        }
        parts
    }

    /// The places of the values of some rows.
    fn entries(&self, rows: Range<usize>) -> Range<usize> {
        match self.blocks.pointers() {
            [] => 0..0,
            pointers => pointers[rows.start] * self.block..pointers[rows.end] * self.block,
        }
    }

    /// The matrices of the entities from `first` on, added. `None`: a block is not in the pattern.
    pub fn add(&self, set: InstructionSet, first: usize, matrices: &[f64], part: &mut OwnRows) -> Option<()> {
        set.checked().run_without_kernel(Addition { scatter: self, first, matrices, part })
    }

    #[inline(always)]
    fn add_by<L: SimdLane, const BLOCK: usize>(
        &self,
        first: usize,
        matrices: &[f64],
        part: &mut OwnRows,
    ) -> Option<()> {
        // What most matrices have, without copies; a bounded number of finders is compiled for each size of a block.
        if let (BlockPlaces::OfCells(map), None) = (&self.map, &self.chosen) {
            let from = map.start(self.tests.shape);
            match &map.places {
                Slots::Bytes(places) => {
                    let known = Known::new(self, map, &places[from..]);
                    return self.add_rows::<L, _, BLOCK>(first, matrices, part, known);
                }
                Slots::Words(places) => {
                    let known = Known::new(self, map, &places[from..]);
                    return self.add_rows::<L, _, BLOCK>(first, matrices, part, known);
                }
                Slots::Long(_) => {}
            }
        }
        let mut known = std::mem::take(&mut part.known);
        let added = self.add_rows::<L, _, BLOCK>(first, matrices, part, Copied::new(self, &mut known));
        part.known = known;
        added
    }

    /// `BLOCK` values per block; 0 where the compiler does not know how many.
    #[inline(always)]
    fn add_rows<L: SimdLane, F: Finder, const BLOCK: usize>(
        &self,
        first: usize,
        matrices: &[f64],
        part: &mut OwnRows,
        mut finder: F,
    ) -> Option<()> {
        let [height, width] = self.nodes;
        let block = if BLOCK == 0 { self.block } else { BLOCK };
        let offset = self.entries(0..part.rows.start).end;
        for (number, matrix) in matrices.chunks_exact(height * width * block).enumerate() {
            let entity = first + number;
            L::prefetch(self.tests.of_later_cell(entity + NODES_AHEAD), 0);
            let places = finder.find(entity)?.chunks_exact(width);
            let rows = self.tests.of(entity).iter().zip(matrix.chunks_exact(width * block)).zip(places);
            for ((&row, blocks), places) in rows {
                let row = row as usize;
                if !part.rows.contains(&row) {
                    part.deferred.keep(row as u32, places, blocks);
                    continue;
                }
                let ends = &self.blocks.pointers()[row..row + 2];
                let (start, end) = (ends[0] * block - offset, ends[1] * block - offset);
                if part.written <= row {
                    self.clear_from(part, row);
                }
                if let Some(zero) = part.zeros.get_mut(row - part.rows.start) {
                    *zero = false;
                }
                add_row::<_, BLOCK>(&mut part.values[start..end], places, blocks, block);
            }
        }
        if finder.ahead() {
            // They come while the kernel computes the next batch.
            let count = matrices.len() / (height * width * block);
            let next = first + count;
            let next = next..self.tests.cells.len().min(next + count);
            finder.look_up(next.clone())?;
            for entity in next {
                self.ask_for::<L, BLOCK>(entity, part, &mut finder)?;
            }
        }
        Some(())
    }

    /// Asks for the blocks of an entity to come.
    #[inline(always)]
    fn ask_for<L: SimdLane, const BLOCK: usize>(
        &self,
        entity: usize,
        part: &OwnRows,
        finder: &mut impl Finder,
    ) -> Option<()> {
        let block = if BLOCK == 0 { self.block } else { BLOCK };
        let places = finder.find(entity)?.chunks_exact(self.nodes[1]);
        for (&row, places) in self.tests.of(entity).iter().zip(places) {
            if part.rows.contains(&(row as usize)) {
                let pointers = self.blocks.pointers();
                let row = (pointers[row as usize] - pointers[part.rows.start]) * block;
                for place in places {
                    let first = row + place.index() * block;
                    L::prefetch(part.values, first);
                    L::prefetch(part.values, first + block - 1);
                }
            }
        }
        Some(())
    }

    /// Sets a row to zero that the walk has come to, with those before it and some that it will come to.
    #[inline(never)]
    fn clear_from(&self, part: &mut OwnRows, row: usize) {
        let starts = &self.blocks.pointers()[row + 1..=part.rows.end];
        let far = starts[0] + CLEARED_AT_ONCE / self.block.max(1);
        let end = row + starts.partition_point(|start| *start <= far);
        self.clear_to(part, end);
        if part.is_dense && !part.zeros.is_empty() {
            let entries = self.entries(part.rows.start..row).len()..self.entries(part.rows.start..end).len();
            hand_over(&mut part.values[entries]);
        }
    }

    /// Sets the rows up to an end to zero, except for those that are known to be.
    fn clear_to(&self, part: &mut OwnRows, end: usize) {
        if part.zeros.is_empty() {
            let offset = self.entries(0..part.rows.start).end;
            let entries = self.entries(part.written..end.max(part.written));
            part.values[entries.start - offset..entries.end - offset].fill(0.0);
            part.written = part.written.max(end);
        } else {
            self.clear_where_needed(part, end);
        }
    }

    #[inline(never)]
    fn clear_where_needed(&self, part: &mut OwnRows, end: usize) {
        let first = part.rows.start;
        let offset = self.entries(0..first).end;
        let mut row = part.written;
        while row < end {
            let known = &mut part.zeros[row - first..end - first];
            let count = known.iter().take_while(|zero| !**zero).count();
            known[..count].fill(true);
            let passed = known[count..].iter().take_while(|zero| **zero).count();
            let entries = self.entries(row..row + count);
            part.values[entries.start - offset..entries.end - offset].fill(0.0);
            row += count + passed;
        }
        part.written = part.written.max(end);
    }

    /// The values that belong to other threads. Rows that the thread did not reach are set to zero.
    pub fn finish(&self, mut part: OwnRows) -> Deferred {
        let end = part.rows.end;
        self.clear_to(&mut part, end);
        part.into_deferred()
    }

    /// The values that threads kept for rows of others, added to those of all rows. Each row is one thread's, which adds to it in the
    /// order of those that kept something.
    pub fn add_deferred(
        &self,
        threads: Threads,
        deferred: &[Deferred],
        (values, zeros): (&mut [f64], &mut [bool]),
    ) {
        let mut touched: Vec<u32> = deferred.iter().flat_map(|deferred| &deferred.rows).copied().collect();
        touched.iter().for_each(|row| zeros[*row as usize] = false);
        let Some(last) = touched.iter().max().map(|last| *last as usize + 1) else { return };
        let parts = threads.for_work(touched.len() * self.nodes[1] * self.block);
        // As many contributions for each thread; parts of equal rows are empty.
        let mut bounds = vec![0];
        for part in 1..parts {
            let place = part * touched.len() / parts;
            bounds.push(*touched.select_nth_unstable(place).1 as usize);
        }
        bounds.push(last);
        let runs: Vec<Range<usize>> = bounds.windows(2).map(|pair| pair[0]..pair[1]).collect();
        let values = self.of_rows(&runs, values);
        threads.run(runs.into_iter().zip(values).collect(), |(rows, values)| {
            for deferred in deferred {
                match self.block {
                    1 => self.add_deferred_by::<1>(deferred, &rows, values),
                    4 => self.add_deferred_by::<4>(deferred, &rows, values),
                    9 => self.add_deferred_by::<9>(deferred, &rows, values),
                    _ => self.add_deferred_by::<0>(deferred, &rows, values),
                }
            }
        });
    }

    /// Adds what a thread kept for some rows, in the values of these.
    fn add_deferred_by<const BLOCK: usize>(
        &self,
        deferred: &Deferred,
        rows: &Range<usize>,
        values: &mut [f64],
    ) {
        let width = self.nodes[1];
        let offset = self.entries(0..rows.start).end;
        let places = deferred.places.chunks_exact(width);
        let blocks = deferred.values.chunks_exact(width * self.block);
        for ((&row, places), blocks) in deferred.rows.iter().zip(places).zip(blocks) {
            let row = row as usize;
            if rows.contains(&row) {
                let entries = self.entries(row..row + 1);
                let row = &mut values[entries.start - offset..entries.end - offset];
                add_row::<_, BLOCK>(row, places, blocks, self.block);
            }
        }
    }
}

/// The matrices of some entities, to be added. Sums of several numbers at once are the same as one by one.
struct Addition<'a, 'v> {
    scatter: &'a MatrixScatter<'a>,
    first: usize,
    matrices: &'a [f64],
    part: &'a mut OwnRows<'v>,
}

impl LaneWork for Addition<'_, '_> {
    type Output = Option<()>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Option<()> {
        let Addition { scatter, first, matrices, part } = self;
        match scatter.block {
            1 => scatter.add_by::<L, 1>(first, matrices, part),
            4 => scatter.add_by::<L, 4>(first, matrices, part),
            9 => scatter.add_by::<L, 9>(first, matrices, part),
            _ => scatter.add_by::<L, 0>(first, matrices, part),
        }
    }
}

/// Adds blocks to a row of the matrix at their places.
#[inline(always)]
fn add_row<P: Slot, const BLOCK: usize>(row: &mut [f64], places: &[P], blocks: &[f64], block: usize) {
    if BLOCK > 0 {
        let (row, _) = row.as_chunks_mut::<BLOCK>();
        let (blocks, _) = blocks.as_chunks::<BLOCK>();
        for (place, values) in places.iter().zip(blocks) {
            // By way of copies: in place the compiler would add one number after the other.
            let entry = &mut row[place.index()];
            let mut sums = *entry;
            for k in 0..BLOCK {
                sums[k] += values[k];
            }
            *entry = sums;
        }
        return;
    }
    for (place, values) in places.iter().zip(blocks.chunks_exact(block)) {
        let start = place.index() * block;
        for (sum, value) in row[start..start + block].iter_mut().zip(values) {
            *sum += value;
        }
    }
}

/// The destination of a group's element vectors.
pub(super) struct VectorScatter<'a> {
    pub tests: GroupNodes<'a>,
    pub components: usize,
    /// Nodes of an entity.
    pub nodes: usize,
}

impl VectorScatter<'_> {
    /// The rows of each thread, as parts of the unknowns of the space.
    pub fn parts<'v>(
        &self,
        partition: &Partition,
        values: &'v mut [f64],
    ) -> Vec<(Range<usize>, OwnRows<'v>)> {
        let is_dense = self.tests.cells.len() * self.nodes * self.components >= values.len();
        let mut rest = values;
        let mut parts = Vec::new();
        for (entities, rows) in partition.entities.iter().zip(&partition.rows) {
            let (own, later) = rest.split_at_mut(rows.len() * self.components);
            rest = later;
            let deferred = Deferred::default();
            let (zeros, known) = (&mut [], CopiedPlaces::default());
            let part = OwnRows {
                rows: rows.clone(),
                values: own,
                zeros,
                written: rows.end,
                is_dense,
                known,
                deferred,
            };
            parts.push((entities.clone(), part));
        }
        parts
    }

    /// The vectors of the entities from `first` on, added.
    pub fn add(&self, first: usize, vectors: &[f64], part: &mut OwnRows) {
        if std::mem::take(&mut part.is_dense) {
            hand_over(part.values);
        }
        let components = self.components;
        for (number, vector) in vectors.chunks_exact(self.nodes * components).enumerate() {
            let rows = self.tests.of(first + number).iter().zip(vector.chunks_exact(components));
            for (&row, values) in rows {
                if !part.rows.contains(&(row as usize)) {
                    part.deferred.rows.push(row);
                    part.deferred.values.extend_from_slice(values);
                    continue;
                }
                let start = (row as usize - part.rows.start) * components;
                for (sum, value) in part.values[start..start + components].iter_mut().zip(values) {
                    *sum += value;
                }
            }
        }
    }

    /// The values that a thread kept for rows of others, added to those of the space's unknowns.
    pub fn add_deferred(&self, part: &Deferred, values: &mut [f64]) {
        let components = self.components;
        for (&row, contribution) in part.rows.iter().zip(part.values.chunks_exact(components)) {
            let sums = &mut values[row as usize * components..][..components];
            for (sum, value) in sums.iter_mut().zip(contribution) {
                *sum += value;
            }
        }
    }
}
