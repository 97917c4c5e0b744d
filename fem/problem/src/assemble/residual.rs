//! Residual vectors: R(u; φ_i e_a) for every test basis function.

use std::sync::Arc;

use forms_core::contract::{Role, Term};

use super::batch::Cells;
use super::binding::Binding;
use super::element_loops::vectors::ElementVectors;
use super::groups::shared_facets::SharedFacetGroups;
use super::kernels::VectorKernel;
use super::scatter::VectorScatter;
use super::scatter::group_nodes::{GroupNodes, Reading, places_on_facet};
use super::{Assembler, AssemblyError, Parts};
use crate::contract::{Form, Function};
use crate::field::{Field, FieldView, views};
use crate::instantiate::instantiate;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

impl<const D: usize> Assembler<D> {
    /// The vector of a linear form, one entry per unknown of the space of its test function.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    pub fn linear_form(&self, form: &Form<D>, space: &Arc<Space<D>>) -> Result<Vec<f64>, AssemblyError> {
        self.residual(form, &[], &[space])
    }

    /// The residual of a form at given unknowns: one entry per unknown of the test spaces, in a row.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn residual(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual_parts(form, unknowns, tests, Parts::ALL)
    }

    /// Some of the integrals of [`Assembler::residual`].
    ///
    /// # Errors
    /// As there.
    pub fn residual_parts(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual_of(form, &views(unknowns), tests, parts)
    }

    /// [`Assembler::residual_parts`] at coefficients that need not be those of a field.
    ///
    /// # Errors
    /// As there.
    #[doc(hidden)]
    #[inline(never)]
    pub fn residual_of(
        &self,
        form: &Function<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual_by(form, (unknowns, tests), parts, &[])
    }

    /// The residual of a form without unknowns, except for the integrals of some of its test functions, by their numbers: zero in their
    /// places.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    #[doc(hidden)]
    #[inline(never)]
    pub fn residual_without(
        &self,
        form: &Function<D>,
        tests: &[&Arc<Space<D>>],
        left_out: &[usize],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.residual_by(form, (&[], tests), Parts::ALL, left_out)
    }

    fn residual_by(
        &self,
        form: &Function<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        left_out: &[usize],
    ) -> Result<Vec<f64>, AssemblyError> {
        let binding = self.bind(form, unknowns)?;
        let is_asked = |term: &&Term<VectorKernel<D>>| {
            parts.contain(term.integral.dependence) && !left_out.contains(&term.integral.test)
        };
        // The parts of an integral may have rules of their own; one rule for all makes the whole their sum.
        let terms: Vec<_> = match parts == Parts::ALL && !self.quadrature.follows_estimates() {
            true => form.joined_residual().filter(is_asked).collect(),
            false => form.residual().iter().filter(is_asked).collect(),
        };
        let mut sum = self.sum_of_terms(binding, tests, &terms, Added::Vectors)?;
        self.add_motion_of_integrands(form, (unknowns, tests), (parts, left_out), &mut sum)?;
        Ok(sum)
    }

    /// The residual of the constant and linear integrals where the unknowns are zero. Those that are proved to vanish there are not
    /// assembled: a coefficient that is no number does not show.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    #[doc(hidden)]
    #[inline(never)]
    pub fn load(&self, form: &Function<D>, tests: &[&Arc<Space<D>>]) -> Result<Vec<f64>, AssemblyError> {
        let zero: Vec<Field<D>> = tests.iter().map(|space| Field::zero(space)).collect();
        let unknowns = views(&zero.iter().collect::<Vec<_>>());
        let binding = self.bind(form, &unknowns)?;
        let parts = Parts::LINEAR_AND_CONSTANT;
        let terms = form.residual().iter();
        let terms: Vec<_> =
            terms.filter(|term| parts.contain(term.integral.dependence) && !term.integral.vanishes).collect();
        let mut sum = self.sum_of_terms(binding, tests, &terms, Added::Vectors)?;
        self.add_motion_of_integrands(form, (&unknowns, tests), (parts, &[]), &mut sum)?;
        Ok(sum)
    }

    /// The size of the terms that are summed in each entry of the residual: contributions of cells and facets, each integral by
    /// itself, with the sign removed.
    ///
    /// # Errors
    /// As [`Assembler::residual`].
    #[doc(hidden)]
    #[inline(never)]
    pub fn sizes_of_contributions(
        &self,
        form: &Function<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        terms: Terms,
    ) -> Result<Vec<f64>, AssemblyError> {
        let all: Vec<_> = form.residual().iter().collect();
        self.sum_of_terms(self.bind(form, unknowns)?, tests, &all, Added::Sizes(terms))
    }

    /// The sum of some terms of a form that is bound.
    #[inline(never)]
    pub(super) fn sum_of_terms(
        &self,
        mut binding: Binding<D>,
        tests: &[&Arc<Space<D>>],
        terms: &[&Term<VectorKernel<D>>],
        added: Added,
    ) -> Result<Vec<f64>, AssemblyError> {
        binding.check_tests(tests, &self.mesh)?;
        let elements = tests.iter().map(|space| binding.element(space)).collect();
        let mut offsets = vec![0];
        for space in tests {
            offsets.push(offsets[offsets.len() - 1] + space.unknowns());
        }
        let degrees = binding.degrees(tests);
        let mut sum = VectorSum {
            binding: &binding,
            quadrature: &self.quadrature,
            threads: self.threads,
            degrees,
            tests,
            elements,
            vector: vec![0.0; offsets[tests.len()]],
            offsets,
            added,
            facets: SharedFacetGroups::default(),
        };
        for term in terms {
            sum.integrate(term)?;
        }
        Ok(sum.vector)
    }
}

/// Adds up integrals that are linear in a test function.
struct VectorSum<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    threads: Threads,
    degrees: Vec<usize>,
    tests: &'a [&'a Arc<Space<D>>],
    elements: Vec<usize>,
    offsets: Vec<usize>,
    vector: Vec<f64>,
    added: Added,
    facets: SharedFacetGroups<D>,
}

/// Amounts that are added up.
#[derive(Clone, Copy)]
pub(super) enum Added {
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

impl<const D: usize> VectorSum<'_, D> {
    #[inline(never)]
    fn integrate(&mut self, term: &Term<VectorKernel<D>>) -> Result<(), AssemblyError> {
        let (integral, constants) = (term.integral, term.kernel.constants());
        let components = constants.components;
        let space = self.tests[integral.test];
        let offset = self.offsets[integral.test];
        let name = self.binding.name_of(Role::Test(integral.test));
        let arguments = [(Role::Test(integral.test), &**space)];
        let groups = self.facets.groups(
            self.binding,
            integral,
            self.quadrature,
            &self.degrees,
            constants.requirements,
            &arguments,
        )?;
        for group in groups.iter() {
            let side = group.side(self.binding.name, integral.test_side)?;
            group.check_support(self.binding.name, name, space, side)?;
            if constants.requirements.test_mean {
                group.check_mean(self.binding.name, name, space)?;
            }
            let element = self.elements[integral.test];
            let cells = Cells::Mesh(self.binding.mesh);
            let task = ElementVectors { binding: self.binding, group, cells, side, element };
            let tests = GroupNodes::new(space, &group.sides[side]);
            let scatter = VectorScatter { tests, components, nodes: task.nodes() };
            let (added, length) = (self.added, components * task.nodes());
            // A node with a part in the vector may have entries that cancel to zero.
            let [reading, _] = Reading::of_arguments(constants.requirements);
            let places = match added {
                Added::Vectors | Added::Sizes(Terms::OfRows) => vec![],
                Added::Sizes(_) => places_on_facet(group, side, space, reading)
                    .unwrap_or_else(|| (0..task.nodes()).collect()),
            };
            let values = &mut self.vector[offset..offset + space.unknowns()];
            let partition = scatter.tests.partition(self.threads);
            let parts = scatter.parts(&partition, values);
            let done = self.threads.run(parts, |(entities, mut part)| {
                let mut sizes = Vec::new();
                term.kernel.compute(&task, entities, &mut |first, vectors| {
                    let added = match added {
                        Added::Vectors => vectors,
                        Added::Sizes(Terms::OfRows) => {
                            sizes.clear();
                            sizes.extend(vectors.iter().map(|value| value.abs()));
                            &sizes
                        }
                        Added::Sizes(terms) => {
                            sizes.clear();
                            for vector in vectors.chunks_exact(length) {
                                let first = sizes.len();
                                sizes.resize(first + length, 0.0_f64);
                                spread_largest(vector, terms, components, &places, &mut sizes[first..]);
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

/// Writes the largest amount of a vector, or of each component, at the places of nodes that have a part in it. Components that are zero
/// at all nodes stay zero.
fn spread_largest(vector: &[f64], terms: Terms, components: usize, places: &[usize], sizes: &mut [f64]) {
    let most = vector.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    for component in 0..components {
        let own = vector.iter().skip(component).step_by(components);
        let largest = own.fold(0.0, |most: f64, value| most.max(value.abs()));
        let size = if terms == Terms::OfCells && largest > 0.0 { most } else { largest };
        places.iter().for_each(|place| sizes[place * components + component] = size);
    }
}

instantiate!(
    residual: VectorSum::<D>::integrate,
    Assembler::<D>::sum_of_terms,
    Assembler::<D>::load,
    Assembler::<D>::sizes_of_contributions,
    Assembler::<D>::residual_of,
    Assembler::<D>::residual_without,
);
