//! Panels of wide supernodes: what an earlier panel takes from a later one, and the factorisation of a panel.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};

use super::dense::{Factor, run};
use super::pivots::Pivots;
use super::{Panel, with_signs};

/// Rows of a tile.
const TILE: usize = 256;

/// Factors a panel whose first column is the given one of its supernode: its triangle and what is below it. `place` is that of the first column in
/// the elimination order. An error is the column of the panel whose pivot is not taken.
pub(super) fn factor<P: Pivots>(
    (pivots, place): (P, usize),
    (panel, height): (&mut [f64], usize),
    first: usize,
    scratch: &mut Panel,
) -> Result<(), usize> {
    let width = panel.len() / height;
    run(Factor { pivots, place, columns: panel, height, first, end: first + width })?;
    P::read_signs(&panel[first..], height, &mut scratch.signs);
    let matrix = MatMut::from_column_major_slice_mut(panel, height, width);
    let (above, below) = matrix.split_at_row_mut(first + width);
    let triangle = above.as_ref().subrows(first, width);
    for mut tile in tiles(below) {
        solve_lower_triangular_in_place(triangle, tile.rb_mut().transpose_mut(), Par::Seq);
        for (column, sign) in tile.col_iter_mut().zip(&scratch.signs).filter(|(_, sign)| **sign < 0.0) {
            column.iter_mut().for_each(|value| *value *= sign);
        }
    }
    Ok(())
}

/// Takes from a panel, whose first column is the given one of its supernode, the products of an earlier one, whose first column is given too.
pub(super) fn take<P: Pivots>(
    (earlier, earlier_first): (&[f64], usize),
    (panel, height): (&mut [f64], usize),
    first: usize,
    scratch: &mut Panel,
) {
    P::read_signs(&earlier[earlier_first..], height, &mut scratch.signs);
    let known = MatRef::from_column_major_slice(earlier, height, earlier.len() / height);
    let (width, matrix) =
        (panel.len() / height, MatMut::from_column_major_slice_mut(panel, height, panel.len() / height));
    let others = with_signs(known.subrows(first, width), &scratch.signs, &mut scratch.signed).transpose();
    let mut row = first;
    for tile in tiles(matrix.split_at_row_mut(first).1) {
        let count = tile.nrows();
        matmul(tile, Accum::Add, known.subrows(row, count), others, -1.0, Par::Seq);
        row += count;
    }
}

/// Tiles of the rows of a matrix.
fn tiles(matrix: MatMut<'_, f64>) -> Vec<MatMut<'_, f64>> {
    let (mut found, mut rest) = (vec![], matrix);
    while rest.nrows() > 0 {
        let count = TILE.min(rest.nrows());
        let (tile, others) = rest.split_at_row_mut(count);
        found.push(tile);
        rest = others;
    }
    found
}
