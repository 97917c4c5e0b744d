//! Errors of Gmsh files.

use std::fmt;

use thiserror::Error;

use crate::mesh::imported::{FilePosition, ImportProblem, dimensions, entities, entity};

/// The reason why a Gmsh file gives no mesh: the file, the position in it, and the problem there.
#[derive(Clone, Debug, PartialEq)]
pub struct GmshError {
    /// The file's name, as it was given.
    pub file: String,
    /// Where, unless the problem is of the whole file.
    pub position: Option<FilePosition>,
    /// The section, without its dollar sign.
    pub section: Option<String>,
    /// The problem.
    pub problem: GmshProblem,
}

/// Problems of a Gmsh file. Tags are the file's own numbers of nodes and elements.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum GmshProblem {
    /// The file cannot be read.
    #[error("{reason}")]
    Unreadable { reason: String },
    /// No Gmsh file.
    #[error("this is no Gmsh mesh: it begins with {start:?}, not with $MeshFormat")]
    NotGmsh {
        /// Its first characters.
        start: String,
    },
    /// Another version of the format.
    #[error("version {version} of the MSH format is not read; write 4.1 or 2.2 (option Mesh.MshFileVersion)")]
    Version {
        /// The file's version.
        version: String,
    },
    /// A field of the header has no meaning.
    #[error("{field} = {value} is not possible: {requirement}")]
    Header {
        /// "file-type", "data-size" or "byte order".
        field: &'static str,
        /// The value in the file.
        value: i64,
        requirement: &'static str,
    },
    /// The file ends too early.
    #[error("the file ends where {expected} should follow")]
    Truncated {
        /// The missing item.
        expected: String,
    },
    /// Something else is found in the place of a number, name or mark.
    #[error("expected {expected}, found {found:?}")]
    Unexpected {
        expected: String,
        /// The text found, shortened.
        found: String,
    },
    /// A count that the rest of the file cannot hold.
    #[error("{count} {what} are announced, but only {left} bytes are left")]
    Count {
        /// The items counted.
        what: &'static str,
        count: u64,
        /// Bytes left in the file.
        left: usize,
    },
    /// Blocks that do not sum up to the count of their section.
    #[error("{announced} {what} are announced, but the blocks hold {found}")]
    Sum {
        /// "nodes" or "elements".
        what: &'static str,
        /// The count of the section.
        announced: u64,
        /// The sum of the blocks' counts, as far as they were read.
        found: u64,
    },
    /// A section is missing.
    #[error("there is no section ${section}")]
    MissingSection {
        /// Its name.
        section: &'static str,
    },
    /// Nodes with parameters in the old version.
    #[error("version 2.2 with parameters of nodes is not read (option Mesh.SaveParametric = 0)")]
    ParametricNodes,
    /// A section occurs twice.
    #[error("there is a second section ${section}")]
    RepeatedSection {
        /// Its name.
        section: String,
    },
    /// An entity occurs twice in its section.
    #[error("{} {tag} is listed twice", entity(*dimension))]
    RepeatedEntity {
        /// Dimension of the entity.
        dimension: usize,
        tag: i64,
    },
    /// A group has two names.
    #[error("the group {tag} of {} has two names", entities(*dimension))]
    RepeatedGroup {
        /// Dimension of the group.
        dimension: usize,
        tag: i64,
    },
    /// A block belongs to an entity that is not listed, so that its groups are unknown.
    #[error("the block belongs to {} {tag}, which neither $Entities nor $PartitionedEntities lists", entity(*dimension))]
    MissingEntity {
        /// Dimension of the entity.
        dimension: usize,
        tag: i64,
    },
    /// A code of an element type that Gmsh does not have, or that is not of first or second order.
    #[error(
        "elements of type {code} are not known; lines, triangles, quadrilaterals, tetrahedra, hexahedra, prisms and \
         pyramids of first and second order are"
    )]
    ElementType { code: i64 },
    /// An element in a block of another dimension.
    #[error("the block belongs to {} {tag}, but holds elements of {} ({kind})", entity(*dimension), dimensions(*found))]
    BlockDimension {
        /// Dimension of the entity.
        dimension: usize,
        /// The entity's tag.
        tag: i64,
        /// The type of the elements.
        kind: &'static str,
        /// Their dimension.
        found: usize,
    },
    /// The content of the file gives no mesh.
    #[error(transparent)]
    Contents(#[from] ImportProblem),
}

impl fmt::Display for GmshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(position) = self.position {
            write!(f, ", {position}")?;
        }
        if let Some(section) = &self.section {
            write!(f, ", in ${section}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for GmshError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        // The message holds the problem already.
        std::error::Error::source(&self.problem)
    }
}
