//! Calls of integrals that have loops which count their lengths.

use std::any::Any;

use forms_core::contract::{BilinearConstants, BilinearKernel, LinearConstants, LinearKernel};

use super::ElementCells;
use super::tables::ElementTables;
use crate::assemble::AssemblyError;
use crate::assemble::element_loops::matrices::{self, ElementMatrices, MatrixBuffers};
use crate::assemble::element_loops::sink::Direct;
use crate::assemble::element_loops::vectors::{self, ElementVectors, VectorBuffers};
use crate::assemble::element_loops::{BilinearCalls, Factors, LinearCalls};
use crate::assemble::groups::Group;
use crate::contract::Form;
use crate::lanes::{SimdLane, with_lanes};

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
    let constants = const { &BilinearConstants::of::<K, D>() };
    let (task, range, sink) = (&task, 0..cells.count, &mut sink);
    with_lanes!(tables.instructions, L => {
        let mut known = recall::<(MatrixBuffers<L, D>, Factors<K, L, D>)>(memory);
        let (buffers, factors) = &mut *known;
        let (buffers, calls) = (Some(buffers), &mut BilinearCalls::new(kernel, factors));
        let done = L::call(matrices::Loops { task, kernel: constants, calls, order, range, buffers, sink });
        *memory = Some(known);
        done
    })
}

/// Element vectors.
pub(super) fn run_vectors<K: LinearKernel<D>, const D: usize>(
    kernel: &K,
    call: Counted<D>,
) -> Result<(), AssemblyError> {
    let Counted { form, tables, group, cells, memory, mut sink } = call;
    let binding = tables.bind(form)?;
    let task = ElementVectors { binding: &binding, group, cells: tables.cells(cells), side: 0, element: 0 };
    let constants = const { &LinearConstants::of::<K, D>() };
    let (task, order, range, sink) = (&task, Some(&tables.orders[2]), 0..cells.count, &mut sink);
    with_lanes!(tables.instructions, L => {
        let mut known = recall::<VectorBuffers<L, D>>(memory);
        let (buffers, calls) = (Some(&mut *known), &mut LinearCalls::<&K, L, D>::new(kernel));
        let done = L::call(vectors::Loops { task, kernel: constants, calls, order, range, buffers, sink });
        *memory = Some(known);
        done
    })
}

/// The memory of a run before, if it was of the same type, or new memory; to be put back after the run.
fn recall<T: Send + Default + 'static>(memory: &mut Kept) -> Box<T> {
    memory.take().and_then(|known| known.downcast().ok()).unwrap_or_default()
}
