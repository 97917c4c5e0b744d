//! Condensation: a factor K = L D Lᵀ with some unknowns c last, D = 1 or a diagonal of signs, and the Schur complement
//! S = L_c D_c L_cᵀ on them, dense.
//!
//! T = K + B, where B couples unknowns of c only, is solved with the factor of K and a dense one of S + B.

mod dense;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::solve;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::perm::PermRef;
use faer::{Conj, Mat, MatMut, Par};

use crate::cholesky::SymmetricFactor;
use crate::csr::Entry;
use crate::error::LinearAlgebraError;
use crate::partial_solves::lower_times_transposed;
use crate::threads::Threads;
use crate::transpose::Transpose;
use crate::wide_registers::cleared;

/// The factor of K and its Schur complement.
#[derive(Debug)]
pub struct Condensation {
    factor: SymmetricFactor,
    /// c, in elimination order.
    unknowns: Vec<u32>,
    /// Place of each unknown among them.
    places: Vec<Option<u32>>,
    lower: Mat<f64>,
    /// D_c.
    signs: Vec<f64>,
    schur: Mat<f64>,
}

/// The dense factor LU of S + B.
#[derive(Debug)]
pub struct DenseFactor {
    /// U, and below it L without its diagonal of ones.
    triangles: Mat<f64>,
    /// The rows in the order of their pivots, and the place of each row in it.
    rows: Vec<u32>,
    places: Vec<u32>,
}

impl DenseFactor {
    /// Of a matrix, in its memory.
    fn new(threads: Threads, mut matrix: Mat<f64>) -> Self {
        let size = matrix.nrows();
        let (mut rows, mut places) = (vec![0_u32; size], vec![0_u32; size]);
        dense::factor_in_place(threads, matrix.as_mut(), &mut rows, &mut places);
        DenseFactor { triangles: matrix, rows, places }
    }

    /// Replaces b by (S + B)⁻¹ b or (S + B)⁻ᵀ b.
    fn solve(&self, b: &mut [f64], transpose: Transpose) {
        let (size, triangles, parallel) = (b.len(), self.triangles.as_ref(), Par::Seq);
        let scratch = solve::solve_in_place_scratch::<u32, f64>(size, 1, parallel)
            .or(solve::solve_transpose_in_place_scratch::<u32, f64>(size, 1, parallel));
        let mut memory = MemBuffer::new(scratch);
        let solve = match transpose {
            Transpose::No => solve::solve_in_place_with_conj::<u32, f64>,
            Transpose::Yes => solve::solve_transpose_in_place_with_conj::<u32, f64>,
        };
        let rows = PermRef::new_checked(&self.rows, &self.places, size);
        let column = MatMut::from_column_major_slice_mut(b, size, 1);
        let stack = MemStack::new(&mut memory);
        cleared(|| solve(triangles, triangles, rows, Conj::No, column, parallel, stack));
    }
}

impl Condensation {
    /// A condensation of a factor whose last `count` unknowns are c.
    pub fn new(threads: Threads, factor: SymmetricFactor, count: usize) -> Self {
        let order = factor.analysis().elimination_order();
        let unknowns = order[order.len() - count..].to_vec();
        let mut places = vec![None; order.len()];
        for (place, unknown) in unknowns.iter().enumerate() {
            places[*unknown as usize] = Some(place as u32);
        }
        let lower = factor.trailing_block(count);
        let mut signs = vec![1.0; order.len()];
        factor.apply_signs(&mut signs);
        let signs = signs.split_off(order.len() - count);
        let schur = lower_times_transposed(threads, &lower, &signs);
        Condensation { factor, unknowns, places, lower, signs, schur }
    }

    /// The factor of K.
    pub fn factor(&self) -> &SymmetricFactor {
        &self.factor
    }

    /// c, in elimination order: that of all vectors and matrices on it.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknowns
    }

    /// Whether all of these are among c.
    pub fn holds(&self, unknowns: &[u32]) -> bool {
        unknowns.iter().all(|unknown| self.places[*unknown as usize].is_some())
    }

    /// The dense factor of S + B; entries outside of c are left out. The memory of an earlier one may be reused. The same bits come from any
    /// number of threads.
    pub fn dense_factor(
        &self,
        threads: Threads,
        additions: &[Entry],
        earlier: Option<DenseFactor>,
    ) -> DenseFactor {
        let size = self.schur.nrows();
        let fits = |matrix: &Mat<f64>| (matrix.nrows(), matrix.ncols()) == (size, size);
        let mut system = match earlier.map(|earlier| earlier.triangles).filter(fits) {
            Some(mut memory) => {
                memory.copy_from(&self.schur);
                memory
            }
            None => self.schur.clone(),
        };
        for Entry { row, column, value } in additions {
            let place = |unknown: u32| self.places[unknown as usize];
            if let (Some(row), Some(column)) = (place(*row), place(*column)) {
                system[(row as usize, column as usize)] += value;
            }
        }
        DenseFactor::new(threads, system)
    }

    /// S x of condensed unknowns.
    pub fn schur_times(&self, x: &[f64]) -> Vec<f64> {
        column(&(&self.schur * as_column(x)))
    }

    /// D⁻¹ L⁻¹ b in elimination order: what back-substitution reads.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn forward(&self, b: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        let mut y = self.factor.solve_lower(b)?;
        self.factor.apply_signs(&mut y);
        Ok(y)
    }

    /// The right-hand side of the condensed system: L_c D_c y_c of a vector y = D⁻¹ L⁻¹ b.
    pub fn condensed_load(&self, y: &[f64]) -> Vec<f64> {
        let last = y[y.len() - self.unknowns.len()..].iter().zip(&self.signs);
        let last: Vec<f64> = last.map(|(value, sign)| value * sign).collect();
        cleared(|| column(&(&self.lower * as_column(&last))))
    }

    /// L_cᵀ x_c, which back-substitution reads in place of y_c.
    pub fn shifted(&self, x: &[f64]) -> Vec<f64> {
        cleared(|| column(&(self.lower.transpose() * as_column(x))))
    }

    /// (S + B)⁻¹ r with the dense factor of S + B; none where B = 0.
    pub fn dense_solve(&self, r: &[f64], dense: Option<&DenseFactor>) -> Vec<f64> {
        let mut x = r.to_vec();
        match dense {
            Some(dense) => dense.solve(&mut x, Transpose::No),
            None => {
                let mut column = MatMut::from_column_major_slice_mut(&mut x, r.len(), 1);
                cleared(|| solve_lower_triangular_in_place(self.lower.as_ref(), column.as_mut(), Par::Seq));
                for (place, sign) in self.signs.iter().enumerate() {
                    column[(place, 0)] *= sign;
                }
                cleared(|| solve_upper_triangular_in_place(self.lower.transpose(), column, Par::Seq));
            }
        }
        x
    }

    /// T⁻¹ b, or T⁻ᵀ b, of all unknowns for several B and b, with the dense factor of each S + B; none where B = 0. The factor of K is read
    /// once for all of them, and each has the bits that it has by itself.
    ///
    /// # Errors
    /// If a size is wrong.
    pub fn solve_each(&self, systems: &[CondensedSide<'_>]) -> Result<Vec<Vec<f64>>, LinearAlgebraError> {
        let sides: Vec<&[f64]> = systems.iter().map(|system| system.b).collect();
        let mut found = self.factor.solve_lower_each(&sides)?;
        for (y, system) in found.iter_mut().zip(systems) {
            self.factor.apply_signs(y);
            if let Some(dense) = system.dense {
                let mut x = self.condensed_load(y);
                dense.solve(&mut x, system.transpose);
                let first = y.len() - self.unknowns.len();
                y[first..].copy_from_slice(&self.shifted(&x));
            }
        }
        self.factor.solve_upper_each(found)
    }
}

/// The right-hand side of a condensed solve, and what tells its matrix from K.
#[derive(Clone, Copy, Debug)]
pub struct CondensedSide<'a> {
    /// On all unknowns.
    pub b: &'a [f64],
    /// The dense factor of S + B; none where B = 0.
    pub dense: Option<&'a DenseFactor>,
    /// Whether T or its transposed is solved with.
    pub transpose: Transpose,
}

fn as_column(x: &[f64]) -> Mat<f64> {
    Mat::from_fn(x.len(), 1, |i, _| x[i])
}

fn column(x: &Mat<f64>) -> Vec<f64> {
    (0..x.nrows()).map(|i| x[(i, 0)]).collect()
}
