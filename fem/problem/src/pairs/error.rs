//! Errors of contact pairs.

use thiserror::Error;

use crate::mesh::MeshError;
use crate::quadrature::QuadratureError;

/// Reasons why surfaces cannot be paired, or kernels not run on their pairs.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PairError {
    /// A surface that the mesh does not have.
    #[error("{source}")]
    Surface {
        /// The mesh's error, which lists the names that exist.
        source: MeshError,
    },
    /// A pairing without surfaces.
    #[error("no surfaces were given")]
    NoSurfaces,
    /// A surface without facets.
    #[error("the surface \"{surface}\" has no facets")]
    Empty {
        /// Its name.
        surface: String,
    },
    /// Two surfaces that have facets in common, but are not the same.
    #[error(
        "\"{own}\" and \"{opposite}\" have {count} facets in common, one of them at {position:?}; for self contact give \
         one name twice (`Pairing::within`)"
    )]
    Overlap {
        /// The surface that is integrated over.
        own: String,
        /// The opposite one.
        opposite: String,
        /// Number of facets in both.
        count: usize,
        /// The centre of the first.
        position: Vec<f64>,
    },
    /// A function of position among the data that is not the own body's on its surface.
    #[error(
        "`{field}` jumps at the surface \"{surface}\": at {position:?} it is {} on it and {} in the cell behind it. Where bodies touch, a \
         function of position does not know which of them is meant: give a field with a value for each cell \
         (`Given::field(&Field::interpolate(&Space::discontinuous_scalar(&mesh, 0)?, ..)?)`)",
        .values[0],
        .values[1]
    )]
    Jump {
        /// Name of the data member.
        field: &'static str,
        /// The surface that is integrated over.
        surface: String,
        /// The centre of a facet.
        position: Vec<f64>,
        /// The values there, and just inside of the cell.
        values: [f64; 2],
    },
    /// A rigid surface that is to be integrated over.
    #[error(
        "the surface \"{surface}\" is rigid: there is nothing to integrate over on it. Let a body face it (`Pairing::onto(body, \
         \"{surface}\")`, with the whole of the integral on the body's side)"
    )]
    RigidSide {
        /// Its name.
        surface: String,
    },
    /// A rigid surface whose nodes are displaced by what is no affine map.
    #[error(
        "the rigid surface \"{surface}\" is bent: a node of the cell that carries it is {away:e} away from where the others put it. \
         Let all of its nodes follow one motion (`Constraints::move_rigidly`, `Constraints::rigid_body`)"
    )]
    Bent {
        /// Its name.
        surface: String,
        /// The distance \[length\].
        away: f64,
    },
    /// A reach that is not positive and finite.
    #[error("the reach is {reach}; it must be a positive length")]
    Reach {
        /// The reach given.
        reach: f64,
    },
    /// A pairing without contact pairs.
    #[error(
        "no point of \"{own}\" faces \"{opposite}\" within reach ({met} points met it from behind or further away)"
    )]
    NoPartners {
        /// The surface that is integrated over.
        own: String,
        /// The opposite one.
        opposite: String,
        /// Points whose surface was found, but from behind or beyond the reach.
        met: usize,
    },
    /// A quadrature rule that does not exist or is not accepted.
    #[error("{source}")]
    Quadrature {
        /// The problem of the rule.
        source: QuadratureError,
    },
    /// A history of pairs that is asked for as one of a region.
    #[error(
        "a history of contact pairs of fixed points is made by `history_on_pairs`, one of own points whose opposite points slide by \
         `history_on_sliding_pairs`"
    )]
    History,
    /// A history at the points of moving segments.
    #[error(
        "the points of moving segments move along the own facets and have no history; leave out `.at(PairQuadrature::Pieces)`, so that the \
         points of whole facets slide"
    )]
    HistoryOnSegments,
    /// An own and an opposite facet that a pairing pairs twice, so that a history cannot tell their points.
    #[error(
        "a history has values for each own and opposite facet once, and this pairing has some of them twice"
    )]
    Twice,
    /// An opposite facet whose corners, as an own facet in space sees them, are not those of a convex polygon, or one of degree two that is folded there.
    #[error(
        "an opposite facet is folded, or no convex polygon, as the own facet at {position:?} sees it, and cannot be cut into pieces: refine, or \
         leave out `.at(PairQuadrature::Pieces)`"
    )]
    SegmentsFolded {
        /// The middle of the own facet.
        position: Vec<f64>,
    },
    /// An opposite facet in space that hides a part of another one.
    #[error(
        "an opposite facet hides a part of another one from the own facet at {position:?}, so that neither is cut into pieces: lower the \
         reach (`Pairing::within_reach`), let the pairing have one of them, or leave out `.at(PairQuadrature::Pieces)`"
    )]
    SegmentsHidden {
        /// The middle of what would see the hidden facet.
        position: Vec<f64>,
    },
    /// Moving segments of facets whose positions have too high a degree.
    #[error(
        "the facets of \"{surface}\" have a degree above two and cannot be cut where opposite nodes slide: take displacements and a mesh of \
         degree one or two, or leave out `.at(PairQuadrature::Pieces)`"
    )]
    SegmentsOfDegree {
        /// The surface with such facets.
        surface: String,
    },
    /// Data without a derivative that are read at the points of moving segments.
    #[error(
        "the points of moving segments move with the displacement, and `{field}` has no derivative along their motion: give a function of position \
         with its gradient or a field, or leave out `.at(PairQuadrature::Pieces)`"
    )]
    NoGradient {
        /// Name of the data member.
        field: &'static str,
    },
    /// A derivative by a displacement that moves points, which it holds.
    #[error(
        "the points of moving segments move with the surfaces, and this derivative by what displaces them holds them: it is not that of what is \
         assembled. Differentiate by the shape or a state, once, in the direction of a test function, in a form that does not depend on unknowns; take \
         the transposed tangent of the residual (as `LoadHistory` does); write an energy of means as a form (`derivative(energy(u), u, v)` of the \
         unknown u); or leave out `.at(PairQuadrature::Pieces)`"
    )]
    HeldPoints,
    /// The residual of an energy over moving segments in space, whose points have no second derivatives.
    #[error(
        "an energy over moving segments has a residual and a tangent in the plane only: in space write it as a form (`derivative(energy(u), u, v)` \
         of the unknown u), or leave out `.at(PairQuadrature::Pieces)`"
    )]
    EnergyInSpace,
    /// Data of an energy without second derivatives that are read at the points of moving segments.
    #[error(
        "the tangent of an energy needs second derivatives along the motion of the points of moving segments, and `{field}` has none: give a field, \
         write the energy as a form (`derivative(energy(u), u, v)` of the unknown u), or leave out `.at(PairQuadrature::Pieces)`"
    )]
    NoSecondDerivative {
        /// Name of the data member.
        field: &'static str,
    },
    /// Dual functions over moving covers where they are neither unknowns nor test functions.
    #[error(
        "the dual functions of `{field}` change with the cover of moving segments: only tangents by unknowns have that change. \
         Take `Elements::Bernstein(1)`, or leave out `.at(PairQuadrature::Pieces)`"
    )]
    DualFunctions {
        /// Name of the field.
        field: &'static str,
    },
    /// A region of pairs without surfaces.
    #[error("the region says no surfaces; give a `Pairing` (`at_pairs` evaluates derived fields there)")]
    NoPairing,
    /// Something else than a field on a space of cells as a displacement of surfaces.
    #[error(
        "`{field}` displaces surfaces and must be a field on a space of cells with the traces of Lagrange elements"
    )]
    NoDisplacement {
        /// Its name in the form.
        field: &'static str,
    },
    /// Displacements at both ends of a motion in spaces that are not the same.
    #[error("a motion goes from one displacement to another in the same space")]
    TwoSpaces,
    /// An approach along no direction, or by an overlap that is no number.
    #[error(
        "a body cannot approach along {direction:?} with an overlap of {overlap}; both must be finite, the direction not zero"
    )]
    Approach {
        /// The direction given.
        direction: Vec<f64>,
        /// The overlap given.
        overlap: f64,
    },
    /// Cells that move to which both surfaces belong, or neither, or a part of one.
    #[error(
        "of the surfaces \"{own}\" and \"{opposite}\" one must belong to the cells \"{moving}\" that move, and the other not"
    )]
    Moving {
        /// The cells that move.
        moving: String,
        /// The surface that is integrated over.
        own: String,
        /// The opposite one.
        opposite: String,
    },
    /// Surfaces that do not meet along a direction.
    #[error("the cells \"{moving}\" meet no opposite surface along {direction:?}")]
    NeverMeet {
        /// The cells that move.
        moving: String,
        /// The unit vector along which they were to move.
        direction: Vec<f64>,
    },
    /// A point that gets deeper behind the opposite surface, on the way from one displacement to another, than half of what contact
    /// can see there: its reach, or the opposite body's thickness.
    #[error(
        "on the way from one displacement to the other, at {part} of it, the point at {position:?} lies {depth:e} behind the opposite \
         surface, where contact sees {visible:e} deep: it may have passed through. Take a smaller step (`LoadSteps` halves it), or a \
         larger reach where that is what ends"
    )]
    Tunnelling {
        /// The point before it is displaced \[length\].
        position: Vec<f64>,
        /// Its depth behind the surface \[length\].
        depth: f64,
        /// The smaller of its reach and the opposite body's thickness \[length\].
        visible: f64,
        /// The part of the way.
        part: f64,
    },
    /// A point that lies that deep behind the opposite surface where the motion begins: one body, or a tool, is put into another.
    #[error(
        "before the step already the point at {position:?} lies {depth:e} behind the opposite surface, where contact sees {visible:e} \
         deep: one body or tool begins inside the other. Put them apart, or let them approach until they touch \
         (`Assembler::first_touch`)"
    )]
    Inside {
        /// The point before it is displaced \[length\].
        position: Vec<f64>,
        /// Its depth behind the surface \[length\].
        depth: f64,
        /// The smaller of its reach and the opposite body's thickness \[length\].
        visible: f64,
    },
    /// Surfaces that move too far, from one displacement to another, to be followed.
    #[error(
        "the surfaces move relative to each other by up to {motion:e}, which is too far to be followed (at most {allowed:e}): take a \
         smaller step"
    )]
    TooFar {
        /// A bound of the relative motion \[length\].
        motion: f64,
        /// The largest one that is followed \[length\].
        allowed: f64,
    },
    /// A place at which pairs cannot be integrated over.
    #[error("{place} cannot integrate over contact pairs")]
    Refused {
        /// "an element kernel".
        place: &'static str,
    },
}
