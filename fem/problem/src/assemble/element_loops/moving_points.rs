//! Derivatives of element vectors whose points move: a linear kernel that is run on values with derivatives along the motion.
//!
//! Points of moving segments follow the feet of opposite nodes. With the coordinate c of a foot, points s of weight W and the density ρ at them
//!
//! ```text
//! ∂/∂c Σ W ρ(s) = Σ W (ρ,_α ∂s^α/∂c + ρ ∂W/∂c / W)
//! ```
//!
//! Integrals at the same points, as of the test functions of both sides, have them in common: geometry, basis functions and fields are evaluated once.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{Basis, Further, Lane, LinearConstants, Requirements};

use super::MovingCalls;
use super::linear_calls::{VectorCall, values_at_point};
use super::sink::Deliver;
#[cfg(not(test))]
use super::{piece_slopes, second_motion};
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::groups::Group;
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

/// A linear kernel whose points move, with its test function.
#[derive(Clone, Copy)]
pub(in crate::assemble) struct MovingTest<'a> {
    pub kernel: LinearConstants,
    /// The factor of the kernel's values.
    pub factor: f64,
    pub motion: PointMotion<'a>,
    /// The side on which the test function lives.
    pub side: usize,
    /// Its element, by index into the binding's.
    pub element: usize,
}

impl MovingTest<'_> {
    /// The places of the test functions that count.
    #[inline(always)]
    fn places(&self) -> &[usize] {
        match self.motion {
            PointMotion::ByFeet(places) => places,
            PointMotion::OfIntegrand => &[0],
        }
    }

    /// Numbers of its vector.
    #[inline(always)]
    pub fn size(&self) -> usize {
        self.places().len() * self.kernel.components
    }

    fn argument(&self) -> Option<ArgumentBasis> {
        let (MovingTest { side, element, .. }, requirements) = (*self, self.kernel.requirements);
        let [reading, _] = Reading::of_arguments(requirements);
        let basis = ArgumentBasis { side, element, reading, mean: requirements.test_mean };
        (self.motion != PointMotion::OfIntegrand).then_some(basis)
    }
}

/// The inputs of kernels that have their points in common.
pub(in crate::assemble) struct MovingVectors<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// The inputs of all kernels together.
    pub requirements: Requirements,
    pub tests: &'a [MovingTest<'a>],
}

/// The loops over the batches of a range: derivatives of the element vectors of its entities, in their order. By each coordinate of a foot an entity
/// has the vectors of all kernels, one after the other.
pub(in crate::assemble) struct Loops<'a, 'd, 'c, L, S, const D: usize> {
    pub task: &'a MovingVectors<'d, D>,
    /// Those of each test function's kernel.
    pub calls: &'a mut [MovingCalls<L, S, D>],
    pub range: Range<usize>,
    pub deliver: Deliver<'c>,
}

impl<L: SimdLane, S: SimdSlope<L>, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, S, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, calls, range, deliver } = self;
        let MovingVectors { binding, group, requirements, tests } = *task;
        // No segments, no feet.
        let Some(moving) = group.pairs().map(|pairs| &pairs.group.motion) else { return Ok(()) };
        let (vectors_each, directions) = (moving.coordinates(group.entities()), D - 1);
        let unit = Basis { value: Moving::splat(1.0), gradient: [Moving::splat(0.0); D] };
        let arguments: Vec<ArgumentBasis> = tests.iter().filter_map(MovingTest::argument).collect();
        let mut buffers = BatchBuffers::<Moving<L, S>, D>::default();
        let cells = Cells::Mesh(binding.mesh);
        let mut batch = Batch::new(binding, group, cells, requirements, &arguments, &mut buffers)?;
        let size: usize = tests.iter().map(MovingTest::size).sum();
        let (zero, stride) = (L::splat(0.0), vectors_each * size);
        let (mut at_point, mut sums) = (vec![], vec![zero; stride]);
        let (mut values, mut slopes) = (vec![zero; size], vec![zero; directions.max(S::DIRECTIONS) * size]);
        let mut vectors = vec![0.0; L::WIDTH * stride];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let geometry = batch.load(start, filled);
            for t in 0..tests.len() {
                calls[t].0.call(&mut VectorCall::Cell(&geometry));
            }
            for k in 0..stride {
                sums[k] = zero;
            }
            for q in 0..group.points() {
                for first in (0..directions).step_by(S::DIRECTIONS) {
                    batch.move_along(first);
                    batch.point(q)?;
                    let mut before = 0;
                    for t in 0..tests.len() {
                        let MovingTest { side, element, motion, .. } = tests[t];
                        let functions = match motion {
                            PointMotion::OfIntegrand => (&[unit][..], &[Further::none()][..]),
                            PointMotion::ByFeet(_) => {
                                batch.functions(side, element, group.sides[side].elements[element].nodes)
                            }
                        };
                        let (places, components) = (tests[t].places(), tests[t].kernel.components);
                        at_point.resize(functions.0.len() * components, Moving::splat(0.0));
                        values_at_point(&mut *calls[t].0, &batch, functions, &mut at_point);
                        for i in 0..places.len() {
                            for component in 0..components {
                                let Moving { value, slope } = at_point[places[i] * components + component];
                                let k = before + i * components + component;
                                // The same in all directions.
                                values[k] = value;
                                for direction in 0..S::DIRECTIONS {
                                    slopes[(first + direction) * size + k] = slope.along(direction);
                                }
                            }
                        }
                        before += places.len() * components;
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
            let mut before = 0;
            for t in 0..tests.len() {
                let (own, factor) = (tests[t].size(), tests[t].factor);
                if factor != 1.0 {
                    for number in 0..vectors_each {
                        for k in number * size + before..number * size + before + own {
                            sums[k] = sums[k] * L::splat(factor);
                        }
                    }
                }
                before += own;
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
