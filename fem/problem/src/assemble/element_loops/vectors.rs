//! Element vectors of a linear integral: the loops over batches and points, from which the integral's kernel is called.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{Basis, Further, LinearConstants};

use super::linear_calls::{VectorCall, VectorCalls};
#[cfg(not(test))]
use super::point_values;
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::element_loops::sink::Sink;
use crate::assemble::element_loops::sum_factorisation::{
    Derivatives, Integration, ProductTables, Stages, axis_operations, unit,
};
use crate::assemble::groups::Group;
use crate::assemble::scatter::group_nodes::Reading;
use crate::instantiate::instantiate;
use crate::lanes::{Order, Ordered, SharedWork, SimdLane, Transposition};

/// Inputs of the element vectors of a group, besides the kernel.
pub(in crate::assemble) struct ElementVectors<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// The source of the cells' nodes.
    pub cells: Cells<'a, D>,
    /// The side on which the test function lives.
    pub side: usize,
    /// Its element, by index into the binding's.
    pub element: usize,
}

/// Memory of the loops, kept from one run to the next.
pub(in crate::assemble) struct VectorBuffers<L, const D: usize> {
    batch: BatchBuffers<L, D>,
    sums: Vec<L>,
    /// Factors of the basis functions' values and derivatives at each point, for sum factorisation.
    at_points: Vec<L>,
    stages: Stages<L>,
}

impl<L: SimdLane, const D: usize> Default for VectorBuffers<L, D> {
    fn default() -> Self {
        VectorBuffers {
            batch: BatchBuffers::default(),
            sums: vec![],
            at_points: vec![],
            stages: Stages::default(),
        }
    }
}

impl<const D: usize> ElementVectors<'_, D> {
    /// Number of test nodes.
    pub fn nodes(&self) -> usize {
        self.group.sides[self.side].elements[self.element].nodes
    }

    /// The tables, if sum factorisation takes fewer operations than sums over the nodes at each point.
    fn factorised(&self, kernel: &LinearConstants) -> Option<&ProductTables> {
        let tables = self.group.sides[self.side].products[self.element].as_ref()?;
        let (requirements, of_test) = (kernel.requirements, kernel.operations.test);
        if requirements.reads_further() {
            return None;
        }
        let (nodes, points) = (self.nodes(), self.group.points());
        let derivatives = Derivatives::of_arguments(requirements);
        let transformed = if derivatives.gradient { D * D } else { 0 };
        let direct = points * nodes * (of_test + transformed);
        let made = points * derivatives.count::<D>() * of_test
            + kernel.components * axis_operations::<D>(tables, derivatives);
        (made < direct).then_some(tables)
    }
}

/// The loops over the batches of a range: element vectors of its entities, in their order. Where sums go along the axes, the kernel is
/// asked at each point for the functions whose value, or whose derivative along one axis of the reference cell, is one.
pub(in crate::assemble) struct Loops<'a, 'd, L, const D: usize> {
    pub task: &'a ElementVectors<'d, D>,
    pub kernel: &'a LinearConstants,
    pub calls: &'a mut dyn VectorCalls<L, D>,
    /// With it entry k of a vector is the `order[k]`-th of `[node][component]`.
    pub order: Option<&'a Order>,
    pub range: Range<usize>,
    /// Memory that is kept; without it the loops have their own.
    pub buffers: Option<&'a mut VectorBuffers<L, D>>,
    pub sink: &'a mut dyn Sink,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, order, range, buffers, sink } = self;
        let ElementVectors { group, side, element, .. } = *task;
        let (components, nodes) = (kernel.components, task.nodes());
        let size = nodes * components;
        let zero = L::splat(0.0);
        let mut own;
        let VectorBuffers { batch, sums, at_points, stages } = match buffers {
            Some(kept) => kept,
            None => {
                own = VectorBuffers::default();
                &mut own
            }
        };
        let factorised = task.factorised(kernel);
        let requirements = *kernel.requirements;
        let [reading, _] = Reading::of_arguments(&requirements);
        let mean = kernel.requirements.test_mean;
        let basis = [ArgumentBasis { side, element, reading, mean }];
        let arguments: &[ArgumentBasis] = if factorised.is_some() { &[] } else { &basis };
        let mut batch = Batch::<L, D>::new(task.binding, group, task.cells, requirements, arguments, batch)?;
        sums.resize(size, zero);
        let derivatives = Derivatives::of_arguments(&requirements);
        let asked = derivatives.count::<D>();
        if let Some(tables) = factorised {
            at_points.resize(components * asked * tables.place_of.len(), zero);
        }
        let mut units = [Basis { value: zero, gradient: [zero; D] }; 4];
        let nothing_further = [Further::none(); 4];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            calls.call(&mut VectorCall::Cell(&batch.load(start, filled)));
            let (target, stride) = match factorised {
                Some(tables) => (&mut at_points[..], tables.place_of.len()),
                None => (&mut sums[..], 1),
            };
            target.fill(zero);
            for q in 0..group.points() {
                batch.point(q)?;
                let (geometry, fields) = (batch.geometry(), batch.fields());
                let (basis, further, place) = match factorised {
                    Some(tables) => {
                        for k in 0..asked {
                            units[k] = unit(batch.inverse(), derivatives.kind(k));
                        }
                        (&units[..asked], &nothing_further[..asked], tables.place_of[q] as usize)
                    }
                    None => (&batch.basis(side, element)[..nodes], &batch.further(side, element)[..nodes], 0),
                };
                let target = &mut target[place..];
                calls.call(&mut VectorCall::Point { geometry, fields, basis, further, target, stride });
            }
            if let Some(tables) = factorised {
                let (source, sums) = (&at_points[..], &mut sums[..]);
                L::call(Integration::<L, D> { tables, derivatives, source, components, stages, sums });
            }
            let target = sink.room(start, filled, size);
            match order {
                None => L::call(Transposition { source: &sums[..size], filled, target, stride: size }),
                Some(order) => {
                    let source = Ordered::new(sums, order, size);
                    L::call(Transposition { source, filled, target, stride: size });
                }
            }
            sink.filled(start, filled, size)?;
            start += filled;
        }
        batch.check_weights(range)
    }
}

instantiate!(
    element_vectors in lanes:
    L::call::<Loops<L, D>>,
    L::call::<point_values::Loops<L, D>>,
);
