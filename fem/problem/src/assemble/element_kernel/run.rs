//! Calls of integrals that have loops which count their lengths.

use std::any::Any;

use forms_core::contract::{BilinearConstants, BilinearKernel, LinearConstants, LinearKernel};

use super::ElementCells;
use super::tables::ElementTables;
use crate::assemble::AssemblyError;
use crate::assemble::element_loops::matrices::{ElementMatrices, MatrixBuffers};
use crate::assemble::element_loops::sink::Direct;
use crate::assemble::element_loops::vectors::{ElementVectors, VectorBuffers};
use crate::assemble::element_loops::{BilinearCalls, Factors, LinearCalls};
use crate::assemble::groups::Group;
use crate::contract::Form;
use crate::lanes::{LaneWork, Order, SimdLane};

/// Memory of the loops, whose types are known inside them.
pub(super) type Kept = Option<Box<dyn Any + Send>>;

/// One call, on the cells or on the facet that was asked for.
pub(super) struct Counted<'a, const D: usize> {
    pub form: &'a Form<D>,
    pub tables: &'a ElementTables<D>,
    pub group: &'a Group<D>,
    pub cells: &'a ElementCells<'a>,
    pub memory: &'a mut Kept,
    pub sink: Direct<'a>,
}

/// Element matrices.
pub(super) fn run_matrices<K: BilinearKernel<D>, const D: usize>(
    kernel: &K,
    call: Counted<D>,
) -> Result<(), AssemblyError> {
    let Counted { form, tables, group, cells, memory, mut sink } = call;
    let task = ElementMatrices {
        binding: &tables.bind(form)?,
        group,
        cells: tables.cells(cells),
        sides: [0, 0],
        elements: [0, 0],
        seen: [None, None],
        symmetric: K::SYMMETRIC,
    };
    let order = &tables.orders[usize::from(K::SYMMETRIC)];
    let (task, sink) = (&task, &mut sink);
    tables.instructions.run(Matrices { task, kernel, order, count: cells.count, memory, sink })
}

/// Element vectors.
pub(super) fn run_vectors<K: LinearKernel<D>, const D: usize>(
    kernel: &K,
    call: Counted<D>,
) -> Result<(), AssemblyError> {
    let Counted { form, tables, group, cells, memory, mut sink } = call;
    let binding = tables.bind(form)?;
    let task = ElementVectors { binding: &binding, group, cells: tables.cells(cells), side: 0, element: 0 };
    let (task, order, sink) = (&task, &tables.orders[2], &mut sink);
    tables.instructions.run(Vectors { task, kernel, order, count: cells.count, memory, sink })
}

struct Matrices<'a, 'r, K, const D: usize> {
    task: &'a ElementMatrices<'a, D>,
    kernel: &'a K,
    order: &'a Order,
    count: usize,
    memory: &'a mut Kept,
    sink: &'a mut Direct<'r>,
}

/// The memory of a run before, if it was of the same type, or new memory; to be put back after the run.
fn recall<T: Send + Default + 'static>(memory: &mut Kept) -> Box<T> {
    memory.take().and_then(|known| known.downcast().ok()).unwrap_or_default()
}

impl<K: BilinearKernel<D>, const D: usize> LaneWork for Matrices<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut memory = recall::<(MatrixBuffers<L, D>, Factors<K, L, D>)>(self.memory);
        let (buffers, factors) = &mut *memory;
        let calls = &mut BilinearCalls::new(self.kernel, factors);
        let constants = const { &BilinearConstants::of::<K, D>() };
        let range = 0..self.count;
        let done = self.task.compute_in_lanes::<L>(constants, calls, self.order, range, buffers, self.sink);
        *self.memory = Some(memory);
        done
    }
}

struct Vectors<'a, 'r, K, const D: usize> {
    task: &'a ElementVectors<'a, D>,
    kernel: &'a K,
    order: &'a Order,
    count: usize,
    memory: &'a mut Kept,
    sink: &'a mut Direct<'r>,
}

impl<K: LinearKernel<D>, const D: usize> LaneWork for Vectors<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut buffers = recall::<VectorBuffers<L, D>>(self.memory);
        let (range, order) = (0..self.count, Some(self.order));
        let calls = &mut LinearCalls::<K, L, D>::new(self.kernel);
        let constants = const { &LinearConstants::of::<K, D>() };
        let done = self.task.compute_in_lanes::<L>(constants, calls, order, range, &mut buffers, self.sink);
        *self.memory = Some(buffers);
        done
    }
}
