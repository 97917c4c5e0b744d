//! Element matrices on affine cells whose coefficients are constant there, without a loop over points.
//!
//! On a simplex with straight edges, ∇φ_i = Σ_a c_a^i ∇λ_a with the barycentric coordinates λ_a, whose gradients
//! are constant. The kernel's block is bilinear in the two basis functions, so that it is
//! Σ_ab R_ab(i, j) B_ab with the blocks B_ab of the functions λ_a and λ_b, made per cell, and the reference
//! tensor R_ab(i, j) = Σ_q w_q c_a^i(x_q) c_b^j(x_q), made once. A value of a basis function counts as one more
//! direction. R is sparse: for quadratic elements a pair has one to four terms.

mod blocks;
mod scalars;

use forms_core::contract::{BilinearConstants, BilinearKernel};

use self::blocks::Terms;
pub(in crate::assemble) use self::scalars::{Coefficient, InLanes, contract as contract_numbers, products};
use super::block_sink::BlockSink;
use crate::assemble::groups::GroupSide;
use crate::instantiate::instantiate;
use crate::lanes::SimdLane;

/// Entries of a block, at most, for which sums are kept in registers.
const LARGEST_BLOCK: usize = 16;

/// Whether a kernel allows for a reference tensor on some cell.
pub(in crate::assemble) const fn suits<K: BilinearKernel<D>, const D: usize>() -> bool {
    allows(&BilinearConstants::of::<K, D>())
}

const fn allows(kernel: &BilinearConstants) -> bool {
    kernel.cell_constant && !kernel.requirements.reads_further() && kernel.entries() <= LARGEST_BLOCK
}

/// R, for the pairs of nodes that are computed.
pub(in crate::assemble) enum ReferenceTensor {
    /// Of forms whose block is a number: all coefficients, zeros included.
    Numbers(Vec<f64>),
    /// Of others.
    Blocks(Terms),
}

impl ReferenceTensor {
    /// The reference tensor of a kernel, if it may be used and takes fewer operations than the loop over points.
    #[inline(never)]
    pub fn new<const D: usize>(
        kernel: &BilinearConstants,
        side: &GroupSide<D>,
        elements: [usize; 2],
        weights: &[f64],
        symmetric: bool,
    ) -> Option<Self> {
        if !allows(kernel) || side.facet.is_some() || side.geometry.nodes != D + 1 {
            return None;
        }
        let count = kernel.operations;
        let [rows, columns] = elements.map(|element| side.elements[element].nodes);
        let pairs = if symmetric { rows * (rows + 1) / 2 } else { rows * columns };
        let per_point =
            count.point + rows * (count.test + D * D) + columns * count.trial + pairs * count.pair;
        let loops = weights.len() * per_point + pairs * count.finish;
        if kernel.scalar() {
            let (directions, products) = (scalars::directions::<D>(kernel), scalars::products::<D>(kernel));
            let made = directions * (count.test + count.trial)
                + products * (count.pair + count.finish)
                + pairs * products;
            let coefficients = || scalars::coefficients(kernel, side, elements, weights, symmetric);
            return (made < loops).then(|| ReferenceTensor::Numbers(coefficients()));
        }
        let nonzero = kernel.nonzero.iter().filter(|nonzero| **nonzero).count();
        let terms = Terms::new(side, elements, weights, symmetric, kernel.requirements);
        let directions = blocks::direction_count::<D>(kernel.requirements);
        let made = directions * directions * (count.pair + count.finish);
        let made = made + directions * (count.test + count.trial) + terms.count() * nonzero;
        (made < loops).then_some(ReferenceTensor::Blocks(terms))
    }
}

/// The blocks of all pairs by a reference tensor. `directions` is memory that is kept.
#[inline(always)]
pub(in crate::assemble) fn contract<
    K: BilinearKernel<D>,
    L: SimdLane,
    S: BlockSink<L> + ?Sized,
    const D: usize,
>(
    kernel: &K,
    cell: &K::Cell<L>,
    tensor: &ReferenceTensor,
    determinant: L,
    inverse: &[[L; D]; D],
    directions: &mut Vec<L>,
    sink: &mut S,
) {
    match tensor {
        // Constant blocks: only the case that is used is compiled.
        ReferenceTensor::Numbers(coefficients) => {
            if const { BilinearConstants::of::<K, D>().scalar() } {
                scalars::contract::<K, L, f64, S, D>(kernel, cell, coefficients, determinant, inverse, sink);
            }
        }
        ReferenceTensor::Blocks(terms) => match const { K::TEST_COMPONENTS * K::TRIAL_COMPONENTS } {
            1 => {}
            4 => {
                blocks::contract::<K, L, S, 4, D>(kernel, cell, terms, determinant, inverse, directions, sink)
            }
            9 => {
                blocks::contract::<K, L, S, 9, D>(kernel, cell, terms, determinant, inverse, directions, sink)
            }
            _ => blocks::contract::<K, L, S, LARGEST_BLOCK, D>(
                kernel,
                cell,
                terms,
                determinant,
                inverse,
                directions,
                sink,
            ),
        },
    }
}

instantiate!(reference_tensor: ReferenceTensor::new::<D>);
