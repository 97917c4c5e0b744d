//! What can be wrong with a Gmsh file, and what is worth knowing of one that was read.

use std::fmt;

use thiserror::Error;

use crate::mesh::MeshError;

/// Where in a file something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, counted from 1.
    Line(usize),
    /// An offset in a binary file \[bytes\], counted from 0.
    Byte(usize),
}

/// Why a Gmsh file gives no mesh: which file, where in it, and what is wrong there.
#[derive(Clone, Debug, PartialEq)]
pub struct GmshError {
    /// The file's name, as it was given.
    pub file: String,
    /// Where, unless the problem is of the whole file.
    pub place: Option<Place>,
    /// The section, without its dollar sign.
    pub section: Option<String>,
    /// What is wrong.
    pub problem: GmshProblem,
}

/// What is wrong with a Gmsh file. Tags are the file's own numbers of nodes and elements.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GmshProblem {
    /// The file cannot be read.
    #[error("{reason}")]
    Unreadable {
        /// What the operating system says.
        reason: String,
    },
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
        /// What the file says.
        value: i64,
        /// What it should be.
        requirement: &'static str,
    },
    /// The file ends too early.
    #[error("the file ends where {expected} should follow")]
    Truncated {
        /// What is missing.
        expected: String,
    },
    /// Something else stands where a number, name or mark should.
    #[error("expected {expected}, found {found:?}")]
    Unexpected {
        /// What should stand there.
        expected: String,
        /// What stands there, shortened.
        found: String,
    },
    /// A count that the rest of the file cannot hold.
    #[error("{count} {what} are announced, but only {left} bytes are left")]
    Count {
        /// What is counted.
        what: &'static str,
        /// The count.
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
    /// A section stands twice.
    #[error("there is a second section ${section}")]
    RepeatedSection {
        /// Its name.
        section: String,
    },
    /// An entity stands twice in its section.
    #[error("{} {tag} is listed twice", entity(*dimension))]
    RepeatedEntity {
        /// Dimension of the entity.
        dimension: usize,
        /// Its tag.
        tag: i64,
    },
    /// A group has two names.
    #[error("the group {tag} of {} has two names", entities(*dimension))]
    RepeatedGroup {
        /// Dimension of the group.
        dimension: usize,
        /// Its tag.
        tag: i64,
    },
    /// A block belongs to an entity that is not listed, so that its groups are unknown.
    #[error("the block belongs to {} {tag}, which neither $Entities nor $PartitionedEntities lists", entity(*dimension))]
    MissingEntity {
        /// Dimension of the entity.
        dimension: usize,
        /// Its tag.
        tag: i64,
    },
    /// A code of an element type that Gmsh does not have, or that is not of first or second order.
    #[error(
        "elements of type {code} are not known; lines, triangles, quadrilaterals, tetrahedra, hexahedra, prisms and \
         pyramids of first and second order are"
    )]
    ElementType {
        /// The code.
        code: i64,
    },
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
    /// A type of cell that a mesh cannot have.
    #[error("element {element} is a {kind}; {advice}")]
    Unsupported {
        /// Its tag.
        element: u64,
        /// Its type.
        kind: &'static str,
        /// What helps.
        advice: &'static str,
    },
    /// Cells of two types.
    #[error(
        "the cells are of two types: element {first_element} is a {first}, element {second_element} a {second}; a mesh has one, or triangles and quadrilaterals of one order"
    )]
    Mixed {
        /// Type of the first cell.
        first: &'static str,
        /// The tag of the first cell.
        first_element: u64,
        /// The other type.
        second: &'static str,
        /// The tag of the first cell of the other type.
        second_element: u64,
    },
    /// No elements that could be cells.
    #[error("the file has no cells")]
    NoCells,
    /// The cells live in another number of dimensions.
    #[error(
        "the cells have {} (element {element} is a {kind}), but a mesh in {} was asked for",
        dimensions(*found),
        dimensions(*asked)
    )]
    Dimension {
        /// Dimension of the file's cells.
        found: usize,
        /// The D asked for.
        asked: usize,
        /// The first cell's tag.
        element: u64,
        /// Its type.
        kind: &'static str,
    },
    /// A plane mesh whose nodes do not have the same z.
    #[error(
        "nodes {first} and {second} of a plane mesh have z = {first_z} and z = {second_z}; all must be equal"
    )]
    NotPlane {
        /// Tag of the first node.
        first: u64,
        /// Its z \[length\].
        first_z: f64,
        /// Tag of a node with another z.
        second: u64,
        /// Its z \[length\].
        second_z: f64,
    },
    /// Two nodes with one tag.
    #[error("there are two nodes with the tag {tag}")]
    RepeatedNode {
        /// The tag.
        tag: u64,
    },
    /// Two elements with one tag.
    #[error("there are two elements with the tag {tag}")]
    RepeatedElement {
        /// The tag.
        tag: u64,
    },
    /// An element names a node that does not exist.
    #[error("element {element} names node {node}, which the file does not have")]
    MissingNode {
        /// The element's tag.
        element: u64,
        /// The node's tag.
        node: u64,
    },
    /// An element names a node twice.
    #[error("element {element} names node {node} twice")]
    NodeTwice {
        /// The element's tag.
        element: u64,
        /// The node's tag.
        node: u64,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {node} has a coordinate that is not finite: {position:?}")]
    NotFinite {
        /// The node's tag.
        node: u64,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// A cell stands twice in the same group.
    #[error("elements {first} and {second} are the same cell")]
    SameCell {
        /// Tag of one element.
        first: u64,
        /// Tag of the other.
        second: u64,
    },
    /// More than two cells share a facet.
    #[error("elements {elements:?} share one facet, with the nodes {nodes:?}; two can")]
    SharedFacet {
        /// Tags of the facet's nodes.
        nodes: Vec<u64>,
        /// Tags of the cells.
        elements: Vec<u64>,
    },
    /// The Jacobian determinant is not positive.
    #[error(
        "element {element} is inverted or degenerate: its Jacobian determinant is {determinant:e} near {position:?}{}",
        if *curved { " (a second-order cell may bend too much: option Mesh.HighOrderOptimize, or smaller cells)" } else { "" }
    )]
    Inverted {
        /// The element's tag.
        element: u64,
        /// The determinant \[length^D\].
        determinant: f64,
        /// Where.
        position: Vec<f64>,
        /// The cells are of second order.
        curved: bool,
    },
    /// An element of a group of facets is no facet of a cell.
    #[error("element {element} of the group \"{group}\" is not a facet of any cell")]
    StrayFacet {
        /// The element's tag.
        element: u64,
        /// The group's name.
        group: String,
    },
    /// A name stands for a group of cells and for one of facets.
    #[error("\"{name}\" names a group of {} and one of {}; the name of a region stands for one of them", entities(*cells), entities(*cells - 1))]
    NameTwice {
        /// The name.
        name: String,
        /// Dimension of the cells.
        cells: usize,
    },
    /// The mesh or a region cannot be made for another reason.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Something in a file that the mesh does not show. Nothing of it makes the mesh wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Note {
    /// Nodes that no cell uses, such as centres of circles: they are left out.
    UnusedNodes {
        /// How many.
        count: usize,
        /// The tag of the first one.
        first: u64,
    },
    /// A group of points, or of curves in space: regions hold cells and facets only.
    GroupLeftOut {
        /// The group's name.
        name: String,
        /// Its dimension.
        dimension: usize,
    },
    /// A group that has a name but no elements: there is no such region.
    EmptyGroup {
        /// The group's name.
        name: String,
        /// Its dimension.
        dimension: usize,
    },
    /// All cells of a surface ran clockwise; they were turned.
    Turned {
        /// The surface's tag.
        surface: i64,
        /// How many cells it has.
        cells: usize,
    },
    /// A group holds facets on the boundary and facets between cells: the latter are a region of their own.
    InteriorPart {
        /// The group's name, which the facets on the boundary have.
        name: String,
        /// The name of the region between cells.
        interior: String,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

impl fmt::Display for GmshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(place) = self.place {
            write!(f, ", {place}")?;
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

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::UnusedNodes { count, first } => {
                write!(f, "no cell uses {count} nodes, the first with the tag {first}; they are left out")
            }
            Note::GroupLeftOut { name, dimension } => write!(
                f,
                "the group \"{name}\" of {} is left out: regions hold cells and facets",
                entities(*dimension)
            ),
            Note::EmptyGroup { name, dimension } => {
                write!(f, "the group \"{name}\" of {} has no elements", entities(*dimension))
            }
            Note::Turned { surface, cells } => {
                write!(f, "the {cells} cells of surface {surface} ran clockwise and were turned")
            }
            Note::InteriorPart { name, interior } => write!(
                f,
                "the group \"{name}\" has facets on the boundary and between cells; the latter are the region \"{interior}\""
            ),
        }
    }
}

/// Gmsh's word for an entity of a dimension.
pub(super) fn entity(dimension: usize) -> &'static str {
    ["point", "curve", "surface", "volume"].get(dimension).copied().unwrap_or("entity")
}

fn entities(dimension: usize) -> &'static str {
    ["points", "curves", "surfaces", "volumes"].get(dimension).copied().unwrap_or("entities")
}

fn dimensions(dimension: usize) -> &'static str {
    ["no dimension", "one dimension", "two dimensions", "three dimensions"]
        .get(dimension)
        .copied()
        .unwrap_or("more dimensions")
}
