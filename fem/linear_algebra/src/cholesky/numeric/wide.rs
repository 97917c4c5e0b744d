//! Supernodes of several panels: work on them is cut into pieces that threads share.

use std::sync::{Mutex, PoisonError};

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};

use super::dense::{Factor, run};
use super::pivots::Pivots;
use super::{PANEL, with_signs};
use crate::threads::Threads;

/// Rows of a tile.
const TILE: usize = 256;

/// Does a work with each item, on several threads. One of them has memory at hand for it.
pub(super) fn share<T: Send, Memory: Default + Send>(
    threads: Threads,
    items: Vec<T>,
    memory: &mut Memory,
    work: impl Fn(T, &mut Memory) + Send + Sync,
) {
    let workers = threads.count().min(items.len()).max(1);
    let items = Mutex::new(items.into_iter());
    let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
    let mut memories = vec![Some(memory)];
    memories.resize_with(workers, || None);
    threads.run(memories, |memory| {
        let mut other = Memory::default();
        let memory = memory.unwrap_or(&mut other);
        while let Some(item) = next() {
            work(item, memory);
        }
    });
}

/// Factors a block of columns from a place of the elimination order on: a triangle and what is below it.
pub(super) fn factor<P: Pivots>(
    threads: Threads,
    (pivots, place): (P, usize),
    block: &mut [f64],
    height: usize,
) -> Result<(), usize> {
    let mut rest = block;
    let mut first = 0;
    let (mut signs, mut signed) = (vec![], vec![]);
    while !rest.is_empty() {
        let width = PANEL.min(rest.len() / height);
        let (panel, later) = rest.split_at_mut(width * height);
        let place = place + first;
        run(Factor { pivots, place, columns: panel, height, first, end: first + width })
            .map_err(|column| first + column)?;
        P::read_signs(&panel[first..], height, &mut signs);
        let matrix = MatMut::from_column_major_slice_mut(panel, height, width);
        let (above, below) = matrix.split_at_row_mut(first + width);
        let triangle = above.as_ref().subrows(first, width);
        share(threads, tiles(below), &mut (), |(_, mut tile), ()| {
            solve_lower_triangular_in_place(triangle, tile.rb_mut().transpose_mut(), Par::Seq);
            for (column, sign) in tile.col_iter_mut().zip(&signs).filter(|(_, sign)| **sign < 0.0) {
                column.iter_mut().for_each(|value| *value *= sign);
            }
        });
        let known = MatRef::from_column_major_slice(&*panel, height, width);
        let with_signs = with_signs(known, &signs, &mut signed);
        let mut products = vec![];
        for (k, columns) in later.chunks_mut(PANEL * height).enumerate() {
            let start = first + width + k * PANEL;
            let count = columns.len() / height;
            let matrix = MatMut::from_column_major_slice_mut(columns, height, count);
            let others = with_signs.subrows(start, count).transpose();
            let below = tiles(matrix.split_at_row_mut(start).1);
            products.extend(below.into_iter().map(|(row, tile)| (start + row, tile, others)));
        }
        share(threads, products, &mut (), |(row, tile, others), ()| {
            let left = known.subrows(row, tile.nrows());
            matmul(tile, Accum::Add, left, others, -1.0, Par::Seq);
        });
        rest = later;
        first += width;
    }
    Ok(())
}

/// Tiles of the rows of a matrix, with their first rows.
fn tiles(matrix: MatMut<'_, f64>) -> Vec<(usize, MatMut<'_, f64>)> {
    let (mut found, mut rest, mut row) = (vec![], matrix, 0);
    while rest.nrows() > 0 {
        let count = TILE.min(rest.nrows());
        let (tile, others) = rest.split_at_row_mut(count);
        found.push((row, tile));
        (rest, row) = (others, row + count);
    }
    found
}
