//! The right-hand sides of a projection, and where its iteration starts: sums over the cells of what they make of the values at
//! their points. Values are taken cell by cell as they are found, and are kept for a few cells only.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::pieces::{CellsOfPiece, Pieces};
use super::start::nearest_on_reference;
use crate::assemble::AssemblyError;
use crate::lanes::{Checked, InstructionSet, LaneWork, SimdLane, WIDEST};
use crate::mesh::CellBlock;
use crate::quadrature::{Quadrature, QuadratureError};
use crate::space::Space;
use crate::threads::Threads;

/// One system for each component: its right-hand side, and its start.
pub(super) type Systems = Vec<(Vec<f64>, Vec<f64>)>;

/// Takes the value at a point and the quadrature weight times measure there.
pub(super) type Receive<'a> = &'a mut dyn FnMut(&[f64], f64);

/// The values at the points of some cells of a block, given by its number, cell by cell.
pub(super) type ValuesOfCells<'a> =
    dyn Fn(usize, Range<usize>, Receive) -> Result<(), AssemblyError> + Sync + 'a;

/// The systems of a function whose values at the points of the rules of blocks are given.
///
/// # Errors
/// The first error of `values`, in the order of cells.
pub(super) fn systems(
    values: &ValuesOfCells,
    blocks: &[Block],
    components: usize,
    pieces: &Pieces,
    (set, threads): (InstructionSet, Threads),
) -> Result<Systems, AssemblyError> {
    let failed: Mutex<Option<(usize, AssemblyError)>> = Mutex::new(None);
    let mut sums = vec![vec![0.0; pieces.count()]; 2 * components];
    let columns = sums.iter_mut().map(|sums| &mut sums[..]);
    pieces.sums_of_columns(
        threads,
        (&mut Vec::new(), 2 * components),
        columns,
        |_, sum| sum,
        |piece, sums| {
            let (block, cells) = (piece.block, piece.cells.clone());
            let number = blocks[..block].iter().map(|block| block.cells).sum::<usize>() + cells.start;
            let mut taken = Contributions::new(&blocks[block], components, piece, sums, set.checked());
            match values(block, cells, &mut |value, weight| taken.take(value, weight)) {
                Ok(()) => taken.add(),
                Err(error) => {
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    if failed.as_ref().is_none_or(|(first, _)| number < *first) {
                        *failed = Some((number, error));
                    }
                }
            }
        },
    );
    if let Some((_, error)) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let mut loads = sums;
    let mut starts = loads.split_off(components);
    for start in &mut starts {
        start.iter_mut().enumerate().for_each(|(node, start)| *start /= pieces.cells_at(node).max(1) as f64);
    }
    Ok(loads.into_iter().zip(starts).collect())
}

/// What the cells of a piece make of the values at their points, as many cells at a time as there are lanes.
struct Contributions<'a> {
    block: &'a Block,
    components: usize,
    /// Numbers of the nodes of the cells that are left.
    numbers: &'a [u32],
    /// For each node the loads of all components, and their starts.
    sums: &'a mut [f64],
    set: Checked,
    /// Values at the points of component after component, one cell per lane; then the same times the weights.
    values: Vec<[f64; WIDEST]>,
    /// The lane and the point that come next.
    next: (usize, usize),
}

impl<'a> Contributions<'a> {
    fn new(
        block: &'a Block,
        components: usize,
        piece: CellsOfPiece<'a>,
        sums: &'a mut [f64],
        set: Checked,
    ) -> Self {
        let values = vec![[0.0; WIDEST]; 2 * components * block.points];
        Contributions { block, components, numbers: piece.numbers, sums, set, values, next: (0, 0) }
    }

    fn take(&mut self, value: &[f64], weight: f64) {
        let points = self.block.points;
        let (plain, weighted) = self.values.split_at_mut(self.components * points);
        let (lane, point) = &mut self.next;
        for component in 0..self.components {
            plain[component * points + *point][*lane] = value[component];
            weighted[component * points + *point][*lane] = weight * value[component];
        }
        *point += 1;
        if *point == points {
            (*lane, *point) = (*lane + 1, 0);
            if *lane == self.set.width() {
                self.add();
            }
        }
    }

    /// Adds what there is.
    fn add(&mut self) {
        let filled = std::mem::take(&mut self.next.0);
        let (numbers, later) = self.numbers.split_at(filled * self.block.nodes);
        self.numbers = later;
        let (block, components, values) = (self.block, self.components, &self.values[..]);
        let sums = &mut *self.sums;
        self.set.run_without_kernel(Sums { block, components, filled, numbers, values, sums });
    }
}

/// The sums over the points of a few cells, one per lane.
struct Sums<'a> {
    block: &'a Block,
    components: usize,
    filled: usize,
    numbers: &'a [u32],
    values: &'a [[f64; WIDEST]],
    sums: &'a mut [f64],
}

impl LaneWork for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: SimdLane>(self) {
        let Sums { block, components, filled, numbers, values, sums } = self;
        let Block { nodes, points, .. } = *block;
        let mut lanes = [0.0; WIDEST];
        for column in 0..2 * components {
            // Loads come first, which are made of the weighted values.
            let (rows, from) = if column < components {
                (&block.tests, column + components)
            } else {
                (&block.nearest, column - components)
            };
            let values = &values[from * points..(from + 1) * points];
            for (node, row) in rows.chunks_exact(points).enumerate() {
                let mut sum = L::splat(0.0);
                for q in 0..points {
                    sum = L::load(&values[q]).multiply_add(L::splat(row[q]), sum);
                }
                sum.store(&mut lanes);
                for lane in 0..filled {
                    let number = numbers[lane * nodes + node] as usize;
                    sums[number * 2 * components + column] += lanes[lane];
                }
            }
        }
    }
}

/// The cells of one shape.
pub(super) struct Block {
    /// Their number.
    pub cells: usize,
    /// Nodes of a cell.
    nodes: usize,
    /// Points of a cell.
    pub points: usize,
    /// The basis: for each node a row with its values at the points.
    tests: Vec<f64>,
    /// The rows that make the nearest polynomial of values; empty where there is none.
    nearest: Vec<f64>,
}

/// The blocks of a space's mesh with the rule of some degree.
///
/// # Errors
/// A degree for which there is no rule.
pub(super) fn blocks<const D: usize>(
    degree: usize,
    quadrature: &Quadrature<D>,
    space: &Space<D>,
) -> Result<Vec<Block>, QuadratureError> {
    let mesh = space.mesh();
    let of_block = |block: CellBlock| {
        let rule = quadrature.rule_on_cells(&mesh.shapes(), block.shape, degree)?;
        let tables = space.element_of(block.shape).tabulate(&rule.points);
        let (cells, nodes, points) = (block.cells.len(), tables.nodes, rule.len());
        let at_points = |node| (0..points).map(move |q| q * nodes + node);
        let tests = (0..nodes).flat_map(at_points).map(|at| tables.value[at]).collect();
        let nearest = nearest_on_reference(&rule, &tables).unwrap_or_default();
        Ok(Block { cells, nodes, points, tests, nearest })
    };
    mesh.body_blocks().map(of_block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::annulus;

    /// Cells in several pieces.
    fn space(shape: CellShape) -> std::sync::Arc<Space<2>> {
        Space::scalar(&annulus(20.0, 30.0, 16, 256, shape, 2).unwrap(), 2).unwrap()
    }

    #[test]
    fn sums_are_those_of_each_point_with_the_same_bits_on_any_number_of_threads() {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            let space = space(shape);
            let pieces = Pieces::new(&space);
            let blocks = blocks(6, &Quadrature::Degree(6), &space).unwrap();
            let points = blocks[0].points;
            // Two components, and weights that differ.
            let value = |cell: usize, q: usize| [(cell * points + q) as f64 * 0.37, (q as f64 + 0.5).sin()];
            let weight = |cell: usize, q: usize| 1.0 + ((cell * 5 + q) as f64).cos();
            let values = |_: usize, cells: Range<usize>, receive: Receive| {
                for (cell, q) in cells.flat_map(|cell| (0..points).map(move |q| (cell, q))) {
                    receive(&value(cell, q), weight(cell, q));
                }
                Ok(())
            };
            let found =
                |set, threads| systems(&values, &blocks, 2, &pieces, (set, Threads::new(threads))).unwrap();
            let rule = Quadrature::<2>::Degree(6).rule_on_cells(&space.mesh().shapes(), shape, 6).unwrap();
            let basis = space.element_of(shape).tabulate(&rule.points);
            let (mut loads, mut sizes) =
                (vec![[0.0; 2]; space.node_count()], vec![[0.0; 2]; space.node_count()]);
            for (cell, q) in (0..blocks[0].cells).flat_map(|cell| (0..points).map(move |q| (cell, q))) {
                for (node, function) in space.cell_nodes(cell).iter().zip(&basis.value[q * basis.nodes..]) {
                    for (component, value) in value(cell, q).iter().enumerate() {
                        let term = function * weight(cell, q) * value;
                        loads[*node as usize][component] += term;
                        sizes[*node as usize][component] += term.abs();
                    }
                }
            }
            for set in InstructionSet::available() {
                let one = found(set, 1);
                for (component, (load, start)) in one.iter().enumerate() {
                    for (node, load) in load.iter().enumerate() {
                        let off = (load - loads[node][component]).abs();
                        assert!(off <= 1e-14 * sizes[node][component], "{set}, node {node}: {off:e}");
                    }
                    assert!(start.iter().all(|start| start.is_finite()) && start.iter().any(|x| *x != 0.0));
                }
                for threads in [2, 3, 7, 16] {
                    assert_eq!(found(set, threads), one, "{set}, {threads} threads");
                }
            }
        }
    }

    #[test]
    fn the_first_cell_that_fails_is_named() {
        let space = space(CellShape::Quadrilateral);
        let (pieces, blocks) = (Pieces::new(&space), blocks(6, &Quadrature::Degree(6), &space).unwrap());
        let first = 700;
        let values = |_: usize, cells: Range<usize>, receive: Receive| {
            for cell in cells {
                if cell >= first {
                    return Err(AssemblyError::ValueNotFinite { form: "f", position: vec![cell as f64] });
                }
                (0..blocks[0].points).for_each(|_| receive(&[1.0], 1.0));
            }
            Ok(())
        };
        for threads in [1, 2, 3, 7, 16] {
            let set = (InstructionSet::best(), Threads::new(threads));
            match systems(&values, &blocks, 1, &pieces, set) {
                Err(AssemblyError::ValueNotFinite { position, .. }) => assert_eq!(position, [first as f64]),
                other => panic!("{other:?}"),
            }
        }
    }
}
