//! Element vectors with loops of known lengths.
//!
//! A kernel's contribution to a test function is linear in its value and gradient. So the kernel is not called for each basis function, but
//! at each point for D + 1 unit functions: one with value one, and one per axis of the reference cell with derivative one along it. A
//! basis function combines the answers (`fluxes`) by its own tabulated value and derivatives.
//!
//! Example: on a quadratic tetrahedron with four points and ten basis functions the kernel is called 4 · (1 + 3) = 16 times, not
//! 4 · 10 = 40, and the gradient of a basis function is never transformed to the physical cell. The rest is, per basis function and
//! component, a sum over the points of up to four products.
//!
//! All points come before the first basis function, so that its two or three sums stay in registers. The lengths of all loops are
//! constants ([`Sizes`]), so that rustc unrolls them; the sums leave through `order`, in the numbering of the caller.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{Basis, Further, LinearKernel};

use super::batch::FixedBatch;
use super::field_buffers::FieldBuffers;
use super::tables::{MOST_COMPONENTS, MOST_NUMBERS};
use super::{Call, FixedIntegral, FixedTables, store};
use crate::assemble::element_kernel::ElementCells;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::lanes::{LaneWork, Order, Ordered, SharedWork, SimdLane};

/// Makes an integral of a residual ready for a lane type.
pub(in crate::assemble) struct PrepareVectors<'a, K, S: Sizes, const D: usize> {
    pub kernel: &'a K,
    pub tables: FixedTables<S, D>,
    /// Entry k of a vector is the `order[k]`-th of `[node][component]`.
    pub order: &'a Order,
}

/// An integral of a residual.
struct Vectors<K, L, S: Sizes, const D: usize> {
    kernel: K,
    tables: FixedTables<S, D>,
    order: Order,
    fields: FieldBuffers<L>,
    /// Contributions of a kernel to each requested function, at each point.
    fluxes: Vec<L>,
    sums: Vec<L>,
}

/// Functions that a kernel is asked for at a point.
const fn asked<K: LinearKernel<D>, const D: usize>() -> usize {
    let requirements = &K::REQUIREMENTS;
    requirements.basis_value as usize + if requirements.basis_gradient { D } else { 0 }
}

impl<K: LinearKernel<D>, S: Sizes, const D: usize> LaneWork for PrepareVectors<'_, K, S, D> {
    type Output = Box<dyn FixedIntegral>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let PrepareVectors { kernel, tables, order } = self;
        let size = <S::Nodes<f64> as Array<f64>>::LENGTH * K::TEST_COMPONENTS;
        let fields = FieldBuffers::new(&K::REQUIREMENTS, &tables);
        let sums = vec![L::splat(0.0); size];
        let points = <S::Points<f64> as Array<f64>>::LENGTH;
        let fluxes = vec![L::splat(0.0); points * asked::<K, D>() * MOST_COMPONENTS];
        let (kernel, order) = (kernel.clone(), order.clone());
        Box::new(Vectors::<K, L, S, D> { kernel, tables, order, fields, fluxes, sums })
    }
}

impl<K: LinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> FixedIntegral for Vectors<K, L, S, D> {
    fn run(&mut self, cells: &ElementCells, target: &mut [f64], add: bool) {
        L::call(Call { integral: self, cells, target, add });
    }
}

impl<K: LinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> SharedWork<L>
    for Call<'_, Vectors<K, L, S, D>>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Call { integral, cells, target, add } = self;
        let size = const { <S::Nodes<f64> as Array<f64>>::LENGTH * K::TEST_COMPONENTS };
        let mut start = 0;
        while start < cells.count {
            let filled = L::WIDTH.min(cells.count - start);
            match K::TEST_COMPONENTS {
                1 => integral.sums::<1>(cells, start, filled),
                2 => integral.sums::<2>(cells, start, filled),
                _ => integral.sums::<MOST_COMPONENTS>(cells, start, filled),
            }
            let source = Ordered::new(&integral.sums, &integral.order, size);
            store(source, size, filled, &mut target[start * size..][..filled * size], add);
            start += filled;
        }
    }
}

impl<K: LinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> Vectors<K, L, S, D> {
    /// The sums of `filled` cells from `start` on.
    #[inline(always)]
    fn sums<const C: usize>(&mut self, cells: &ElementCells, start: usize, filled: usize) {
        let requirements = &K::REQUIREMENTS;
        let zero = L::splat(0.0);
        let Vectors { kernel, tables, fields, fluxes, sums, .. } = self;
        let (kernel, tables) = (&*kernel, &*tables);
        let batch = FixedBatch::<L, S, D>::load(requirements, tables, cells, start, filled, fields);
        let cell = kernel.cell(&batch.cell_geometry(requirements));
        let asked = const { asked::<K, D>() };
        // Of known lengths: nothing is checked per function.
        let (fluxes, _) = fluxes.as_chunks_mut::<C>();
        let fluxes = &mut fluxes[..<S::Points<f64> as Array<f64>>::LENGTH * asked];
        let further = Further::none();
        let arguments = &tables.arguments;
        let mut numbers = [zero; MOST_NUMBERS];
        for q in 0..<S::Points<f64> as Array<f64>>::LENGTH {
            let map = batch.map_at(q);
            let geometry = batch.point(requirements, q, &map, fields, &mut numbers);
            let flux = kernel.point(&cell, &geometry, &numbers);
            for number in 0..asked {
                let mut unit = Basis { value: zero, gradient: [zero; D] };
                if requirements.basis_value && number == 0 {
                    unit.value = L::splat(1.0);
                } else {
                    let j = number - requirements.basis_value as usize;
                    for i in 0..D {
                        unit.gradient[i] = map.inverse[i][j];
                    }
                }
                let block = kernel.test(&flux, &unit, &further);
                let block = &block.as_ref()[..C];
                for component in 0..C {
                    fluxes[q * asked + number][component] = block[component];
                }
            }
        }
        let (sums, _) = sums.as_chunks_mut::<C>();
        let sums = &mut sums[..<S::Nodes<f64> as Array<f64>>::LENGTH];
        for node in 0..sums.len() {
            let mut sum = [zero; C];
            for q in 0..<S::Points<f64> as Array<f64>>::LENGTH {
                let mut own = &fluxes[q * asked..][..asked];
                if requirements.basis_value
                    && let Some((flux, others)) = own.split_first()
                {
                    let value = L::splat(arguments.values.entries()[q].entries()[node]);
                    for component in 0..C {
                        sum[component] = flux[component].multiply_add(value, sum[component]);
                    }
                    own = others;
                }
                if requirements.basis_gradient {
                    let slopes = &arguments.slopes.entries()[q].entries()[node];
                    for j in 0..D {
                        let slope = L::splat(slopes[j]);
                        for component in 0..C {
                            sum[component] = own[j][component].multiply_add(slope, sum[component]);
                        }
                    }
                }
            }
            sums[node] = sum;
        }
    }
}
