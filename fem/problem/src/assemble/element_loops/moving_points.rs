//! Derivatives of element vectors whose points move: a linear kernel that is run on values with derivatives along the motion.
//!
//! Points of moving segments follow the feet of opposite nodes. With the coordinate c of a foot, points s of weight W and the density ρ at them
//!
//! ```text
//! ∂/∂c Σ W ρ(s) = Σ W (ρ,_α ∂s^α/∂c + ρ ∂W/∂c / W)
//! ```

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{Basis, Further, Lane, LinearConstants};

use super::linear_calls::{VectorCall, VectorCalls};
use super::sink::Deliver;
use super::vectors::ElementVectors;
#[cfg(not(test))]
use super::{piece_slopes, second_motion};
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers};
use crate::assemble::scatter::group_nodes::Reading;
use crate::instantiate::instantiate;
#[cfg(not(test))]
use crate::lanes::Both;
use crate::lanes::{Moving, SharedWork, SimdLane, SimdSlope, Transposition, WIDEST};

/// The motion of the points of moving segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointMotion<'a> {
    /// By the feet of their nodes: one vector per coordinate of each foot, of the test functions at some places among those of a cell.
    ByFeet(&'a [usize]),
    /// The same of the integrand: its test function is 1 in each component.
    OfIntegrand,
}

/// The loops over the batches of a range: derivatives of the element vectors of its entities, in their order.
pub(in crate::assemble) struct Loops<'a, 'd, 'c, L, S, const D: usize> {
    pub task: &'a ElementVectors<'d, D>,
    pub kernel: &'a LinearConstants,
    pub calls: &'a mut dyn VectorCalls<Moving<L, S>, D>,
    pub motion: PointMotion<'a>,
    pub range: Range<usize>,
    pub deliver: Deliver<'c>,
}

impl<L: SimdLane, S: SimdSlope<L>, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, S, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, motion, range, deliver } = self;
        let ElementVectors { group, side, element, .. } = *task;
        // No segments, no feet.
        let Some(moving) = group.pairs().map(|pairs| &pairs.group.motion) else { return Ok(()) };
        let (vectors_each, directions) = (moving.coordinates(group.entities()), D - 1);
        let (of_integrand, places) = match motion {
            PointMotion::ByFeet(places) => (false, places),
            PointMotion::OfIntegrand => (true, &[0][..]),
        };
        let (nodes, zero) = (if of_integrand { 1 } else { task.nodes() }, L::splat(0.0));
        let unit = Basis { value: Moving::splat(1.0), gradient: [Moving::splat(0.0); D] };
        let (components, size) = (kernel.components, places.len() * kernel.components);
        let requirements = *kernel.requirements;
        let [reading, _] = Reading::of_arguments(&requirements);
        let own = [ArgumentBasis { side, element, reading, mean: requirements.test_mean }];
        let arguments = if of_integrand { &[][..] } else { &own };
        let mut buffers = BatchBuffers::<Moving<L, S>, D>::default();
        let mut batch = Batch::new(task.binding, group, task.cells, requirements, arguments, &mut buffers)?;
        let nothing = Moving::<L, S>::splat(0.0);
        let stride = vectors_each * size;
        let (mut at_point, mut sums) = (vec![nothing; nodes * components], vec![zero; stride]);
        let (mut values, mut slopes) = (vec![zero; size], vec![zero; directions.max(S::DIRECTIONS) * size]);
        let mut vectors = vec![0.0; L::WIDTH * stride];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            calls.call(&mut VectorCall::Cell(&batch.load(start, filled)));
            for k in 0..stride {
                sums[k] = zero;
            }
            for q in 0..group.points() {
                for first in (0..directions).step_by(S::DIRECTIONS) {
                    for k in 0..nodes * components {
                        at_point[k] = nothing;
                    }
                    batch.move_along(first);
                    batch.point(q)?;
                    let (geometry, fields) = (batch.geometry(), batch.fields());
                    let (basis, further) = match of_integrand {
                        true => (&[unit][..], &[Further::none()][..]),
                        false => {
                            (&batch.basis(side, element)[..nodes], &batch.further(side, element)[..nodes])
                        }
                    };
                    let target = &mut at_point[..];
                    calls.call(&mut VectorCall::Point {
                        geometry,
                        fields,
                        basis,
                        further,
                        target,
                        stride: 1,
                    });
                    for i in 0..places.len() {
                        for component in 0..components {
                            let Moving { value, slope } = at_point[places[i] * components + component];
                            let k = i * components + component;
                            // The same in all directions.
                            values[k] = value;
                            for direction in 0..S::DIRECTIONS {
                                slopes[(first + direction) * size + k] = slope.along(direction);
                            }
                        }
                    }
                }
                let mut first = [0; WIDEST];
                for lane in 0..L::WIDTH {
                    let unit = start + lane.min(filled - 1);
                    first[lane] = (unit * group.points() + q) * vectors_each * D;
                }
                let [along, across] = [&slopes[..size], &slopes[(directions - 1) * size..][..size]];
                for number in 0..vectors_each {
                    let shares = L::gather::<D>(&moving.shares, &first);
                    for lane in 0..L::WIDTH {
                        first[lane] += D;
                    }
                    let sums = &mut sums[number * size..][..size];
                    for k in 0..size {
                        let mut sum = shares[D - 1].multiply_add(values[k], sums[k]);
                        sum = shares[0].multiply_add(along[k], sum);
                        if D == 3 {
                            sum = shares[1].multiply_add(across[k], sum);
                        }
                        sums[k] = sum;
                    }
                }
            }
            L::call(Transposition { source: &sums[..], filled, target: &mut vectors, stride });
            deliver(start, &vectors[..filled * stride])?;
            start += filled;
        }
        Ok(())
    }
}

instantiate!(moving_points in lanes: L::call::<Loops<L, L, D>>, L::call::<Loops<L, Both<L>, D>>, L::call::<piece_slopes::Loops<L, D>>,
    L::call::<second_motion::Loops<L, D>>);
