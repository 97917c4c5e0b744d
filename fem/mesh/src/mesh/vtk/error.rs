//! Errors of VTK files.

use std::fmt;

use thiserror::Error;

use crate::mesh::imported::{FilePosition, ImportProblem};

/// The reason why a VTK file gives no mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct VtkError {
    /// The file's name, as it was given.
    pub file: String,
    /// The problem.
    pub problem: VtkProblem,
}

/// Problems of a VTK file. Points and cells are counted from 0, as VTK does.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum VtkProblem {
    /// The file cannot be read.
    #[error("{reason}")]
    Unreadable { reason: String },
    /// No VTK file.
    #[error("this is no VTK file: it begins with {start:?}, neither with <VTKFile nor with # vtk DataFile")]
    NotVtk {
        /// Its first characters.
        start: String,
    },
    /// A VTK file of another sort.
    #[error("the file holds {found}; an unstructured grid of one piece is read")]
    NotOneGrid { found: String },
    /// Something else is found in the place of a number, a name or a mark, or the file ends.
    #[error("{position}: expected {expected}, found {found}")]
    Unexpected {
        position: FilePosition,
        expected: String,
        /// The text found, shortened.
        found: String,
    },
    /// A part of the file is missing.
    #[error("there is no {what}")]
    Missing {
        /// The missing item.
        what: String,
    },
    /// The values of an array cannot be read.
    #[error("array \"{array}\": {reason}")]
    Array { array: String, reason: String },
    /// A type of cell that VTK does not have, or a wrong number of points.
    #[error("cell {cell} is of type {code} and has {points} points; {advice}")]
    CellType {
        cell: usize,
        /// The code of its type.
        code: i64,
        points: usize,
        /// The supported types.
        advice: &'static str,
    },
    /// A cell's points do not lie in the connectivity.
    #[error("cell {cell} takes the entries from {start} to {end} of the connectivity, which has {length}")]
    Connectivity {
        cell: usize,
        /// The start of its points.
        start: i64,
        end: i64,
        /// Length of the connectivity.
        length: usize,
    },
    /// A cell names a point that does not exist.
    #[error("cell {cell} names point {point}, but there are {count} points (numbered from 0)")]
    PointRange {
        cell: usize,
        /// The number.
        point: i64,
        /// Number of points.
        count: usize,
    },
    /// The array that should hold the regions is not there.
    #[error("there is no array \"{array}\" on the cells; the file has {existing:?}")]
    NoRegionArray { array: String, existing: Vec<String> },
    /// The array that should hold the regions does not hold one whole number per cell.
    #[error("array \"{array}\" cannot hold regions: cell {cell} has {value} in it, which is no whole number")]
    NoRegionNumber { array: String, cell: usize, value: f64 },
    /// A number was given a name but no cell has it.
    #[error(
        "the region \"{name}\" would be empty: no {what} has the number {number}, and the numbers are {existing:?}"
    )]
    NoSuchNumber {
        name: String,
        /// "cell" or "facet".
        what: &'static str,
        number: i64,
        existing: Vec<i64>,
    },
    /// The content of the file gives no mesh.
    #[error(transparent)]
    Contents(#[from] ImportProblem),
}

impl VtkProblem {
    pub(super) fn array(array: &str, reason: impl Into<String>) -> Self {
        VtkProblem::Array { array: array.to_owned(), reason: reason.into() }
    }

    pub(super) fn missing(what: impl Into<String>) -> Self {
        VtkProblem::Missing { what: what.into() }
    }
}

impl fmt::Display for VtkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file, self.problem)
    }
}

impl std::error::Error for VtkError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        // The message holds the problem already.
        std::error::Error::source(&self.problem)
    }
}
