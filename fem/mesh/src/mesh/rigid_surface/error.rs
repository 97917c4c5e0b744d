//! Errors of rigid surfaces and of the files that they come from.

use thiserror::Error;

use crate::mesh::MeshError;

/// Errors of a rigid surface.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum RigidSurfaceError {
    /// No facets.
    #[error("the surface has no facets")]
    Empty,
    /// A facet with a point that does not exist.
    #[error("facet {facet} names point {point}, but there are {count} points (numbered from 0)")]
    NoPoint {
        facet: usize,
        point: u32,
        /// Number of points.
        count: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("point {point} has a coordinate that is not finite: {position:?}")]
    NotFinite { point: usize, position: Vec<f64> },
    /// A facet whose corners lie at one place or on one line.
    #[error("facet {facet} at {position:?} is degenerate: it has no area, and no normal")]
    Degenerate {
        facet: usize,
        /// Its first corner.
        position: Vec<f64>,
    },
    /// Facets that do not agree on what is outward.
    #[error(
        "facet {facet} with the corners {corners:?} and its neighbour at {position:?} turn opposite sides outward, or more than two \
         facets meet there"
    )]
    Sides {
        /// One of the facets.
        facet: usize,
        corners: Vec<u32>,
        /// The middle of the edge between them, or the point.
        position: Vec<f64>,
    },
    /// An open surface where a closed one is needed.
    #[error(
        "the surface is open: {rim} edges have only one facet, the first is that of facet {facet} near {position:?} (facets are numbered \
         from 0 in the order of the file; corners at one place must agree to the last bit)"
    )]
    Open {
        /// Number of open edges.
        rim: usize,
        /// The first facet with one.
        facet: usize,
        /// The middle of its edge.
        position: Vec<f64>,
    },
    /// A closed surface whose outward side looks inward.
    #[error(
        "the surface is closed and encloses the volume {volume}: its outward side looks inward (`RigidSurface::new` takes such, for a \
         mould)"
    )]
    InsideOut {
        /// The volume \[length³\].
        volume: f64,
    },
    /// A region that the body does not have.
    #[error("{source}")]
    Region { source: MeshError },
    /// A body with curved facets.
    #[error(
        "the facets of \"{region}\" may be curved: the body's geometry has degree 2, and a rigid surface has flat facets"
    )]
    Curved { region: String },
    /// A binary STL file that is shorter or longer than its number of triangles says.
    #[error(
        "the STL file says that it has {triangles} triangles, which take {expected} bytes, but it has {found}{}",
        cut(*found, *expected)
    )]
    Length {
        /// Number of triangles that it says.
        triangles: u32,
        /// The length that goes with it \[bytes\].
        expected: u64,
        /// Its length \[bytes\].
        found: u64,
    },
    /// A file that is no STL file.
    #[error(
        "this is no STL file: it has {found} bytes, does not begin with \"solid\", and is too short for a binary header of 84"
    )]
    NoStl {
        /// Its length \[bytes\].
        found: u64,
    },
    /// Unexpected text in an STL file.
    #[error("line {line}: {found}, where {expected} should stand")]
    Text {
        /// The line, from 1.
        line: usize,
        /// The text found, quoted, or "the end of the file".
        found: String,
        expected: &'static str,
    },
    /// A triangle of an STL file that cannot be used.
    #[error("triangle {triangle} at {place}: {why}")]
    Triangle {
        /// Its number in the file, from 0.
        triangle: usize,
        /// "byte 84", "line 2".
        place: String,
        why: String,
    },
    /// A mistake in a file.
    #[error("{path}: {source}")]
    File { path: String, source: Box<RigidSurfaceError> },
    /// A file that cannot be read.
    #[error("{path}: {source}")]
    Read { path: String, source: std::io::Error },
}

/// The place at which a file breaks off, in words.
fn cut(found: u64, expected: u64) -> String {
    match found.checked_sub(84) {
        Some(data) if found < expected => {
            format!("; it breaks off in triangle {}, at byte {found}", data / 50)
        }
        _ => String::new(),
    }
}
