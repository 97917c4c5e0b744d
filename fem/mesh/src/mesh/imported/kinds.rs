//! A format's entry for a type of its elements.

use crate::element::CellShape;

/// A type of element.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::mesh) struct Kind {
    /// The code in the file.
    pub(in crate::mesh) code: u8,
    pub(in crate::mesh) name: &'static str,
    pub(in crate::mesh) dimension: usize,
    pub(in crate::mesh) nodes: usize,
    /// Number of vertices, which come first.
    pub(in crate::mesh) vertices: usize,
    /// The cells that it can be.
    pub(in crate::mesh) cell: Option<Cell>,
}

/// A cell of a mesh.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::mesh) struct Cell {
    pub(in crate::mesh) shape: CellShape,
    pub(in crate::mesh) degree: usize,
    /// For each of our nodes its place in the format's list.
    pub(in crate::mesh) order: &'static [u8],
}

pub(in crate::mesh) const fn cell(shape: CellShape, degree: usize, order: &'static [u8]) -> Option<Cell> {
    Some(Cell { shape, degree, order })
}

pub(in crate::mesh) const fn kind(
    code: u8,
    name: &'static str,
    dimension: usize,
    nodes: usize,
    vertices: usize,
    cell: Option<Cell>,
) -> Kind {
    Kind { code, name, dimension, nodes, vertices, cell }
}
