//! The mass matrix of a projection without its entries: products cell by cell.
//!
//! A cell's matrix is Bᵀ W B with the values B of the basis at quadrature points, which all cells of a shape share, and the cell's
//! weights W; on affine cells the determinant times the reference cell's matrix. A product reads some numbers per cell, where
//! a matrix of all nodes has a dozen entries for each of them.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::cell::RefCell;
use std::ops::Range;

use super::pieces::{CellsOfPiece, Pieces};
use super::start::reference_mass;
use crate::element::MAXIMUM_NODES;
use crate::lanes::{Checked, InstructionSet, LaneWork, SimdLane, WIDEST};
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::{Entries, LinearAlgebraError, LinearOperator, OperatorError};
use crate::mesh::Mesh;
use crate::mesh::small_matrices::determinant;
use crate::quadrature::{Quadrature, QuadratureError};
use crate::space::Space;
use crate::threads::Threads;

/// The scalar mass matrix of a space; the identity at nodes that no cell of a body has.
#[derive(Debug)]
pub(super) struct MassByCells<'a> {
    pieces: &'a Pieces,
    blocks: Vec<BlockMass>,
    lone_nodes: Vec<usize>,
    set: Checked,
}

/// The cells of one shape.
#[derive(Debug)]
struct BlockMass {
    /// Nodes of a cell.
    nodes: usize,
    common: Common,
    /// The same in absolute values.
    sizes: Common,
    /// Determinants, or weights of points, cell by cell.
    of_cells: Vec<f64>,
}

/// Numbers that all cells of a shape share.
#[derive(Debug)]
enum Common {
    /// The reference cell's matrix; a cell has its determinant.
    Matrix(Vec<f64>),
    /// The basis at the points, point after point; a cell has the weights of its points.
    Basis(Vec<f64>),
}

impl Common {
    fn sizes(&self) -> Self {
        let absolute = |values: &[f64]| values.iter().map(|value| value.abs()).collect();
        match self {
            Common::Matrix(values) => Common::Matrix(absolute(values)),
            Common::Basis(values) => Common::Basis(absolute(values)),
        }
    }

    /// Numbers that a cell has of its own.
    fn per_cell(&self, nodes: usize) -> usize {
        match self {
            Common::Matrix(_) => 1,
            Common::Basis(values) => values.len() / nodes,
        }
    }
}

impl<'a> MassByCells<'a> {
    /// That of a space by the rule of some degree.
    ///
    /// # Errors
    /// A degree for which there is no rule.
    pub(super) fn new<const D: usize>(
        space: &Space<D>,
        pieces: &'a Pieces,
        degree: usize,
        set: InstructionSet,
    ) -> Result<Self, QuadratureError> {
        let (mesh, mut blocks) = (space.mesh(), vec![]);
        for block in mesh.body_blocks() {
            let rule = Quadrature::Degree(degree).rule_on_cells(&mesh.shapes(), block.shape, degree)?;
            let tables = space.element_of(block.shape).tabulate(&rule.points);
            let affine = mesh.is_affine_on(block.shape);
            let (common, of_cells) = if affine {
                let determinants = weights(mesh, block.cells.clone(), &[1.0], &[block.shape.centre()]);
                (Common::Matrix(reference_mass(&rule, &tables)), determinants)
            } else {
                (Common::Basis(tables.value), weights(mesh, block.cells.clone(), &rule.weights, &rule.points))
            };
            blocks.push(BlockMass { nodes: tables.nodes, sizes: common.sizes(), common, of_cells });
        }
        Ok(MassByCells { pieces, blocks, lone_nodes: pieces.lone_nodes().collect(), set: set.checked() })
    }

    /// This matrix for products on some threads.
    pub(super) fn on(&self, threads: Threads) -> OnThreads<'_> {
        OnThreads { mass: self, threads, room: RefCell::default() }
    }

    /// The diagonal.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.pieces.count()];
        self.pieces.sums(Threads::ONE, &mut Vec::new(), &mut diagonal, |piece, sums| {
            let block = &self.blocks[piece.block];
            let (n, per_cell) = (block.nodes, block.common.per_cell(block.nodes));
            let of_cells = block.of_cells.chunks(per_cell).skip(piece.cells.start);
            for (numbers, own) in piece.numbers.chunks(n).zip(of_cells) {
                for (i, number) in numbers.iter().enumerate() {
                    sums[*number as usize] += match &block.common {
                        Common::Matrix(matrix) => own[0] * matrix[i * n + i],
                        Common::Basis(basis) => {
                            let at_points = own.iter().zip(basis.chunks(n));
                            at_points.map(|(weight, basis)| weight * basis[i] * basis[i]).sum()
                        }
                    };
                }
            }
        });
        self.lone_nodes.iter().for_each(|node| diagonal[*node] = 1.0);
        diagonal
    }

    /// The product by what the cells share, as it is or in absolute values. `room` is kept from one product to the next.
    fn multiply(
        &self,
        threads: Threads,
        common: fn(&BlockMass) -> &Common,
        x: &[f64],
        room: &mut Vec<f64>,
        y: &mut [f64],
    ) {
        self.pieces.sums(threads, room, y, |piece, sums| {
            let block = &self.blocks[piece.block];
            let (common, nodes) = (common(block), block.nodes);
            let of_cells = &block.of_cells[piece.cells.start * common.per_cell(nodes)..];
            let CellsOfPiece { numbers, .. } = piece;
            let x: Vec<f64> = piece.nodes.iter().map(|node| x[*node as usize]).collect();
            self.set.run_without_kernel(Products { common, nodes, numbers, of_cells, x: &x, sums });
        });
        self.lone_nodes.iter().for_each(|node| y[*node] = x[*node]);
    }
}

/// Weights times determinants at points of the reference cell, cell by cell.
fn weights<const D: usize>(
    mesh: &Mesh<D>,
    cells: Range<usize>,
    weights: &[f64],
    points: &[[f64; D]],
) -> Vec<f64> {
    let shape = mesh.cell_shape(cells.start);
    let geometry = mesh.element_of(shape).tabulate(points);
    let mut found = Vec::with_capacity(cells.len() * points.len());
    for cell in cells {
        for (q, weight) in weights.iter().enumerate() {
            let at = q * geometry.nodes..(q + 1) * geometry.nodes;
            let (_, jacobian) = mesh.map_by(cell, &geometry.value[at.clone()], &geometry.gradient[at]);
            found.push(weight * determinant(&jacobian));
        }
    }
    found
}

/// The products of a piece's cells with the entries of a vector at its nodes.
struct Products<'a> {
    common: &'a Common,
    /// Nodes of a cell.
    nodes: usize,
    /// Numbers of the cells' nodes.
    numbers: &'a [u32],
    /// Determinants, or weights of points, from the first of these cells on.
    of_cells: &'a [f64],
    x: &'a [f64],
    /// Sums to which products are added.
    sums: &'a mut [f64],
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
            (10, Common::Matrix(_)) => self.of::<L, 10>(),
            _ => self.of::<L, MAXIMUM_NODES>(),
        }
    }
}

impl Products<'_> {
    /// Cells of N nodes, or of at most N nodes for [`MAXIMUM_NODES`].
    #[inline(always)]
    fn of<L: SimdLane, const N: usize>(self) {
        let n = if N == MAXIMUM_NODES { self.nodes } else { N };
        let (mut x, mut sums) = ([L::splat(0.0); N], [L::splat(0.0); N]);
        let (mut lanes, mut cell) = ([0.0; WIDEST], 0);
        for numbers in self.numbers.chunks(n * L::WIDTH) {
            let filled = numbers.len() / n;
            for i in 0..n {
                for lane in 0..filled {
                    lanes[lane] = self.x[numbers[lane * n + i] as usize];
                }
                x[i] = L::load(&lanes);
            }
            match self.common {
                Common::Matrix(matrix) => {
                    lanes[..filled].copy_from_slice(&self.of_cells[cell..cell + filled]);
                    let determinants = L::load(&lanes);
                    for i in 0..n {
                        let row = &matrix[i * n..(i + 1) * n];
                        let mut product = L::splat(0.0);
                        for j in 0..n {
                            product = x[j].multiply_add(L::splat(row[j]), product);
                        }
                        sums[i] = product * determinants;
                    }
                }
                Common::Basis(basis) => {
                    sums[..n].fill(L::splat(0.0));
                    let points = basis.len() / n;
                    for q in 0..points {
                        let basis = &basis[q * n..(q + 1) * n];
                        let mut value = L::splat(0.0);
                        for i in 0..n {
                            value = x[i].multiply_add(L::splat(basis[i]), value);
                        }
                        for lane in 0..filled {
                            lanes[lane] = self.of_cells[(cell + lane) * points + q];
                        }
                        value = value * L::load(&lanes);
                        for i in 0..n {
                            sums[i] = value.multiply_add(L::splat(basis[i]), sums[i]);
                        }
                    }
                }
            }
            for i in 0..n {
                sums[i].store(&mut lanes);
                for lane in 0..filled {
                    self.sums[numbers[lane * n + i] as usize] += lanes[lane];
                }
            }
            cell += filled;
        }
    }
}

/// A mass matrix as Krylov methods see it.
#[derive(Debug)]
pub(super) struct OnThreads<'a> {
    mass: &'a MassByCells<'a>,
    threads: Threads,
    /// Products of the cells.
    room: RefCell<Vec<f64>>,
}

impl OnThreads<'_> {
    fn multiply(&self, common: fn(&BlockMass) -> &Common, x: &[f64], y: &mut [f64]) {
        self.mass.multiply(self.threads, common, x, &mut self.room.borrow_mut(), y);
    }
}

impl LinearOperator for OnThreads<'_> {
    fn size(&self) -> usize {
        self.mass.pieces.count()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError> {
        self.multiply(|block| &block.common, x, y);
        Ok(())
    }

    fn entries(&self) -> Option<Entries<'_>> {
        Some(Entries::Sum(self))
    }
}

impl Equations for OnThreads<'_> {
    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        let (mut sums, mut sizes) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        let absolute: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        self.multiply(|block| &block.common, x, &mut sums);
        self.multiply(|block| &block.sizes, &absolute, &mut sizes);
        Ok((sums, sizes))
    }

    fn diagonal(&self) -> Vec<f64> {
        self.mass.diagonal()
    }
}

#[cfg(test)]
mod tests;
