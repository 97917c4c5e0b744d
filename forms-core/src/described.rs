//! A backend without code: forms that only say what they are.

use crate::integrals::Backend;
use crate::kernel::{BilinearKernel, ExpressionKernel, LinearKernel};
use crate::kernel_constants::{BilinearConstants, ExpressionConstants, LinearConstants};

/// The backend for descriptions of functions. It keeps only the constants of kernels.
#[derive(Clone, Copy, Debug)]
pub struct Described;

impl<const D: usize> Backend<D> for Described {
    type Linear = LinearConstants;
    type Bilinear = BilinearConstants;
    type Expression = ExpressionConstants;

    fn linear<K: LinearKernel<D>>(_: K) -> LinearConstants {
        LinearConstants::of::<K, D>()
    }

    fn bilinear<K: BilinearKernel<D>>(_: K) -> BilinearConstants {
        BilinearConstants::of::<K, D>()
    }

    fn expression<K: ExpressionKernel<D>>(_: K) -> ExpressionConstants {
        ExpressionConstants::of::<K, D>()
    }
}
