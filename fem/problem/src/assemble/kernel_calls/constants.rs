//! Constants of kernels, for loops that do not know the kernel's type.

use forms_core::contract::{BilinearKernel, LinearKernel, Operations, Requirements};

/// The constants of a linear kernel.
#[derive(Clone, Copy)]
pub(in crate::assemble) struct LinearConstants {
    pub requirements: &'static Requirements,
    /// Scalar components of the test function.
    pub components: usize,
    pub operations: Operations,
}

impl LinearConstants {
    pub const fn of<K: LinearKernel<D>, const D: usize>() -> Self {
        LinearConstants {
            requirements: const { &K::REQUIREMENTS },
            components: K::TEST_COMPONENTS,
            operations: K::OPERATIONS,
        }
    }
}

/// The constants of a bilinear kernel.
#[derive(Clone, Copy)]
pub(in crate::assemble) struct BilinearConstants {
    pub requirements: &'static Requirements,
    /// Scalar components of the test and of the trial function.
    pub components: [usize; 2],
    /// The block of a pair (j, i) is the transpose of that of (i, j).
    pub symmetric: bool,
    /// The coefficients are constant on a cell.
    pub cell_constant: bool,
    /// Per entry of a block, row after row: false where it is zero for all data.
    pub nonzero: &'static [bool],
    pub operations: Operations,
}

impl BilinearConstants {
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
