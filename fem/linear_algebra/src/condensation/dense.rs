//! Dense LU with partial pivoting on threads. Columns are cut into panels and tiles that do not depend on the number of threads, so
//! that each entry comes from the same operations.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par, Spec};

use crate::threads::Threads;
use crate::wide_registers::cleared;

/// Columns of a panel.
const PANEL: usize = 64;
/// Columns of a tile of the other ones.
const TILE: usize = 96;
/// Unknowns from which on a matrix is cut into panels.
const LARGE: usize = 384;

/// Factors a matrix in place, U and below it L without its diagonal of ones. `rows` gets the rows in the order of their pivots, and
/// `places` the place of each row in it.
pub(super) fn factor_in_place(
    threads: Threads,
    mut matrix: MatMut<'_, f64>,
    rows: &mut [u32],
    places: &mut [u32],
) {
    let size = matrix.nrows();
    if size < LARGE {
        return factor_panel(matrix, rows, places);
    }
    (0..).zip(rows.iter_mut()).for_each(|(number, row)| *row = number);
    let (mut order, mut inverse) = (vec![0_u32; size], vec![0_u32; size]);
    let mut first = 0;
    while first < size {
        let width = PANEL.min(size - first);
        let (done, rest) = matrix.rb_mut().split_at_col_mut(first);
        let (mut panel, later) = rest.split_at_col_mut(width);
        let height = size - first;
        let (order, inverse) = (&mut order[..height], &mut inverse[..height]);
        factor_panel(panel.rb_mut().subrows_mut(first, height), order, inverse);
        let earlier = rows[first..].to_vec();
        rows[first..].iter_mut().zip(&*order).for_each(|(row, from)| *row = earlier[*from as usize]);
        let panel = panel.rb().subrows(first, height);
        let tiles = tiles(done).into_iter().map(|tile| (tile, Work::Exchange));
        let tiles = tiles.chain(self::tiles(later).into_iter().map(|tile| (tile, Work::Eliminate))).collect();
        threads.share(tiles, |(tile, work): (MatMut<'_, f64>, Work)| {
            let mut tile = tile.subrows_mut(first, height);
            exchange(tile.rb_mut(), order);
            if let Work::Eliminate = work {
                eliminate(tile, panel);
            }
        });
        first += width;
    }
    (0..).zip(&*rows).for_each(|(place, row)| places[*row as usize] = place);
}

/// Work on the columns outside of the panel.
#[derive(Clone, Copy)]
enum Work {
    /// Of finished columns rows change places only.
    Exchange,
    /// From later ones the panel's products are taken, too.
    Eliminate,
}

fn factor_panel(panel: MatMut<'_, f64>, rows: &mut [u32], places: &mut [u32]) {
    let (parallel, params) = (Par::Seq, Spec::default());
    let scratch = factor::lu_in_place_scratch::<u32, f64>(panel.nrows(), panel.ncols(), parallel, params);
    let mut memory = MemBuffer::new(scratch);
    cleared(|| {
        factor::lu_in_place(panel, rows, places, parallel, MemStack::new(&mut memory), params);
    });
}

/// Brings rows into an order.
fn exchange(tile: MatMut<'_, f64>, order: &[u32]) {
    let mut before = vec![0.0; order.len()];
    for mut column in tile.col_iter_mut() {
        before.iter_mut().zip(column.rb_mut().iter_mut()).for_each(|(before, value)| *before = *value);
        column.iter_mut().zip(order).for_each(|(value, from)| *value = before[*from as usize]);
    }
}

/// Takes the products of a factored panel out of some columns.
fn eliminate(tile: MatMut<'_, f64>, panel: MatRef<'_, f64>) {
    let (mut above, below) = tile.split_at_row_mut(panel.ncols());
    let (triangle, left) = panel.split_at_row(panel.ncols());
    cleared(|| {
        solve_unit_lower_triangular_in_place(triangle, above.rb_mut(), Par::Seq);
        matmul(below, Accum::Add, left, above.rb(), -1.0, Par::Seq);
    });
}

fn tiles(matrix: MatMut<'_, f64>) -> Vec<MatMut<'_, f64>> {
    let (mut found, mut rest) = (vec![], matrix);
    while rest.ncols() > 0 {
        let count = TILE.min(rest.ncols());
        let (tile, others) = rest.split_at_col_mut(count);
        found.push(tile);
        rest = others;
    }
    found
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;

    #[test]
    fn factors_multiply_to_the_matrix_with_the_same_bits_on_any_number_of_threads() {
        for size in [0, 1, 90, 384, 500, 901] {
            let matrix = Mat::from_fn(size, size, |i, j| ((i * 37 + j * 101 + i * j) as f64).sin());
            let factored = |threads: usize| {
                let (mut triangles, mut rows, mut places) = (matrix.clone(), vec![0; size], vec![0; size]);
                factor_in_place(Threads::new(threads), triangles.as_mut(), &mut rows, &mut places);
                (triangles, rows, places)
            };
            let (triangles, rows, places) = factored(1);
            let lower = Mat::from_fn(size, size, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Less => 0.0,
                std::cmp::Ordering::Equal => 1.0,
                std::cmp::Ordering::Greater => triangles[(i, j)],
            });
            let upper = Mat::from_fn(size, size, |i, j| if i <= j { triangles[(i, j)] } else { 0.0 });
            let product = &lower * &upper;
            for i in 0..size {
                assert_eq!(places[rows[i] as usize], i as u32);
                for j in 0..size {
                    assert!(i <= j || triangles[(i, j)].abs() <= 1.0, "{size}: a pivot is not the largest");
                    let difference = product[(i, j)] - matrix[(rows[i] as usize, j)];
                    assert!(difference.abs() < 1e-11, "{size} ({i}, {j}): {difference:e}");
                }
            }
            let bits = |matrix: &Mat<f64>| {
                let columns = matrix.col_iter().flat_map(|column| column.iter());
                columns.map(|value| value.to_bits()).collect::<Vec<_>>()
            };
            for threads in [2, 3, 7, 16] {
                let (other, other_rows, _) = factored(threads);
                assert!(bits(&other) == bits(&triangles) && other_rows == rows, "{size}: {threads} threads");
            }
        }
    }
}
