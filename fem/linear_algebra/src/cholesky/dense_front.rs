//! Elimination of the columns of one dense front, in tiles of fixed sizes.
//!
//! Which numbers meet in which product does not depend on the number of threads, and neither does a bit of the result.

use std::sync::{Mutex, PoisonError};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltError, LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::IntoConst;
use faer::{Accum, MatMut, MatRef, Par, Spec};

use crate::threads::Threads;

/// Columns of a tile.
const COLUMNS: usize = 128;
/// Rows of a tile below the diagonal.
const ROWS: usize = 512;
/// Multiplications below which a front is not worth being cut for threads.
const WORTHWHILE: f64 = 2e6;

/// Memory of the factorisation of a block on the diagonal.
pub(super) struct Room(MemBuffer);

impl Room {
    pub(super) fn new() -> Room {
        Room(MemBuffer::new(cholesky_in_place_scratch::<f64>(COLUMNS, Par::Seq, Spec::default())))
    }
}

/// Replaces the columns of a front, the lower trapezoid of its first columns, by those of its Cholesky factor, and subtracts
/// from the lower triangle of `update` what they change in the rows below them.
///
/// # Errors
/// The first column whose pivot is not positive.
pub(super) fn eliminate(
    mut columns: MatMut<'_, f64>,
    update: MatMut<'_, f64>,
    room: &mut Room,
    threads: Threads,
) -> Result<(), usize> {
    let (rows, count) = (columns.nrows(), columns.ncols());
    let threads = if (rows * rows * count) as f64 > WORTHWHILE { threads } else { Threads::ONE };
    let mut begin = 0;
    while begin < count {
        let width = COLUMNS.min(count - begin);
        let rest = columns.as_mut().submatrix_mut(begin, begin, rows - begin, count - begin);
        let (panel, trailing) = rest.split_at_col_mut(width);
        let (mut diagonal, mut below) = panel.split_at_row_mut(width);
        let stack = MemStack::new(&mut room.0);
        cholesky_in_place(diagonal.as_mut(), LltRegularization::default(), Par::Seq, stack, Spec::default())
            .map_err(|LltError::NonPositivePivot { index }| begin + index)?;
        let diagonal = diagonal.into_const();
        each(threads, cut_rows(below.as_mut()), |tile| {
            solve_lower_triangular_in_place(diagonal, tile.transpose_mut(), Par::Seq);
        });
        let trailing = trailing.subrows_mut(width, rows - begin - width);
        subtract_product(trailing, below.into_const(), threads);
        begin += width;
    }
    subtract_product(update, columns.into_const().subrows(count, rows - count), threads);
    Ok(())
}

/// Subtracts `factor` times its transposed from the first columns of a lower triangle, tile by tile.
fn subtract_product(target: MatMut<'_, f64>, factor: MatRef<'_, f64>, threads: Threads) {
    let mut tiles = Vec::new();
    let mut rest = target;
    let mut begin = 0;
    while rest.ncols() > 0 {
        let width = COLUMNS.min(rest.ncols());
        let (tile, further) = rest.split_at_col_mut(width);
        let (diagonal, below) = tile.split_at_row_mut(width);
        tiles.push((diagonal, begin, begin));
        let first = begin + width;
        tiles
            .extend(cut_rows(below).into_iter().enumerate().map(|(k, tile)| (tile, first + k * ROWS, begin)));
        let height = further.nrows();
        rest = further.subrows_mut(width, height - width);
        begin += width;
    }
    each(threads, tiles, |(tile, row, column)| {
        let left = factor.subrows(row, tile.nrows());
        let right = factor.subrows(column, tile.ncols()).transpose();
        if row == column {
            let (lower, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
            triangular::matmul(tile, lower, Accum::Add, left, full, right, full, -1.0, Par::Seq);
        } else {
            matmul(tile, Accum::Add, left, right, -1.0, Par::Seq);
        }
    });
}

fn cut_rows(matrix: MatMut<'_, f64>) -> Vec<MatMut<'_, f64>> {
    let mut tiles = Vec::with_capacity(matrix.nrows().div_ceil(ROWS));
    let mut rest = matrix;
    while rest.nrows() > 0 {
        let height = ROWS.min(rest.nrows());
        let (tile, further) = rest.split_at_row_mut(height);
        tiles.push(tile);
        rest = further;
    }
    tiles
}

/// Does the work on each of the tasks, in any order.
pub(super) fn each<T: Send>(threads: Threads, tasks: Vec<T>, work: impl Fn(T) + Send + Sync) {
    if threads == Threads::ONE || tasks.len() < 2 {
        return tasks.into_iter().for_each(work);
    }
    let workers = threads.count().min(tasks.len());
    let queue = Mutex::new(tasks.into_iter());
    threads.run(vec![(); workers], |()| {
        loop {
            let task = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(task) = task else { break };
            work(task);
        }
    });
}
