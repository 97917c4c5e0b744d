//! Reasons why a `.vtu` file cannot be written.

use thiserror::Error;

use crate::element::Elements;
use crate::space::Scope;

/// Errors of writing a `.vtu` file.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum VtuError {
    /// Data of the wrong length.
    #[error("\"{name}\" has {found} values where {expected} are needed")]
    Length {
        /// Name of the data array.
        name: String,
        expected: usize,
        found: usize,
    },
    /// Values without components.
    #[error("\"{name}\" has {components} components")]
    Components {
        /// Name of the data array.
        name: String,
        /// Number of components.
        components: usize,
    },
    /// A value or a coordinate that is not a finite number.
    #[error("value {index} of \"{name}\" is {value}")]
    NotFinite {
        /// Name of the data array.
        name: String,
        /// Number of the point or cell.
        index: usize,
        value: f64,
    },
    /// Two arrays of the same name at the points or at the cells.
    #[error("there are two data arrays \"{name}\"")]
    Twice {
        /// Name of the data arrays.
        name: String,
    },
    /// A field that has no values in cells.
    #[error("the field \"{name}\" lives on the facets of \"{region}\" alone, and the file shows cells")]
    OnFacets {
        /// Name of the data array.
        name: String,
        /// The facet region of its space.
        region: String,
    },
    /// A field that is not known in all cells.
    #[error("\"{name}\" has {elements} {scope}, which .vtu files have no place for")]
    Scope { name: String, elements: Elements, scope: Scope },
    /// A field on another mesh.
    #[error("the field \"{name}\" lives on another mesh")]
    OtherMesh {
        /// Name of the data array.
        name: String,
    },
    /// No region of cells, or one that holds a cell of another one.
    #[error("the region \"{region}\" has no number of its own: {reason}")]
    Region { region: String, reason: String },
    /// A path without the name of a file.
    #[error("\"{}\" names no .pvd file", path.display())]
    Series { path: std::path::PathBuf },
    /// A piece of a mesh without the processes that have the others.
    #[error(transparent)]
    Mesh(#[from] crate::mesh::MeshError),
    /// Other processes failed, or write something else.
    #[error("a .vtu file of several processes: {source}")]
    Processes {
        /// The failure.
        source: crate::solve::CommunicationError,
    },
    /// The file cannot be written.
    #[error("the .vtu file cannot be written: {source}")]
    Write {
        /// The system's error, with the name of the file.
        source: std::io::Error,
    },
}
