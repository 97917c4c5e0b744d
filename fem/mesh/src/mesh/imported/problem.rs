//! Problems of a file's content, and notes on a file that was read.

use std::fmt;

use thiserror::Error;

use crate::mesh::MeshError;

/// A position in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePosition {
    /// A line of a text file, counted from 1.
    Line(usize),
    /// An offset in a binary file \[bytes\], counted from 0.
    Byte(usize),
}

/// Result of a step of an import, whose error is a flaw of the file.
pub(super) type Result<T> = std::result::Result<T, Flaw>;

/// A problem, and where the file lists what it is about \[bytes\], if it is about one thing.
pub(in crate::mesh) struct Flaw {
    pub(in crate::mesh) at: Option<usize>,
    pub(in crate::mesh) problem: ImportProblem,
}

impl Flaw {
    pub(super) fn at(at: usize, problem: ImportProblem) -> Self {
        Flaw { at: Some(at), problem }
    }
}

impl<P: Into<ImportProblem>> From<P> for Flaw {
    fn from(problem: P) -> Self {
        Flaw { at: None, problem: problem.into() }
    }
}

/// A node or an element under the file's own number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// The format's word: "node", "point", "element" or "cell".
    pub what: &'static str,
    /// The number, or tag, that the file gives it.
    pub tag: u64,
}

/// Reasons why a file gives no mesh.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum ImportProblem {
    /// A type of cell that a mesh cannot have.
    #[error("{element} is a {kind}; {advice}")]
    Unsupported {
        element: Item,
        kind: &'static str,
        /// Help.
        advice: &'static str,
    },
    /// Cells of two types.
    #[error(
        "the cells are of two types: {first_element} is a {first}, {second_element} a {second}; a mesh has one, or triangles and quadrilaterals of one order"
    )]
    Mixed {
        /// Type of the first cell.
        first: &'static str,
        /// The first cell.
        first_element: Item,
        /// The other type.
        second: &'static str,
        /// The first cell of the other type.
        second_element: Item,
    },
    /// No elements that could be cells.
    #[error("the file has no cells{advice}")]
    NoCells {
        /// Help, where the file has groups.
        advice: &'static str,
    },
    /// The cells live in another number of dimensions.
    #[error(
        "the cells have {} ({element} is a {kind}), but a mesh in {} was asked for{advice}",
        dimensions(*found),
        dimensions(*asked)
    )]
    Dimension {
        /// Dimension of the file's cells.
        found: usize,
        /// The D asked for.
        asked: usize,
        /// The first cell.
        element: Item,
        kind: &'static str,
        /// Help, where the file has groups and none of cells.
        advice: &'static str,
    },
    /// A plane mesh whose nodes do not have the same z.
    #[error(
        "{}s {} and {} of a plane mesh have z = {first_z} and z = {second_z}; all must be equal",
        first.what, first.tag, second.tag
    )]
    NotPlane {
        /// The first node.
        first: Item,
        /// Its z \[length\].
        first_z: f64,
        /// A node with another z.
        second: Item,
        /// Its z \[length\].
        second_z: f64,
    },
    /// Two nodes or two elements with one tag.
    #[error("there are two {}s with the tag {}", item.what, item.tag)]
    Repeated {
        /// The second one.
        item: Item,
    },
    /// An element names a node that does not exist.
    #[error("{element} names {node}, which the file does not have")]
    MissingNode { element: Item, node: Item },
    /// An element names a node twice.
    #[error("{element} names {node} twice")]
    NodeTwice { element: Item, node: Item },
    /// A coordinate is NaN or infinite.
    #[error("{node} has a coordinate that is not finite: {position:?}")]
    NotFinite { node: Item, position: [f64; 3] },
    /// A cell occurs twice in the same group.
    #[error("{}s {} and {} are the same cell", first.what, first.tag, second.tag)]
    SameCell {
        /// One element.
        first: Item,
        second: Item,
    },
    /// More than two cells share a facet.
    #[error("{} share one facet, with the {}; two can", list(elements), list(nodes))]
    SharedFacet {
        /// The facet's nodes.
        nodes: Vec<Item>,
        /// The cells.
        elements: Vec<Item>,
    },
    /// The Jacobian determinant is not positive.
    #[error(
        "{element} is inverted or degenerate: its Jacobian determinant is {determinant:e} near {position:?}{advice}"
    )]
    Inverted {
        element: Item,
        /// The determinant \[length^D\].
        determinant: f64,
        position: Vec<f64>,
        /// Help, in brackets; empty for cells of first order.
        advice: &'static str,
    },
    /// An edge so short compared with the others that double precision does not tell its ends apart.
    #[error(
        "{element} is degenerate: its {} and {} are {length:e} apart, and its longest edge is {longest:e} long; double precision does not tell them apart",
        .nodes[0], .nodes[1]
    )]
    ShortEdge {
        element: Item,
        /// The ends of the edge.
        nodes: [Item; 2],
        /// Its length, the largest component \[length\].
        length: f64,
        /// That of the element's longest edge \[length\].
        longest: f64,
    },
    /// The Jacobian determinant nearly vanishes along a part of a cell: it could not be proved positive.
    #[error(
        "{element} is nearly degenerate: near {position:?} no better bound of its Jacobian determinant was found than {bound:e}, which is not positive"
    )]
    Undecided {
        element: Item,
        /// A lower bound of the determinant \[length^D\].
        bound: f64,
        position: Vec<f64>,
    },
    /// Two cells on one side of the facet that they share.
    #[error("{first} and {second} overlap: they lie on the same side of the facet with the {}", list(nodes))]
    SameSide {
        /// One cell.
        first: Item,
        second: Item,
        /// The facet's nodes.
        nodes: Vec<Item>,
    },
    /// Two cells have a facet at one place, and lie on the same side of it.
    #[error(
        "{first} and {second} overlap: they lie on the same side of facets that coincide, at {position:?}"
    )]
    Overlap {
        /// One cell.
        first: Item,
        second: Item,
        /// The facets' centre.
        position: Vec<f64>,
    },
    /// Two cells that share vertices, but not the node between them.
    #[error(
        "{} and {} have different {} between the {} that they share",
        .elements[0], .elements[1], list(nodes), list(vertices)
    )]
    MiddleNode {
        /// The two cells.
        elements: [Item; 2],
        /// The node of each.
        nodes: [Item; 2],
        /// The ends of the edge, or the corners of the face.
        vertices: Vec<Item>,
    },
    /// An element of a group of facets is no facet of a cell.
    #[error("{element} of the group \"{group}\" is not a facet of any cell")]
    StrayFacet { element: Item, group: String },
    /// A name belongs to a group of cells and to one of facets.
    #[error("\"{name}\" names a group of {} and one of {}; the name of a region stands for one of them", entities(*cells), entities(*cells - 1))]
    NameTwice {
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
        /// Their number.
        count: usize,
        /// The first one.
        first: Item,
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
    /// All cells of a surface or region ran clockwise; they were turned.
    Turned {
        /// The surface or region.
        part: String,
        /// Number of its cells.
        cells: usize,
    },
    /// Points at one place that cells do not share: the mesh is not connected there.
    Coincident {
        /// The number of those at the position of another one.
        count: usize,
        /// The first two at one place.
        first: [Item; 2],
    },
    /// Facets that coincide, and that the cells on their two sides do not share.
    Cracks {
        /// Number of pairs of facets.
        count: usize,
        /// The cells at the first one.
        first: [Item; 2],
    },
    /// Vertices on facets of cells that do not have them: nothing holds the two sides together there.
    HangingNodes {
        /// Their number.
        count: usize,
        /// The first one.
        node: Item,
        /// The cell on whose facet it lies.
        element: Item,
    },
    /// Cells of dimension D − 1 in a file that says nothing of regions: no facets are named.
    FacetsLeftOut {
        /// Their number.
        count: usize,
    },
    /// A group holds facets on the boundary and facets between cells: the latter are a region of their own.
    InteriorPart {
        /// The group's name, which the facets on the boundary have.
        name: String,
        /// The name of the region between cells.
        interior: String,
    },
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.what, self.tag)
    }
}

// "nodes [3, 4]".
fn list(items: &[Item]) -> String {
    let tags: Vec<u64> = items.iter().map(|item| item.tag).collect();
    format!("{}s {tags:?}", items.first().map_or("", |item| item.what))
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::UnusedNodes { count, first } => {
                write!(
                    f,
                    "no cell uses {count} {}s, the first of which is {first}; they are left out",
                    first.what
                )
            }
            Note::GroupLeftOut { name, dimension } => write!(
                f,
                "the group \"{name}\" of {} is left out: regions hold cells and facets",
                entities(*dimension)
            ),
            Note::EmptyGroup { name, dimension } => {
                write!(f, "the group \"{name}\" of {} has no elements", entities(*dimension))
            }
            Note::Turned { part, cells } => {
                write!(f, "the {cells} cells of {part} ran clockwise and were turned")
            }
            Note::Coincident { count, first: [first, second] } => write!(
                f,
                "{count} {}s stand where another one does, as {second} where {first} does, and cells do not share them",
                first.what
            ),
            Note::Cracks { count, first: [first, second] } => write!(
                f,
                "the mesh has cracks: facets of {first} and {second} coincide and are not shared; pairs of such facets: {count}"
            ),
            Note::HangingNodes { count, node, element } => write!(
                f,
                "the mesh has hanging nodes: {node} lies on a facet of {element}, which does not have it; such nodes: {count}"
            ),
            Note::FacetsLeftOut { count } => {
                write!(f, "{count} cells that may be facets belong to no region and are left out")
            }
            Note::InteriorPart { name, interior } => write!(
                f,
                "the group \"{name}\" has facets on the boundary and between cells; the latter are the region \"{interior}\""
            ),
        }
    }
}

/// The word for an entity of a dimension.
pub(in crate::mesh) fn entity(dimension: usize) -> &'static str {
    ["point", "curve", "surface", "volume"].get(dimension).copied().unwrap_or("entity")
}

pub(in crate::mesh) fn entities(dimension: usize) -> &'static str {
    ["points", "curves", "surfaces", "volumes"].get(dimension).copied().unwrap_or("entities")
}

pub(in crate::mesh) fn dimensions(dimension: usize) -> &'static str {
    ["no dimension", "one dimension", "two dimensions", "three dimensions"]
        .get(dimension)
        .copied()
        .unwrap_or("more dimensions")
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FilePosition::Line(line) => write!(f, "line {line}"),
            FilePosition::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

/// The beginning of what a file says, for a message.
pub(in crate::mesh) fn shortened(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
    if bytes.len() > 40 { format!("{text}…") } else { text.into_owned() }
}
