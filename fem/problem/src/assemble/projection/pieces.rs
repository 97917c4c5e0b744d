//! Contributions of cells to the nodes of a space, in sums that do not depend on the number of threads.
//!
//! Cells are cut into pieces of a fixed size, each with numbers of its own for its nodes, so that a piece's part of a vector fits into a
//! fast memory. A piece adds up its cells in their order; at a node of several pieces their sums are added in the order of the pieces.

use std::ops::Range;

use crate::space::Space;
use crate::threads::Threads;

/// Nodes of cells in a piece, those that cells share counted for each of them.
const PIECE: usize = 1 << 14;

/// Nodes at which the sums of one column after the other are finished, so that the numbers of all of them are read from memory once.
const TOGETHER: usize = 128;

/// The cells of bodies, in pieces.
#[derive(Debug)]
pub(in crate::assemble) struct Pieces {
    pieces: Vec<Piece>,
    /// For each cell after the other, the numbers of its nodes within its piece.
    numbers: Vec<u32>,
    /// The nodes of each piece after the other.
    nodes: Vec<u32>,
    /// `places[starts[n]..starts[n + 1]]` are those of node n among `nodes`, ascending.
    starts: Vec<usize>,
    places: Vec<usize>,
    /// Number of cells at each node.
    counts: Vec<u32>,
}

/// Some cells of one shape.
#[derive(Debug)]
struct Piece {
    /// The number of the cells' block.
    block: usize,
    /// Cells, counted from the block's first.
    cells: Range<usize>,
    /// Places of the cells' nodes among all numbers.
    numbers: Range<usize>,
    /// Places of its nodes among those of all pieces.
    nodes: Range<usize>,
}

/// A piece, as those see it who add to its nodes.
#[derive(Clone, Debug)]
pub(super) struct CellsOfPiece<'a> {
    /// The number of their block among those of bodies.
    pub block: usize,
    /// Cells, counted from the block's first.
    pub cells: Range<usize>,
    /// For each cell after the other, the numbers of its nodes within the piece.
    pub numbers: &'a [u32],
    /// The nodes of the piece.
    pub nodes: &'a [u32],
}

impl Pieces {
    /// Those of a space on cells.
    pub(in crate::assemble) fn new<const D: usize>(space: &Space<D>) -> Self {
        let (mut pieces, mut numbers, mut nodes) = (vec![], vec![], vec![]);
        // Of each node, the last piece that has it, and its number there.
        let mut seen = vec![(u32::MAX, 0); space.node_count()];
        let mut counts = vec![0; space.node_count()];
        for (number, block) in space.mesh().body_blocks().enumerate() {
            let at_once = (PIECE / space.element_of(block.shape).nodes()).max(1);
            for first in (0..block.cells.len()).step_by(at_once) {
                let cells = first..(first + at_once).min(block.cells.len());
                let (of_numbers, of_nodes, piece) = (numbers.len(), nodes.len(), pieces.len() as u32);
                for cell in cells.clone() {
                    for &node in space.cell_nodes(block.cells.start + cell) {
                        counts[node as usize] += 1;
                        let own = &mut seen[node as usize];
                        if own.0 != piece {
                            *own = (piece, (nodes.len() - of_nodes) as u32);
                            nodes.push(node);
                        }
                        numbers.push(own.1);
                    }
                }
                let (of_numbers, of_nodes) = (of_numbers..numbers.len(), of_nodes..nodes.len());
                pieces.push(Piece { block: number, cells, numbers: of_numbers, nodes: of_nodes });
            }
        }
        let (starts, places) = by_nodes(&nodes, space.node_count());
        Pieces { pieces, numbers, nodes, starts, places, counts }
    }

    /// Number of nodes of the space.
    pub(super) fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of the pieces' cells at a node.
    pub(super) fn cells_at(&self, node: usize) -> u32 {
        self.counts[node]
    }

    /// The nodes that no cell of a body has.
    pub(super) fn lone_nodes(&self) -> impl Iterator<Item = usize> {
        (0..self.count()).filter(|node| self.starts[*node] == self.starts[node + 1])
    }

    /// The pieces of each thread: shares that differ by one piece at most.
    fn parts(&self, threads: Threads) -> impl Iterator<Item = &[Piece]> {
        let (count, parts) = (self.pieces.len(), threads.for_work(self.numbers.len()));
        let parts = parts.min(count).max(1);
        (0..parts).map(move |part| &self.pieces[part * count / parts..(part + 1) * count / parts])
    }

    /// Cells of each thread in a sum.
    pub(super) fn cells_of_parts(&self, threads: Threads) -> Vec<f64> {
        let cells = |pieces: &[Piece]| pieces.iter().map(|piece| piece.cells.len() as f64).sum();
        self.parts(threads).map(cells).collect()
    }

    /// Writes at each node the sum of what `work` adds for the cells of each piece to zeros, by their numbers within it. `room` is
    /// memory that is kept from one sum to the next.
    pub(super) fn sums(
        &self,
        threads: Threads,
        room: &mut Vec<f64>,
        sums: &mut [f64],
        work: impl Fn(CellsOfPiece, &mut [f64]) + Send + Sync,
    ) {
        self.sums_of_columns(threads, (room, 1), [sums].into_iter(), |_, sum| sum, work);
    }

    /// The same for several columns: `work` adds the numbers of all columns at a node one after the other, where the first one of the next node
    /// is `stride` numbers later. A sum at a node is finished by `finish`.
    pub(super) fn sums_of_columns<'s>(
        &self,
        threads: Threads,
        (room, stride): (&mut Vec<f64>, usize),
        columns: impl ExactSizeIterator<Item = &'s mut [f64]>,
        finish: impl Fn(usize, f64) -> f64 + Send + Sync,
        work: impl Fn(CellsOfPiece, &mut [f64]) + Send + Sync,
    ) {
        room.resize(self.nodes.len() * stride, 0.0);
        let (mut parts, mut rest) = (vec![], &mut room[..]);
        for pieces in self.parts(threads) {
            let nodes: usize = pieces.iter().map(|piece| piece.nodes.len()).sum();
            let (own, later) = rest.split_at_mut(nodes * stride);
            parts.push((pieces, own));
            rest = later;
        }
        threads.run(parts, |(pieces, mut sums): (&[Piece], &mut [f64])| {
            for piece in pieces {
                let (own, later) = std::mem::take(&mut sums).split_at_mut(piece.nodes.len() * stride);
                own.fill(0.0);
                let seen = CellsOfPiece {
                    block: piece.block,
                    cells: piece.cells.clone(),
                    numbers: &self.numbers[piece.numbers.clone()],
                    nodes: &self.nodes[piece.nodes.clone()],
                };
                work(seen, own);
                sums = later;
            }
        });
        let length = self.count().div_ceil(threads.for_work(self.count())).max(1);
        let mut shares: Vec<Vec<(usize, &mut [f64])>> = vec![];
        for (column, sums) in columns.enumerate() {
            for (part, sums) in sums.chunks_mut(length).enumerate() {
                if part == shares.len() {
                    shares.push(vec![]);
                }
                shares[part].push((column, sums));
            }
        }
        let shares = shares.into_iter().enumerate().collect();
        threads.run(shares, |(part, mut columns): (usize, Vec<(usize, &mut [f64])>)| {
            for first in (0..length).step_by(TOGETHER) {
                for (column, sums) in &mut columns {
                    let some = first.min(sums.len())..(first + TOGETHER).min(sums.len());
                    for (node, sum) in (part * length + first..).zip(&mut sums[some]) {
                        let places = &self.places[self.starts[node]..self.starts[node + 1]];
                        let total =
                            places.iter().fold(0.0, |sum, place| sum + room[*place * stride + *column]);
                        *sum = finish(node, total);
                    }
                }
            }
        });
    }
}

/// The places of each node in a list, node after node, and where those of each begin.
fn by_nodes(nodes: &[u32], count: usize) -> (Vec<usize>, Vec<usize>) {
    let mut starts = vec![0; count + 1];
    for node in nodes {
        starts[*node as usize + 1] += 1;
    }
    for node in 0..count {
        starts[node + 1] += starts[node];
    }
    let (mut next, mut places) = (starts.clone(), vec![0; nodes.len()]);
    for (place, node) in nodes.iter().enumerate() {
        let next = &mut next[*node as usize];
        places[*next] = place;
        *next += 1;
    }
    (starts, places)
}
