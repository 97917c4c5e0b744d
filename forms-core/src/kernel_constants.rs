//! Constants of kernels, for code that does not know the kernel's type.

use crate::kernel::{BilinearKernel, ExpressionKernel, LinearKernel, Operations, Requirements};

/// The constants of a linear kernel.
#[derive(Clone, Copy, Debug)]
pub struct LinearConstants {
    /// Inputs at each point.
    pub requirements: &'static Requirements,
    /// Scalar components of the test function.
    pub components: usize,
    /// Cost of its functions.
    pub operations: Operations,
}

impl LinearConstants {
    /// Constants of a kernel type.
    pub const fn of<K: LinearKernel<D>, const D: usize>() -> Self {
        LinearConstants {
            requirements: const { &K::REQUIREMENTS },
            components: K::TEST_COMPONENTS,
            operations: K::OPERATIONS,
        }
    }
}

/// The constants of a bilinear kernel.
#[derive(Clone, Copy, Debug)]
pub struct BilinearConstants {
    /// Inputs at each point.
    pub requirements: &'static Requirements,
    /// Scalar components of the test and of the trial function.
    pub components: [usize; 2],
    /// The block of a pair (j, i) is the transpose of that of (i, j).
    pub symmetric: bool,
    /// The coefficients are constant on a cell.
    pub cell_constant: bool,
    /// Per entry of a block, row after row: false where it is zero for all data.
    pub nonzero: &'static [bool],
    /// Cost of its functions.
    pub operations: Operations,
}

impl BilinearConstants {
    /// Constants of a kernel type.
    pub const fn of<K: BilinearKernel<D>, const D: usize>() -> Self {
        BilinearConstants {
            requirements: const { &K::REQUIREMENTS },
            components: [K::TEST_COMPONENTS, K::TRIAL_COMPONENTS],
            symmetric: K::SYMMETRIC,
            cell_constant: K::CELL_CONSTANT,
            nonzero: K::NONZERO,
            operations: K::OPERATIONS,
        }
    }

    /// Entries of a block.
    pub const fn entries(&self) -> usize {
        self.components[0] * self.components[1]
    }

    /// Whether a block is a number.
    pub const fn scalar(&self) -> bool {
        self.entries() == 1
    }
}

/// The constants of a kernel without test function.
#[derive(Clone, Copy, Debug)]
pub struct ExpressionConstants {
    /// Inputs at each point.
    pub requirements: &'static Requirements,
    /// Shape of the value.
    pub shape: &'static [usize],
}

impl ExpressionConstants {
    /// Constants of a kernel type.
    pub const fn of<K: ExpressionKernel<D>, const D: usize>() -> Self {
        ExpressionConstants { requirements: const { &K::REQUIREMENTS }, shape: K::SHAPE }
    }
}
