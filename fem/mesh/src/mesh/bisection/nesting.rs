//! Cells of a mesh inside those of a coarser one.

use std::ops::Range;

use super::marked_edges::Part;
use super::simplex;

/// For each cell of a mesh of simplices the cell of a coarser mesh that it is a part of, and where in it: between a mesh and what
/// [`super::BisectedMesh::refined`] or [`super::BisectedMesh::coarsened`] makes of it. Parts of a cell have consecutive numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nesting<const D: usize> {
    /// The number of the first part of each coarse cell, and at the end the number of fine cells.
    first: Vec<u32>,
    /// The coarse cell of each fine one.
    coarse: Vec<u32>,
    /// The ends of each fine cell's steps among all.
    ends: Vec<u32>,
    /// The bisections that lead from a coarse cell to a fine one: the number of the divided edge, doubled, and 1 more for the
    /// second part.
    steps: Vec<u8>,
}

/// A list of the fine cells in their order, from which a nesting is made.
#[derive(Default)]
pub(super) struct Parts<const D: usize> {
    first: Vec<u32>,
    coarse: Vec<u32>,
    ends: Vec<u32>,
    steps: Vec<u8>,
}

/// A step of a path: the part that the division of an edge gives.
pub(super) fn step(edge: usize, part: Part) -> u8 {
    2 * edge as u8 + u8::from(part == Part::KeepsSecond)
}

impl<const D: usize> Parts<D> {
    /// Begins the next coarse cell.
    pub(super) fn next_coarse(&mut self) {
        self.first.push(self.coarse.len() as u32);
    }

    /// Adds a part of the present coarse cell.
    pub(super) fn add(&mut self, path: &[u8]) {
        self.coarse.push(self.first.len() as u32 - 1);
        self.steps.extend_from_slice(path);
        self.ends.push(self.steps.len() as u32);
    }

    pub(super) fn nesting(self) -> Nesting<D> {
        let Parts { mut first, coarse, ends, steps } = self;
        first.push(coarse.len() as u32);
        Nesting { first, coarse, ends, steps }
    }
}

impl<const D: usize> Nesting<D> {
    /// Number of cells of the coarser mesh.
    pub fn coarse_cell_count(&self) -> usize {
        self.first.len() - 1
    }

    /// Number of cells of the finer mesh.
    pub fn fine_cell_count(&self) -> usize {
        self.coarse.len()
    }

    /// The cell of the coarser mesh that a cell of the finer one is a part of.
    ///
    /// # Panics
    /// When `fine` is not below [`Nesting::fine_cell_count`].
    pub fn coarse_cell(&self, fine: usize) -> usize {
        self.coarse[fine] as usize
    }

    /// The parts of a cell of the coarser mesh: itself under its new number, if it is not divided.
    ///
    /// # Panics
    /// When `coarse` is not below [`Nesting::coarse_cell_count`].
    pub fn fine_cells(&self, coarse: usize) -> Range<usize> {
        self.first[coarse] as usize..self.first[coarse + 1] as usize
    }

    /// Number of bisections that lead from the coarser mesh's cell to a part of it: 0 for an undivided cell.
    ///
    /// # Panics
    /// When `fine` is not below [`Nesting::fine_cell_count`].
    pub fn bisections(&self, fine: usize) -> usize {
        self.path(fine).len()
    }

    /// The vertices of a cell of the finer mesh, in reference coordinates of the coarser mesh's cell that it is a part of: exact,
    /// for they are multiples of powers of two.
    ///
    /// # Panics
    /// When `fine` is not below [`Nesting::fine_cell_count`].
    pub fn vertices(&self, fine: usize) -> Vec<[f64; D]> {
        let shape = simplex::<D>();
        let mut vertices: Vec<[f64; D]> =
            shape.vertex_points().iter().map(|point| std::array::from_fn(|k| point[k])).collect();
        for step in self.path(fine) {
            let [a, b] = shape.edges()[usize::from(step / 2)];
            let middle = std::array::from_fn(|k| 0.5 * (vertices[a][k] + vertices[b][k]));
            let part = Part::BOTH[usize::from(step % 2)];
            let [_, new] = part.kept_and_new([a, b]);
            vertices[new] = middle;
        }
        vertices
    }

    /// The reference coordinates, in the coarser mesh's cell, of a point given by those in a part of it.
    ///
    /// # Panics
    /// When `fine` is not below [`Nesting::fine_cell_count`].
    pub fn to_coarse(&self, fine: usize, reference: &[f64; D]) -> [f64; D] {
        let vertices = self.vertices(fine);
        let mut point = vertices[0];
        for (vertex, coordinate) in vertices[1..].iter().zip(reference) {
            for (x, (v, origin)) in point.iter_mut().zip(vertex.iter().zip(&vertices[0])) {
                *x += coordinate * (v - origin);
            }
        }
        point
    }

    fn path(&self, fine: usize) -> &[u8] {
        let start = if fine == 0 { 0 } else { self.ends[fine - 1] as usize };
        &self.steps[start..self.ends[fine] as usize]
    }
}
