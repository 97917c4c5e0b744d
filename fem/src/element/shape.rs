//! Reference cells: vertices, facets, and how facets are parametrised.

/// The shape of a cell. Reference cells live on [0,1]: the unit simplex or the unit cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CellShape {
    /// Vertices (0,0) (1,0) (0,1).
    Triangle,
    /// Vertices (0,0) (1,0) (1,1) (0,1), counter-clockwise.
    Quadrilateral,
    /// Vertices (0,0,0) (1,0,0) (0,1,0) (0,0,1).
    Tetrahedron,
    /// Vertices of the lower face counter-clockwise, then those of the upper face.
    Hexahedron,
}
