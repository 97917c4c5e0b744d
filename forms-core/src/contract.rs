//! The contract between compiled forms and backends: everything that emitted code and backends name. What a form is, is in
//! `form.rs` and `function.rs`, its integrands and the order in which a backend calls them in `kernel.rs`, the values of its fields in `source.rs`. Emitted paths read `<crate>::contract::Name`, so a
//! crate that re-exports this module can replace `forms-core` (`#[forms(crate = that_crate)]`).

pub use crate::adaptation::Adaptation;
pub use crate::degree::{Degree, DegreeSum, Derivatives, GeometryDegrees};
pub use crate::dimension::{Dim, Dimension};
pub use crate::dual::{Dual, Seeded};
pub use crate::external::{External, external, tabulated};
pub use crate::form::{
    Constants, Dependence, Entity, FieldDescription, Formula, Inputs, Integral, Means, Region, RegionRule,
    Role,
};
pub use crate::function::{CombinationError, Function, is_on_same_points};
pub use crate::history::History;
pub use crate::integrals::{Backend, CombiningBackend, Integrals, Term};
pub use crate::kernel::{
    Basis, BilinearKernel, CellGeometry, ExpressionKernel, FieldSlot, Further, Hessian, LinearKernel,
    Operations, OppositePoint, Order, PointGeometry, Requirements, Side,
};
pub use crate::kernel_constants::{BilinearConstants, ExpressionConstants, LinearConstants};
pub use crate::lane::{Lane, Parts};
pub use crate::pairing::{Facing, PairQuadrature, Pairing, Projection};
pub use crate::real::Real;
pub use crate::source::{
    Datum, DiscreteField, FieldHandle, FieldValue, Given, HistoryHandle, QuadratureValues, Source,
};
pub use crate::spectral::{
    TensorExponential, TensorLogarithm, TensorSquareRoot, tensor_exp, tensor_ln, tensor_sqrt,
};
pub use crate::table::{Table, TableError};
#[doc(hidden)]
pub use forms_macro::resume_forms;

use crate::described::Described;

/// A form without kernels, for its description. A backend's contract has one with its kernels.
pub type Form<const D: usize> = crate::function::Form<D, Described>;
/// An energy without kernels.
pub type Energy<const D: usize> = crate::function::Energy<D, Described>;
/// A functional without kernels.
pub type Functional<const D: usize> = crate::function::Functional<D, Described>;
/// An expression without kernels.
pub type Expression<const D: usize> = crate::function::Expression<D, Described>;
