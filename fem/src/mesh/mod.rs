//! Meshes with named regions.

use std::collections::BTreeMap;

use crate::element::CellShape;

/// An exterior facet: the cell that owns it and its local number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Cell index.
    pub cell: u32,
    /// Local facet number in the cell's shape.
    pub local: u8,
}

/// A mesh of cells of one shape in D dimensions, with isoparametric geometry of degree 1 or 2.
/// Geometry nodes of a cell stand in the order of [`crate::element::Lagrange`].
#[derive(Clone, Debug)]
pub struct Mesh<const D: usize> {
    /// Shape of every cell.
    pub(crate) shape: CellShape,
    /// Degree of the geometry map.
    pub(crate) degree: usize,
    /// Node coordinates \[length\].
    pub(crate) nodes: Vec<[f64; D]>,
    /// Node numbers, cell after cell.
    pub(crate) cells: Vec<u32>,
    /// Named sets of cells.
    pub(crate) cell_regions: BTreeMap<String, Vec<u32>>,
    /// Named sets of facets.
    pub(crate) facet_regions: BTreeMap<String, Vec<Facet>>,
}
