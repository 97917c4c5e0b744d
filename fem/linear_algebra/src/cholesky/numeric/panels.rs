//! Panels of wide supernodes: what an earlier panel takes from a later one, and the factorisation of a panel.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};

use super::triangles::{Columns, Triangles};
use super::{Panel, with_signs};
use crate::wide_registers::cleared;

/// Rows of a tile.
const TILE: usize = 256;

/// Factors a panel whose first column is the given one of its supernode: its triangle and what is below it. `place` is that of the first column in
/// the elimination order. An error is the column of the panel whose pivot is not taken.
pub(super) fn factor<P: Triangles>(
    (pivots, place): (P, usize),
    (panel, height): (&mut [f64], usize),
    first: usize,
    scratch: &mut Panel,
) -> Result<(), usize> {
    let width = panel.len() / (P::COUNT * height);
    pivots.factor(Columns { place, values: panel, height, first, end: first + width })?;
    P::read_signs(&panel[first..], height, &mut scratch.signs);
    let parts = panel.chunks_exact_mut(width * height);
    let (above, below): (Vec<_>, Vec<_>) = parts
        .map(|part| MatMut::from_column_major_slice_mut(part, height, width).split_at_row_mut(first + width))
        .unzip();
    for (number, below) in below.into_iter().enumerate() {
        // Rows of L are solved with U, and those of Uᵀ with L.
        let triangle = above[P::COUNT - 1 - number].as_ref().subrows(first, width);
        for mut tile in tiles(below) {
            let rows = tile.rb_mut().transpose_mut();
            cleared(|| solve_lower_triangular_in_place(triangle, rows, Par::Seq));
            for (column, sign) in tile.col_iter_mut().zip(&scratch.signs).filter(|(_, sign)| **sign < 0.0) {
                column.iter_mut().for_each(|value| *value *= sign);
            }
        }
    }
    Ok(())
}

/// Takes from a panel, whose first column is the given one of its supernode, the products of an earlier one, whose first column is given too.
pub(super) fn take<P: Triangles>(
    (earlier, earlier_first): (&[f64], usize),
    (panel, height): (&mut [f64], usize),
    first: usize,
    scratch: &mut Panel,
) {
    P::read_signs(&earlier[earlier_first..], height, &mut scratch.signs);
    let width = panel.len() / (P::COUNT * height);
    for (number, part) in panel.chunks_exact_mut(width * height).enumerate() {
        let (known, factors) = P::with_factors(earlier, number);
        let [known, factors] =
            [known, factors].map(|part| MatRef::from_column_major_slice(part, height, part.len() / height));
        let factors = factors.subrows(first, width);
        let others = with_signs(factors, &scratch.signs, &mut scratch.signed).transpose();
        let mut row = first;
        let matrix = MatMut::from_column_major_slice_mut(part, height, width);
        for tile in tiles(matrix.split_at_row_mut(first).1) {
            let count = tile.nrows();
            cleared(|| matmul(tile, Accum::Add, known.subrows(row, count), others, -1.0, Par::Seq));
            row += count;
        }
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
