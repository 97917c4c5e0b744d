//! Element vectors with loops of known lengths.
//!
//! What a kernel adds to a test function is linear in it: at each point the kernel is asked for the functions
//! whose value, or whose derivative along one axis of the reference cell, is one, and each basis function
//! combines these by its own tabulated values.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{Basis, LinearKernel};

use super::batch::{FieldBuffers, FixedBatch};
use super::tables::MOST_COMPONENTS;
use super::{FixedTask, put_out};
use crate::assemble::element_kernel::{Kept, recall};
use crate::assemble::sizes::{Array, Sizes};
use crate::lanes::{LaneWork, Order, Ordered, SimdLane};

/// One run over the cells that the caller lists.
pub(in crate::assemble) struct FixedVectors<'a, K, S: Sizes, const D: usize> {
    pub task: FixedTask<'a, K, S, D>,
    /// Entry k of a vector is the `order[k]`-th of `[node][component]`.
    pub order: &'a Order,
    pub memory: &'a mut Kept,
    pub target: &'a mut [f64],
    /// Adds to what is there.
    pub add: bool,
}

struct Buffers<L> {
    fields: FieldBuffers<L>,
    sums: Vec<L>,
}

impl<L> Default for Buffers<L> {
    fn default() -> Self {
        Buffers { fields: FieldBuffers::default(), sums: vec![] }
    }
}

impl<K: LinearKernel<D>, S: Sizes, const D: usize> LaneWork for FixedVectors<'_, K, S, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: SimdLane>(self) {
        let listed = self.task.listed;
        let mut buffers = recall::<Buffers<L>>(self.memory);
        let size = <S::Nodes<f64> as Array<f64>>::LENGTH * K::TEST_COMPONENTS;
        let mut start = 0;
        while start < listed.count {
            let filled = L::WIDTH.min(listed.count - start);
            match K::TEST_COMPONENTS {
                1 => self.task.sums::<L, 1>(start, filled, &mut buffers),
                2 => self.task.sums::<L, 2>(start, filled, &mut buffers),
                _ => self.task.sums::<L, MOST_COMPONENTS>(start, filled, &mut buffers),
            }
            let source = &Ordered::new(&buffers.sums, self.order, size);
            let target = &mut self.target[start * size..][..filled * size];
            put_out(source, size, filled, target, self.add);
            start += filled;
        }
        *self.memory = Some(buffers);
    }
}

impl<K: LinearKernel<D>, S: Sizes, const D: usize> FixedTask<'_, K, S, D> {
    #[inline(always)]
    fn sums<L: SimdLane, const C: usize>(&self, start: usize, filled: usize, buffers: &mut Buffers<L>) {
        let requirements = &K::REQUIREMENTS;
        let zero = L::splat(0.0);
        let kernel = self.kernel;
        let Buffers { fields, sums } = buffers;
        let batch = FixedBatch::<L, S, D>::load(
            requirements,
            self.group,
            self.tables,
            &self.listed,
            start,
            filled,
            fields,
        );
        let cell = kernel.cell(&batch.cell_geometry(requirements));
        let mut totals = S::Nodes::filled([zero; C]);
        let totals = totals.entries_mut();
        let hessian = [[zero; D]; D];
        let arguments = &self.tables.arguments;
        for q in 0..<S::Points<f64> as Array<f64>>::LENGTH {
            let place = batch.place(q);
            let geometry = batch.point(requirements, q, &place, fields);
            let flux = kernel.point(&cell, &geometry, &fields.fields);
            let values = &arguments.values.entries()[q].entries()[..totals.len()];
            let slopes = &arguments.slopes.entries()[q].entries()[..totals.len()];
            if requirements.basis_value {
                let unit = Basis { value: L::splat(1.0), gradient: [zero; D] };
                let block = kernel.test(&flux, &unit, &hessian);
                let block = &block.as_ref()[..C];
                for i in 0..totals.len() {
                    for component in 0..C {
                        totals[i][component] =
                            block[component].multiply_add(L::splat(values[i]), totals[i][component]);
                    }
                }
            }
            if requirements.basis_gradient {
                let mut blocks = [[zero; C]; D];
                for j in 0..D {
                    let mut unit = Basis { value: zero, gradient: [zero; D] };
                    for i in 0..D {
                        unit.gradient[i] = place.inverse[i][j];
                    }
                    let block = kernel.test(&flux, &unit, &hessian);
                    let block = &block.as_ref()[..C];
                    for component in 0..C {
                        blocks[j][component] = block[component];
                    }
                }
                for i in 0..totals.len() {
                    for j in 0..D {
                        let slope = L::splat(slopes[i][j]);
                        for component in 0..C {
                            totals[i][component] =
                                blocks[j][component].multiply_add(slope, totals[i][component]);
                        }
                    }
                }
            }
        }
        sums.resize(totals.len() * C, zero);
        let sums = &mut sums[..totals.len() * C];
        for i in 0..totals.len() {
            for component in 0..C {
                sums[i * C + component] = totals[i][component];
            }
        }
    }
}
