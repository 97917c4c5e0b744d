//! Cells of a mesh inside those of a coarser one.

use std::ops::Range;

use super::Mesh;
use super::bisection::step_of_bisection;
use crate::element::CellShape;

/// For each cell of a mesh the cell of a coarser mesh that contains it, and its place there. Refining or coarsening a [`super::BisectedMesh`] or
/// [`super::OctreeMesh`] returns one. Parts of a cell have consecutive numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nesting<const D: usize> {
    /// The shape of all cells.
    shape: CellShape,
    /// The number of the first part of each coarse cell, and at the end the number of fine cells.
    first: Vec<u32>,
    /// The coarse cell of each fine one.
    coarse: Vec<u32>,
    /// The ends of each fine cell's steps among all.
    ends: Vec<u32>,
    /// The divisions that lead from a coarse cell to a fine one. Of a simplex: the number of the divided edge, doubled, and 1 more
    /// for the second part; of a quadrilateral or hexahedron: the vertex at which the part lies.
    steps: Vec<u8>,
}

/// A list of the fine cells in their order, from which a nesting is made.
pub(super) struct Parts<const D: usize>(Nesting<D>);

impl<const D: usize> Parts<D> {
    /// An empty list for cells of a shape.
    pub(super) fn new(shape: CellShape) -> Self {
        Parts(Nesting { shape, first: vec![], coarse: vec![], ends: vec![], steps: vec![] })
    }

    /// Begins the next coarse cell.
    pub(super) fn next_coarse(&mut self) {
        self.0.first.push(self.0.coarse.len() as u32);
    }

    /// Adds a part of the present coarse cell.
    pub(super) fn add(&mut self, path: &[u8]) {
        self.0.coarse.push(self.0.first.len() as u32 - 1);
        self.0.steps.extend_from_slice(path);
        self.0.ends.push(self.0.steps.len() as u32);
    }

    pub(super) fn nesting(mut self) -> Nesting<D> {
        self.0.first.push(self.0.coarse.len() as u32);
        self.0
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

    /// Number of divisions that lead from the coarser mesh's cell to a part of it, bisections of a simplex and divisions of a
    /// quadrilateral or hexahedron into 2^D: 0 for an undivided cell.
    ///
    /// # Panics
    /// When `fine` is not below [`Nesting::fine_cell_count`].
    pub fn divisions(&self, fine: usize) -> usize {
        self.path(fine).len()
    }

    /// The vertices of a cell of the finer mesh, in reference coordinates of the coarser mesh's cell that it is a part of: exact,
    /// for they are multiples of powers of two.
    ///
    /// # Panics
    /// When `fine` is not below [`Nesting::fine_cell_count`].
    pub fn vertices(&self, fine: usize) -> Vec<[f64; D]> {
        let points = self.shape.vertex_points().iter();
        let mut vertices: Vec<[f64; D]> = points.map(|point| std::array::from_fn(|k| point[k])).collect();
        let between = |a: [f64; D], b: [f64; D]| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        for &step in self.path(fine) {
            if self.shape.is_simplex() {
                let (new, [a, b]) = step_of_bisection(self.shape, step);
                vertices[new] = between(vertices[a], vertices[b]);
            } else {
                let corner = vertices[usize::from(step)];
                vertices.iter_mut().for_each(|vertex| *vertex = between(corner, *vertex));
            }
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
        // The vertices at the ends of the axes, whatever the shape.
        for (vertex, corner) in vertices.iter().zip(self.shape.vertex_points()) {
            let Some(axis) = corner.iter().position(|x| *x == 1.0) else { continue };
            if corner.iter().sum::<f64>() != 1.0 {
                continue;
            }
            for (x, (v, origin)) in point.iter_mut().zip(vertex.iter().zip(&vertices[0])) {
                *x += reference[axis] * (v - origin);
            }
        }
        point
    }

    fn path(&self, fine: usize) -> &[u8] {
        let start = if fine == 0 { 0 } else { self.ends[fine - 1] as usize };
        &self.steps[start..self.ends[fine] as usize]
    }
}

impl<const D: usize> Mesh<D> {
    /// The nodes that some cells have, in their order, and for each of the mesh's nodes its number among them, the largest for
    /// one that is not; the cells name them by these numbers afterwards.
    pub(super) fn nodes_of_cells(&self, cells: &mut [u32]) -> (Vec<[f64; D]>, Vec<u32>) {
        let mut stays = vec![true; self.node_count()];
        self.cells.iter().for_each(|node| stays[*node as usize] = false);
        cells.iter().for_each(|node| stays[*node as usize] = true);
        let mut numbers = Vec::with_capacity(stays.len());
        let mut nodes = Vec::with_capacity(stays.len());
        for (position, stays) in self.nodes.iter().zip(stays) {
            numbers.push(if stays { nodes.len() as u32 } else { u32::MAX });
            if stays {
                nodes.push(*position);
            }
        }
        cells.iter_mut().for_each(|node| *node = numbers[*node as usize]);
        (nodes, numbers)
    }
}
