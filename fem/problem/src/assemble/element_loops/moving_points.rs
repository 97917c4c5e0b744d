//! Derivatives of element vectors whose points move: a linear kernel that is run on values with derivatives along the motion.
//!
//! Points of cut cells move with the level set function, together with their weights. Those of moving segments follow the two ends. With
//! points s = (1 − ξ) a + ξ b of weight w (b − a) and the density ρ at them
//!
//! ```text
//! ∂/∂a Σ w (b − a) ρ(s) = Σ w (−ρ + (b − a)(1 − ξ) ρ′),  ∂/∂b: Σ w (ρ + (b − a) ξ ρ′)
//! ```

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
use crate::lanes::{InstructionSet, LaneWork, Moving, SharedWork, SimdLane, Transposition, WIDEST};

/// The motion of a group's points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointMotion {
    /// That of each point's record, with its weight: one vector per entity.
    OfRecords,
    /// Those by the two ends of moving segments: two vectors per entity, that by the first end before that by the last one.
    ByEnds,
}

impl PointMotion {
    /// Vectors per entity.
    fn vectors(self) -> usize {
        match self {
            PointMotion::OfRecords => 1,
            PointMotion::ByEnds => 2,
        }
    }
}

impl<const D: usize> ElementVectors<'_, D> {
    /// The derivatives of the element vectors of a group whose points move, as [`ElementVectors::compute`] hands over vectors.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub fn compute_moving<K: LinearKernel<D>>(
        &self,
        (kernel, constants): (&K, &LinearConstants),
        set: InstructionSet,
        (motion, range): (PointMotion, Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        set.checked().run(Compute { task: self, kernel, constants, motion, range, deliver })
    }

    #[inline(never)]
    fn moving_in_lanes<L: SimdLane>(
        &self,
        kernel: &LinearConstants,
        calls: &mut dyn VectorCalls<Moving<L>, D>,
        (motion, range): (PointMotion, Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        L::call(Loops { task: self, kernel, calls, motion, range, deliver })
    }
}

struct Compute<'a, 'd, K, const D: usize> {
    task: &'a ElementVectors<'a, D>,
    kernel: &'a K,
    constants: &'a LinearConstants,
    motion: PointMotion,
    range: Range<usize>,
    deliver: Deliver<'d>,
}

impl<K: LinearKernel<D>, const D: usize> LaneWork for Compute<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let calls = &mut LinearCalls::<K, Moving<L>, D>::new(self.kernel);
        self.task.moving_in_lanes::<L>(self.constants, calls, (self.motion, self.range), self.deliver)
    }
}

/// The loops over the batches of a range.
struct Loops<'a, 'd, 'c, L, const D: usize> {
    task: &'a ElementVectors<'d, D>,
    kernel: &'a LinearConstants,
    calls: &'a mut dyn VectorCalls<Moving<L>, D>,
    motion: PointMotion,
    range: Range<usize>,
    deliver: Deliver<'c>,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, motion, range, deliver } = self;
        let ElementVectors { group, side, element, .. } = *task;
        let ends = match (motion, group.pairs()) {
            (PointMotion::OfRecords, _) => None,
            (PointMotion::ByEnds, Some(pairs)) => Some(&pairs.group.motion),
            // No segments, no ends.
            (PointMotion::ByEnds, None) => return Ok(()),
        };
        let (nodes, zero, one) = (task.nodes(), L::splat(0.0), L::splat(1.0));
        let size = nodes * kernel.components;
        let requirements = *kernel.requirements;
        let [reading, _] = Reading::of_arguments(&requirements);
        let arguments = [ArgumentBasis { side, element, reading, mean: requirements.test_mean }];
        let mut buffers = BatchBuffers::<Moving<L>, D>::default();
        let mut batch = Batch::new(task.binding, group, task.cells, requirements, &arguments, &mut buffers)?;
        let nothing = Moving { value: zero, slope: zero };
        let stride = motion.vectors() * size;
        let (mut at_point, mut sums) = (vec![nothing; size], vec![zero; stride]);
        let mut vectors = vec![0.0; L::WIDTH * stride];
        let (mut rates, mut places) = ([0.0; WIDEST], [0; WIDEST]);
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            if let Some(motion) = ends {
                for lane in 0..L::WIDTH {
                    let unit = start + lane.min(filled - 1);
                    let [first, last] = &motion.ends[unit];
                    rates[lane] = 1.0 / (last.s - first.s);
                    places[lane] = unit * group.points();
                }
            }
            let rate = L::load(&rates);
            calls.call(&mut VectorCall::Cell(&batch.load(start, filled)));
            for k in 0..stride {
                sums[k] = zero;
            }
            for q in 0..group.points() {
                for k in 0..size {
                    at_point[k] = nothing;
                }
                batch.point(q)?;
                let (geometry, fields) = (batch.geometry(), batch.fields());
                let basis = &batch.basis(side, element)[..nodes];
                let further = &batch.further(side, element)[..nodes];
                let target = &mut at_point[..];
                calls.call(&mut VectorCall::Point { geometry, fields, basis, further, target, stride: 1 });
                let Some(motion) = ends else {
                    for k in 0..size {
                        sums[k] += at_point[k].slope;
                    }
                    continue;
                };
                let [part] = L::gather::<1>(&motion.fractions, &places);
                for lane in 0..L::WIDTH {
                    places[lane] += 1;
                }
                for k in 0..size {
                    let Moving { value, slope } = at_point[k];
                    let longer = rate * value;
                    sums[k] = sums[k] + (one - part) * slope - longer;
                    sums[size + k] = sums[size + k] + part * slope + longer;
                }
            }
            L::call(Transposition { source: &sums[..], filled, target: &mut vectors, stride });
            deliver(start, &vectors[..filled * stride])?;
            start += filled;
        }
        Ok(())
    }
}

instantiate!(moving_points in lanes: ElementVectors::<D>::moving_in_lanes::<L>);
