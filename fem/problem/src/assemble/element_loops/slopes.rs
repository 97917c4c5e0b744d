//! Derivatives of element vectors along a motion of their points: a linear kernel that is run on values with derivatives.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{LinearConstants, LinearKernel};

use super::linear_calls::{LinearCalls, VectorCall, VectorCalls};
use super::sink::Deliver;
use super::vectors::ElementVectors;
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers};
use crate::assemble::scatter::group_nodes::Reading;
use crate::instantiate::instantiate;
use crate::lanes::{InstructionSet, LaneWork, Moving, SharedWork, SimdLane, Transposition};

impl<const D: usize> ElementVectors<'_, D> {
    /// The derivatives of the element vectors of a group whose points move, handed over as [`ElementVectors::compute`] hands over vectors.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub fn compute_slopes<K: LinearKernel<D>>(
        &self,
        (kernel, constants): (&K, &LinearConstants),
        set: InstructionSet,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        set.checked().run(Compute { task: self, kernel, constants, range, deliver })
    }

    #[inline(never)]
    fn slopes_in_lanes<L: SimdLane>(
        &self,
        kernel: &LinearConstants,
        calls: &mut dyn VectorCalls<Moving<L>, D>,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        L::call(Loops { task: self, kernel, calls, range, deliver })
    }
}

struct Compute<'a, 'd, K, const D: usize> {
    task: &'a ElementVectors<'a, D>,
    kernel: &'a K,
    constants: &'a LinearConstants,
    range: Range<usize>,
    deliver: Deliver<'d>,
}

impl<K: LinearKernel<D>, const D: usize> LaneWork for Compute<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let calls = &mut LinearCalls::<K, Moving<L>, D>::new(self.kernel);
        self.task.slopes_in_lanes::<L>(self.constants, calls, self.range, self.deliver)
    }
}

/// The loops over the batches of a range.
struct Loops<'a, 'd, 'c, L, const D: usize> {
    task: &'a ElementVectors<'d, D>,
    kernel: &'a LinearConstants,
    calls: &'a mut dyn VectorCalls<Moving<L>, D>,
    range: Range<usize>,
    deliver: Deliver<'c>,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, range, deliver } = self;
        let ElementVectors { group, side, element, .. } = *task;
        let (nodes, zero) = (task.nodes(), L::splat(0.0));
        let size = nodes * kernel.components;
        let requirements = *kernel.requirements;
        let [reading, _] = Reading::of_arguments(&requirements);
        let arguments = [ArgumentBasis { side, element, reading, mean: requirements.test_mean }];
        let mut buffers = BatchBuffers::<Moving<L>, D>::default();
        let mut batch = Batch::new(task.binding, group, task.cells, requirements, &arguments, &mut buffers)?;
        let nothing = Moving { value: zero, slope: zero };
        let (mut sums, mut slopes) = (vec![nothing; size], vec![zero; size]);
        let mut vectors = vec![0.0; L::WIDTH * size];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            calls.call(&mut VectorCall::Cell(&batch.load(start, filled)));
            for k in 0..size {
                sums[k] = nothing;
            }
            for q in 0..group.points() {
                batch.point(q)?;
                let (geometry, fields) = (batch.geometry(), batch.fields());
                let basis = &batch.basis(side, element)[..nodes];
                let further = &batch.further(side, element)[..nodes];
                let target = &mut sums[..];
                calls.call(&mut VectorCall::Point { geometry, fields, basis, further, target, stride: 1 });
            }
            for k in 0..size {
                slopes[k] = sums[k].slope;
            }
            L::call(Transposition { source: &slopes[..], filled, target: &mut vectors, stride: size });
            deliver(start, &vectors[..filled * size])?;
            start += filled;
        }
        Ok(())
    }
}

instantiate!(slopes in lanes: ElementVectors::<D>::slopes_in_lanes::<L>);
