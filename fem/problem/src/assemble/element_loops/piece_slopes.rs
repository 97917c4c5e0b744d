//! Slopes of integrals over pieces by the numbers of their points: a linear kernel that is run on values with derivatives, once for each coordinate
//! of a point and of its normal. In the weight an integral is linear.
//!
//! A level set function moves all of these numbers, by each of its values on a cell: there are more values than numbers of a point.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::LinearConstants;

use super::linear_calls::{VectorCall, VectorCalls, values_at_point};
use super::sink::Deliver;
use super::vectors::ElementVectors;
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers};
use crate::assemble::groups::OwnPoints;
use crate::assemble::scatter::group_nodes::Reading;
use crate::lanes::{Moving, SharedWork, SimdLane, Transposition, WIDEST};

/// The loops over the batches of a range: of each entity in its order the slopes by all numbers of its points.
pub(in crate::assemble) struct Loops<'a, 'd, 'c, L, const D: usize> {
    pub task: &'a ElementVectors<'d, D>,
    pub kernel: &'a LinearConstants,
    pub calls: &'a mut dyn VectorCalls<Moving<L>, D>,
    /// The coefficients of the field in the place of the test function, entity by entity of the range.
    pub tests: &'a [f64],
    pub range: Range<usize>,
    pub deliver: Deliver<'c>,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, tests, range, deliver } = self;
        let ElementVectors { group, side, element, .. } = *task;
        let Some(OwnPoints::Cut(pieces)) = &group.own else { return Ok(()) };
        let (nodes, zero) = (task.nodes(), L::splat(0.0));
        let size = nodes * kernel.components;
        let requirements = *kernel.requirements;
        let [reading, _] = Reading::of_arguments(&requirements);
        let own = [ArgumentBasis { side, element, reading, mean: requirements.test_mean }];
        let mut buffers = BatchBuffers::<Moving<L>, D>::default();
        let mut batch = Batch::new(task.binding, group, task.cells, requirements, &own, &mut buffers)?;
        let nothing = Moving { value: zero, slope: zero };
        let (numbers, length) = (pieces.stride(), pieces.stride() * group.points());
        let (mut at_point, mut test, mut slopes) =
            (vec![nothing; size], vec![zero; size], vec![zero; length]);
        let mut delivered = vec![0.0; L::WIDTH * length];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            calls.call(&mut VectorCall::Cell(&batch.load(start, filled)));
            let (mut places, mut weights) = ([0; WIDEST], [0; WIDEST]);
            for lane in 0..L::WIDTH {
                let entity = start + lane.min(filled - 1);
                places[lane] = (entity - range.start) * size;
                weights[lane] = entity * length + D;
            }
            for k in 0..size {
                [test[k]] = L::gather::<1>(tests, &places);
                for lane in 0..L::WIDTH {
                    places[lane] += 1;
                }
            }
            for q in 0..group.points() {
                let own = &mut slopes[q * numbers..][..numbers];
                for number in (0..numbers).filter(|number| *number != D) {
                    batch.move_along(number);
                    batch.point(q)?;
                    let functions = batch.functions(side, element, nodes);
                    values_at_point(calls, &batch, functions, &mut at_point);
                    let (mut slope, mut value) = (zero, zero);
                    for k in 0..size {
                        slope = at_point[k].slope.multiply_add(test[k], slope);
                        value = at_point[k].value.multiply_add(test[k], value);
                    }
                    own[number] = slope;
                    if number == 0 {
                        let [weight] = L::gather::<1>(&pieces.points, &weights);
                        // Points without weight fill lanes only.
                        own[D] = L::select(weight.equal(zero), zero, value / weight);
                    }
                }
                for lane in 0..L::WIDTH {
                    weights[lane] += numbers;
                }
            }
            L::call(Transposition { source: &slopes[..], filled, target: &mut delivered, stride: length });
            deliver(start, &delivered[..filled * length])?;
            start += filled;
        }
        Ok(())
    }
}
