//! A call of an element kernel that has loops which count their lengths: a walk over the form's integrals, since their types
//! must be known.

use std::marker::PhantomData;

use forms_core::contract::{BilinearKernel, BilinearVisitor, Form, Integral, LinearKernel, LinearVisitor};

use super::ElementCells;
use super::prepare::{Kept, Lengths, Prepared, of_facet};
use super::tables::ElementTables;
use crate::assemble::AssemblyError;
use crate::assemble::element_kernel::sizes::Sizes;
use crate::assemble::kernel_calls::matrices::{ElementMatrices, MatrixBuffers};
use crate::assemble::kernel_calls::sink::Direct;
use crate::assemble::kernel_calls::vectors::{ElementVectors, VectorBuffers};
use crate::assemble::kernel_calls::{
    BilinearCalls, BilinearConstants, Factors, LinearCalls, LinearConstants,
};
use crate::assemble::walk::Group;
use crate::lanes::{LaneWork, Order, SimdLane};

/// One call.
pub(super) struct Run<'a, F, S: Sizes, const D: usize> {
    pub form: &'a F,
    pub tables: &'a ElementTables<D>,
    pub integrals: &'a mut [Prepared<D>],
    pub addend: &'a mut Vec<f64>,
    pub cells: &'a ElementCells<'a>,
    pub target: &'a mut [f64],
    /// Number of integrals that were walked.
    pub index: usize,
    pub sizes: PhantomData<S>,
}

/// An integral whose loops count their lengths, on the cells or on the facet that was asked for.
struct Counted<'a, const D: usize> {
    group: &'a Group<D>,
    memory: &'a mut Kept,
    sink: Direct<'a>,
}

impl<F: Form<D>, S: Sizes, const D: usize> Run<'_, F, S, D> {
    /// The next integral, unless its lengths are fixed: such a one is done here.
    fn next(&mut self) -> Result<Option<Counted<'_, D>>, AssemblyError> {
        let (index, form) = (self.index, self.form.name());
        self.index += 1;
        match &mut self.integrals[index] {
            Prepared::Fixed(groups) => {
                let group = of_facet(form, groups, self.cells.facet)?;
                group.run(self.cells, self.target, index > 0);
                Ok(None)
            }
            Prepared::Counted { groups, memory } => {
                let group = of_facet(form, groups, self.cells.facet)?;
                let addend = (index > 0).then_some(&mut *self.addend);
                Ok(Some(Counted { group, memory, sink: Direct { target: &mut *self.target, addend } }))
            }
        }
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> BilinearVisitor<D> for Run<'_, F, S, D> {
    type Error = AssemblyError;

    fn visit<K: BilinearKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (form, tables, cells) = (self.form, self.tables, self.cells);
        let Some(Counted { group, memory, mut sink }) = self.next()? else { return Ok(()) };
        // `prepare` gave these loops of fixed lengths, so that this is not reached: it keeps others from being compiled.
        if const { Lengths::<K, S>::of_matrices_always() } {
            return Ok(());
        }
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
}

impl<F: Form<D>, S: Sizes, const D: usize> LinearVisitor<D> for Run<'_, F, S, D> {
    type Error = AssemblyError;

    fn visit<K: LinearKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (form, tables, cells) = (self.form, self.tables, self.cells);
        let Some(Counted { group, memory, mut sink }) = self.next()? else { return Ok(()) };
        // As above.
        if const { Lengths::<K, S>::of_vectors() } {
            return Ok(());
        }
        let binding = tables.bind(form)?;
        let task =
            ElementVectors { binding: &binding, group, cells: tables.cells(cells), side: 0, element: 0 };
        let (task, order, sink) = (&task, &tables.orders[2], &mut sink);
        tables.instructions.run(Vectors { task, kernel, order, count: cells.count, memory, sink })
    }
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
