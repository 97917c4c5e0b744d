//! Element vectors of a linear integral: the loops over batches, points and basis functions.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{Basis, LinearKernel};

use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::kernel_calls::sink::{Buffered, Deliver, Sink};
use crate::assemble::kernel_calls::sum_factorisation::{
    Derivatives, Integration, ProductTables, Stages, axis_operations, unit,
};
use crate::assemble::scatter::group_nodes::Reading;
use crate::assemble::walk::Group;
use crate::lanes::{InstructionSet, LaneWork, Order, Ordered, SimdLane, Transposition};

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

    /// Computes the element vectors of the group's entities in a range, and hands them over in their order:
    /// `deliver(first, vectors)` gets whole element vectors, that of entity `first` first, each as
    /// `[node][component]`.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub fn compute<K: LinearKernel<D>>(
        &self,
        kernel: &K,
        set: InstructionSet,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        set.checked().run(Compute { task: self, kernel, order: None, range, sink: Buffered::new(deliver) })
    }

    /// The loops. Where sums go along the axes, the kernel is asked at each point for the functions whose value, or whose
    /// derivative along one axis of the reference cell, is one. With an `order`, entry k of a vector is the `order[k]`-th of `[node][component]`.
    #[inline(always)]
    pub fn compute_in_lanes<K: LinearKernel<D>, L: SimdLane>(
        &self,
        kernel: &K,
        order: Option<&Order>,
        range: Range<usize>,
        buffers: &mut VectorBuffers<L, D>,
        sink: &mut impl Sink,
    ) -> Result<(), AssemblyError> {
        let components = K::TEST_COMPONENTS;
        let nodes = self.nodes();
        let size = nodes * components;
        let zero = L::splat(0.0);
        let VectorBuffers { batch, sums, at_points, stages } = buffers;
        let factorised = self.factorised::<K>();
        let [reading, _] = Reading::of_arguments(&K::REQUIREMENTS);
        let own = [ArgumentBasis { side: self.side, element: self.element, reading }];
        let arguments: &[ArgumentBasis] = if factorised.is_some() { &[] } else { &own };
        let mut batch =
            Batch::<L, D>::new(self.binding, self.group, self.cells, K::REQUIREMENTS, arguments, batch)?;
        sums.resize(size, zero);
        let derivatives = Derivatives::of_arguments(&K::REQUIREMENTS);
        let asked = derivatives.count::<D>();
        if let Some(tables) = factorised {
            at_points.resize(components * asked * tables.place_of.len(), zero);
        }
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let cell = kernel.cell(&batch.load(start, filled));
            // What is added for function i and component c stands at `(i * components + c) * stride`, from `place` on.
            let (target, stride) = match factorised {
                Some(tables) => (&mut at_points[..], tables.place_of.len()),
                None => (&mut sums[..], 1),
            };
            target.fill(zero);
            for q in 0..self.group.points() {
                batch.point(q)?;
                let geometry = batch.geometry();
                let flux = kernel.point(&cell, geometry, batch.fields());
                let mut units = [Basis { value: zero, gradient: [zero; D] }; 4];
                let (functions, hessians, place) = match factorised {
                    Some(tables) => {
                        for k in 0..asked {
                            units[k] = unit(batch.inverse(), derivatives.kind(k));
                        }
                        (&units[..asked], &[[[zero; D]; D]; 4][..asked], tables.place_of[q] as usize)
                    }
                    None => {
                        let basis = &batch.basis(self.side, self.element)[..nodes];
                        (basis, &batch.hessians(self.side, self.element)[..nodes], 0)
                    }
                };
                for i in 0..functions.len() {
                    let block = kernel.test(&flux, &functions[i], &hessians[i]);
                    let block = &block.as_ref()[..components];
                    for component in 0..components {
                        target[(i * components + component) * stride + place] += block[component];
                    }
                }
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

    /// The tables, if sum factorisation takes fewer operations than sums over the nodes at each point.
    fn factorised<K: LinearKernel<D>>(&self) -> Option<&ProductTables> {
        let tables = self.group.sides[self.side].products[self.element].as_ref()?;
        let requirements = &K::REQUIREMENTS;
        if requirements.hessian {
            return None;
        }
        let (nodes, points) = (self.nodes(), self.group.points());
        let derivatives = Derivatives::of_arguments(requirements);
        let transformed = if derivatives.gradient { D * D } else { 0 };
        let direct = points * nodes * (K::OPERATIONS.test + transformed);
        let made = points * derivatives.count::<D>() * K::OPERATIONS.test
            + K::TEST_COMPONENTS * axis_operations::<D>(tables, derivatives);
        (made < direct).then_some(tables)
    }
}

struct Compute<'a, 'd, K, const D: usize> {
    task: &'a ElementVectors<'a, D>,
    kernel: &'a K,
    order: Option<&'a Order>,
    range: Range<usize>,
    sink: Buffered<'d>,
}

impl<K: LinearKernel<D>, const D: usize> LaneWork for Compute<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(mut self) -> Self::Output {
        let mut buffers = VectorBuffers::<L, D>::default();
        let (task, sink) = (self.task, &mut self.sink);
        task.compute_in_lanes::<K, L>(self.kernel, self.order, self.range, &mut buffers, sink)
    }
}
