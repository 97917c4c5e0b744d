//! The layout of the caller's lists, and the cells that they describe.

use crate::element::Lagrange;

/// The layout of the caller's lists of coordinates, coefficients and results. Nodes are numbered as in
/// [`Lagrange`].
#[derive(Clone, Debug)]
pub struct ElementLayout {
    /// The element of the geometry map.
    pub geometry: Lagrange,
    /// The element of the test function, and of the unknown.
    pub element: Lagrange,
    /// Coordinates of geometry node n of cell c start at `c * coordinate_stride + coordinate_offsets[n]`.
    pub coordinate_stride: usize,
    /// See there.
    pub coordinate_offsets: Vec<usize>,
    /// From the coefficients of one cell to those of the next.
    pub coefficient_stride: usize,
    /// Fields (by the names in the form) whose coefficients the caller lists. The unknown need not be there if
    /// the form is linear in it.
    pub fields: Vec<FieldLayout>,
    /// Row (and column) of component a of node n, at `n * components + a`.
    pub rows: Vec<usize>,
}

/// Coefficients of one field.
#[derive(Clone, Debug)]
pub struct FieldLayout {
    /// The field's name in the form.
    pub name: String,
    /// Its element.
    pub element: Lagrange,
    /// The coefficients of node n of cell c, one component after the other, start at
    /// `c * coefficient_stride + offsets[n]`.
    pub offsets: Vec<usize>,
}

/// Cells on which a kernel is run.
#[derive(Clone, Copy, Debug)]
pub struct ElementCells<'a> {
    /// Their number.
    pub count: usize,
    /// Coordinates of their geometry nodes \[length\].
    pub coordinates: &'a [f64],
    /// Coefficients of their fields.
    pub coefficients: &'a [f64],
    /// The local facet, the same for all, of integrals over facets.
    pub facet: usize,
}
