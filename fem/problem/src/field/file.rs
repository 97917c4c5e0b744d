//! Fields in files, to the last bit.
//!
//! A file is text. After a header, which says to which space the numbers belong, comes a line for each node with its
//! components, in the shortest decimal digits that read back to the same number, and a last line `end`:
//!
//! ```text
//! forms field 1
//! dimension 2
//! family with continuous values
//! degree 1
//! shape [2]
//! nodes 3
//! mesh 9b0f7c3e11d2a458
//! 0.0 1.0
//! 0.1 -2.5e-8
//! 0.30000000000000004 0.0
//! end
//! ```
//!
//! `mesh` is [`Mesh::checksum`](crate::mesh::Mesh::checksum) in hexadecimal digits.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;

use super::{Field, FieldError};
use crate::element::Elements;
use crate::instantiate::instantiate;
use crate::mesh::MeshError;
use crate::output::write_whole;
use crate::space::Space;

/// Errors of fields in files.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum FieldFileError {
    /// The file cannot be read.
    #[error("{path}: {source}", path = path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    /// The file cannot be written; the message names it.
    #[error(transparent)]
    Unwritable(std::io::Error),
    /// A line of the header that is not the one of the space.
    #[error("{path}: line {line} is \"{found}\"; for this space it is \"{expected}\"", path = path.display())]
    Header {
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Contents of the file there.
        found: String,
        /// Value that a field of the space would have.
        expected: String,
    },
    /// A field on one process's piece of a mesh.
    #[error(transparent)]
    Piece(MeshError),
    /// The file breaks off.
    #[error("{path} breaks off after line {line}", path = path.display())]
    BreaksOff {
        path: PathBuf,
        /// The last line.
        line: usize,
    },
    /// A line that does not hold a node's components.
    #[error("{path}: line {line} is \"{found}\" instead of {expected}", path = path.display())]
    Line {
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Contents of the file there.
        found: String,
        expected: String,
    },
    /// A coefficient is not finite.
    #[error("{path}: {source}", path = path.display())]
    Field {
        path: PathBuf,
        /// The node.
        source: FieldError,
    },
}

/// The line of a space's elements: of Lagrange elements their degree.
fn elements(elements: &Elements) -> String {
    match elements {
        Elements::Lagrange(degree) => format!("degree {degree}"),
        other => other.to_string(),
    }
}

/// The header of the fields of a space, line by line.
fn header<const D: usize>(space: &Space<D>) -> [String; 7] {
    [
        "forms field 1".to_owned(),
        format!("dimension {D}"),
        format!("family {}", space.scope()),
        elements(space.elements()),
        format!("shape {:?}", space.shape()),
        format!("nodes {}", space.node_count()),
        format!("mesh {:016x}", space.mesh().checksum()),
    ]
}

/// Processes with pieces of a mesh would write the same file, one over the other.
fn check_mesh<const D: usize>(space: &Space<D>) -> Result<(), FieldFileError> {
    let whole = space.mesh().without_pieces("a file of a field", "take a `PartCheckpoint`");
    whole.map_err(FieldFileError::Piece)
}

impl<const D: usize> Field<D> {
    /// A file with the field, which appears whole or not at all; [`Field::read`] reads it to the last bit.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?;
    /// let space = Space::vector(&mesh, 2)?;
    /// let u = Field::interpolate(&space, |x| [x[0].sin(), x[1] / 3.0])?;
    /// let path = std::env::temp_dir().join(format!("field_{}.txt", std::process::id()));
    /// u.write(&path)?;
    /// assert_eq!(Field::read(&path, &space)?.values(), u.values());
    /// # std::fs::remove_file(path)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldFileError::Unwritable`]; [`FieldFileError::Field`] for a coefficient that is not finite; [`FieldFileError::Piece`]
    /// on several processes that have pieces of a mesh.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), FieldFileError> {
        self.write_to(path.as_ref())
    }

    #[inline(never)]
    fn write_to(&self, path: &Path) -> Result<(), FieldFileError> {
        check_mesh(self.space())?;
        // What could not be read back is not written.
        Field::from_values(self.space(), self.values().to_vec())
            .map_err(|source| FieldFileError::Field { path: path.to_owned(), source })?;
        let write = |out: &mut dyn Write| {
            for line in header(self.space()) {
                writeln!(out, "{line}")?;
            }
            for node in self.values().chunks(self.space().components()) {
                for (component, value) in node.iter().enumerate() {
                    write!(out, "{}{value:?}", if component == 0 { "" } else { " " })?;
                }
                writeln!(out)?;
            }
            writeln!(out, "end")
        };
        write_whole(path, |out| write(out)).map_err(FieldFileError::Unwritable)
    }

    /// The field of a space that [`Field::write`] has written.
    ///
    /// # Errors
    /// [`FieldFileError`]: a file of another space or mesh, or with a mistake in it, by its line; a piece of a mesh.
    pub fn read(path: impl AsRef<Path>, space: &Arc<Space<D>>) -> Result<Self, FieldFileError> {
        Field::read_from(path.as_ref(), space)
    }

    #[inline(never)]
    fn read_from(path: &Path, space: &Arc<Space<D>>) -> Result<Self, FieldFileError> {
        check_mesh(space)?;
        let text = std::fs::read_to_string(path)
            .map_err(|source| FieldFileError::Unreadable { path: path.to_owned(), source })?;
        // A last line without its end may have lost some of its characters.
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let mut lines = whole.lines().zip(1..);
        let count = whole.lines().count();
        let mut next =
            || lines.next().ok_or_else(|| FieldFileError::BreaksOff { path: path.to_owned(), line: count });
        for expected in header(space) {
            let (found, line) = next()?;
            if found != expected {
                let (path, found) = (path.to_owned(), found.to_owned());
                return Err(FieldFileError::Header { path, line, found, expected });
            }
        }
        let mistake = |line: usize, found: &str, expected: String| FieldFileError::Line {
            path: path.to_owned(),
            line,
            found: found.to_owned(),
            expected,
        };
        let components = space.components();
        let mut values = Vec::with_capacity(space.unknowns());
        for _ in 0..space.node_count() {
            let (found, line) = next()?;
            let before = values.len();
            for word in found.split(' ') {
                let value = word.parse::<f64>();
                values.push(value.map_err(|_| mistake(line, found, format!("{components} numbers")))?);
            }
            if values.len() - before != components {
                return Err(mistake(line, found, format!("{components} numbers")));
            }
        }
        let (found, line) = next()?;
        if found != "end" {
            return Err(mistake(line, found, "\"end\"".to_owned()));
        }
        if let Some((found, line)) = lines.next() {
            return Err(mistake(line, found, "the end of the file".to_owned()));
        }
        Field::from_values(space, values)
            .map_err(|source| FieldFileError::Field { path: path.to_owned(), source })
    }
}

instantiate!(file: Field::<D>::write_to, Field::<D>::read_from);
