//! Errors of assembly: a form, its data and its mesh do not fit.

use std::sync::Arc;

use forms_core::contract::CombinationError;
use thiserror::Error;

use crate::element::Elements;
use crate::space::Scope;

use crate::constraints::ConstraintsError;
use crate::cut::CutError;
use crate::history::HistoryMismatch;
use crate::linear_algebra::LinearAlgebraError;
use crate::mesh::MeshError;
use crate::pairs::PairError;
use crate::quadrature::QuadratureError;
use crate::solve::CommunicationError;

/// Errors of assembly. Every message names the form and the thing in it.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum AssemblyError {
    /// A sum of forms that do not fit each other.
    #[error("{source}")]
    Combination {
        /// The forms and their fields.
        source: CombinationError,
    },
    /// A product without a matrix of a form that has no kernels for it.
    #[error(
        "`{form}` has no kernels for products without a matrix; write `#[forms(matrix_free)]` on its module"
    )]
    NoAction {
        /// The form.
        form: &'static str,
    },
    /// A derivative by a level set function of a form that has no kernels for it.
    #[error(
        "`{form}` has no kernels for derivatives by a level set function; write `#[forms(level_set_derivatives)]` on its module"
    )]
    NoLevelSetDerivative {
        /// The form.
        form: &'static str,
    },
    /// Constraints on a space on which the form has no unknown, or on which all have theirs.
    #[error("form `{form}`: constraints were given for a space on which no unknown is left without")]
    Constraints {
        /// The form.
        form: &'static str,
    },
    /// Hanging nodes at which a space cannot be made continuous.
    #[error("form `{form}`: {source}")]
    Hanging {
        /// The form.
        form: &'static str,
        /// The reason.
        source: Box<ConstraintsError>,
    },
    /// A failed exchange between processes, or an error on another one.
    #[error("form `{form}`: {source}")]
    Communication {
        /// The form.
        form: &'static str,
        /// The reason.
        source: CommunicationError,
    },
    /// More unknowns than steps in time or of a history take.
    #[error("`{form}` has more than {most} unknowns: a step takes no more")]
    TooManyUnknowns {
        /// The form.
        form: &'static str,
        /// The largest number.
        most: usize,
    },
    /// Kernels for instructions that this machine does not have.
    #[error(
        "form `{form}`: this program's kernels were compiled for {compiled}, which this machine does not have: build it here, \
         or with FORMS_ALL_INSTRUCTION_SETS=1 in the environment"
    )]
    Instructions {
        /// The form.
        form: &'static str,
        /// The sets of instructions of the build.
        compiled: String,
    },
    /// An environment variable of the library has a value that cannot be read.
    #[error("form `{form}`: {what}")]
    Environment {
        /// The form that was about to be assembled.
        form: &'static str,
        /// The variable, and what is wrong with its value.
        what: String,
    },
    /// The layout of an element kernel does not fit the form or its cells.
    #[error("form `{form}`, element kernel: {what}")]
    Layout {
        /// The form.
        form: &'static str,
        /// The mismatch.
        what: String,
    },
    /// A mesh on which the form cannot be assembled.
    #[error("form `{form}`: {source}")]
    Mesh {
        /// The form.
        form: &'static str,
        /// The mesh's error.
        source: MeshError,
    },
    /// A region that the mesh does not have.
    #[error("form `{form}`, region `{symbol}`: {source}")]
    Region {
        /// The form.
        form: &'static str,
        /// The region's name in the forms module.
        symbol: &'static str,
        /// The mesh's error.
        source: MeshError,
    },
    /// Contact pairs that cannot be made, or not be integrated over.
    #[error("form `{form}`, pairs `{symbol}` ({pairing}): {source}")]
    Pairs {
        /// The form or function.
        form: &'static str,
        /// The region's name in the forms module.
        symbol: &'static str,
        /// The surfaces.
        pairing: String,
        /// The reason.
        source: PairError,
    },
    /// A body that is cut from the mesh, or an integral over it.
    #[error("form `{form}`, {place}: {source}")]
    Cut {
        /// The form or function.
        form: &'static str,
        /// The region.
        place: String,
        /// The reason.
        source: CutError,
    },
    /// The opposite point of a place that has none.
    #[error("`{form}` reads the gap or an opposite point, but {place} consists of no contact pairs")]
    NeedsPairs {
        /// The form or function.
        form: &'static str,
        /// The place of integration or evaluation.
        place: String,
    },
    /// Means over own facets where there are none.
    #[error(
        "`{form}` has means over the own facets of contact pairs, which couple the cells of all facets opposite to one: they have no element matrices"
    )]
    Means {
        /// The form.
        form: &'static str,
    },
    /// Facets whose sides do not fit each other.
    #[error("form `{form}`, {place}: {source}")]
    Facets {
        /// The form.
        form: &'static str,
        /// The region.
        place: String,
        /// The problem of the mesh.
        source: MeshError,
    },
    /// A cell that is inverted at a quadrature point, or anywhere.
    #[error(
        "form `{form}`, {place}: cell {cell} is inverted at {position:?}, where its Jacobian determinant is \
         {determinant:e}"
    )]
    Weight {
        /// The form.
        form: &'static str,
        /// The region.
        place: String,
        /// Cell index.
        cell: usize,
        /// The determinant \[length^D\].
        determinant: f64,
        /// The point.
        position: Vec<f64>,
    },
    /// A quadrature rule that does not exist or is not accepted.
    #[error("form `{form}`: {source}")]
    Quadrature {
        /// The form.
        form: &'static str,
        /// The problem of the rule.
        source: QuadratureError,
    },
    /// A parameter that is not finite.
    #[error("form `{form}`: the parameter `{parameter}` is {value}")]
    Parameter {
        /// The form.
        form: &'static str,
        /// Name of the data member, with its component.
        parameter: String,
        /// Its value.
        value: f64,
    },
    /// A parameter outside the range that its formulation allows.
    #[error("form `{form}`: the parameter `{parameter}` is {value}; it must be {range}")]
    ParameterRange {
        /// The form.
        form: &'static str,
        /// Name of the data member.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Which values are allowed, in words.
        range: &'static str,
    },
    /// A parameter that is to be a rotation and is none.
    #[error("form `{form}`: the parameter `{parameter}` is no rotation: {deviation}")]
    NoRotation {
        /// The form.
        form: &'static str,
        /// Name of the data member.
        parameter: &'static str,
        /// Its deviation from a rotation, in words.
        deviation: String,
    },
    /// A direction whose length is not 1.
    #[error("form `{form}`: the parameter `{parameter}` has the length {length}; it must be 1")]
    NoUnitVector {
        /// The form.
        form: &'static str,
        /// Name of the data member.
        parameter: &'static str,
        /// Its length.
        length: f64,
    },
    /// A region of cells that ought to hold each cell with a facet of another region.
    #[error(
        "form `{form}`: the cells \"{cells}\" lack the one at {position:?}, of which a facet belongs to \"{facets}\" \
         (`Mesh::name_cells_of_facets` names them all)"
    )]
    CellOfFacet {
        /// The form.
        form: &'static str,
        /// The region of cells.
        cells: String,
        /// The region of facets.
        facets: String,
        /// The centre of the cell that is missing.
        position: Vec<f64>,
    },
    /// A field with the wrong number of components.
    #[error("form `{form}`: `{field}` has {expected} components, the field given has {found}")]
    Components {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// Components that the form declares.
        expected: usize,
        /// Components that were given.
        found: usize,
    },
    /// A field that is not one of this backend, or of another dimension.
    #[error("form `{form}`: `{field}` is not a field of this backend in {dimension} dimensions")]
    ForeignField {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// Dimension of the mesh.
        dimension: usize,
    },
    /// A field on another mesh than the one integrated over.
    #[error(
        "form `{form}`: `{field}` lives on another mesh; give it as a function that evaluates it at a point"
    )]
    OtherMesh {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
    },
    /// A field whose coefficients, or a function whose value, is not finite.
    #[error("form `{form}`: `{field}` is not finite{}", at(.position))]
    NotFinite {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// Where, if it is known.
        position: Option<Vec<f64>>,
    },
    /// A gradient of data that have none.
    #[error(
        "form `{form}` reads the gradient of `{field}`, which is given as a function of position alone; give it with its gradient (`Given::function_with_gradient`) or as a field on a space"
    )]
    GradientOfFunction {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
    },
    /// Second derivatives of data that have none.
    #[error(
        "form `{form}` reads the second derivatives of `{field}`, which is given as a function of position; give it as a field on a space"
    )]
    HessianOfFunction {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
    },
    /// The mean over a cell of data that are given at points.
    #[error(
        "form `{form}` reads the mean over a cell of `{field}`, which is given as a function of position; give it as a field on a space"
    )]
    MeanOfFunction {
        /// The form.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
    },
    /// A history that does not fit.
    #[error("form `{form}`, history `{field}`: {source}")]
    History {
        /// The form.
        form: &'static str,
        /// The history's name in the form.
        field: &'static str,
        /// Why.
        source: HistoryMismatch,
    },
    /// The wrong number of unknowns, directions or test spaces, or a vector of another size.
    #[error("form `{form}` has {expected} {what}, {found} were given")]
    Count {
        /// The form.
        form: &'static str,
        /// "unknowns", "directions", "test functions" or "entries of a vector".
        what: &'static str,
        /// In the form.
        expected: usize,
        /// Given.
        found: usize,
    },
    /// The value of a density or derived field is not finite.
    #[error("`{form}` is not finite at x = {position:?}")]
    ValueNotFinite {
        /// The form or function.
        form: &'static str,
        /// Where.
        position: Vec<f64>,
    },
    /// A derived field that needs a facet was asked for inside cells.
    #[error(
        "`{form}` reads the normal, the area or the curvature of a facet: evaluate it along a facet region"
    )]
    NeedsFacet {
        /// The function.
        form: &'static str,
    },
    /// The other side of a facet that has only one.
    #[error("`{form}` reads the other side of a facet, but {place} has no facets with two sides")]
    NeedsInteriorFacet {
        /// The form or function.
        form: &'static str,
        /// The place where it is integrated or evaluated.
        place: String,
    },
    /// A field that lives on facets is needed elsewhere.
    #[error(
        "form `{form}` needs `{field}` over {place}, but its space lives on the facets of \"{region}\" alone"
    )]
    OffItsFacets {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// The place where it is integrated or evaluated.
        place: String,
        /// The facet region of the field's space.
        region: String,
    },
    /// A field where its space, which is limited to some cells, has no nodes.
    #[error("form `{form}` needs `{field}` over {place}, but its space is one {scope}")]
    OffItsCells {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// The place where it is integrated or evaluated.
        place: String,
        /// The scope of the field's space.
        scope: Scope,
    },
    /// Values at points where an integral has other points.
    #[error(
        "form `{form}` needs `{field}` over {place}, but it has {elements}: integrals on cells take that rule where the assembler has \
         no other choice of quadrature, and nothing else in them has another rule"
    )]
    OffItsPoints {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// The place where it is integrated.
        place: String,
        /// Elements of its space.
        elements: Elements,
    },
    /// Functions of several kinds on facets in a sum over nodes.
    #[error(
        "form `{form}` needs `{field}` over {place}, a sum over the nodes of its Bernstein elements of degree 2, together with `{other}`, which has {elements}: \
         give both the same elements"
    )]
    OtherNodes {
        /// The form or function.
        form: &'static str,
        /// The field or function with nodes of degree 2, by its name in the form.
        field: &'static str,
        /// The place where it is summed.
        place: String,
        /// The other one.
        other: &'static str,
        /// Elements of its space.
        elements: Elements,
    },
    /// A derivative of values at points.
    #[error("form `{form}` reads a derivative of `{field}`, which is known at the points of a rule only")]
    DerivativeAtPoints {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
    },
    /// A space that cannot be projected or interpolated to.
    #[error("`{form}` has no values on a space of {elements} {scope}")]
    NoValuesOn {
        /// The expression.
        form: &'static str,
        /// Elements of the space.
        elements: Elements,
        /// Scope of the space.
        scope: Scope,
    },
    /// Second derivatives of a field that lives on facets.
    #[error(
        "form `{form}` reads second derivatives of `{field}`, whose space lives on the facets of \"{region}\" alone: \
         it has values and a tangential gradient only"
    )]
    HessianOnFacets {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// The facet region of the field's space.
        region: String,
    },
    /// The mean over a cell of a field that lives on facets.
    #[error(
        "form `{form}` reads the mean over a cell of `{field}`, whose space lives on the facets of \"{region}\" alone"
    )]
    MeanOnFacets {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// The facet region of the field's space.
        region: String,
    },
    /// The mean over a cell of functions that no table of a reference cell has.
    #[error(
        "form `{form}` reads the mean over a cell of `{field}`, which has {elements}: their means are not available"
    )]
    NoMean {
        /// The form or function.
        form: &'static str,
        /// The field's name in the form.
        field: &'static str,
        /// Elements of its space.
        elements: Elements,
    },
    /// The two sides of an interior facet do not meet.
    #[error(
        "form `{form}`: cells {} and {} share a facet, but at x = {position:?} their sides are {distance:e} apart",
        .cells[0], .cells[1]
    )]
    FacetMismatch {
        /// The form.
        form: &'static str,
        /// The two cells.
        cells: [u32; 2],
        /// Where.
        position: Vec<f64>,
        /// Distance between the two sides \[length\].
        distance: f64,
    },
    /// A start, constraints or a matrix pattern of other spaces than the form's.
    #[error("form `{form}`: the {what} given for `{field}` belong to another space")]
    OtherSpace {
        /// The form.
        form: &'static str,
        /// The unknown's or test function's name in the form.
        field: &'static str,
        /// "start", "constraints", "coefficients" or "positions of the matrix".
        what: &'static str,
    },
    /// A matrix pattern made for another form.
    #[error("form `{form}` couples `{test}` with `{trial}` where the matrix pattern has no entries")]
    Pattern {
        /// The form.
        form: &'static str,
        /// The test function.
        test: &'static str,
        /// The unknown.
        trial: &'static str,
    },
    /// A point outside the mesh.
    #[error("`{form}`: the point {position:?} is outside the mesh")]
    Outside {
        /// The function.
        form: &'static str,
        /// The point.
        position: Vec<f64>,
    },
    /// Matrices and vectors that do not fit.
    #[error("form `{form}`: {source}")]
    LinearAlgebra {
        /// The form.
        form: &'static str,
        /// The mismatch.
        source: LinearAlgebraError,
    },
    /// Any error of a nonlinear problem that is not assembled from a form.
    #[error(transparent)]
    Other(OtherError),
}

impl AssemblyError {
    /// An error of another type, which [`OtherError::get`] returns. Its message stays as it is.
    pub fn other(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        AssemblyError::Other(OtherError(Arc::new(error)))
    }
}

/// An error of any type. A clone is equal to it, and no other error is.
#[derive(Clone, Debug, Error)]
#[error(transparent)]
pub struct OtherError(Arc<dyn std::error::Error + Send + Sync>);

impl OtherError {
    /// The error itself, for `downcast_ref`.
    pub fn get(&self) -> &(dyn std::error::Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl PartialEq for OtherError {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

fn at(position: &Option<Vec<f64>>) -> String {
    position.as_ref().map(|x| format!(" at x = {x:?}")).unwrap_or_default()
}
