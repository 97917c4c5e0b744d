//! The contract between compiled weak forms and any finite element backend.
//!
//! `#[forms]` (from `forms-macro`, re-exported here) turns weak forms into kernels: small straight-line
//! functions that know physics and no mesh. A backend owns meshes, elements, quadrature, loops and
//! scatter, and knows no physics. What the two share stands in [`contract`] and nowhere else; the
//! toy backend in this package's tests shows that nothing more is needed.
//!
//! Reading order: [`lane`] (the number type), [`kernel`] (what is called at a point), [`mod@form`] (how a
//! form hands its kernels over), [`dimension`] (one bound for all forms), [`source`] (where data come from). Functions written in Rust compute with
//! [`real`] and [`dual`] numbers, are called through [`external`], and may use [`spectral`] ones; a [`table`]
//! is a law given by points, and [`history`] what a material remembers. [`pairing`] says which surfaces of a region of contact pairs meet.

pub mod dimension;
pub mod dual;
mod error_function;
pub mod external;
pub mod form;
pub mod history;
pub mod kernel;
pub mod lane;
pub mod pairing;
pub mod real;
pub mod source;
pub mod spectral;
pub mod table;

pub use forms_macro::{form, forms};

/// Everything that emitted code and backends name. Emitted paths read `<crate>::contract::Name`, so a
/// crate that re-exports this module can stand in for `forms-core` (`#[forms(crate = that_crate)]`).
pub mod contract {
    pub use crate::dimension::{Constants, Dim, Dimension, Integrals};
    pub use crate::dual::{Dual, Seeded};
    pub use crate::external::{External, external, tabulated};
    pub use crate::form::{
        BilinearVisitor, Dependence, Entity, Expression, ExpressionVisitor, FieldDescription, Form, Formula,
        Functional, Inputs, Integral, LinearVisitor, Region, Role,
    };
    pub use crate::history::{History, HistoryHandle, QuadratureValues};
    pub use crate::kernel::{
        Basis, BilinearKernel, CellGeometry, ExpressionKernel, FieldSlot, Hessian, LinearKernel, Operations,
        OppositePoint, Order, PointGeometry, Requirements, Side,
    };
    pub use crate::lane::Lane;
    pub use crate::pairing::{Facing, PairQuadrature, Pairing, Projection};
    pub use crate::real::Real;
    pub use crate::source::{DiscreteField, FieldHandle, FieldValue, Given, Source};
    pub use crate::spectral::{
        TensorExponential, TensorLogarithm, TensorSquareRoot, tensor_exp, tensor_ln, tensor_sqrt,
    };
    pub use crate::table::{Table, TableError};
    #[doc(hidden)]
    pub use forms_macro::resume_forms;
}
