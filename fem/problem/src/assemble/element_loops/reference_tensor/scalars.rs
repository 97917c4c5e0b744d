//! The reference tensor of forms whose block is a number.
//!
//! There are so few blocks of pairs of directions (three for gradients in the plane, six in space, for a symmetric form)
//! that all of them stay in registers while the pairs of nodes pass: every pair takes every block, zeros included, which
//! costs less than to look up which ones it needs.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, BilinearKernel, Further, PointGeometry, Requirements};

use crate::assemble::element_loops::block_sink::BlockSink;
use crate::assemble::groups::GroupSide;
use crate::lanes::SimdLane;
use forms_core::contract::BilinearConstants;

/// Axes of the reference cell, and the value: directions in which a basis function is known.
pub(super) const fn directions<const D: usize>(kernel: &BilinearConstants) -> usize {
    let gradients = if kernel.requirements.basis_gradient { D } else { 0 };
    gradients + kernel.requirements.basis_value as usize
}

/// Blocks of pairs of directions (a, b); of a symmetric form those with a ≤ b.
pub(in crate::assemble) const fn products<const D: usize>(kernel: &BilinearConstants) -> usize {
    let directions = directions::<D>(kernel);
    if kernel.symmetric { directions * (directions + 1) / 2 } else { directions * directions }
}

/// R_ab(i, j) for the pairs of nodes that are computed, pair after pair; of a symmetric form R_ab + R_ba.
pub(super) fn coefficients<const D: usize>(
    kernel: &BilinearConstants,
    side: &GroupSide<D>,
    elements: [usize; 2],
    weights: &[f64],
    symmetric: bool,
) -> Vec<f64> {
    let [tests, trials] =
        elements.map(|element| components(kernel.requirements, side, element, weights.len()));
    let directions = directions::<D>(kernel);
    let mut coefficients = Vec::new();
    for (i, test) in tests.chunks_exact(weights.len() * directions).enumerate() {
        for (j, trial) in trials.chunks_exact(weights.len() * directions).enumerate() {
            if symmetric && j < i {
                continue;
            }
            let entry = |a: usize, b: usize| -> f64 {
                let at = |(q, weight): (usize, &f64)| {
                    weight * test[q * directions + a] * trial[q * directions + b]
                };
                weights.iter().enumerate().map(at).sum()
            };
            for a in 0..directions {
                for b in if kernel.symmetric { a } else { 0 }..directions {
                    let mirrored = if kernel.symmetric && a != b { entry(b, a) } else { 0.0 };
                    coefficients.push(entry(a, b) + mirrored);
                }
            }
        }
    }
    coefficients
}

/// Of each node and point, the basis function's slopes and value, as far as the kernel reads them.
fn components<const D: usize>(
    requirements: &Requirements,
    side: &GroupSide<D>,
    element: usize,
    points: usize,
) -> Vec<f64> {
    let Requirements { basis_gradient, basis_value, .. } = *requirements;
    let table = &side.elements[element];
    let mut components = Vec::new();
    for node in 0..table.nodes {
        for q in 0..points {
            if basis_gradient {
                components.extend(table.gradient[q * table.nodes + node]);
            }
            if basis_value {
                components.push(table.value[q * table.nodes + node]);
            }
        }
    }
    components
}

/// A coefficient: a number, or one that is in all lanes already. Where the instructions that multiply cannot take a number from memory
/// for all lanes, the latter saves one per product.
pub(in crate::assemble) trait Coefficient<L> {
    fn lanes(&self) -> L;
}

impl<L: SimdLane> Coefficient<L> for f64 {
    #[inline(always)]
    fn lanes(&self) -> L {
        L::splat(*self)
    }
}

/// A number in all lanes.
pub(in crate::assemble) struct InLanes<L>(pub L);

impl<L: Copy> Coefficient<L> for InLanes<L> {
    #[inline(always)]
    fn lanes(&self) -> L {
        self.0
    }
}

/// The numbers of all pairs, as sums of coefficients.
#[inline(always)]
pub(in crate::assemble) fn contract<K, L, C, S, const D: usize>(
    kernel: &K,
    cell: &K::Cell<L>,
    coefficients: &[C],
    determinant: L,
    inverse: &[[L; D]; D],
    sink: &mut S,
) where
    K: BilinearKernel<D>,
    L: SimdLane,
    C: Coefficient<L>,
    S: BlockSink<L> + ?Sized,
{
    // A constant block: only the case that is used is compiled.
    match const { products::<D>(&BilinearConstants::of::<K, D>()) } {
        1 => contract_products::<K, L, C, S, 1, D>(kernel, cell, coefficients, determinant, inverse, sink),
        3 => contract_products::<K, L, C, S, 3, D>(kernel, cell, coefficients, determinant, inverse, sink),
        4 => contract_products::<K, L, C, S, 4, D>(kernel, cell, coefficients, determinant, inverse, sink),
        6 => contract_products::<K, L, C, S, 6, D>(kernel, cell, coefficients, determinant, inverse, sink),
        9 => contract_products::<K, L, C, S, 9, D>(kernel, cell, coefficients, determinant, inverse, sink),
        10 => contract_products::<K, L, C, S, 10, D>(kernel, cell, coefficients, determinant, inverse, sink),
        16 => contract_products::<K, L, C, S, 16, D>(kernel, cell, coefficients, determinant, inverse, sink),
        _ => unreachable!("at most three axes and the value"),
    }
}

#[inline(always)]
fn contract_products<K, L, C, S, const PRODUCTS: usize, const D: usize>(
    kernel: &K,
    cell: &K::Cell<L>,
    coefficients: &[C],
    determinant: L,
    inverse: &[[L; D]; D],
    sink: &mut S,
) where
    K: BilinearKernel<D>,
    L: SimdLane,
    C: Coefficient<L>,
    S: BlockSink<L> + ?Sized,
{
    let zero = L::splat(0.0);
    let geometry = PointGeometry::of_weight(determinant);
    let point = kernel.point(cell, &geometry, &[]);
    let further = Further::none();
    let mut products = [zero; PRODUCTS];
    let directions = const { directions::<D>(&BilinearConstants::of::<K, D>()) };
    let mut product = 0;
    for a in 0..directions {
        let test = kernel.test(&point, &direction::<K, L, D>(inverse, a), &further);
        for b in if K::SYMMETRIC { a } else { 0 }..directions {
            let trial = kernel.trial(&point, &direction::<K, L, D>(inverse, b), &further);
            let mut sum = K::zero::<L>();
            K::pair(&mut sum, &test, &trial);
            products[product] = kernel.finish(cell, &sum).as_ref()[0];
            product += 1;
        }
    }
    let (coefficients, _) = coefficients.as_chunks::<PRODUCTS>();
    sink.put_sums(&products, coefficients);
}

/// A function whose derivative along one axis of the reference cell is one, or whose value is.
#[inline(always)]
fn direction<K: BilinearKernel<D>, L: SimdLane, const D: usize>(
    inverse: &[[L; D]; D],
    number: usize,
) -> Basis<L, D> {
    let zero = L::splat(0.0);
    let mut basis = Basis { value: zero, gradient: [zero; D] };
    if K::REQUIREMENTS.basis_gradient && number < D {
        for i in 0..D {
            basis.gradient[i] = inverse[i][number];
        }
    } else {
        basis.value = L::splat(1.0);
    }
    basis
}
