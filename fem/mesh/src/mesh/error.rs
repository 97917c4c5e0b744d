//! Errors of meshes.

use thiserror::Error;

use super::Facet;
use crate::element::{CellShape, ElementError, plurals};

/// Errors of a mesh or of a region of it.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum MeshError {
    /// The geometry map has no such degree.
    #[error(transparent)]
    Element(#[from] ElementError),
    /// The shape does not live in D dimensions.
    #[error("a mesh of {} cells has {} dimensions, not {dimension}", shape.name(), shape.dimension())]
    Dimension {
        shape: CellShape,
        /// The D asked for.
        dimension: usize,
    },
    /// Shapes whose facets do not meet.
    #[error(
        "{} and {} do not make one mesh: only triangles and quadrilaterals do",
        .shapes[0].plural(), .shapes[1].plural()
    )]
    ShapesTogether {
        /// Two of the shapes.
        shapes: [CellShape; 2],
    },
    /// Bodies that do not make one mesh.
    #[error("these bodies do not make one mesh: {why}")]
    Bodies { why: String },
    /// A feature that needs a mesh of one shape.
    #[error("{feature} needs a mesh of one shape; this one has {}", plurals(shapes))]
    SeveralShapes { feature: &'static str, shapes: Vec<CellShape> },
    /// A feature of triangles and tetrahedra alone.
    #[error("{feature} is of triangles and tetrahedra; this mesh has {} (`Mesh::simplices` divides them)", shape.plural())]
    NotSimplices { feature: &'static str, shape: CellShape },
    /// A feature that meshes with rigid surfaces do not have.
    #[error("{what} is of bodies alone, and this mesh has the rigid surface \"{name}\": add it afterwards")]
    RigidSurface {
        /// The first rigid surface.
        name: String,
        what: &'static str,
    },
    /// A surface that no process has whole.
    #[error(
        "the surface \"{name}\" is divided among processes; name it in `part.with_surfaces(..)` before spaces are made"
    )]
    DividedSurface {
        /// Name of the surface.
        name: String,
    },
    /// A feature that needs a whole mesh.
    #[error("{what} is not available on a mesh that is divided among processes; {instead}")]
    Piece {
        what: &'static str,
        /// Advice.
        instead: &'static str,
    },
    /// A feature for quadrilaterals and hexahedra.
    #[error("{feature} is of quadrilaterals and hexahedra; this mesh has {} (`BisectedMesh` refines them)", shape.plural())]
    NotTensorProducts { feature: &'static str, shape: CellShape },
    /// A feature that meshes with hanging nodes do not have.
    #[error(
        "{what} is of meshes whose cells share whole facets; facet {} of cell {} is a part of facet {} of cell {}",
        .facets[0].local, .facets[0].cell, .facets[1].local, .facets[1].cell
    )]
    FacetParts {
        /// The small facet and the larger one.
        facets: [Facet; 2],
        what: &'static str,
    },
    /// A rigid surface as a region of cells to integrate over.
    #[error(
        "\"{name}\" is a rigid surface: the cell that carries it is no part of a body, and nothing is integrated over it"
    )]
    NoBody { name: String },
    /// No cells.
    #[error("the mesh has no cells")]
    Empty,
    /// The list of node numbers is not a whole number of cells.
    #[error(
        "the cells list {length} node numbers, which is not a multiple of {per_cell}, the nodes of a cell"
    )]
    CellLength {
        /// Length of the list.
        length: usize,
        /// Nodes of a cell.
        per_cell: usize,
    },
    /// More nodes or cells than `u32` counts.
    #[error("the mesh has more {what} than 4294967295")]
    TooLarge {
        /// "nodes" or "cells".
        what: &'static str,
    },
    /// The system has not enough memory.
    #[error("there is not enough memory for {count} {what}, {:.1} GB", *bytes as f64 / 1e9)]
    NoMemory {
        /// "nodes" or "cells".
        what: &'static str,
        count: usize,
        /// Memory that they need \[bytes\].
        bytes: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {node} has a coordinate that is not finite: {position:?}")]
    NotFinite { node: usize, position: Vec<f64> },
    /// A list has not one entry per node.
    #[error("{given} positions were given, but the mesh has {count} nodes")]
    NodeCount {
        given: usize,
        /// Number of nodes.
        count: usize,
    },
    /// A cell names a node that does not exist.
    #[error("cell {cell} names node {node}, but the mesh has {count} nodes (numbered from 0)")]
    NodeRange {
        cell: usize,
        node: u32,
        /// Number of nodes.
        count: usize,
    },
    /// A cell names a node twice.
    #[error("cell {cell} names node {node} twice")]
    RepeatedNode { cell: usize, node: u32 },
    /// The Jacobian determinant is not positive.
    #[error(
        "cell {cell} is inverted or degenerate: its Jacobian determinant is {determinant:e} near {position:?}"
    )]
    Inverted {
        cell: usize,
        /// The determinant \[length^D\].
        determinant: f64,
        position: Vec<f64>,
    },
    /// An edge so short compared with the others that double precision does not tell its ends apart.
    #[error(
        "cell {cell} is degenerate: its nodes {} and {} are {length:e} apart, and its longest edge is {longest:e} long; double \
         precision does not tell them apart",
        .nodes[0], .nodes[1]
    )]
    ShortEdge {
        cell: usize,
        /// The ends of the edge.
        nodes: [u32; 2],
        /// Its length, the largest component \[length\].
        length: f64,
        /// That of the cell's longest edge \[length\].
        longest: f64,
    },
    /// The Jacobian determinant nearly vanishes along a part of a cell: it could not be proved positive.
    #[error(
        "cell {cell} is nearly degenerate: near {position:?} no better bound of its Jacobian determinant was found \
         than {bound:e}, which is not positive"
    )]
    Undecided {
        cell: usize,
        /// A lower bound of the determinant \[length^D\].
        bound: f64,
        position: Vec<f64>,
    },
    /// Two cells on one side of the facet that they share.
    #[error(
        "cells {} and {} overlap: they lie on the same side of the facet that they share, with the vertices \
         {vertices:?}",
        .cells[0], .cells[1]
    )]
    SameSide {
        /// The two cells.
        cells: [u32; 2],
        /// The facet's node numbers, as the first cell has them.
        vertices: Vec<u32>,
    },
    /// Two cells that share vertices, but not the node between them.
    #[error(
        "cells {} and {} name different nodes, {} and {}, between the vertices {vertices:?} that they share",
        .cells[0], .cells[1], .nodes[0], .nodes[1]
    )]
    MiddleNode {
        /// The two cells.
        cells: [u32; 2],
        /// The node of each.
        nodes: [u32; 2],
        /// The ends of the edge, or the corners of the face.
        vertices: Vec<u32>,
    },
    /// A vertex in a facet of a cell that does not have it.
    #[error(
        "node {node} at {position:?} lies on facet {} of cell {}, which does not have it as a vertex: nothing would \
         hold the two sides together there (`Mesh::from_nonconforming_blocks` takes such meshes)",
        facet.local, facet.cell
    )]
    HangingNode { node: usize, position: Vec<f64>, facet: Facet },
    /// A facet that lies on another one in part only.
    #[error(
        "facet {} of cell {} and facet {} of cell {} lie on each other in part, at {position:?}: neither holds the other",
        .facets[0].local, .facets[0].cell, .facets[1].local, .facets[1].cell
    )]
    NotNested {
        /// The two facets.
        facets: [Facet; 2],
        /// A vertex of the first one on the other.
        position: Vec<f64>,
    },
    /// Two cells have a facet at one place, and lie on the same side of it.
    #[error(
        "cells {} and {} overlap: they lie on the same side of facets that coincide, at {position:?}",
        .cells[0], .cells[1]
    )]
    Overlap {
        /// The two cells.
        cells: [u32; 2],
        /// The facets' centre.
        position: Vec<f64>,
    },
    /// A listed cell that does not exist.
    #[error("region \"{name}\": there is no cell {cell}; the mesh has {count} cells (numbered from 0)")]
    NoCell {
        /// The region's name.
        name: String,
        cell: u32,
        /// Number of cells.
        count: usize,
    },
    /// A marked cell that does not exist.
    #[error("cell {cell} is marked, but the mesh has {count} cells (numbered from 0)")]
    MarkedCell {
        cell: u32,
        /// Number of cells.
        count: usize,
    },
    /// A listed facet that is not on the boundary.
    #[error("region \"{name}\": facet {local} of cell {cell} does not exist or is not on the boundary")]
    NotExterior {
        /// The region's name.
        name: String,
        cell: u32,
        /// Local facet number.
        local: u8,
    },
    /// A listed facet that is not between two cells.
    #[error("region \"{name}\": facet {local} of cell {cell} does not exist or is not between two cells")]
    NotInterior {
        /// The region's name.
        name: String,
        cell: u32,
        /// Local facet number.
        local: u8,
    },
    /// The vertices of two sides of a facet do not run in the same order around it.
    #[error(
        "cells {} and {} share the vertices of a facet, but not in the same order around it",
        .cells[0], .cells[1]
    )]
    TwistedFacet {
        /// The two cells.
        cells: [u32; 2],
    },
    /// More than two cells share a facet.
    #[error("the facet with vertices {vertices:?} belongs to more than two cells: {cells:?}")]
    SharedFacet {
        /// Its node numbers.
        vertices: Vec<u32>,
        cells: Vec<u32>,
    },
    /// No such cell region.
    #[error("there is no cell region \"{name}\"; the mesh has {}", quoted(existing))]
    UnknownCellRegion { name: String, existing: Vec<String> },
    /// No such facet region.
    #[error(
        "there is no facet region \"{name}\"; the mesh has {}{}",
        quoted(existing),
        kind(*interior, name, "interior facets, which have two sides")
    )]
    UnknownFacetRegion {
        name: String,
        existing: Vec<String>,
        /// There is a region of interior facets of this name.
        interior: bool,
    },
    /// No such region of interior facets.
    #[error(
        "there is no region \"{name}\" of interior facets; the mesh has {}{}",
        quoted(existing),
        kind(*exterior, name, "exterior facets, which have one side only")
    )]
    UnknownInteriorRegion {
        name: String,
        existing: Vec<String>,
        /// There is a region of exterior facets of this name.
        exterior: bool,
    },
    /// Neither a cell region nor a facet region.
    #[error(
        "there is no region \"{name}\"; the mesh has the cell regions {}, the facet regions {} and the \
         interior facet regions {}",
        quoted(cells),
        quoted(facets),
        quoted(interior)
    )]
    UnknownRegion {
        name: String,
        /// The cell regions that exist.
        cells: Vec<String>,
        /// The facet regions that exist.
        facets: Vec<String>,
        /// The regions of interior facets that exist.
        interior: Vec<String>,
    },
    /// The name is taken.
    #[error("the mesh already has a region \"{name}\"")]
    RegionExists { name: String },
    /// A rigid surface whose points are all inside the bodies, where no surface of theirs can face it.
    #[error(
        "the rigid surface \"{name}\" lies inside a body: all of its points, the first at {position:?}, are in cells that do not \
         reach the boundary. Put it beside the bodies"
    )]
    InsideBody {
        name: String,
        /// Its first point \[length\].
        position: Vec<f64>,
    },
    /// The new region would have no member.
    #[error("the region \"{name}\" would be empty: no {entity} satisfies its condition")]
    EmptyRegion {
        name: String,
        /// "cell" or "facet".
        entity: &'static str,
    },
    /// A generator's parameter is out of range.
    #[error("{parameter} = {value} is not possible: {requirement}")]
    Parameter { parameter: &'static str, value: String, requirement: &'static str },
}

fn kind(exists: bool, name: &str, what: &str) -> String {
    if exists { format!(" (\"{name}\" consists of {what})") } else { String::new() }
}

fn quoted(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}
