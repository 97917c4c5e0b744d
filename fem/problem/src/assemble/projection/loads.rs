//! The right-hand sides of a projection, and where its iteration starts: sums over the cells of what they make of the values at
//! their points.

use std::ops::Range;

use super::ValuesAtPoints;
use super::pieces::Pieces;
use super::start::nearest_on_reference;
use crate::mesh::CellBlock;
use crate::quadrature::{Quadrature, QuadratureError};
use crate::space::Space;
use crate::threads::Threads;

/// One system for each component: its right-hand side, and its start.
pub(super) type Systems = Vec<(Vec<f64>, Vec<f64>)>;

/// The systems of a function that is known at the points of a rule.
///
/// # Errors
/// A degree for which there is no rule.
pub(super) fn systems<const D: usize>(
    known: &ValuesAtPoints,
    quadrature: &Quadrature<D>,
    space: &Space<D>,
    pieces: &Pieces,
    threads: Threads,
) -> Result<Systems, QuadratureError> {
    let blocks = blocks(known, quadrature, space)?;
    let mut room = Vec::new();
    let mut sums = |values: &[f64], rows: fn(&Block) -> Option<&[f64]>| {
        let mut sums = vec![0.0; pieces.count()];
        pieces.sums(threads, &mut room, &mut sums, |piece, sums| {
            let block = &blocks[piece.block];
            let Some(rows) = rows(block) else { return };
            let of_cells = values[block.values.clone()].chunks(block.points).skip(piece.cells.start);
            for (numbers, values) in piece.numbers.chunks(block.nodes).zip(of_cells) {
                for (number, row) in numbers.iter().zip(rows.chunks(block.points)) {
                    let share = row.iter().zip(values).fold(0.0, |sum, (factor, value)| sum + factor * value);
                    sums[*number as usize] += share;
                }
            }
        });
        sums
    };
    let mut counts = vec![0.0; pieces.count()];
    pieces.sums(threads, &mut Vec::new(), &mut counts, |piece, counts| {
        piece.numbers.iter().for_each(|number| counts[*number as usize] += 1.0);
    });
    let of_component = |component| {
        let plain = known.values.iter().skip(component).step_by(space.components());
        let weighted = plain.clone().zip(known.weights).map(|(value, weight)| weight * value);
        let load = sums(&weighted.collect::<Vec<_>>(), |block| Some(&block.tests));
        let mut start = sums(&plain.copied().collect::<Vec<_>>(), |block| block.nearest.as_deref());
        start.iter_mut().zip(&counts).for_each(|(start, count)| *start /= count.max(1.0));
        (load, start)
    };
    Ok((0..space.components()).map(of_component).collect())
}

/// The cells of one shape.
struct Block {
    /// Nodes of a cell.
    nodes: usize,
    /// Points of a cell.
    points: usize,
    /// The numbers of the cells' points.
    values: Range<usize>,
    /// The basis: for each node a row with its values at the points.
    tests: Vec<f64>,
    /// The rows that make the nearest polynomial of values.
    nearest: Option<Vec<f64>>,
}

fn blocks<const D: usize>(
    known: &ValuesAtPoints,
    quadrature: &Quadrature<D>,
    space: &Space<D>,
) -> Result<Vec<Block>, QuadratureError> {
    let (mesh, mut value) = (space.mesh(), 0);
    let of_block = |block: CellBlock| {
        let rule = quadrature.rule_on_cells(&mesh.shapes(), block.shape, known.degree)?;
        let tables = space.element_of(block.shape).tabulate(&rule.points);
        let (nodes, points) = (tables.nodes, rule.len());
        let values = value..value + block.cells.len() * points;
        value = values.end;
        let at_points = |node| (0..points).map(move |q| q * nodes + node);
        let tests = (0..nodes).flat_map(at_points).map(|at| tables.value[at]).collect();
        Ok(Block { nodes, points, values, tests, nearest: nearest_on_reference(&rule, &tables) })
    };
    mesh.body_blocks().map(of_block).collect()
}
