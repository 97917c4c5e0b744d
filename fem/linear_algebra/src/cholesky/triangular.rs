//! Solves with the triangles of a factor for a few right-hand sides, supernode by supernode of a unit.
//!
//! faer's solves are made for many right-hand sides: each product with a supernode's block is a call of its general kernels, which
//! takes longer than the product where supernodes are small. Here each right-hand side is treated as it would be by itself, with the same
//! bits, while the columns of the factor that all of them read are at hand.

use super::tree_solves::{Outside, Triangle};
use crate::ahead::ask_for;
use crate::elimination::{PANEL, Unit};

/// Columns that are taken at once, so that what is below them is read and written once.
const AT_ONCE: usize = 4;
/// Parts of a dot product that are summed side by side.
const PARTS: usize = 4;
/// Numbers of a supernode's block that are asked for while the one before it is at work: the processor by itself notices columns of
/// some length alone.
const AHEAD: usize = 1 << 11;

/// The columns of a supernode, with the rows of its triangle and those below.
struct Supernode<'a> {
    /// Column by column of each panel of each triangle.
    block: &'a [f64],
    /// Which of the triangles in the block it is, and their number.
    triangle: (usize, usize),
    first: usize,
    width: usize,
    /// The rows below, ascending.
    rows: &'a [u32],
}

impl<'a> Supernode<'a> {
    /// Columns of one panel.
    fn columns<const N: usize>(&self, from: usize) -> [&'a [f64]; N] {
        let height = self.width + self.rows.len();
        let (triangle, count) = self.triangle;
        let panel = from / PANEL * PANEL;
        let before = count * panel + triangle * PANEL.min(self.width - panel) + from - panel;
        std::array::from_fn(|k| &self.block[(before + k) * height..][..height])
    }

    /// Asks for the columns that are taken at once from a first one on.
    fn ask_for_columns(&self, from: usize) {
        if from + AT_ONCE <= self.width {
            self.columns::<AT_ONCE>(from).iter().for_each(|column| ask_for(&column[from..]));
        }
    }

    /// Solves with some columns, and takes them out of the rows that follow: those of the triangle in `own`, those below in `below`.
    fn forward<const N: usize>(&self, from: usize, own: &mut [f64], below: &mut [f64]) {
        let columns = self.columns::<N>(from);
        let (solved, rest) = own[from..].split_at_mut(N);
        let mut factors = [0.0; N];
        for k in 0..N {
            let known: f64 = (0..k).map(|l| columns[l][from + k] * factors[l]).sum();
            factors[k] = (solved[k] - known) / columns[k][from + k];
        }
        solved.copy_from_slice(&factors);
        subtract(rest, columns.map(|column| &column[from + N..self.width]), factors);
        subtract(below, columns.map(|column| &column[self.width..]), factors);
    }

    /// Solves with the transposed of some columns, where the values at the following rows are known.
    fn backward<const N: usize>(&self, from: usize, own: &mut [f64], below: &[f64]) {
        let columns = self.columns::<N>(from);
        let (unknown, known) = own[from..].split_at_mut(N);
        let inside = products(columns.map(|column| &column[from + N..self.width]), known);
        let beyond = products(columns.map(|column| &column[self.width..]), below);
        for k in (0..N).rev() {
            let near: f64 = (k + 1..N).map(|l| columns[k][from + l] * unknown[l]).sum();
            unknown[k] = (unknown[k] - (inside[k] + beyond[k] + near)) / columns[k][from + k];
        }
    }
}

/// y −= Σ factor × column.
fn subtract<const N: usize>(y: &mut [f64], columns: [&[f64]; N], factors: [f64; N]) {
    let columns = columns.map(|column| &column[..y.len()]);
    for (i, target) in y.iter_mut().enumerate() {
        let mut rest = *target;
        for k in 0..N {
            rest -= factors[k] * columns[k][i];
        }
        *target = rest;
    }
}

/// The dot product of each column with x.
fn products<const N: usize>(columns: [&[f64]; N], x: &[f64]) -> [f64; N] {
    let (pieces, tail) = x.as_chunks::<PARTS>();
    let mut sums = [[0.0; PARTS]; N];
    let in_pieces = columns.map(|column| &column.as_chunks::<PARTS>().0[..pieces.len()]);
    for (i, piece) in pieces.iter().enumerate() {
        for k in 0..N {
            for part in 0..PARTS {
                sums[k][part] += in_pieces[k][i][part] * piece[part];
            }
        }
    }
    let start = x.len() - tail.len();
    std::array::from_fn(|k| {
        let last: f64 = columns[k][start..].iter().zip(tail).map(|(a, b)| a * b).sum();
        sums[k].iter().sum::<f64>() + last
    })
}

impl Triangle<'_> {
    fn supernode(&self, number: usize) -> Supernode<'_> {
        let symbolic = &self.analysis.supernodes;
        let first = symbolic.supernode_begin()[number] as usize;
        let width = symbolic.supernode_end()[number] as usize - first;
        let values = &symbolic.col_ptr_for_val()[number..number + 2];
        let [start, end] = [values[0], values[1]].map(|value| self.count * value as usize);
        let triangle = (self.number, self.count);
        let block = &self.values[start..end];
        Supernode { block, triangle, first, width, rows: symbolic.supernode(number).pattern() }
    }

    /// Solves with the triangle in the supernodes of a unit, whose unknowns are given for each right-hand side with the place of the first one. What they
    /// take from later ones is added to the values outside, by rows of the matrix.
    pub(super) fn forward(
        &self,
        unit: &Unit,
        (start, sides): (usize, &mut [&mut [f64]]),
        memory: &mut [Outside],
    ) {
        let Some(end) = sides.first().map(|side| start + side.len()) else { return };
        for number in unit.supernodes.clone() {
            let node = self.supernode(number);
            let own = node.first - start..node.first - start + node.width;
            let mut changes = false;
            for (side, memory) in sides.iter().zip(&mut *memory) {
                // As away from the loads, where these are on a boundary.
                memory.rests = side[own.clone()].iter().all(|value| *value == 0.0);
                if !memory.rests {
                    memory.below.clear();
                    memory.below.resize(node.rows.len(), 0.0);
                    changes = true;
                }
            }
            if !changes {
                continue;
            }
            if number + 1 < unit.supernodes.end {
                let next = self.supernode(number + 1).block;
                ask_for(&next[..next.len().min(AHEAD)]);
            }
            let fours = node.width / AT_ONCE * AT_ONCE;
            for from in (0..fours).step_by(AT_ONCE).chain(fours..node.width) {
                node.ask_for_columns(from + AT_ONCE);
                for (side, memory) in sides.iter_mut().zip(&mut *memory).filter(|(_, memory)| !memory.rests) {
                    let (own, below) = (&mut side[own.clone()], &mut memory.below[..]);
                    match from < fours {
                        true => node.forward::<AT_ONCE>(from, own, below),
                        false => node.forward::<1>(from, own, below),
                    }
                }
            }
            let inside = node.rows.partition_point(|row| (*row as usize) < end);
            for (side, memory) in sides.iter_mut().zip(&mut *memory).filter(|(_, memory)| !memory.rests) {
                let Outside { values, below, .. } = memory;
                for (row, change) in node.rows[..inside].iter().zip(&below[..]) {
                    side[*row as usize - start] += change;
                }
                for (row, change) in node.rows[inside..].iter().zip(&below[inside..]) {
                    values[*row as usize] += change;
                }
            }
        }
    }

    /// Solves with the transposed triangle in some supernodes, ascending, whose unknowns are given for each right-hand side with the place of the first one. The
    /// values of later ones are those outside, by rows of the matrix.
    pub(super) fn backward(
        &self,
        supernodes: &[u32],
        (start, sides): (usize, &mut [&mut [f64]]),
        memory: &mut [Outside],
    ) {
        let Some(end) = sides.first().map(|side| start + side.len()) else { return };
        let mut supernodes = supernodes.iter().rev().peekable();
        while let Some(number) = supernodes.next() {
            let node = self.supernode(*number as usize);
            if let Some(next) = supernodes.peek() {
                let next = self.supernode(**next as usize).block;
                ask_for(&next[next.len().saturating_sub(AHEAD)..]);
            }
            let (inside, beyond) = node.rows.split_at(node.rows.partition_point(|row| (*row as usize) < end));
            for (side, Outside { values, below, .. }) in sides.iter().zip(&mut *memory) {
                below.clear();
                below.extend(inside.iter().map(|row| side[*row as usize - start]));
                below.extend(beyond.iter().map(|row| values[*row as usize]));
            }
            let own = node.first - start..node.first - start + node.width;
            let fours = node.width / AT_ONCE * AT_ONCE;
            for from in (fours..node.width).rev().chain((0..fours).step_by(AT_ONCE).rev()) {
                if let Some(from) = from.checked_sub(AT_ONCE) {
                    node.ask_for_columns(from);
                }
                for (side, Outside { below, .. }) in sides.iter_mut().zip(&*memory) {
                    let own = &mut side[own.clone()];
                    match from < fours {
                        true => node.backward::<AT_ONCE>(from, own, below),
                        false => node.backward::<1>(from, own, below),
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::{Analysis, CsrMatrix, Ordering, SymmetricFactor};

    /// The nine-point stencil on m × m nodes, two unknowns each, with other numbers everywhere.
    fn grid(m: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for node in 0..m * m {
            for (step, inside) in
                [(1, node % m + 1 < m), (m, node / m + 1 < m), (m + 1, node % m + 1 < m && node / m + 1 < m)]
            {
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().filter(|_| inside) {
                    let (row, column) = (2 * node + a, 2 * (node + step) + b);
                    let value = ((row * 7 + column * 3) as f64).sin();
                    triplets.extend([(row, column, value), (column, row, value)]);
                }
            }
            triplets.extend((0..2).map(|a| (2 * node + a, 2 * node + a, 17.0 + (node as f64).cos())));
        }
        CsrMatrix::from_triplets(2 * m * m, 2 * m * m, &triplets).unwrap()
    }

    #[test]
    fn triangles_multiply_to_the_matrix() {
        // Supernodes of all widths and heights, also those that are no multiple of four.
        for m in [1, 2, 3, 7, 24] {
            let matrix = grid(m);
            for ordering in [Ordering::MinimumDegree, Ordering::NestedDissection] {
                let analysis = Arc::new(Analysis::new(matrix.pattern(), &ordering).unwrap());
                let factor = SymmetricFactor::cholesky(&analysis, &matrix, vec![]).unwrap();
                let exact: Vec<f64> = (0..matrix.rows()).map(|k| (k as f64 * 0.37).sin() - 0.2).collect();
                let b = matrix.multiply(&exact).unwrap();
                let order = analysis.elimination_order();
                let mut x: Vec<f64> = order.iter().map(|unknown| b[*unknown as usize]).collect();
                factor.solve_with_lower(&mut [&mut x]);
                // ‖L⁻¹ P b‖² = b·x.
                let square: f64 = x.iter().map(|value| value * value).sum();
                let work: f64 = b.iter().zip(&exact).map(|(b, x)| b * x).sum();
                assert!((square - work).abs() < 1e-13 * work, "{m}: {square} is not {work}");
                factor.solve_with_upper(&mut [&mut x]);
                for (value, unknown) in x.iter().zip(order) {
                    let expected = exact[*unknown as usize];
                    assert!((value - expected).abs() < 1e-14, "{m}: {value} is not {expected}");
                }
            }
        }
    }
}
