//! Products of the matrices of cells with the values of vectors at their nodes, in lanes.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use crate::element::MAXIMUM_NODES;
use crate::lanes::{LaneWork, SimdLane, WIDEST};

/// Numbers that all cells of a shape share.
#[derive(Debug)]
pub(super) enum Common {
    /// The reference cell's matrix; a cell has its determinant.
    Matrix(Vec<f64>),
    /// The basis at the points, point after point; a cell has the weights of its points.
    Basis(Vec<f64>),
}

impl Common {
    pub(super) fn sizes(&self) -> Self {
        let absolute = |values: &[f64]| values.iter().map(|value| value.abs()).collect();
        match self {
            Common::Matrix(values) => Common::Matrix(absolute(values)),
            Common::Basis(values) => Common::Basis(absolute(values)),
        }
    }

    /// Numbers that a cell has of its own.
    pub(super) fn per_cell(&self, nodes: usize) -> usize {
        match self {
            Common::Matrix(_) => 1,
            Common::Basis(values) => values.len() / nodes,
        }
    }
}

/// The products of a piece's cells with the entries of vectors at its nodes.
pub(super) struct Products<'a> {
    pub common: &'a Common,
    /// Nodes of a cell.
    pub nodes: usize,
    /// Numbers at a node, one for each vector; those that fill up registers are zero.
    pub stride: usize,
    /// Numbers of the cells' nodes.
    pub numbers: &'a [u32],
    /// Determinants, or weights of points, from the first of these cells on.
    pub of_cells: &'a [f64],
    pub x: &'a [f64],
    /// Sums to which products are added.
    pub sums: &'a mut [f64],
}

impl LaneWork for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: SimdLane>(self) {
        // The compiler keeps what it can count in registers: straight cells of degree 1 and 2.
        match (self.nodes, self.common) {
            (3, Common::Matrix(_)) => self.of::<L, 3>(),
            (4, Common::Matrix(_)) => self.of::<L, 4>(),
            (6, Common::Matrix(_)) => self.of::<L, 6>(),
            (9, _) => self.of::<L, 9>(),
            (10, Common::Matrix(_)) => self.of::<L, 10>(),
            _ => self.of::<L, MAXIMUM_NODES>(),
        }
    }
}

impl Products<'_> {
    /// Cells of N nodes, or of at most N nodes for [`MAXIMUM_NODES`].
    #[inline(always)]
    fn of<L: SimdLane, const N: usize>(self) {
        if self.stride.is_multiple_of(L::WIDTH) {
            self.vectors_in_lanes::<L, N>()
        } else {
            self.cells_in_lanes::<L, N>()
        }
    }

    /// Several vectors in the lanes, one cell after the other: numbers of a node are read as they lie.
    #[inline(always)]
    fn vectors_in_lanes<L: SimdLane, const N: usize>(self) {
        let n = if N == MAXIMUM_NODES { self.nodes } else { N };
        let (mut x, mut sums) = ([L::splat(0.0); N], [L::splat(0.0); N]);
        let per_cell = self.common.per_cell(n);
        let mut own = vec![L::splat(0.0); per_cell];
        for (cell, numbers) in self.numbers.chunks_exact(n).enumerate() {
            for q in 0..per_cell {
                own[q] = L::splat(self.of_cells[cell * per_cell + q]);
            }
            for vector in 0..self.stride / L::WIDTH {
                for i in 0..n {
                    x[i] = L::load(&self.x[numbers[i] as usize * self.stride + vector * L::WIDTH..]);
                }
                self.common.multiply(n, &own, &x, &mut sums);
                for i in 0..n {
                    let target = &mut self.sums[numbers[i] as usize * self.stride + vector * L::WIDTH..];
                    (L::load(target) + sums[i]).store(target);
                }
            }
        }
    }

    /// Several cells in the lanes, one vector after the other.
    #[inline(always)]
    fn cells_in_lanes<L: SimdLane, const N: usize>(self) {
        let n = if N == MAXIMUM_NODES { self.nodes } else { N };
        let (mut x, mut sums) = ([L::splat(0.0); N], [L::splat(0.0); N]);
        let (mut lanes, mut cell, per_cell) = ([0.0; WIDEST], 0, self.common.per_cell(n));
        // The cells' own numbers, one cell per lane.
        let mut own = vec![L::splat(0.0); per_cell];
        for numbers in self.numbers.chunks(n * L::WIDTH) {
            let filled = numbers.len() / n;
            for q in 0..per_cell {
                for lane in 0..filled {
                    lanes[lane] = self.of_cells[(cell + lane) * per_cell + q];
                }
                own[q] = L::load(&lanes);
            }
            for column in 0..self.stride {
                for i in 0..n {
                    for lane in 0..filled {
                        lanes[lane] = self.x[numbers[lane * n + i] as usize * self.stride + column];
                    }
                    x[i] = L::load(&lanes);
                }
                self.common.multiply(n, &own, &x, &mut sums);
                for i in 0..n {
                    sums[i].store(&mut lanes);
                    for lane in 0..filled {
                        self.sums[numbers[lane * n + i] as usize * self.stride + column] += lanes[lane];
                    }
                }
            }
            cell += filled;
        }
    }
}

impl Common {
    /// The products of cells' matrices, whose own numbers are given, with the values at n nodes.
    #[inline(always)]
    fn multiply<L: SimdLane, const N: usize>(&self, n: usize, own: &[L], x: &[L; N], sums: &mut [L; N]) {
        match self {
            Common::Matrix(matrix) => {
                for i in 0..n {
                    let row = &matrix[i * n..(i + 1) * n];
                    let mut product = L::splat(0.0);
                    for j in 0..n {
                        product = x[j].multiply_add(L::splat(row[j]), product);
                    }
                    sums[i] = product * own[0];
                }
            }
            Common::Basis(basis) => {
                for i in 0..n {
                    sums[i] = L::splat(0.0);
                }
                for q in 0..own.len() {
                    let basis = &basis[q * n..(q + 1) * n];
                    let mut value = L::splat(0.0);
                    for i in 0..n {
                        value = x[i].multiply_add(L::splat(basis[i]), value);
                    }
                    value = value * own[q];
                    for i in 0..n {
                        sums[i] = value.multiply_add(L::splat(basis[i]), sums[i]);
                    }
                }
            }
        }
    }
}
