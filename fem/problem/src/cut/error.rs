//! Errors of cut bodies.

use thiserror::Error;

use crate::element::{CellShape, Elements};
use crate::space::Scope;

/// Errors of a body that is cut from a mesh, and of integrals over it.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum CutError {
    /// A level set function that is no scalar.
    #[error("the level set function has {found} components; it must be a scalar")]
    Components { found: usize },
    /// A level set function of other elements.
    #[error(
        "the level set function has {elements} {scope}; it must be continuous and of degree 1 or 2 on all cells"
    )]
    Elements { elements: Elements, scope: Scope },
    /// A value that is no number.
    #[error("the level set function is not finite at {position:?}")]
    NotFinite { position: Vec<f64> },
    /// Cells that are cut by functions of degree 1 only.
    #[error(
        "a level set function of degree 2 does not cut cells of the shape {shape:?}; it must be of degree 1, or on quadrilaterals or hexahedra"
    )]
    DegreeOnSimplices { shape: CellShape },
    /// Cells that meet smaller ones.
    #[error("a mesh with hanging nodes is not cut")]
    HangingNodes,
    /// A region with a name that the cut gives.
    #[error(
        "the mesh has a region \"{name}\", which is a name that a cut gives (\"cut\", \"ghost\", \"inside\")"
    )]
    Name { name: &'static str },
    /// Nothing is inside.
    #[error("the level set function is nowhere negative: there is no body")]
    Empty,
    /// A field or an assembler on another mesh.
    #[error("the level set function lives on another mesh than the assembler")]
    OtherMesh,
    /// An interface without a level set function.
    #[error("there is no interface without a level set function (`Assembler::cut_by`)")]
    NoCut,
    /// A way of integration that is not available on a cut mesh.
    #[error("{what} is not available on a cut mesh")]
    Refused { what: &'static str },
    /// Explicit points.
    #[error("explicit points say nothing about pieces of cells and facets; choose a degree")]
    ExplicitPoints,
    /// Interior facets whose parts inside move with the interface.
    #[error(
        "the interface passes through an interior facet near {position:?}; the derivative of such integrals is not known, except on the facets \"ghost\""
    )]
    InteriorFacet { position: Vec<f64> },
    /// Contact pairs on facets that are not whole.
    #[error("the surface has a facet near {position:?} that is not inside; contact pairs need whole facets")]
    PairedFacet { position: Vec<f64> },
    /// Data whose derivative in space is not known.
    #[error("the derivative of `{field}` in space is not known, or a value is not finite; give a gradient")]
    NoGradient { field: &'static str },
    /// Unknowns of a space that are none of cells.
    #[error("a space on facets has no unknowns of cells to be held")]
    OnFacets,
    /// A region that touches no part of the body.
    #[error("no part of the body touches {names}")]
    NoPart { names: String },
    /// A function that has changed by more than a band allows.
    #[error("near {position:?} the level set function has changed by more than the band's width")]
    LeftBand { position: Vec<f64> },
    /// Aggregates of a cut whose ghost facets a band keeps.
    #[error("a cut within a band keeps its ghost facets; aggregates are for cuts made with `Cut::by`")]
    Band,
    /// A cell whose polynomials have no values outside of it.
    #[error(
        "the cell near {position:?} is curved; aggregates need cells with straight edges, and of quadrilaterals parallelograms"
    )]
    CurvedAggregate { position: Vec<f64> },
    /// A surface that encloses no body.
    #[error("{text}")]
    Surface { text: String },
    /// A problem of the mesh.
    #[error("{text}")]
    Mesh { text: String },
    /// Constraints that contradict each other.
    #[error("{text}")]
    Constraints { text: String },
}
