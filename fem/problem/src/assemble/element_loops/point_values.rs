//! Values of an expression at the points of a group: the loops over batches and points, from which its kernel is called.

use std::any::Any;
use std::ops::Range;

use forms_core::contract::{CellGeometry, ExpressionKernel, PointGeometry, Requirements};

use crate::assemble::AssemblyError;
use crate::assemble::batch::{Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::groups::Group;
use crate::lanes::{SharedWork, SimdLane, Transposition};

/// Takes the value, weight and position of a quadrature point.
pub(in crate::assemble) type ReceivePoint<'a, const D: usize> =
    dyn FnMut(&[f64], f64, &[f64; D]) -> Result<(), AssemblyError> + 'a;

/// Inputs of the values at a group's points, besides the kernel.
pub(in crate::assemble) struct PointValues<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// What is needed at each point: what the kernel reads, and the position.
    pub requirements: Requirements,
    /// Components of the value.
    pub components: usize,
}

/// Memory of the loops for lanes of any type, kept from one run to the next.
pub(in crate::assemble) struct PointBuffers(Box<dyn Any + Send>);

impl Default for PointBuffers {
    fn default() -> Self {
        PointBuffers(Box::new(()))
    }
}

/// That for a type of lane.
struct BuffersInLanes<L, const D: usize> {
    batch: BatchBuffers<L, D>,
    /// Of each point of a batch: value, weight, position.
    found: Vec<L>,
    /// The same, cell by cell.
    of_cells: Vec<f64>,
}

impl PointBuffers {
    fn in_lanes<L: SimdLane, const D: usize>(&mut self) -> Option<&mut BuffersInLanes<L, D>> {
        if !self.0.is::<BuffersInLanes<L, D>>() {
            let batch = BatchBuffers::default();
            self.0 = Box::new(BuffersInLanes::<L, D> { batch, found: vec![], of_cells: vec![] });
        }
        self.0.downcast_mut()
    }
}

/// The loops over the batches of a range: values at every quadrature point of its entities, in their order.
pub(in crate::assemble) struct Loops<'a, 'd, 'r, L, const D: usize> {
    pub task: &'a PointValues<'d, D>,
    pub calls: &'a mut dyn ValueCalls<L, D>,
    pub buffers: &'a mut PointBuffers,
    pub range: Range<usize>,
    pub receive: &'a mut ReceivePoint<'r, D>,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, calls, buffers, range, receive } = self;
        let PointValues { binding, group, requirements, components } = *task;
        let Some(buffers) = buffers.in_lanes::<L, D>() else { return Ok(()) };
        let BuffersInLanes { batch, found, of_cells } = buffers;
        let of_point = components + 1 + D;
        let of_cell = group.points() * of_point;
        found.resize(of_cell, L::splat(0.0));
        of_cells.resize(of_cell * L::WIDTH, 0.0);
        let cells = Cells::Mesh(binding.mesh);
        let mut batch = Batch::<L, D>::new(binding, group, cells, requirements, &[], batch)?;
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            calls.call(&mut ValueCall::Cell(&batch.load(start, filled)));
            for q in 0..group.points() {
                batch.point(q)?;
                let (geometry, fields) = (batch.geometry(), batch.fields());
                let target = &mut found[q * of_point..(q + 1) * of_point];
                target[components] = geometry.weight;
                target[components + 1..].copy_from_slice(&geometry.position);
                calls.call(&mut ValueCall::Point { geometry, fields, target: &mut target[..components] });
            }
            let source = &found[..of_cell];
            L::call(Transposition { source, filled, target: &mut of_cells[..], stride: of_cell });
            for point in of_cells[..filled * of_cell].chunks_exact(of_point) {
                let (value, rest) = point.split_at(components);
                let mut position = [0.0; D];
                position.copy_from_slice(&rest[1..]);
                receive(value, rest[0], &position)?;
            }
            start += filled;
        }
        batch.check_weights(range)
    }
}

/// A call for the cells of a batch.
pub(in crate::assemble) enum ValueCall<'a, L, const D: usize> {
    /// Quantities that are constant on the cells, before the first point.
    Cell(&'a CellGeometry<L>),
    /// The value at a point.
    Point { geometry: &'a PointGeometry<L, D>, fields: &'a [L], target: &'a mut [L] },
}

/// A kernel whose type is forgotten, and what it knows of the cells at hand.
pub(in crate::assemble) trait ValueCalls<L, const D: usize> {
    fn call(&mut self, call: &mut ValueCall<L, D>);
}

/// The calls of a kernel of a known type.
pub(in crate::assemble) struct ExpressionCalls<'a, K: ExpressionKernel<D>, L: SimdLane, const D: usize> {
    kernel: &'a K,
    cell: Option<K::Cell<L>>,
}

impl<'a, K: ExpressionKernel<D>, L: SimdLane, const D: usize> ExpressionCalls<'a, K, L, D> {
    #[inline(always)]
    pub fn new(kernel: &'a K) -> Self {
        ExpressionCalls { kernel, cell: None }
    }
}

impl<K: ExpressionKernel<D>, L: SimdLane, const D: usize> ValueCalls<L, D> for ExpressionCalls<'_, K, L, D> {
    fn call(&mut self, call: &mut ValueCall<L, D>) {
        L::call(Work { calls: self, call });
    }
}

/// A call, compiled for the lane type's instructions.
struct Work<'a, 'c, C, L, const D: usize> {
    calls: &'a mut C,
    call: &'a mut ValueCall<'c, L, D>,
}

impl<K: ExpressionKernel<D>, L: SimdLane, const D: usize> SharedWork<L>
    for Work<'_, '_, ExpressionCalls<'_, K, L, D>, L, D>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let ExpressionCalls { kernel, cell } = self.calls;
        match self.call {
            ValueCall::Cell(geometry) => *cell = Some(kernel.cell(geometry)),
            ValueCall::Point { geometry, fields, target } => {
                let Some(cell) = cell else { unreachable!("a cell comes before its points") };
                let value = kernel.evaluate(cell, geometry, fields);
                target.copy_from_slice(&value.as_ref()[..target.len()]);
            }
        }
    }
}
