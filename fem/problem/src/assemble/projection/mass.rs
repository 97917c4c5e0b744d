//! The mass matrix of a projection without its entries: products cell by cell.
//!
//! A cell's matrix is Bᵀ W B with the values B of the basis at quadrature points, which all cells of a shape share, and the cell's
//! weights W; on affine cells the determinant times the reference cell's matrix. A product reads some numbers per cell, where
//! a matrix of all nodes has a dozen entries for each of them.

mod products;

use std::cell::RefCell;
use std::ops::Range;

use self::products::{Common, Products};
use super::pieces::{CellsOfPiece, Pieces};
use super::start::{reference_mass, scaled_inverse};
use crate::lanes::{Checked, InstructionSet};
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
    /// None where a rule has too few points to invert the matrices of cells.
    inverse: Option<Inverse>,
    set: Checked,
}

/// An approximation of the inverse: E⁻¹ (Σ E_c M_c⁻¹ E_c) E⁻¹ with the diagonals E_c of the matrices M_c of cells, and their sum E.
///
/// It is the inverse on cells that share no nodes. Its product with the matrix has eigenvalues from 1 to 1.5 for biquadratic
/// quadrilaterals and to 1.8 for quadratic triangles, whatever the sizes of cells; with the diagonal they are from 0.25 to 1.56, and
/// from 0.39 to 2.1. Cells that are not affine count as affine ones of their size.
#[derive(Debug)]
struct Inverse {
    blocks: Vec<BlockMass>,
    /// The inverse of E at each node.
    scales: Vec<f64>,
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
        let (mesh, mut blocks, mut inverses) = (space.mesh(), vec![], vec![]);
        for block in mesh.body_blocks() {
            let rule = Quadrature::Degree(degree).rule_on_cells(&mesh.shapes(), block.shape, degree)?;
            let tables = space.element_of(block.shape).tabulate(&rule.points);
            let (nodes, reference) = (tables.nodes, reference_mass(&rule, &tables));
            let (common, of_cells) = if mesh.is_affine_on(block.shape) {
                let determinants = weights(mesh, block.cells.clone(), &[1.0], &[block.shape.centre()]);
                (Common::Matrix(reference.clone()), determinants)
            } else {
                (Common::Basis(tables.value), weights(mesh, block.cells.clone(), &rule.weights, &rule.points))
            };
            let volume: f64 = rule.weights.iter().sum();
            let determinants = match &common {
                Common::Matrix(_) => of_cells.clone(),
                Common::Basis(_) => {
                    of_cells.chunks(rule.len()).map(|weights| weights.iter().sum::<f64>() / volume).collect()
                }
            };
            let near = scaled_inverse(nodes, &reference).map(|matrix| {
                let common = Common::Matrix(matrix);
                let diagonal: Vec<f64> = (0..nodes).map(|i| reference[i * nodes + i]).collect();
                (BlockMass { nodes, sizes: common.sizes(), common, of_cells: determinants }, diagonal)
            });
            inverses.push(near);
            blocks.push(BlockMass { nodes, sizes: common.sizes(), common, of_cells });
        }
        let lone_nodes: Vec<usize> = pieces.lone_nodes().collect();
        let inverse = inverses.into_iter().collect::<Option<Vec<_>>>().map(|inverses| {
            let (blocks, diagonals): (Vec<_>, Vec<_>) = inverses.into_iter().unzip();
            let mut scales = sums_of_diagonals(pieces, &blocks, &diagonals);
            lone_nodes.iter().for_each(|node| scales[*node] = 1.0);
            scales.iter_mut().for_each(|scale| *scale = scale.recip());
            Inverse { blocks, scales }
        });
        Ok(MassByCells { pieces, blocks, lone_nodes, inverse, set: set.checked() })
    }

    /// Whether there is an approximation of the inverse.
    pub(super) fn has_inverse(&self) -> bool {
        self.inverse.is_some()
    }

    /// Sums of the sizes of the terms of products with several vectors.
    pub(super) fn sizes(
        &self,
        threads: Threads,
        x: &[Vec<f64>],
        room: &mut Vec<f64>,
        sizes: &mut [Vec<f64>],
    ) {
        let absolute: Vec<Vec<f64>> = x.iter().map(|x| x.iter().map(|value| value.abs()).collect()).collect();
        let sizes = sizes.iter_mut().map(|sizes| &mut sizes[..]);
        self.multiply(threads, (&self.blocks[..], None), |block| &block.sizes, &absolute, room, sizes);
    }

    /// Products with several vectors.
    pub(super) fn products(&self, threads: Threads, x: &[Vec<f64>], room: &mut Vec<f64>, y: &mut [Vec<f64>]) {
        let y = y.iter_mut().map(|y| &mut y[..]);
        self.multiply(threads, (&self.blocks[..], None), |block| &block.common, x, room, y);
    }

    /// Products of the approximate inverse with several vectors; the vectors themselves where there is none.
    pub(super) fn precondition(
        &self,
        threads: Threads,
        x: &[Vec<f64>],
        room: &mut Vec<f64>,
        y: &mut [Vec<f64>],
    ) {
        let Some(Inverse { blocks, scales }) = &self.inverse else {
            return y.clone_from_slice(x);
        };
        let y = y.iter_mut().map(|y| &mut y[..]);
        self.multiply(threads, (&blocks[..], Some(&scales[..])), |block| &block.common, x, room, y);
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

    /// The products of several vectors by what the cells of blocks share, with vectors and products scaled at each node. `room` is kept from one
    /// product to the next.
    fn multiply<'y>(
        &self,
        threads: Threads,
        (blocks, scales): (&[BlockMass], Option<&[f64]>),
        common: fn(&BlockMass) -> &Common,
        x: &[impl AsRef<[f64]> + Sync],
        room: &mut Vec<f64>,
        y: impl ExactSizeIterator<Item = &'y mut [f64]>,
    ) {
        let width = self.set.width();
        // Numbers of a node fill registers where there are enough; of few vectors, those of several cells do.
        let stride = if 2 * x.len() > width { x.len().next_multiple_of(width) } else { x.len() };
        let scale = |node: usize| scales.map_or(1.0, |scales| scales[node]);
        let mut y: Vec<&mut [f64]> = y.collect();
        let finish = |node: usize, sum: f64| sum * scale(node);
        let of_columns = y.iter_mut().map(|y| &mut **y);
        self.pieces.sums_of_columns(threads, (room, stride), of_columns, finish, |piece, sums| {
            let block = &blocks[piece.block];
            let (common, nodes) = (common(block), block.nodes);
            let of_cells = &block.of_cells[piece.cells.start * common.per_cell(nodes)..];
            let CellsOfPiece { numbers, .. } = piece;
            let mut own = vec![0.0; piece.nodes.len() * stride];
            for (own, node) in own.chunks_exact_mut(stride).zip(piece.nodes) {
                let (node, scale) = (*node as usize, scale(*node as usize));
                own.iter_mut().zip(x).for_each(|(own, x)| *own = scale * x.as_ref()[node]);
            }
            let x = &own;
            self.set.run_without_kernel(Products { common, nodes, stride, numbers, of_cells, x, sums });
        });
        for (x, y) in x.iter().zip(y) {
            self.lone_nodes.iter().for_each(|node| y[*node] = x.as_ref()[*node]);
        }
    }
}

/// The sums at nodes of the diagonals of cells.
fn sums_of_diagonals(pieces: &Pieces, blocks: &[BlockMass], diagonals: &[Vec<f64>]) -> Vec<f64> {
    let mut sums = vec![0.0; pieces.count()];
    pieces.sums(Threads::ONE, &mut Vec::new(), &mut sums, |piece, sums| {
        let (block, diagonal) = (&blocks[piece.block], &diagonals[piece.block]);
        let of_cells = &block.of_cells[piece.cells.start..];
        for (numbers, determinant) in piece.numbers.chunks(block.nodes).zip(of_cells) {
            for (number, entry) in numbers.iter().zip(diagonal) {
                sums[*number as usize] += determinant * entry;
            }
        }
    });
    sums
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
        let (blocks, mut room) = (&self.mass.blocks[..], self.room.borrow_mut());
        self.mass.multiply(self.threads, (blocks, None), common, &[x], &mut room, [y].into_iter());
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
