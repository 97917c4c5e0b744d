//! One call of an element kernel: a walk over the form's integrals.

use std::any::Any;
use std::marker::PhantomData;

use forms_core::contract::{
    BilinearKernel, BilinearVisitor, Form, Integral, LinearKernel, LinearVisitor, Requirements,
};

use super::ElementCells;
use super::tables::ElementTables;
use crate::assemble::AssemblyError;
use crate::assemble::element_matrices::{ElementMatrices, MatrixBuffers, along_axes, scalar};
use crate::assemble::element_vectors::{ElementVectors, VectorBuffers};
use crate::assemble::fixed::{FixedMatrices, FixedTables, FixedTask, FixedVectors, fits};
use crate::assemble::receiver::Direct;
use crate::assemble::sizes::Sizes;
use crate::assemble::walk::Group;
use crate::lanes::{LaneWork, Order, SimdLane};

/// One call: a walk over the integrals.
pub(super) struct Run<'a, F, S: Sizes, const D: usize> {
    pub form: &'a F,
    pub tables: &'a ElementTables<D>,
    /// The groups of each integral, and their tables if their sizes are fixed.
    pub groups: &'a [Vec<Group<D>>],
    pub fixed: &'a [Vec<FixedTables<S, D>>],
    /// One per integral.
    pub memory: &'a mut Vec<Kept>,
    pub addend: &'a mut Vec<f64>,
    pub cells: &'a ElementCells<'a>,
    pub target: &'a mut [f64],
    /// Number of integrals that were walked.
    pub index: usize,
}

#[cold]
fn no_facet(form: &'static str, facet: usize) -> AssemblyError {
    AssemblyError::Layout { form, what: format!("there is no facet {facet}") }
}

/// The entry of the facet that was asked for, or of the cells.
#[inline(always)]
fn choose<T>(groups: &[T], facet: usize) -> Option<&T> {
    if groups.len() == 1 { groups.first() } else { groups.get(facet) }
}

impl<'a, F: Form<D>, S: Sizes, const D: usize> Run<'a, F, S, D> {
    /// The group of the next integral.
    #[inline(always)]
    fn group(&self) -> Result<&'a Group<D>, AssemblyError> {
        let facet = self.cells.facet;
        choose(&self.groups[self.index], facet).ok_or_else(|| no_facet(self.form.name(), facet))
    }

    #[inline(always)]
    fn fixed_matrices<K: BilinearKernel<D>>(&mut self, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, add) = (self.tables, self.index > 0);
        let (group, fixed) = (self.group()?, self.fixed()?);
        tables.instructions.run(FixedMatrices {
            task: FixedTask { kernel, group, tables: fixed, listed: tables.listed_cells(self.cells) },
            order: &tables.orders[usize::from(K::SYMMETRIC)],
            memory: &mut self.memory[self.index],
            target: &mut *self.target,
            add,
        });
        self.index += 1;
        Ok(())
    }

    /// Whether the loops that count their lengths do with fewer operations: those with fixed ones do not sum along axes.
    fn sums_along_axes<K: BilinearKernel<D>>(&self) -> Result<bool, AssemblyError> {
        let tables = self.group()?.sides[0].products[0].as_ref();
        Ok(tables.is_some_and(|tables| along_axes::<K, D>(tables, K::SYMMETRIC)))
    }

    #[inline(always)]
    fn fixed(&self) -> Result<&'a FixedTables<S, D>, AssemblyError> {
        let facet = self.cells.facet;
        choose(&self.fixed[self.index], facet).ok_or_else(|| no_facet(self.form.name(), facet))
    }
}

/// Whether a kernel's loops have fixed lengths.
struct Path<K, S>(PhantomData<(K, S)>);

impl<K, S: Sizes> Path<K, S> {
    const fn fixed(requirements: &Requirements, components: usize) -> bool {
        S::FIXED && components <= 3 && fits(requirements)
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> BilinearVisitor<D> for Run<'_, F, S, D> {
    type Error = AssemblyError;

    #[inline]
    fn visit<K: BilinearKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, add) = (self.tables, self.index > 0);
        let order = &tables.orders[usize::from(K::SYMMETRIC)];
        if const { Path::<K, S>::fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS) && !scalar::<K, D>() } {
            return self.fixed_matrices(kernel);
        }
        if const { Path::<K, S>::fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS) }
            && !self.sums_along_axes::<K>()?
        {
            return self.fixed_matrices(kernel);
        }
        let (binding, group) = (tables.bind(self.form)?, self.group()?);
        let task = ElementMatrices {
            binding: &binding,
            group,
            cells: tables.cells(self.cells),
            sides: [0, 0],
            elements: [0, 0],
            symmetric: K::SYMMETRIC,
        };
        let mut receiver = Direct { target: &mut *self.target, addend: add.then_some(&mut *self.addend) };
        let result = tables.instructions.run(Matrices::<K, D> {
            task: &task,
            kernel,
            order,
            count: self.cells.count,
            memory: &mut self.memory[self.index],
            receiver: &mut receiver,
        });
        self.index += 1;
        result
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> LinearVisitor<D> for Run<'_, F, S, D> {
    type Error = AssemblyError;

    #[inline]
    fn visit<K: LinearKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, add) = (self.tables, self.index > 0);
        let order = &tables.orders[2];
        if const { Path::<K, S>::fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS) } {
            let (group, fixed) = (self.group()?, self.fixed()?);
            tables.instructions.run(FixedVectors {
                task: FixedTask { kernel, group, tables: fixed, listed: tables.listed_cells(self.cells) },
                order,
                memory: &mut self.memory[self.index],
                target: &mut *self.target,
                add,
            });
            self.index += 1;
            return Ok(());
        }
        let (binding, group) = (tables.bind(self.form)?, self.group()?);
        let task =
            ElementVectors { binding: &binding, group, cells: tables.cells(self.cells), side: 0, element: 0 };
        let mut receiver = Direct { target: &mut *self.target, addend: add.then_some(&mut *self.addend) };
        let result = tables.instructions.run(Vectors::<K, D> {
            task: &task,
            kernel,
            order,
            count: self.cells.count,
            memory: &mut self.memory[self.index],
            receiver: &mut receiver,
        });
        self.index += 1;
        result
    }
}

struct Matrices<'a, 'r, K, const D: usize> {
    task: &'a ElementMatrices<'a, D>,
    kernel: &'a K,
    order: &'a Order,
    count: usize,
    memory: &'a mut Kept,
    receiver: &'a mut Direct<'r>,
}

/// Memory of the loops, whose types are known inside them.
pub(in crate::assemble) type Kept = Option<Box<dyn Any + Send>>;

/// The memory of a run before, if it was of the same type, or new memory; to be put back after the run.
#[inline(always)]
pub(in crate::assemble) fn recall<T: Any + Send + Default>(memory: &mut Kept) -> Box<T> {
    memory.take().and_then(|known| known.downcast().ok()).unwrap_or_default()
}

impl<K: BilinearKernel<D>, const D: usize> LaneWork for Matrices<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut buffers = recall::<MatrixBuffers<K, L, D>>(self.memory);
        let range = 0..self.count;
        let done =
            self.task.compute_in_lanes::<K, L>(self.kernel, self.order, range, &mut buffers, self.receiver);
        *self.memory = Some(buffers);
        done
    }
}

struct Vectors<'a, 'r, K, const D: usize> {
    task: &'a ElementVectors<'a, D>,
    kernel: &'a K,
    order: &'a Order,
    count: usize,
    memory: &'a mut Kept,
    receiver: &'a mut Direct<'r>,
}

impl<K: LinearKernel<D>, const D: usize> LaneWork for Vectors<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut buffers = recall::<VectorBuffers<L, D>>(self.memory);
        let (range, order) = (0..self.count, Some(self.order));
        let done = self.task.compute_in_lanes::<K, L>(self.kernel, order, range, &mut buffers, self.receiver);
        *self.memory = Some(buffers);
        done
    }
}
