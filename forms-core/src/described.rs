//! A backend without code: forms that only say what they are.

use crate::adaptation::Adaptation;
use crate::integrals::{Backend, CombiningBackend};
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

impl<const D: usize> CombiningBackend<D> for Described {
    fn adapt_linear(kernel: &LinearConstants, adaptation: Adaptation) -> LinearConstants {
        LinearConstants { requirements: adaptation.requirements(kernel.requirements), ..*kernel }
    }

    fn adapt_bilinear(kernel: &BilinearConstants, adaptation: Adaptation) -> BilinearConstants {
        BilinearConstants { requirements: adaptation.requirements(kernel.requirements), ..*kernel }
    }

    fn adapt_expression(kernel: &ExpressionConstants, adaptation: Adaptation) -> ExpressionConstants {
        ExpressionConstants { requirements: adaptation.requirements(kernel.requirements), ..*kernel }
    }
}
