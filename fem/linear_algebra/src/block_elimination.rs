//! Exact elimination of groups of unknowns that are coupled only within a group and with the remaining unknowns, as unknowns that live
//! in one cell each.
//!
//! With r for the remaining unknowns and g for those of a group, S = A_rr − Σ A_rg A_gg⁻¹ A_gr is the matrix that is left, the sum in the
//! order of the groups. With S x_r = b_r − Σ A_rg A_gg⁻¹ b_g the others follow group by group, x_g = A_gg⁻¹ (b_g − A_gr x_r); the
//! transposed system likewise.

mod groups;
mod pivots;

use std::ops::Range;
use std::sync::Arc;

pub use groups::{Counts, Groups, MultiplierNode};
use groups::{NONE, Plan};

use super::csr::CsrMatrix;
use super::error::{LinearAlgebraError, check_size};
use super::pattern::SparsityPattern;
use super::small_inverse::small_inverse;
use super::threads::Threads;
use super::transpose::Transpose;

/// Groups whose products are formed side by side before they are added one after the other.
const AT_ONCE: usize = 4096;

/// Symbolic part of the elimination of groups: what a pattern says.
#[derive(Debug)]
pub struct BlockElimination {
    pattern: Arc<SparsityPattern>,
    plan: Plan,
    /// Pattern of S.
    left: Arc<SparsityPattern>,
    counts: Counts,
    groups: Groups,
    /// Unknowns that pivots of an earlier matrix kept.
    refused: Vec<bool>,
}

/// The groups' blocks of a matrix.
#[derive(Debug)]
pub struct Eliminated {
    blocks: Vec<Block>,
}

/// Of a group, row by row.
#[derive(Debug)]
struct Block {
    /// A_gg⁻¹.
    inverse: Vec<f64>,
    /// A_gg⁻¹ A_gr.
    right: Vec<f64>,
    /// A_rg A_gg⁻¹.
    left: Vec<f64>,
    /// A_rg A_gg⁻¹ A_gr.
    product: Vec<f64>,
}

impl BlockElimination {
    /// The elimination of groups from matrices of a pattern. None if nothing can be eliminated, or nothing would be left.
    ///
    /// # Errors
    /// If the pattern is not square, or what is left has too many entries for 32-bit indices.
    pub fn new(
        pattern: &Arc<SparsityPattern>,
        groups: &Groups,
    ) -> Result<(Option<Self>, Counts), LinearAlgebraError> {
        Self::without(pattern, groups, vec![false; pattern.rows()])
    }

    fn without(
        pattern: &Arc<SparsityPattern>,
        groups: &Groups,
        refused: Vec<bool>,
    ) -> Result<(Option<Self>, Counts), LinearAlgebraError> {
        check_size("the set of columns of a square matrix", pattern.rows(), pattern.columns())?;
        let (plan, coupled) = Plan::new(pattern, groups, &refused);
        let counts = Counts {
            coupled,
            by_pivots: refused.iter().filter(|refused| **refused).count(),
            eliminated: plan.members.len(),
        };
        if plan.members.is_empty() || plan.rest.is_empty() {
            return Ok((None, Counts { eliminated: 0, ..counts }));
        }
        let left = Arc::new(plan.pattern_of_rest(pattern)?);
        let (pattern, groups) = (pattern.clone(), groups.clone());
        Ok((Some(BlockElimination { pattern, plan, left, counts, groups, refused }), counts))
    }

    /// Numbers of unknowns that are eliminated, and of others by the reason.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Whether a matrix has the pattern of this elimination.
    pub fn fits(&self, matrix: &CsrMatrix) -> bool {
        Arc::ptr_eq(matrix.pattern(), &self.pattern) || **matrix.pattern() == *self.pattern
    }

    /// The pattern of the whole matrix.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.pattern
    }

    /// The remaining unknowns, ascending.
    pub fn rest(&self) -> &[u32] {
        &self.plan.rest
    }

    /// S of a matrix, and the groups' blocks. The same bits come from any number of threads. The error is an elimination without the groups that
    /// have a pivot below 1e-10 of its scale; none if no group is left, or if it happens a second time.
    ///
    /// # Errors
    /// As [`BlockElimination::new`], or if the matrix has another pattern.
    #[allow(clippy::type_complexity)]
    pub fn eliminate(
        &self,
        threads: Threads,
        matrix: &CsrMatrix,
    ) -> Result<Result<(CsrMatrix, Eliminated), (Option<Self>, Counts)>, LinearAlgebraError> {
        if !self.fits(matrix) {
            return Err(LinearAlgebraError::PatternMismatch {
                what: "eliminating groups of another pattern",
            });
        }
        let scales = pivots::scales(matrix, &self.plan.owner);
        let mut values = self.values_of_rest(matrix);
        let mut blocks: Vec<Option<Block>> = Vec::with_capacity(self.plan.count());
        let mut from = 0;
        while from < self.plan.count() {
            let end = self.plan.count().min(from + AT_ONCE);
            let length = (end - from).div_ceil(threads.count()).max(1);
            let parts: Vec<Range<usize>> =
                (from..end).step_by(length).map(|start| start..end.min(start + length)).collect();
            let found = threads.run(parts, |groups| {
                groups.map(|group| self.block(matrix, group, &scales)).collect::<Vec<_>>()
            });
            blocks.extend(found.into_iter().flatten());
            for (group, block) in (from..).zip(&mut blocks[from..]) {
                if let Some(block) = block {
                    self.subtract(group, &std::mem::take(&mut block.product), &mut values);
                }
            }
            from = end;
        }
        if blocks.iter().any(Option::is_none) {
            let mut refused = self.refused.clone();
            // Where pivots vanish in a later matrix once more, none is eliminated: each time, the rest is analysed anew.
            let is_first = !refused.contains(&true);
            for group in (0..blocks.len()).filter(|group| !is_first || blocks[*group].is_none()) {
                self.plan.members_of(group).iter().for_each(|unknown| refused[*unknown as usize] = true);
            }
            return Ok(Err(Self::without(&self.pattern, &self.groups, refused)?));
        }
        let left = CsrMatrix::from_pattern(&self.left, values)?;
        Ok(Ok((left, Eliminated { blocks: blocks.into_iter().flatten().collect() })))
    }

    /// A_rr on the pattern of S.
    fn values_of_rest(&self, matrix: &CsrMatrix) -> Vec<f64> {
        let mut values = vec![0.0; self.left.entries()];
        for (row, unknown) in self.plan.rest.iter().enumerate() {
            let range = self.left.row_range(row);
            let (columns, own) = (&self.left.column_indices()[range.clone()], &mut values[range]);
            let (unknowns, entries) = matrix.row(*unknown as usize);
            let mut place = 0;
            for (other, value) in unknowns.iter().zip(entries) {
                let column = self.plan.number[*other as usize];
                if self.plan.owner[*other as usize] == NONE {
                    while columns[place] != column {
                        place += 1;
                    }
                    own[place] = *value;
                }
            }
        }
        values
    }

    /// The block of a group; none if a pivot is too small.
    fn block(&self, matrix: &CsrMatrix, group: usize, scales: &[f64]) -> Option<Block> {
        let members = self.plan.members_of(group);
        let (rows, columns) = (self.plan.rows_of(group), self.plan.columns_of(group));
        let size = members.len();
        let mut own = vec![0.0; size * size];
        let mut right = vec![0.0; size * columns.len()];
        for (i, member) in members.iter().enumerate() {
            let (unknowns, entries) = matrix.row(*member as usize);
            let mut place = 0;
            for (unknown, value) in unknowns.iter().zip(entries) {
                let number = self.plan.number[*unknown as usize];
                if self.plan.owner[*unknown as usize] == NONE {
                    while columns[place] != number {
                        place += 1;
                    }
                    right[i * columns.len() + place] = *value;
                } else {
                    own[i * size + number as usize] = *value;
                }
            }
        }
        let mut beside = vec![0.0; rows.len() * size];
        for (i, row) in rows.iter().enumerate() {
            let (unknowns, entries) = matrix.row(self.plan.rest[*row as usize] as usize);
            for (k, member) in members.iter().enumerate() {
                if let Ok(place) = unknowns.binary_search(member) {
                    beside[i * size + k] = entries[place];
                }
            }
        }
        let scales: Vec<f64> = members.iter().map(|member| scales[*member as usize]).collect();
        let inverse = small_inverse(own, &scales)?;
        let left = multiply(&beside, &inverse, size, size);
        let solved = multiply(&inverse, &right, size, columns.len());
        let product = multiply(&beside, &solved, size, columns.len());
        Some(Block { inverse, right: solved, left, product })
    }

    /// Takes a group's product out of S.
    fn subtract(&self, group: usize, product: &[f64], values: &mut [f64]) {
        let (rows, columns) = (self.plan.rows_of(group), self.plan.columns_of(group));
        if columns.is_empty() {
            return;
        }
        for (row, product) in rows.iter().zip(product.chunks_exact(columns.len())) {
            let range = self.left.row_range(*row as usize);
            let (all, own) = (&self.left.column_indices()[range.clone()], &mut values[range]);
            let mut place = 0;
            for (column, value) in columns.iter().zip(product) {
                while all[place] != *column {
                    place += 1;
                }
                own[place] -= value;
            }
        }
    }

    /// b_r − Σ A_rg A_gg⁻¹ b_g, or that of the transposed system.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn reduce(
        &self,
        blocks: &Eliminated,
        b: &[f64],
        transpose: Transpose,
    ) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the right-hand side", self.pattern.rows(), b.len())?;
        let mut reduced: Vec<f64> = self.plan.rest.iter().map(|unknown| b[*unknown as usize]).collect();
        for (group, block) in blocks.blocks.iter().enumerate() {
            let members = self.plan.members_of(group);
            match transpose {
                Transpose::No => {
                    for (row, own) in
                        self.plan.rows_of(group).iter().zip(block.left.chunks_exact(members.len()))
                    {
                        let terms =
                            own.iter().zip(members).map(|(value, member)| value * b[*member as usize]);
                        reduced[*row as usize] -= terms.sum::<f64>();
                    }
                }
                Transpose::Yes => {
                    let columns = self.plan.columns_of(group);
                    for (k, member) in members.iter().enumerate() {
                        let own = &block.right[k * columns.len()..][..columns.len()];
                        for (column, value) in columns.iter().zip(own) {
                            reduced[*column as usize] -= value * b[*member as usize];
                        }
                    }
                }
            }
        }
        Ok(reduced)
    }

    /// The whole solution from that of the remaining unknowns.
    ///
    /// # Errors
    /// If a size is wrong.
    pub fn recover(
        &self,
        blocks: &Eliminated,
        b: &[f64],
        rest: &[f64],
        transpose: Transpose,
    ) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the right-hand side", self.pattern.rows(), b.len())?;
        check_size("the solution of the remaining unknowns", self.plan.rest.len(), rest.len())?;
        let mut x = vec![0.0; b.len()];
        self.plan.rest.iter().zip(rest).for_each(|(unknown, value)| x[*unknown as usize] = *value);
        for (group, block) in blocks.blocks.iter().enumerate() {
            let members = self.plan.members_of(group);
            let (rows, columns) = (self.plan.rows_of(group), self.plan.columns_of(group));
            let size = members.len();
            for (k, member) in members.iter().enumerate() {
                let mut value = 0.0;
                for (l, other) in members.iter().enumerate() {
                    let entry = match transpose {
                        Transpose::No => block.inverse[k * size + l],
                        Transpose::Yes => block.inverse[l * size + k],
                    };
                    value += entry * b[*other as usize];
                }
                match transpose {
                    Transpose::No => {
                        let own = &block.right[k * columns.len()..][..columns.len()];
                        for (column, entry) in columns.iter().zip(own) {
                            value -= entry * rest[*column as usize];
                        }
                    }
                    Transpose::Yes => {
                        for (i, row) in rows.iter().enumerate() {
                            value -= block.left[i * size + k] * rest[*row as usize];
                        }
                    }
                }
                x[*member as usize] = value;
            }
        }
        Ok(x)
    }
}

/// The product of two matrices that are stored row by row, the first with `inner` columns, the second with `width`.
fn multiply(a: &[f64], b: &[f64], inner: usize, width: usize) -> Vec<f64> {
    let rows = a.len() / inner.max(1);
    let mut product = vec![0.0; rows * width];
    for i in 0..rows {
        let target = &mut product[i * width..][..width];
        for k in 0..inner {
            let factor = a[i * inner + k];
            for (target, value) in target.iter_mut().zip(&b[k * width..][..width]) {
                *target += factor * value;
            }
        }
    }
    product
}

#[cfg(test)]
mod tests;
