//! LLᵀ, LSLᵀ with signs S, or LU without exchanges of rows, on given supernodes, looking left: a supernode takes from its columns the products of the rows that earlier supernodes
//! have in it, one earlier supernode after the other, and is factored then.
//!
//! Columns are cut into panels, and the rows of wide supernodes into tiles, that do not depend on the number of threads, and each entry
//! is computed by the same operations in the same order whoever computes it.

mod dense;
mod entries;
mod panels;
mod pivots;
mod rooms;
mod tasks;
mod triangles;

use std::marker::PhantomData;
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};

use self::dense::{Rows, Subtract, run};
pub(super) use self::pivots::{Positive, Signed, Unpivoted};
use self::tasks::Source;
use self::triangles::{Columns, Triangles};
use crate::analysis::Analysis;
use crate::csr::CsrMatrix;
use crate::elimination::{Elimination, PANEL};
use crate::error::LinearAlgebraError;
use crate::large_pages::PrefaultedArray;
use crate::wide_registers::cleared;

/// Least number of multiplications for which a product of wide factors uses faer's kernels.
const LARGE: usize = 1 << 17;
/// Columns of the one, and rows of the other factor from which on they are wide.
const WIDE: usize = 24;
/// Rows of such a product that are formed at once.
const TILE: usize = 512;

/// The supernodes of a factor whose values are computed.
pub(super) struct Numeric<'a, P> {
    pivots: P,
    symbolic: &'a SymbolicSupernodalCholesky<u32>,
    matrix: &'a CsrMatrix,
    /// The unknown at each place, and the place of each unknown.
    order: &'a [u32],
    places: &'a [u32],
    /// Whether the row of each unknown has the pattern of the row before it.
    is_like_last: &'a [bool],
    /// Position of (j, i) for each entry (i, j) of an unsymmetric matrix.
    partners: &'a [u32],
    elimination: &'a Elimination,
}

/// Memory for the work of a thread.
#[derive(Default)]
struct Scratch {
    /// Row of the supernode at work for each row of the matrix that it has.
    places: Vec<u32>,
    own: Panel,
    /// The end of the values whose memory has been handed over.
    handed_over: usize,
    supply: Option<PrefaultedArray>,
}

impl Scratch {
    /// Forgets what was prefaulted: work goes on at another place.
    fn begin(&mut self, place: usize) {
        self.handed_over = place;
    }

    /// Prefaults the memory of the next values from the given place on, as far as the given number is needed at once.
    fn prefault(&mut self, place: usize, needed: usize, next: &mut [f64]) {
        if place + needed > self.handed_over {
            let supply = self.supply.get_or_insert_with(|| PrefaultedArray::of(size_of_val(next)));
            self.handed_over = place + supply.prefault(next, needed);
        }
    }
}

/// Memory for the work on a panel.
#[derive(Default)]
struct Panel {
    targets: Vec<u32>,
    products: Vec<f64>,
    /// Signs of the columns of an earlier supernode.
    signs: Vec<f64>,
    /// Rows of that with these signs.
    signed: Vec<f64>,
}

impl<'a, P: Triangles> Numeric<'a, P> {
    /// The factorisation of a matrix, which must have the pattern that was analysed.
    pub(super) fn new(
        pivots: P,
        analysis: &'a Analysis,
        matrix: &'a CsrMatrix,
    ) -> Result<Self, LinearAlgebraError> {
        let (places, symbolic) = (analysis.places(matrix)?, &analysis.supernodes);
        let (order, is_like_last) = (&analysis.order[..], &analysis.is_like_last[..]);
        let elimination = analysis.elimination();
        let partners = if P::COUNT > 1 { analysis.partners() } else { &[] };
        Ok(Self { pivots, symbolic, matrix, order, places, is_like_last, partners, elimination })
    }

    fn columns(&self, supernode: usize) -> Range<usize> {
        let (begin, end) = (self.symbolic.supernode_begin(), self.symbolic.supernode_end());
        begin[supernode] as usize..end[supernode] as usize
    }

    /// Positions of the values of some supernodes.
    fn values(&self, supernodes: Range<usize>) -> Range<usize> {
        let starts = self.symbolic.col_ptr_for_val();
        P::COUNT * starts[supernodes.start] as usize..P::COUNT * starts[supernodes.end] as usize
    }

    /// Number of values of a panel of a supernode whose columns have the given height.
    fn panel_length(height: usize) -> usize {
        P::COUNT * PANEL * height
    }

    /// Notes the row of a supernode for each row of the matrix that it has.
    fn place_rows(&self, supernode: usize, scratch: &mut Scratch) {
        let columns = self.columns(supernode);
        scratch.places.resize(self.symbolic.nrows(), 0);
        for (place, row) in (0..).zip(columns.clone()) {
            scratch.places[row] = place;
        }
        for (place, row) in (columns.len() as u32..).zip(self.symbolic.supernode(supernode).pattern()) {
            scratch.places[*row as usize] = place;
        }
    }

    /// Factors a supernode into its block. All that it depends on has been factored.
    fn supernode(
        &self,
        supernode: usize,
        source: Source<'_, '_>,
        block: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), usize> {
        let columns = self.columns(supernode);
        let height = block.len() / (P::COUNT * columns.len());
        let length = Self::panel_length(height);
        self.place_rows(supernode, scratch);
        let Scratch { places, own, .. } = scratch;
        for (first, panel) in columns.clone().step_by(PANEL).zip(block.chunks_mut(length)) {
            self.gather(supernode, first, source, (panel, height), places, own);
        }
        if columns.len() <= PANEL {
            let all = Columns { place: columns.start, values: block, height, first: 0, end: height };
            return self.pivots.factor(all).map_err(|column| columns.start + column);
        }
        for number in 0..columns.len().div_ceil(PANEL) {
            let (known, rest) = block.split_at_mut(number * length);
            let next = rest.len().min(length);
            let (panel, first) = (&mut rest[..next], number * PANEL);
            for (earlier, known) in known.chunks(length).enumerate() {
                panels::take::<P>((known, earlier * PANEL), (panel, height), first, own);
            }
            let place = columns.start + first;
            panels::factor((self.pivots, place), (panel, height), first, own)
                .map_err(|column| place + column)?;
        }
        Ok(())
    }

    /// Columns of a supernode from one on, with what all earlier supernodes take from them.
    fn gather(
        &self,
        supernode: usize,
        first: usize,
        source: Source<'_, '_>,
        (panel, height): (&mut [f64], usize),
        places: &[u32],
        scratch: &mut Panel,
    ) {
        panel.fill(0.0);
        let columns = first..first + panel.len() / (P::COUNT * height);
        let values = self.matrix.values();
        if P::COUNT == 1 {
            self.copy_entries(columns.clone(), panel, places, |entry| values[entry]);
        } else {
            // Rows of the matrix are columns of Uᵀ.
            let (lower, upper) = panel.split_at_mut(columns.len() * height);
            let of_column = |entry: usize| values[self.partners[entry] as usize];
            self.copy_entries(columns.clone(), lower, places, of_column);
            self.copy_entries(columns.clone(), upper, places, |entry| values[entry]);
        }
        let target_first = places[first] as usize;
        let is_whole = columns == self.columns(supernode);
        for update in self.elimination.updates.of(supernode) {
            let earlier = update.supernode as usize;
            let width = self.columns(earlier).len();
            let mut rows = &self.symbolic.supernode(earlier).pattern()[update.first as usize..];
            let mut count = update.count as usize;
            let mut above = width + update.first as usize;
            if !is_whole {
                let skipped = rows[..count].partition_point(|row| (*row as usize) < columns.start);
                count = rows[skipped..count].partition_point(|row| (*row as usize) < columns.end);
                rows = &rows[skipped..];
                above += skipped;
                if count == 0 {
                    continue;
                }
            }
            scratch.targets.clear();
            scratch.targets.extend(rows.iter().map(|row| places[*row as usize]));
            let place = self.values(earlier..earlier + 1);
            let earlier_height = place.len() / (P::COUNT * width);
            let products = Products { height: earlier_height, above, count, target_first };
            // One triangle by itself is not cut into panels.
            let length = if P::COUNT == 1 { place.len() } else { Self::panel_length(earlier_height) };
            if earlier >= source.first {
                let block = &source.own[place.start - source.start..place.end - source.start];
                products.subtract::<P>(block.chunks(length), width, (panel, height), scratch);
            } else {
                let room = &source.rooms[self.elimination.unit_of[earlier] as usize];
                let blocks = room.blocks(place).flat_map(|block| block.chunks(length));
                products.subtract::<P>(blocks, width, (panel, height), scratch);
            }
        }
    }
}

/// Rows of an earlier supernode whose products with some of them are taken from a panel.
struct Products {
    /// Of the earlier supernode's columns.
    height: usize,
    /// The first of the rows.
    above: usize,
    /// Number of them that are columns of the panel.
    count: usize,
    /// Of the first of the panel's columns, in its rows.
    target_first: usize,
}

impl Products {
    /// Takes the products of columns that come in one block or panel by panel, of the given width in all. Their targets are in the scratch.
    /// The diagonal of a panel begins in the row with the number of its first column.
    fn subtract<'b, P: Triangles>(
        &self,
        blocks: impl Iterator<Item = &'b [f64]>,
        width: usize,
        (panel, height): (&mut [f64], usize),
        scratch: &mut Panel,
    ) {
        let Products { height: block_height, above, count, target_first } = *self;
        let Panel { targets, products, signs, signed } = scratch;
        let length = panel.len() / P::COUNT;
        if width.min(count) < WIDE || targets.len() * width * count < LARGE {
            for (number, block) in blocks.enumerate() {
                P::read_signs(&block[number * PANEL..], block_height, signs);
                for (triangle, target) in panel.chunks_exact_mut(length).enumerate() {
                    let (block, factors) = P::with_factors(block, triangle);
                    run(Subtract::<P> {
                        rows: Rows { block, factors, height: block_height, first: above },
                        signs,
                        rule: PhantomData,
                        columns: count,
                        targets,
                        target,
                        target_height: height,
                        target_first,
                    });
                }
            }
            return;
        }
        let blocks = blocks.collect::<Vec<_>>();
        for (triangle, panel) in panel.chunks_exact_mut(length).enumerate() {
            let mut done = 0;
            while done < targets.len() {
                let tile = TILE.min(targets.len() - done);
                products.resize(TILE * PANEL, 0.0);
                let products = &mut products[..tile * count];
                let mut accumulate = Accum::Replace;
                for (number, block) in blocks.iter().enumerate() {
                    P::read_signs(&block[number * PANEL..], block_height, signs);
                    let (block, factors) = P::with_factors(block, triangle);
                    let [block, factors] = [block, factors].map(|part| {
                        MatRef::from_column_major_slice(part, block_height, part.len() / block_height)
                    });
                    let others = with_signs(factors.subrows(above, count), signs, signed).transpose();
                    let sums = MatMut::from_column_major_slice_mut(products, tile, count);
                    let own = block.subrows(above + done, tile);
                    cleared(|| matmul(sums, accumulate, own, others, 1.0, Par::Seq));
                    accumulate = Accum::Add;
                }
                for (k, products) in products.chunks_exact(tile).enumerate() {
                    let column = &mut panel[(targets[k] as usize - target_first) * height..][..height];
                    let skipped = k.saturating_sub(done).min(tile);
                    subtract(column, &targets[done + skipped..done + tile], &products[skipped..]);
                }
                done += tile;
            }
        }
    }
}

/// The columns of a matrix with their signs; itself if none is negative.
fn with_signs<'a>(matrix: MatRef<'a, f64>, signs: &[f64], memory: &'a mut Vec<f64>) -> MatRef<'a, f64> {
    if signs.iter().all(|sign| *sign > 0.0) {
        return matrix;
    }
    memory.clear();
    for (column, sign) in matrix.col_iter().zip(signs) {
        memory.extend(column.iter().map(|value| sign * value));
    }
    MatRef::from_column_major_slice(memory, matrix.nrows(), matrix.ncols())
}

/// Subtracts numbers from those at some places of a column, run by run of neighbours.
#[inline]
fn subtract(column: &mut [f64], targets: &[u32], numbers: &[f64]) {
    let (Some(first), Some(last)) = (targets.first(), targets.last()) else { return };
    if (last - first) as usize + 1 == targets.len() {
        let column = &mut column[*first as usize..][..targets.len()];
        for (value, number) in column.iter_mut().zip(numbers) {
            *value -= number;
        }
    } else {
        for (target, number) in targets.iter().zip(numbers) {
            column[*target as usize] -= number;
        }
    }
}
