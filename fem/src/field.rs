//! Discrete fields: coefficients on a space.

use std::sync::Arc;

use crate::space::Space;

/// A field on a space: one coefficient per unknown, `values[node * components + component]`.
#[derive(Clone, Debug)]
pub struct Field<const D: usize> {
    pub(crate) space: Arc<Space<D>>,
    pub(crate) values: Arc<Vec<f64>>,
}
