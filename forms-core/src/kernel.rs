//! Kernels, called at quadrature points: linear, bilinear and expression kernels.
//!
//! The order of calls, for one batch of [`Lane::WIDTH`] cells (or facets) of one integral:
//!
//! ```text
//! cell      once per batch               what is constant on the cell
//! point     per quadrature point         fields and geometry -> coefficients, weight included
//! test      per point and test node      basis function -> factors of the test side
//! trial     per point and trial node     basis function -> factors of the trial side
//! pair      per point and node pair      accumulates into that pair's accumulator
//! finish    per node pair                accumulator -> block (test components x trial components)
//! ```
//!
//! A kernel that accumulates per cell (the coefficient is constant there) does its contraction in
//! `finish`; one with factored point data does it in `pair`, and `finish` only hands the block over.
//! The backend owns tables, geometry, lanes, loops and their order, symmetry, buffers and scatter.

use crate::lane::Lane;

/// A scalar basis function φ at a point: its value and its gradient in physical coordinates [1/length].
/// Component a of a vector unknown has the basis φ e_a; kernels handle the components themselves.
#[derive(Clone, Copy, Debug)]
pub struct Basis<L, const D: usize> {
    /// φ(x).
    pub value: L,
    /// ∇φ(x).
    pub gradient: [L; D],
}

/// Second derivatives ∂²φ/∂x_i∂x_j of a basis function \[1/length²\].
pub type Hessian<L, const D: usize> = [[L; D]; D];

/// Data of a basis function that few kernels read, separate from [`Basis`]. Zeros where [`Requirements::reads_further`] is false.
#[derive(Clone, Copy, Debug)]
pub struct Further<L, const D: usize> {
    /// Second derivatives, where [`Requirements::hessian`] asks.
    pub hessian: Hessian<L, D>,
    /// Means of value and gradient over the cell, where [`Requirements::test_mean`] or `trial_mean` asks: (∫ φ, ∫ ∇φ) / |T|, the same numbers at all
    /// points of the cell and of its facets.
    pub mean: Basis<L, D>,
}

impl<L: Lane, const D: usize> Further<L, D> {
    /// Zeros, for a function that is known by value and gradient only.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::splat(0.0);
        Further { hessian: [[zero; D]; D], mean: Basis { value: zero, gradient: [zero; D] } }
    }
}

/// Geometry that is constant on a cell, or on a facet together with the cell that owns it.
#[derive(Clone, Copy, Debug)]
pub struct CellGeometry<L> {
    /// h_T, the largest distance between two vertices of the cell \[length\].
    pub diameter: L,
    /// |T| \[length^D\].
    pub cell_volume: L,
    /// |F| \[length^(D-1)\]; zero in cell integrals, where no form can ask for it.
    pub facet_area: L,
    /// h of the cell across an interior facet, or of that of a pair's opposite point; zero elsewhere.
    pub opposite_diameter: L,
    /// Volume of that cell; zero elsewhere.
    pub opposite_volume: L,
}

/// The opposite point Y of a quadrature point X of a contact pair.
#[derive(Clone, Copy, Debug)]
pub struct OppositePoint<L, const D: usize> {
    /// g, the distance of Y from X along [`OppositePoint::toward`], negative where the bodies overlap \[length\].
    pub gap: L,
    /// n_y, the unit vector from this body into the opposite one.
    pub toward: [L; D],
    /// Y.
    pub position: [L; D],
    /// The opposite body's outward unit normal at Y.
    pub normal: [L; D],
    /// ∇n along the opposite surface at Y \[1/length\]: row i, column j is ∂n_i along axis j; zero where it is flat.
    pub shape_operator: [[L; D]; D],
}

impl<L: Lane, const D: usize> OppositePoint<L, D> {
    /// The opposite point of a point which is not of a pair: zeros, which no form can ask for.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::splat(0.0);
        OppositePoint {
            gap: zero,
            toward: [zero; D],
            position: [zero; D],
            normal: [zero; D],
            shape_operator: [[zero; D]; D],
        }
    }
}

/// Geometry at a quadrature point.
#[derive(Clone, Copy, Debug)]
pub struct PointGeometry<L, const D: usize> {
    /// Quadrature weight times the measure (Jacobian determinant, or surface element).
    pub weight: L,
    /// x.
    pub position: [L; D],
    /// n, the outward unit normal; zero in cell integrals, where no form can ask for it. On an interior
    /// facet it points out of the cell of [`Side::This`].
    pub normal: [L; D],
    /// κ = div n \[1/length\]; filled only where [`Requirements::curvature`] asks.
    pub curvature: L,
    /// The opposite point of a contact pair, as far as the kernel reads it.
    pub opposite: OppositePoint<L, D>,
}

impl<L: Lane, const D: usize> PointGeometry<L, D> {
    /// Only a weight; all else is zero.
    #[inline(always)]
    pub fn of_weight(weight: L) -> Self {
        let zero = L::splat(0.0);
        PointGeometry {
            weight,
            position: [zero; D],
            normal: [zero; D],
            curvature: zero,
            opposite: OppositePoint::none(),
        }
    }
}

/// The derivative of a field that a kernel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// The value: `components` numbers.
    Value,
    /// The gradient: `components * D` numbers, row-major (component, then direction).
    Gradient,
    /// Second derivatives: `components * D * D` numbers, row-major (component, then both directions).
    Hessian,
    /// The mean of the value over the cell, as [`Order::Value`].
    MeanValue,
    /// The mean of the gradient over the cell, as [`Order::Gradient`].
    MeanGradient,
}

impl Order {
    /// Number of axes along which a component is differentiated.
    #[inline]
    pub const fn axes(self) -> usize {
        match self {
            Order::Value | Order::MeanValue => 0,
            Order::Gradient | Order::MeanGradient => 1,
            Order::Hessian => 2,
        }
    }

    /// Whether it is a mean over the cell.
    #[inline]
    pub const fn is_mean(self) -> bool {
        matches!(self, Order::MeanValue | Order::MeanGradient)
    }
}

/// The side of a facet on which a field is read. Cells and exterior facets have only `This`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The cell that owns the facet.
    This,
    /// The cell across an interior facet, or that of a contact pair's opposite point.
    Other,
}

/// One entry of the field data that a kernel reads at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FieldSlot {
    /// Index into [`crate::form::Inputs::sources`] and [`crate::function::Function::fields`].
    pub field: usize,
    /// Value, gradient, second derivatives, or a mean.
    pub order: Order,
    /// Side of the facet.
    pub side: Side,
    /// Number of scalar components of the field.
    pub components: usize,
    /// The start of this entry in the `fields` slice.
    pub offset: usize,
}

/// The inputs of a kernel; a backend need not compute anything else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Requirements {
    /// Reads [`CellGeometry::diameter`].
    pub diameter: bool,
    /// Reads [`CellGeometry::cell_volume`].
    pub cell_volume: bool,
    /// Reads [`CellGeometry::facet_area`].
    pub facet_area: bool,
    /// Reads [`PointGeometry::position`].
    pub position: bool,
    /// Reads [`PointGeometry::normal`].
    pub normal: bool,
    /// Reads [`PointGeometry::curvature`].
    pub curvature: bool,
    /// Reads [`CellGeometry::opposite_diameter`].
    pub opposite_diameter: bool,
    /// Reads [`CellGeometry::opposite_volume`].
    pub opposite_volume: bool,
    /// Reads [`OppositePoint::gap`].
    pub gap: bool,
    /// Reads [`OppositePoint::toward`].
    pub toward: bool,
    /// Reads [`OppositePoint::position`].
    pub opposite_position: bool,
    /// Reads [`OppositePoint::normal`].
    pub opposite_normal: bool,
    /// Reads [`OppositePoint::shape_operator`].
    pub opposite_shape_operator: bool,
    /// `test` or `trial` reads [`Basis::value`].
    pub basis_value: bool,
    /// `test` or `trial` reads [`Basis::gradient`].
    pub basis_gradient: bool,
    /// `test` reads derivatives or means; otherwise functions that vanish at a point contribute nothing there.
    pub test_derivatives: bool,
    /// The same of `trial`.
    pub trial_derivatives: bool,
    /// Reads the second derivatives of test or trial functions.
    pub hessian: bool,
    /// `test` reads [`Further::mean`].
    pub test_mean: bool,
    /// `trial` reads [`Further::mean`].
    pub trial_mean: bool,
    /// A derivative by the displacement of its contact pairs, at points that are held: wrong where points move with the pairs. Of residuals
    /// of energies of means, and of derivatives of integrals that a state displaces.
    pub holds_points: bool,
    /// The first variation of an energy, or its tangent, by the displacement of its contact pairs at points that are held. In the plane
    /// `Function::motion` has the density whose motion completes it.
    pub varies_energy: bool,
    /// The layout of the `fields` slice.
    pub fields: &'static [FieldSlot],
    /// Length of the `fields` slice.
    pub field_length: usize,
}

impl Requirements {
    /// Nothing is read.
    pub const NONE: Requirements = Requirements {
        diameter: false,
        cell_volume: false,
        facet_area: false,
        position: false,
        normal: false,
        curvature: false,
        opposite_diameter: false,
        opposite_volume: false,
        gap: false,
        toward: false,
        opposite_position: false,
        opposite_normal: false,
        opposite_shape_operator: false,
        basis_value: false,
        basis_gradient: false,
        test_derivatives: false,
        trial_derivatives: false,
        hessian: false,
        test_mean: false,
        trial_mean: false,
        holds_points: false,
        varies_energy: false,
        fields: &[],
        field_length: 0,
    };

    /// Whether `test` or `trial` reads [`Further`]. Ways that know functions by value and gradient only do not serve then.
    pub const fn reads_further(&self) -> bool {
        self.hessian || self.test_mean || self.trial_mean
    }

    /// Whether means over the cell are read, of basis functions or of fields.
    pub fn reads_means(&self) -> bool {
        self.test_mean || self.trial_mean || self.fields.iter().any(|slot| slot.order.is_mean())
    }
}

/// Operations of one call of each of a kernel's functions, counted in the emitted code. An addition, a product, a
/// contracted multiply-add, a quotient, a function or a comparison is one; a sign and a literal are none. With the
/// numbers of nodes and points they say what a way to run the kernel costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Of `point`.
    pub point: usize,
    /// Of `test`.
    pub test: usize,
    /// Of [`BilinearKernel::trial`]; none in a linear kernel.
    pub trial: usize,
    /// Of [`BilinearKernel::pair`].
    pub pair: usize,
    /// Of [`BilinearKernel::finish`].
    pub finish: usize,
}

/// One integral, linear in one test function: ∫ (flux, test) as `Σ_points Σ_nodes`.
///
/// `test` is linear in its basis function (value, gradient and [`Further`] together): a backend may ask for
/// other functions and combine the results.
pub trait LinearKernel<const D: usize>: Clone + Send + Sync + 'static {
    /// Inputs at each point.
    const REQUIREMENTS: Requirements;
    /// Number of scalar components of the test function.
    const TEST_COMPONENTS: usize;
    /// Cost of its functions.
    const OPERATIONS: Operations;
    /// It is an integral over contact pairs that an unknown displaces: backends may run it on numbers with derivatives along the motion of
    /// its points.
    const SLIDES: bool = false;
    /// It is the density of an energy times a test function, over contact pairs that an unknown displaces: backends may run it on numbers with
    /// two derivatives along the motion of its points.
    const OF_ENERGY: bool = false;
    /// A level set function may move its points (`#[forms(level_set_derivatives)]`): backends may run it on numbers with derivatives by
    /// the function's values.
    const MOVED_BY_LEVEL_SET: bool = false;
    /// Constants of the cell.
    type Cell<L: Lane>: Copy;
    /// Coefficients of the test function's value and gradient, weight included.
    type Flux<L: Lane>: Copy;
    /// Contribution to one test node: [`LinearKernel::TEST_COMPONENTS`] numbers.
    type Block<L: Lane>: Copy + AsRef<[L]>;

    /// Once per cell.
    fn cell<L: Lane>(&self, geometry: &CellGeometry<L>) -> Self::Cell<L>;
    /// Once per point.
    fn point<L: Lane>(
        &self,
        cell: &Self::Cell<L>,
        geometry: &PointGeometry<L, D>,
        fields: &[L],
    ) -> Self::Flux<L>;
    /// Per point and test node: what this point adds to that node.
    fn test<L: Lane>(
        &self,
        flux: &Self::Flux<L>,
        basis: &Basis<L, D>,
        further: &Further<L, D>,
    ) -> Self::Block<L>;
}

/// One integral, linear in one test and one trial function.
///
/// `test` and `trial` are linear in their basis function (value, gradient and [`Further`] together), `pair` adds
/// what is bilinear in their results, and `finish` is linear in the accumulator: a backend may put other linear
/// functions in place of basis functions, as a reference tensor and sum factorisation do.
pub trait BilinearKernel<const D: usize>: Clone + Send + Sync + 'static {
    /// Inputs at each point.
    const REQUIREMENTS: Requirements;
    /// Number of scalar components of the test function.
    const TEST_COMPONENTS: usize;
    /// Number of scalar components of the trial function.
    const TRIAL_COMPONENTS: usize;
    /// The compiler has proved block(i, j) = block(j, i)ᵀ: only pairs i ≤ j need be computed.
    const SYMMETRIC: bool;
    /// The coefficients are constant on the cell: `point` reads its cell and the weight, in which it is linear, but no
    /// position, normal, curvature or field. On affine cells the loop over points may be replaced by a reference tensor.
    const CELL_CONSTANT: bool;
    /// Per entry of the block, row-major: false where it is proved zero for all data.
    const NONZERO: &'static [bool];
    /// Cost of its functions.
    const OPERATIONS: Operations;
    /// Constants of the cell.
    type Cell<L: Lane>: Copy;
    /// Coefficients at a point, weight included.
    type Point<L: Lane>: Copy;
    /// Factors of one test node at a point.
    type Test<L: Lane>: Copy + Send + 'static;
    /// Factors of one trial node at a point.
    type Trial<L: Lane>: Copy + Send + 'static;
    /// The sums that a node pair accumulates over the points.
    type Accumulator<L: Lane>: Copy + AsMut<[L]>;
    /// Row-major block: test components × trial components.
    type Block<L: Lane>: Copy + AsRef<[L]>;

    /// Once per cell.
    fn cell<L: Lane>(&self, geometry: &CellGeometry<L>) -> Self::Cell<L>;
    /// Once per point.
    fn point<L: Lane>(
        &self,
        cell: &Self::Cell<L>,
        geometry: &PointGeometry<L, D>,
        fields: &[L],
    ) -> Self::Point<L>;
    /// Per point and test node.
    fn test<L: Lane>(
        &self,
        point: &Self::Point<L>,
        basis: &Basis<L, D>,
        further: &Further<L, D>,
    ) -> Self::Test<L>;
    /// Per point and trial node.
    fn trial<L: Lane>(
        &self,
        point: &Self::Point<L>,
        basis: &Basis<L, D>,
        further: &Further<L, D>,
    ) -> Self::Trial<L>;
    /// Factors of a basis function that is zero: what memory holds before others are made.
    fn zero_factors<L: Lane>() -> (Self::Test<L>, Self::Trial<L>);
    /// An empty accumulator.
    fn zero<L: Lane>() -> Self::Accumulator<L>;
    /// Per point and node pair.
    fn pair<L: Lane>(accumulator: &mut Self::Accumulator<L>, test: &Self::Test<L>, trial: &Self::Trial<L>);
    /// Per node pair, after the last point.
    fn finish<L: Lane>(&self, cell: &Self::Cell<L>, accumulator: &Self::Accumulator<L>) -> Self::Block<L>;
}

/// A density, a derived field, or any other function of position: no test function.
pub trait ExpressionKernel<const D: usize>: Send + Sync + 'static {
    /// Inputs at each point.
    const REQUIREMENTS: Requirements;
    /// Shape of the value: `[]` scalar, `[D]` vector, `[D, D]` tensor, or any extents up to rank 4.
    const SHAPE: &'static [usize];
    /// Constants of the cell.
    type Cell<L: Lane>: Copy;
    /// The value, row-major. The quadrature weight is not in it.
    type Value<L: Lane>: Copy + AsRef<[L]>;

    /// Once per cell.
    fn cell<L: Lane>(&self, geometry: &CellGeometry<L>) -> Self::Cell<L>;
    /// Once per point.
    fn evaluate<L: Lane>(
        &self,
        cell: &Self::Cell<L>,
        geometry: &PointGeometry<L, D>,
        fields: &[L],
    ) -> Self::Value<L>;
}
