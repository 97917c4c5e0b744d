//! Square matrices as systems of equations: b − A x and the equation that holds worst in it, in one pass over the matrix.

use std::fmt;

use super::block_matrix::BlockMatrix;
use super::csr::{CsrMatrix, Entry};
use super::error::{LinearAlgebraError, check_size};
use super::transpose::Transpose;
use crate::threads::Threads;

/// Smaller residuals are underflow of their terms.
const UNDERFLOW: f64 = f64::MIN_POSITIVE / f64::EPSILON;
/// Equations that are judged together, on any number of threads.
const PIECE: usize = 4096;

/// A square matrix, with the operations that judging a solution needs.
pub trait Equations: fmt::Debug {
    /// Writes b − A x, and returns the equation that holds worst, both the same for each number of threads. `room` is memory
    /// that is kept from one call to the next. From the products, unless there is a quicker way.
    fn residual(
        &self,
        _threads: Threads,
        x: &[f64],
        b: &[f64],
        rest: &mut Vec<f64>,
        _room: &mut Vec<f64>,
    ) -> Result<WorstRow, LinearAlgebraError> {
        let (sums, sizes) = self.products(x)?;
        judged((&sums, &sizes), b, rest)
    }

    /// A x, and of each row Σ |a_ij x_j|.
    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError>;

    /// The diagonal.
    fn diagonal(&self) -> Vec<f64>;
}

/// The equation that holds worst, and |b − A x|_i relative to the sizes of its terms; infinite where a number is not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorstRow {
    pub row: usize,
    pub error: f64,
}

impl WorstRow {
    /// Residual b_i − (A x)_i of a row, which is recorded with (|A| |x|)_i.
    #[inline(always)]
    pub fn visit(&mut self, row: usize, b: f64, sum: f64, size: f64) -> f64 {
        let (rest, size) = (b - sum, size + b.abs());
        // A product comes first: divisions are slow, and hardly a row is worse than those before it. A NaN holds nothing.
        let holds_better = rest.abs() < self.error * size;
        if !holds_better {
            self.compare(row, rest.abs(), size);
        }
        rest
    }

    #[cold]
    fn compare(&mut self, row: usize, off: f64, size: f64) {
        if self.error == f64::INFINITY {
            return;
        }
        if !(off.is_finite() && size.is_finite()) {
            *self = WorstRow { row, error: f64::INFINITY };
        } else if off > self.error * size && off > UNDERFLOW {
            *self = WorstRow { row, error: off / size };
        }
    }

    /// The worst of residuals, each relative to its size.
    pub fn of(rest: &[f64], sizes: &[f64]) -> Self {
        let mut worst = WorstRow::default();
        for (row, (rest, size)) in rest.iter().zip(sizes).enumerate() {
            worst.visit(row, 0.0, *rest, *size);
        }
        worst
    }
}

/// Sums and sizes to residuals, with the worst of them.
fn judged(
    (sums, sizes): (&[f64], &[f64]),
    b: &[f64],
    rest: &mut Vec<f64>,
) -> Result<WorstRow, LinearAlgebraError> {
    check_size("the right-hand side", sums.len(), b.len())?;
    rest.resize(b.len(), 0.0);
    let mut worst = WorstRow::default();
    for (row, ((rest, b), (sum, size))) in rest.iter_mut().zip(b).zip(sums.iter().zip(sizes)).enumerate() {
        *rest = worst.visit(row, *b, *sum, *size);
    }
    Ok(worst)
}

/// Divides the rows into pieces, and the pieces among threads. `work` judges the rows of a piece, which starts at a given row.
fn by_pieces(
    threads: Threads,
    numbers: usize,
    rest: &mut [f64],
    piece: usize,
    work: impl Fn(usize, &mut [f64]) -> WorstRow + Send + Sync,
) -> WorstRow {
    let pieces = rest.len().div_ceil(piece);
    let length = pieces.div_ceil(threads.for_work(numbers)).max(1) * piece;
    let parts = rest.chunks_mut(length).enumerate().collect();
    let of_part = |(part, rest): (usize, &mut [f64])| {
        let pieces = rest.chunks_mut(piece).enumerate();
        worst_of(pieces.map(|(number, rest)| work(part * length + number * piece, rest)))
    };
    worst_of(threads.run(parts, of_part).into_iter())
}

/// Residuals of several systems: each with the bits that it has by itself. Where all are stored by rows, threads go from one piece of the rows to
/// the next with all systems, so that a matrix that these share is read once.
///
/// # Errors
/// If a size is wrong.
pub(crate) fn residual_each(
    threads: Threads,
    systems: &[(&Side<'_>, &[f64], &[f64])],
    rests: Vec<&mut Vec<f64>>,
) -> Result<Vec<WorstRow>, LinearAlgebraError> {
    let size = systems.first().map_or(0, |(_, x, _)| x.len());
    let by_rows = |(side, x, _): &(&Side<'_>, &[f64], &[f64])| {
        side.transpose == Transpose::No && side.matrix.rows() == size && x.len() == size
    };
    if systems.len() == 1 || !systems.iter().all(by_rows) {
        let each = systems.iter().zip(rests);
        return each.map(|((side, x, b), rest)| side.residual(threads, x, b, rest, &mut vec![])).collect();
    }
    let pieces = size.div_ceil(PIECE);
    let numbers = systems.iter().map(|(side, ..)| side.matrix.values().len()).sum();
    let length = pieces.div_ceil(threads.for_work(numbers)).max(1) * PIECE;
    let mut parts: Vec<Vec<std::slice::ChunksMut<'_, f64>>> = vec![];
    parts.resize_with(size.div_ceil(length), Vec::new);
    for ((side, x, b), rest) in systems.iter().zip(rests) {
        side.check(x, b)?;
        rest.resize(size, 0.0);
        for (part, rest) in parts.iter_mut().zip(rest.chunks_mut(length)) {
            part.push(rest.chunks_mut(PIECE));
        }
    }
    let of_part = |(part, mut rests): (usize, Vec<std::slice::ChunksMut<'_, f64>>)| {
        let mut worst = vec![WorstRow::default(); systems.len()];
        for first in (part * length..).step_by(PIECE).take(length / PIECE) {
            for ((worst, (side, x, b)), rest) in worst.iter_mut().zip(systems).zip(&mut rests) {
                if let Some(rest) = rest.next() {
                    *worst = worst_of([*worst, side.rows(x, b, first, rest)].into_iter());
                }
            }
        }
        worst
    };
    let of_parts = threads.run(parts.into_iter().enumerate().collect(), of_part);
    Ok((0..systems.len()).map(|k| worst_of(of_parts.iter().map(|worst| worst[k]))).collect())
}

/// The first of the worst.
fn worst_of(all: impl Iterator<Item = WorstRow>) -> WorstRow {
    all.fold(WorstRow::default(), |worst, next| if next.error > worst.error { next } else { worst })
}

/// A matrix or its transposed, with additions to some of its entries.
#[derive(Clone, Debug)]
pub struct Side<'a> {
    matrix: &'a CsrMatrix,
    transpose: Transpose,
    /// Additions to entries, by rows of this side.
    additions: Vec<Entry>,
}

impl<'a> Side<'a> {
    /// The side that a solve asks for.
    pub fn of(matrix: &'a CsrMatrix, transpose: Transpose) -> Self {
        Side { matrix, transpose, additions: vec![] }
    }

    /// A x = b.
    pub fn plain(matrix: &'a CsrMatrix) -> Self {
        Side::of(matrix, Transpose::No)
    }

    /// The side of a matrix that is symmetric except for rounding, so that its rows are its columns: products by rows are faster.
    pub fn of_symmetric(matrix: &'a CsrMatrix) -> Self {
        Side::plain(matrix)
    }

    /// This side with additions to entries of the matrix whose `transpose`d side this is.
    pub fn with_additions(mut self, additions: &[Entry], transpose: Transpose) -> Self {
        let turned = |entry: &Entry| match transpose {
            Transpose::No => *entry,
            Transpose::Yes => Entry { row: entry.column, column: entry.row, value: entry.value },
        };
        self.additions = additions.iter().map(turned).collect();
        self.additions.sort_by_key(|entry| entry.row); // stable: sums keep their order
        self
    }

    fn check(&self, x: &[f64], b: &[f64]) -> Result<(), LinearAlgebraError> {
        check_size("the vector to multiply", self.matrix.columns(), x.len())?;
        check_size("the set of columns of a square matrix", self.matrix.rows(), x.len())?;
        check_size("the right-hand side", x.len(), b.len())
    }

    /// Judges the rows from a first one on.
    fn rows(&self, x: &[f64], b: &[f64], first: usize, rest: &mut [f64]) -> WorstRow {
        let mut worst = WorstRow::default();
        let end = first + rest.len();
        let (mut row, mut left) = (first, rest);
        let start = self.additions.partition_point(|entry| (entry.row as usize) < first);
        for own in self.additions[start..].chunk_by(|a, b| a.row == b.row) {
            let changed = own[0].row as usize;
            if changed >= end {
                break;
            }
            let (before, from) = left.split_at_mut(changed - row);
            self.plain_rows(x, b, row, before, &mut worst);
            let (mut sum, mut size) = sum_and_size(self.matrix.row(changed), x);
            for entry in own {
                let term = entry.value * x[entry.column as usize];
                (sum, size) = (sum + term, size + term.abs());
            }
            if let Some((rest, after)) = from.split_first_mut() {
                *rest = worst.visit(changed, b[changed], sum, size);
                (row, left) = (changed + 1, after);
            } else {
                (row, left) = (changed, &mut []);
            }
        }
        self.plain_rows(x, b, row, left, &mut worst);
        worst
    }

    fn plain_rows(&self, x: &[f64], b: &[f64], first: usize, rest: &mut [f64], worst: &mut WorstRow) {
        for ((row, rest), b) in (first..).zip(rest).zip(&b[first..]) {
            let (sum, size) = sum_and_size(self.matrix.row(row), x);
            *rest = worst.visit(row, *b, sum, size);
        }
    }

    /// Sums and sizes of the columns, side by side.
    fn columns(&self, x: &[f64], room: &mut Vec<f64>) {
        room.clear();
        room.resize(2 * self.matrix.columns(), 0.0);
        let (of_columns, _) = room.as_chunks_mut::<2>();
        for (row, factor) in x.iter().enumerate() {
            let (columns, values) = self.matrix.row(row);
            for (&column, value) in columns.iter().zip(values) {
                let term = value * factor;
                let target = &mut of_columns[column as usize];
                *target = [target[0] + term, target[1] + term.abs()];
            }
        }
        for entry in &self.additions {
            let term = entry.value * x[entry.column as usize];
            let target = &mut of_columns[entry.row as usize];
            *target = [target[0] + term, target[1] + term.abs()];
        }
    }
}

impl Equations for Side<'_> {
    fn residual(
        &self,
        threads: Threads,
        x: &[f64],
        b: &[f64],
        rest: &mut Vec<f64>,
        room: &mut Vec<f64>,
    ) -> Result<WorstRow, LinearAlgebraError> {
        self.check(x, b)?;
        rest.resize(b.len(), 0.0);
        if self.transpose == Transpose::No {
            let work = |first: usize, rest: &mut [f64]| self.rows(x, b, first, rest);
            return Ok(by_pieces(threads, self.matrix.values().len(), rest, PIECE, work));
        }
        self.columns(x, room);
        let mut worst = WorstRow::default();
        for (row, ((rest, b), [sum, size])) in rest.iter_mut().zip(b).zip(room.as_chunks::<2>().0).enumerate()
        {
            *rest = worst.visit(row, *b, *sum, *size);
        }
        Ok(worst)
    }

    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        self.check(x, x)?;
        if self.transpose == Transpose::Yes {
            let mut room = Vec::new();
            self.columns(x, &mut room);
            return Ok(room.as_chunks::<2>().0.iter().map(|[sum, size]| (*sum, *size)).unzip());
        }
        let of_row = |row: usize| sum_and_size(self.matrix.row(row), x);
        let (mut sums, mut sizes): (Vec<f64>, Vec<f64>) = (0..self.matrix.rows()).map(of_row).unzip();
        for entry in &self.additions {
            let term = entry.value * x[entry.column as usize];
            sums[entry.row as usize] += term;
            sizes[entry.row as usize] += term.abs();
        }
        Ok((sums, sizes))
    }

    fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = self.matrix.diagonal();
        for entry in self.additions.iter().filter(|entry| entry.row == entry.column) {
            diagonal[entry.row as usize] += entry.value;
        }
        diagonal
    }
}

#[inline(always)]
fn sum_and_size((columns, values): (&[u32], &[f64]), x: &[f64]) -> (f64, f64) {
    columns.iter().zip(values).fold((0.0, 0.0), |(sum, size), (column, value)| {
        let term = value * x[*column as usize];
        (sum + term, size + term.abs())
    })
}

impl Equations for BlockMatrix {
    fn residual(
        &self,
        threads: Threads,
        x: &[f64],
        b: &[f64],
        rest: &mut Vec<f64>,
        _: &mut Vec<f64>,
    ) -> Result<WorstRow, LinearAlgebraError> {
        check_size("the vector to multiply", self.columns(), x.len())?;
        check_size("the right-hand side", self.rows(), b.len())?;
        rest.resize(b.len(), 0.0);
        let mut later = &mut rest[..];
        let mut worst = WorstRow::default();
        for (set, rows) in self.sparsity().row_sets().iter().enumerate() {
            let own;
            (own, later) = later.split_at_mut(rows.nodes * rows.components);
            let height = rows.components.max(1);
            let piece = (PIECE / height).max(1) * height;
            let found = by_pieces(threads, self.values().len(), own, piece, |first, rest| {
                let mut worst = WorstRow::default();
                self.visit_terms(set, first / height, rest.len() / height, x, |place, sum, size| {
                    let row = rows.offset + first + place;
                    rest[place] = worst.visit(row, b[row], sum, size);
                });
                worst
            });
            worst = worst_of([worst, found].into_iter());
        }
        Ok(worst)
    }

    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        check_size("the vector to multiply", self.columns(), x.len())?;
        let (mut sums, mut sizes) = (Vec::with_capacity(self.rows()), Vec::with_capacity(self.rows()));
        for (set, rows) in self.sparsity().row_sets().iter().enumerate() {
            self.visit_terms(set, 0, rows.nodes, x, |_, sum, size| {
                sums.push(sum);
                sizes.push(size);
            });
        }
        Ok((sums, sizes))
    }

    fn diagonal(&self) -> Vec<f64> {
        BlockMatrix::diagonal(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of three entries with irregular values, more of them than a piece.
    fn matrix() -> CsrMatrix {
        let size = 2 * PIECE + 700;
        let value = |k: usize| ((k * 7919 % 1013) as f64 - 500.0) / 37.0;
        let triplets: Vec<_> = (0..size)
            .flat_map(|row| [1, 17, 900].map(|step| (row, (row * step + 3) % size, value(row + 5 * step))))
            .collect();
        CsrMatrix::from_triplets(size, size, &triplets).unwrap()
    }

    fn check(equations: &impl Equations, x: &[f64], b: &[f64]) {
        let (sums, mut sizes) = equations.products(x).unwrap();
        let expected: Vec<f64> = sums.iter().zip(b).map(|(sum, b)| b - sum).collect();
        sizes.iter_mut().zip(b).for_each(|(size, b)| *size += b.abs());
        let worst = WorstRow::of(&expected, &sizes);
        let (mut rest, mut room) = (vec![], vec![]);
        for threads in [1, 2, 3] {
            let found = equations.residual(Threads::new(threads), x, b, &mut rest, &mut room).unwrap();
            assert_eq!((&rest, found), (&expected, worst));
        }
    }

    #[test]
    fn one_pass_finds_what_several_find_on_any_number_of_threads() {
        let matrix = matrix();
        let size = matrix.rows();
        let x: Vec<f64> = (0..size).map(|k| (k as f64 * 0.7).sin()).collect();
        let b: Vec<f64> = (0..size).map(|k| (k as f64 * 0.3).cos()).collect();
        let of = |(row, column): (usize, usize)| Entry { row: row as u32, column: column as u32, value: 3.0 };
        let additions = [(PIECE, 5), (0, 1), (PIECE - 1, 3), (size - 1, 0), (7, PIECE), (PIECE, 2)].map(of);
        for transpose in [Transpose::No, Transpose::Yes] {
            check(&Side::of(&matrix, transpose), &x, &b);
            check(&Side::of(&matrix, transpose).with_additions(&additions, transpose), &x, &b);
        }
        assert_eq!(Side::plain(&matrix).products(&x).unwrap().0, matrix.multiply(&x).unwrap());
        check(&BlockMatrix::from(matrix), &x, &b);
        let mut bad = x.clone();
        bad[11] = f64::NAN;
        let blocks = BlockMatrix::from(self::matrix());
        let found = blocks.residual(Threads::ONE, &bad, &b, &mut vec![], &mut vec![]).unwrap();
        assert_eq!(found.error, f64::INFINITY);
    }

    /// Systems of one matrix with additions of their own, and one by columns.
    #[test]
    fn residuals_of_several_systems_have_the_bits_of_each() {
        let matrix = matrix();
        let size = matrix.rows();
        let vector =
            |k: usize| -> Vec<f64> { (0..size).map(|i| ((i * (k + 2)) as f64 * 0.37).sin()).collect() };
        let vectors: Vec<_> = (0..4).map(|k| (vector(k), vector(k + 7))).collect();
        let addition = |k: usize| Entry { row: (PIECE + k) as u32, column: k as u32, value: 3.0 + k as f64 };
        for transposes in [[Transpose::No; 4], [Transpose::No, Transpose::Yes, Transpose::No, Transpose::No]]
        {
            let of = |k: usize| {
                Side::of(&matrix, transposes[k]).with_additions(&[addition(k)][..k.min(1)], transposes[k])
            };
            let sides: Vec<_> = (0..4).map(of).collect();
            let systems: Vec<_> =
                sides.iter().zip(&vectors).map(|(side, (x, b))| (side, &x[..], &b[..])).collect();
            for threads in [1, 2, 3, 7, 16].map(Threads::new) {
                for count in 1..=4 {
                    let mut rests = vec![vec![]; count];
                    let found =
                        residual_each(threads, &systems[..count], rests.iter_mut().collect()).unwrap();
                    for ((side, x, b), (rest, worst)) in systems.iter().zip(rests.iter().zip(found)) {
                        let (mut alone, mut room) = (vec![], vec![]);
                        assert_eq!(worst, side.residual(Threads::ONE, x, b, &mut alone, &mut room).unwrap());
                        assert_eq!(*rest, alone);
                    }
                }
            }
        }
        let plain = Side::plain(&matrix);
        let wrong = [(&plain, &vectors[0].0[..], &[1.0][..]); 2];
        assert!(residual_each(Threads::ONE, &wrong, vec![&mut vec![], &mut vec![]]).is_err());
    }
}
