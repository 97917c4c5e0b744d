//! Names of facets, by a cell and a number in it.

/// A facet of a cell: the cell that owns it and its local number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Cell index.
    pub cell: u32,
    /// Local facet number in the cell's shape.
    pub local: u8,
}
