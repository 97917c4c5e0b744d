//! The calls of a linear kernel whose type is forgotten, one for each point of a batch of cells: what surrounds them is compiled once
//! and not for every kernel.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Deref;

use forms_core::contract::{Basis, CellGeometry, Further, LinearKernel, PointGeometry};

use crate::assemble::batch::Batch;
use crate::lanes::{Moving, SharedWork, SimdLane};

/// A call for the cells of a batch.
pub(in crate::assemble) enum VectorCall<'a, L, const D: usize> {
    /// Quantities that are constant on the cells, before the first point.
    Cell(&'a CellGeometry<L>),
    /// The contributions of a point to some test functions.
    Point {
        geometry: &'a PointGeometry<L, D>,
        fields: &'a [L],
        basis: &'a [Basis<L, D>],
        /// As many as basis functions.
        further: &'a [Further<L, D>],
        /// That for function i and component c is added at `(i * components + c) * stride`.
        target: &'a mut [L],
        stride: usize,
    },
}

/// A kernel, and what it knows of the cells at hand.
pub(in crate::assemble) trait VectorCalls<L, const D: usize> {
    fn call(&mut self, call: &mut VectorCall<L, D>);
}

/// The calls of a kernel on values with derivatives along the motion of their points, as a type that does not depend on the kernel's.
pub(in crate::assemble) struct MovingCalls<L, S, const D: usize>(pub Box<dyn VectorCalls<Moving<L, S>, D>>);

/// The values of a kernel at the current point of a batch, for some functions, in place of those in a list.
#[inline(always)]
pub(in crate::assemble) fn values_at_point<L: SimdLane, const D: usize>(
    calls: &mut dyn VectorCalls<L, D>,
    batch: &Batch<L, D>,
    (basis, further): (&[Basis<L, D>], &[Further<L, D>]),
    target: &mut [L],
) {
    for k in 0..target.len() {
        target[k] = L::splat(0.0);
    }
    let (geometry, fields) = (batch.geometry(), batch.fields());
    calls.call(&mut VectorCall::Point { geometry, fields, basis, further, target, stride: 1 });
}

/// The calls of a kernel of a known type, by a pointer to it.
pub(in crate::assemble) struct LinearCalls<P: Deref, L: SimdLane, const D: usize>
where
    P::Target: LinearKernel<D>,
{
    kernel: P,
    cell: Option<<P::Target as LinearKernel<D>>::Cell<L>>,
}

impl<P: Deref, L: SimdLane, const D: usize> LinearCalls<P, L, D>
where
    P::Target: LinearKernel<D>,
{
    #[inline(always)]
    pub fn new(kernel: P) -> Self {
        LinearCalls { kernel, cell: None }
    }
}

impl<K: LinearKernel<D>, P: Deref<Target = K>, L: SimdLane, const D: usize> VectorCalls<L, D>
    for LinearCalls<P, L, D>
{
    fn call(&mut self, call: &mut VectorCall<L, D>) {
        L::call(Work { calls: self, call });
    }
}

/// A call, compiled for the lane type's instructions. Two pointers: what is longer would be copied on its way.
struct Work<'a, 'c, C, L, const D: usize> {
    calls: &'a mut C,
    call: &'a mut VectorCall<'c, L, D>,
}

impl<K: LinearKernel<D>, P: Deref<Target = K>, L: SimdLane, const D: usize> SharedWork<L>
    for Work<'_, '_, LinearCalls<P, L, D>, L, D>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let LinearCalls { kernel, cell } = self.calls;
        let kernel: &K = kernel;
        match self.call {
            VectorCall::Cell(geometry) => *cell = Some(kernel.cell(geometry)),
            VectorCall::Point { geometry, fields, basis, further, target, stride } => {
                let Some(cell) = cell else { unreachable!("a cell comes before its points") };
                let flux = kernel.point(cell, geometry, fields);
                let (components, stride) = (K::TEST_COMPONENTS, *stride);
                let further = &further[..basis.len()];
                for i in 0..basis.len() {
                    let block = kernel.test(&flux, &basis[i], &further[i]);
                    let block = &block.as_ref()[..components];
                    for component in 0..components {
                        target[(i * components + component) * stride] += block[component];
                    }
                }
            }
        }
    }
}
