//! Residual vectors: R(u; φ_i e_a) for every test basis function.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{Form, Integral, LinearKernel, LinearVisitor, Requirements, Role};

use super::batch::Cells;
use super::binding::Binding;
use super::binding::outline::Described;
use super::kernel_calls::vectors::ElementVectors;
use super::scatter::VectorScatter;
use super::walk::groups;
use super::{Assembler, AssemblyError, Parts};
use crate::assemble::kernel_calls::sink::Deliver;
use crate::assemble::scatter::group_nodes::GroupNodes;
use crate::compiled_here::compiled_here;
use crate::field::{Field, FieldView, views};
use crate::lanes::InstructionSet;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

impl<const D: usize> Assembler<D> {
    /// The vector of a linear form, one entry per unknown of the space of its test function.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    pub fn linear_form<F: Form<D>>(
        &self,
        form: &F,
        space: &Arc<Space<D>>,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual(form, &[], &[space])
    }

    /// The residual of a form at given unknowns: one entry per unknown of the test spaces, in a row.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn residual<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual_parts(form, unknowns, tests, Parts::ALL)
    }

    /// Some of the integrals of [`Assembler::residual`].
    ///
    /// # Errors
    /// As there.
    pub fn residual_parts<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual_of(form, &views(unknowns), tests, parts)
    }

    /// [`Assembler::residual_parts`] at coefficients that need not be those of a field.
    pub(crate) fn residual_of<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.whole_or_parts(Described::of(form), (unknowns, tests), (parts, &[]), &mut walk(form))
    }

    /// The residual of a form without unknowns, except for the integrals of some of its test functions, by their numbers: zero in their
    /// places.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    pub(crate) fn residual_without<F: Form<D>>(
        &self,
        form: &F,
        tests: &[&Arc<Space<D>>],
        left_out: &[usize],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.whole_or_parts(Described::of(form), (&[], tests), (Parts::ALL, left_out), &mut walk(form))
    }

    /// The residual of the constant and linear integrals where the unknowns are zero. Those that are proved to vanish there are not
    /// assembled: a coefficient that is no number does not show.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    pub(crate) fn load<F: Form<D>>(
        &self,
        form: &F,
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.load_of(Described::of(form), tests, &mut walk(form))
    }

    #[inline(never)]
    fn load_of(
        &self,
        form: Described<D>,
        tests: &[&Arc<Space<D>>],
        walk: WalkResidual<D>,
    ) -> Result<Vec<f64>, AssemblyError> {
        let zero: Vec<Field<D>> = tests.iter().map(|space| Field::zero(space)).collect();
        let unknowns = views(&zero.iter().collect::<Vec<_>>());
        let binding = self.bind(form, &unknowns)?;
        self.linear_integrals(binding, tests, Parts::LINEAR_AND_CONSTANT, &mut |visitor| {
            visitor.at_zero = true;
            walk(visitor, Integrals::Apart)
        })
    }

    #[inline(never)]
    fn whole_or_parts(
        &self,
        form: Described<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        (parts, left_out): (Parts, &[usize]),
        walk: WalkResidual<D>,
    ) -> Result<Vec<f64>, AssemblyError> {
        // The parts of an integral may have rules of their own; one rule for all makes the whole their sum.
        let whole = parts == Parts::ALL && !self.quadrature.follows_estimates();
        let integrals = if whole { Integrals::Whole } else { Integrals::Apart };
        self.linear_integrals(self.bind(form, unknowns)?, tests, parts, &mut |visitor| {
            visitor.left_out = left_out.to_vec();
            walk(visitor, integrals)
        })
    }

    /// The size of the terms that are summed in each entry of the residual: contributions of cells and facets, each integral by
    /// itself, with the sign removed.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    pub(crate) fn sizes_of_contributions<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        terms: Terms,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.sizes_of(Described::of(form), (unknowns, tests), terms, &mut walk(form))
    }

    #[inline(never)]
    fn sizes_of(
        &self,
        form: Described<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        terms: Terms,
        walk: WalkResidual<D>,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.linear_integrals(self.bind(form, unknowns)?, tests, Parts::ALL, &mut |visitor| {
            visitor.added = Added::Sizes(terms);
            walk(visitor, Integrals::Apart)
        })
    }

    /// The sum of the integrals that a form hands to the visitor.
    #[inline(never)]
    pub(super) fn linear_integrals(
        &self,
        mut binding: Binding<D>,
        tests: &[&Arc<Space<D>>],
        parts: Parts,
        walk: &mut dyn FnMut(&mut VectorVisitor<D>) -> Result<(), AssemblyError>,
    ) -> Result<Vec<f64>, AssemblyError> {
        binding.check_tests(tests, &self.mesh)?;
        let elements = tests.iter().map(|space| binding.element(space)).collect();
        let mut offsets = vec![0];
        for space in tests {
            offsets.push(offsets[offsets.len() - 1] + space.unknowns());
        }
        let degrees = binding.degrees(tests);
        let mut visitor = VectorVisitor {
            binding: &binding,
            quadrature: &self.quadrature,
            threads: self.threads,
            degrees,
            tests,
            elements,
            vector: vec![0.0; offsets[tests.len()]],
            offsets,
            parts,
            left_out: vec![],
            at_zero: false,
            added: Added::Vectors,
            set: self.instructions,
        };
        walk(&mut visitor)?;
        Ok(visitor.vector)
    }
}

/// Hands a form's integrals to the visitor; the form's type is forgotten.
type WalkResidual<'a, const D: usize> =
    &'a mut dyn FnMut(&mut VectorVisitor<D>, Integrals) -> Result<(), AssemblyError>;

/// Integrals of a residual.
#[derive(Clone, Copy)]
enum Integrals {
    /// Those that depend on the unknowns in different ways apart ([`Form::residual`]).
    Apart,
    /// One for all of a region ([`Form::whole_residual`]).
    Whole,
}

fn walk<F: Form<D>, const D: usize>(
    form: &F,
) -> impl FnMut(&mut VectorVisitor<D>, Integrals) -> Result<(), AssemblyError> {
    |visitor, integrals| match integrals {
        Integrals::Apart => form.residual(visitor),
        Integrals::Whole => form.whole_residual(visitor),
    }
}

/// Adds up integrals that are linear in a test function.
pub(super) struct VectorVisitor<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    threads: Threads,
    degrees: Vec<usize>,
    tests: &'a [&'a Arc<Space<D>>],
    elements: Vec<usize>,
    offsets: Vec<usize>,
    vector: Vec<f64>,
    parts: Parts,
    /// Test functions whose integrals are not visited, by their numbers.
    left_out: Vec<usize>,
    /// Unknowns are zero, and integrals that vanish there are not visited.
    at_zero: bool,
    added: Added,
    set: InstructionSet,
}

/// Amounts that are added up.
#[derive(Clone, Copy)]
enum Added {
    /// Element vectors.
    Vectors,
    /// Sizes of element vectors.
    Sizes(Terms),
}

/// Sizes of the terms of a residual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terms {
    /// The amount of each entry of an element vector, in its own row: what must balance there.
    OfRows,
    /// The largest amount in an element vector, in all rows to which it adds: what an entry was computed from, where the terms of a row
    /// cancel inside of the cell.
    OfCells,
    /// The same among the entries of one component, in the rows of that component.
    OfCellsByComponent,
}

impl<const D: usize> LinearVisitor<D> for VectorVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: LinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let left_out = self.left_out.contains(&integral.test) || (self.at_zero && integral.vanishes);
        if left_out || !self.parts.contain(integral.dependence) {
            return Ok(());
        }
        let set = self.set;
        let compute: Compute<D> = &|task, entities, deliver| task.compute(kernel, set, entities, deliver);
        self.integrate(integral, &K::REQUIREMENTS, K::TEST_COMPONENTS, compute)
    }
}

/// Computes element vectors by a kernel whose type is forgotten: what surrounds the loops over cells is compiled once
/// and not for every kernel.
type Compute<'a, const D: usize> =
    &'a (dyn Fn(&ElementVectors<D>, Range<usize>, Deliver) -> Result<(), AssemblyError> + Sync);

impl<const D: usize> VectorVisitor<'_, D> {
    #[inline(never)]
    fn integrate(
        &mut self,
        integral: &Integral,
        requirements: &Requirements,
        components: usize,
        compute: Compute<D>,
    ) -> Result<(), AssemblyError> {
        let space = self.tests[integral.test];
        let offset = self.offsets[integral.test];
        let name = self.binding.name_of(Role::Test(integral.test));
        for group in groups(self.binding, integral, self.quadrature, &self.degrees, requirements)? {
            let side = group.side(self.binding.name, integral.test_side)?;
            group.check_support(self.binding.name, name, space, side)?;
            let element = self.elements[integral.test];
            let cells = Cells::Mesh(self.binding.mesh);
            let task = ElementVectors { binding: self.binding, group: &group, cells, side, element };
            let tests = GroupNodes::new(space, &group.sides[side]);
            let scatter = VectorScatter { tests, components, nodes: task.nodes() };
            let (added, length) = (self.added, components * task.nodes());
            let values = &mut self.vector[offset..offset + space.unknowns()];
            let partition = scatter.tests.partition(self.threads);
            let parts = scatter.parts(&partition, values);
            let done = self.threads.run(parts, |(entities, mut part)| {
                let mut sizes = Vec::new();
                compute(&task, entities, &mut |first, vectors| {
                    let added = match added {
                        Added::Vectors => vectors,
                        Added::Sizes(Terms::OfRows) => {
                            sizes.clear();
                            sizes.extend(vectors.iter().map(|value| value.abs()));
                            &sizes
                        }
                        Added::Sizes(terms) => {
                            let stride = if terms == Terms::OfCells { 1 } else { components };
                            sizes.clear();
                            for vector in vectors.chunks_exact(length) {
                                let first = sizes.len();
                                sizes.resize(first + length, 0.0_f64);
                                spread_largest(vector, stride, &mut sizes[first..]);
                            }
                            &sizes
                        }
                    };
                    scatter.add(first, added, &mut part);
                    Ok(())
                })?;
                Ok(part.into_deferred())
            });
            for deferred in done {
                scatter.add_deferred(&deferred?, values);
            }
        }
        Ok(())
    }
}

/// Writes the largest amount of every `stride`-th entry of a vector into those of its places that are not zero: at a facet the nodes away
/// from it have no part in the vector.
fn spread_largest(vector: &[f64], stride: usize, sizes: &mut [f64]) {
    for first in 0..stride {
        let own = || vector.iter().skip(first).step_by(stride);
        let most = own().fold(0.0, |most: f64, value| most.max(value.abs()));
        let places = sizes.iter_mut().skip(first).step_by(stride).zip(own());
        places.filter(|(_, value)| **value != 0.0).for_each(|(size, _)| *size = most);
    }
}

compiled_here!(
    residual: VectorVisitor::<D>::integrate,
    Assembler::<D>::linear_integrals,
    Assembler::<D>::load_of,
    Assembler::<D>::sizes_of,
    Assembler::<D>::whole_or_parts,
);
