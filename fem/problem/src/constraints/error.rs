//! Errors of conditions.

use thiserror::Error;

use crate::element::Elements;
use crate::mesh::{Facet, MeshError};
use crate::space::Scope;

/// Errors of a condition. The constraints stay as they were.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum ConstraintsError {
    /// No such region.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Facets that could be joined only across bodies that share no vertex.
    #[error(
        "facet {} of cell {} (at {position:?}) lies on facet {} of cell {}, of a body that shares no vertex with its own: bodies that touch are \
         not joined; where they are one, let their cells share vertices",
        .facets[0].local, .facets[0].cell, .facets[1].local, .facets[1].cell
    )]
    SeparateBodies {
        /// The small facet, and the large one that it lies on.
        facets: [Facet; 2],
        /// The centre of the small facet's cell.
        position: Vec<f64>,
    },
    /// The value has another number of components than the space.
    #[error("{place}: the space has {space} components, but the prescribed value has {value}")]
    Components {
        place: String,
        /// Components of the space.
        space: usize,
        /// Components of the value.
        value: usize,
    },
    /// No such component.
    #[error("{place}: there is no component {component}; the space has {components} (numbered from 0)")]
    Component {
        /// The region or node.
        place: String,
        /// The component asked for.
        component: usize,
        /// Components of the space.
        components: usize,
    },
    /// The region has no nodes of the space: nothing would be prescribed.
    #[error("{place} has no nodes of the space, which has {elements} {scope}")]
    NoNodes {
        place: String,
        /// Elements of the space.
        elements: Elements,
        /// Scope of the space.
        scope: Scope,
    },
    /// Coefficients that are no values.
    #[error("{place}: the coefficients of {elements} are not values that can be prescribed")]
    NotNodal { place: String, elements: Elements },
    /// No node is near a point that is not finite.
    #[error("there is no node nearest to {point:?}")]
    NoNearest { point: Vec<f64> },
    /// No such node.
    #[error("there is no node {node}; the space has {count} (numbered from 0)")]
    Node {
        node: usize,
        /// Nodes of the space.
        count: usize,
    },
    /// A prescribed value is NaN or infinite.
    #[error("{place}: the value prescribed for component {component} at {position:?} is not finite: {value}")]
    NotFinite {
        /// The region or node.
        place: String,
        component: usize,
        position: Vec<f64>,
        value: f64,
    },
    /// The unknown is prescribed already, with another value.
    #[error(
        "{place}: component {component} at {position:?} is prescribed as {value}, but as {earlier} before"
    )]
    Conflict {
        /// The region or node.
        place: String,
        component: usize,
        position: Vec<f64>,
        /// The new value.
        value: f64,
        earlier: f64,
    },
    /// Together with earlier conditions it has no solution.
    #[error("{place} contradicts {earlier} at node {node}, {position:?}: they differ by {difference}")]
    Contradiction {
        /// The regions or node.
        place: String,
        earlier: String,
        node: usize,
        position: Vec<f64>,
        /// The remainder of the right-hand side after the earlier conditions.
        difference: f64,
    },
    /// A map that is no motion of a rigid body.
    #[error(
        "{place}: a rigid body does not move by {rotation:?} x + {translation:?}, which turns it inside out, stretches it or is not finite"
    )]
    NotRigid {
        place: String,
        /// The matrix, by rows.
        rotation: Vec<Vec<f64>>,
        translation: Vec<f64>,
    },
    /// Nodes that do not say how a body has moved.
    #[error(
        "the nodes of {place} fix no motion: they lie on a line or in a plane, are turned inside out or nowhere finite"
    )]
    NoMotion { place: String },
    /// A direction without a length.
    #[error("{place}: the normal at {position:?} is {normal:?}")]
    Normal { place: String, position: Vec<f64>, normal: Vec<f64> },
    /// A periodic node whose image is no node.
    #[error(
        "node {node} of the region \"{region}\", at {position:?}, has no partner on \"{other}\"; the nearest is \
         {distance:e} away from where it should be"
    )]
    NoPartner {
        /// The node's region.
        region: String,
        /// The region searched.
        other: String,
        node: usize,
        position: Vec<f64>,
        /// Distance between its image and the nearest node \[length\].
        distance: f64,
    },
    /// A periodic condition between nodes and themselves.
    #[error(
        "the regions \"{from}\" and \"{to}\" are not periodic under this map: it leaves all nodes where they are, such \
         as node {node} at {position:?}"
    )]
    OntoItself {
        /// The region that is mapped.
        from: String,
        /// The other region.
        to: String,
        node: usize,
        position: Vec<f64>,
    },
    /// A sum of no unknowns, or of too many.
    #[error(
        "{name}: {count} unknowns are related; one at least and {most} at most can be. A mean of more is an equation of an unknown of \
         the whole body (`Scope::Body`): add `integral(Omega, m * v + (u - value) * w)` to the form, m and w its unknown and test function"
    )]
    Terms {
        name: String,
        /// Unknowns in it.
        count: usize,
        /// The largest number.
        most: usize,
    },
    /// No such unknown.
    #[error("{name}: there is no unknown {unknown}; the space has {count} (numbered from 0)")]
    Unknown {
        name: String,
        /// The unknown asked for.
        unknown: usize,
        /// Unknowns of the space.
        count: usize,
    },
    /// A dependent unknown that other conditions have given already.
    #[error(
        "{name} cannot give unknown {unknown}, at {position:?}: {earlier} has given it, or those that it is to depend on"
    )]
    AlreadyGiven {
        name: String,
        /// The dependent unknown.
        unknown: usize,
        position: Vec<f64>,
        earlier: String,
    },
    /// A space whose cells share no nodes, or whose traces are not those of Lagrange elements.
    #[error("hanging nodes are those of continuous Lagrange elements; this space has {elements} {scope}")]
    NotContinuous {
        /// Elements of the space.
        elements: Elements,
        /// Scope of the space.
        scope: Scope,
    },
    /// A coefficient or value of a sum is NaN or infinite.
    #[error("{name}: a coefficient or the value is not finite: {number}")]
    SumNotFinite { name: String, number: f64 },
    /// The basis functions could not be integrated.
    #[error("{place}: {why}")]
    Integral {
        place: String,
        /// The error of assembly.
        why: String,
    },
}
