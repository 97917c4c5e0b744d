//! Tangent matrices: ∂R/∂u applied to every trial basis function, tested with every test basis function.

use std::sync::Arc;

use forms_core::contract::{Integral, Requirements, Role, Side, Term};

use super::batch::Cells;
use super::binding::Binding;
use super::element_loops::matrices::ElementMatrices;
use super::groups::Group;
use super::groups::shared_facets::SharedFacetGroups;
use super::kernels::MatrixKernel;
use super::scatter::MatrixScatter;
use super::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::assemble::binding::outline::Outline;
use crate::assemble::scatter::block_positions::{BlockPlaces, ChosenPairs};
use crate::assemble::scatter::group_nodes::{GroupNodes, Reading, seen_places};
use crate::contract::{Form, Function};
use crate::field::{Field, FieldView, views};
use crate::instantiate::instantiate;
use crate::linear_algebra::{BlockMatrix, CsrMatrix, LinearAlgebraError};
use crate::mesh::Facet;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

impl<const D: usize> Assembler<D> {
    /// The tangent of a form at given unknowns: rows are the test spaces' unknowns, columns those of the
    /// form's unknowns. For a form that is linear in its unknown this is its matrix.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn tangent(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<CsrMatrix, AssemblyError> {
        let outline = Outline::of(form, Parts::ALL);
        let pattern = BlockPattern::at_iterate(&outline, tests, &views(unknowns), self)?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        self.add_tangent(form, unknowns, tests, Parts::ALL, &pattern, &mut matrix)?;
        Ok(matrix.into_csr())
    }

    /// The tangent of some of the integrals, in place of the values of a matrix on the pattern. The pattern must be
    /// of the same spaces and hold every entry that the form touches. This is the fastest way to assemble a matrix
    /// again: rows are set to zero when they are first needed.
    ///
    /// # Errors
    /// As [`Assembler::tangent`]; then the values mean nothing.
    pub fn assemble_tangent(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let arguments = (&views(unknowns)[..], tests);
        self.write_tangent(form, arguments, parts, pattern, matrix, ValuesBefore::Vanish)
    }

    /// The tangent of some of the integrals, added to a matrix on the pattern. The pattern must be of the same spaces and
    /// hold every entry that the form touches.
    ///
    /// # Errors
    /// As [`Assembler::tangent`].
    pub fn add_tangent(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let arguments = (&views(unknowns)[..], tests);
        self.write_tangent(form, arguments, parts, pattern, matrix, ValuesBefore::Count)
    }

    /// Tangent of some of the integrals, written to a matrix on the pattern.
    ///
    /// # Errors
    /// As [`Assembler::tangent`].
    #[doc(hidden)]
    #[inline(never)]
    pub fn write_tangent(
        &self,
        form: &Function<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
        values_before: ValuesBefore,
    ) -> Result<(), AssemblyError> {
        let trials: Vec<&Arc<Space<D>>> = unknowns.iter().map(|view| view.space).collect();
        pattern.check(form, tests, &trials)?;
        let (own, given) = (matrix.sparsity(), pattern.sparsity());
        if !Arc::ptr_eq(own, given) && **own != **given {
            let source = LinearAlgebraError::PatternMismatch { what: "assembling a matrix" };
            return Err(AssemblyError::LinearAlgebra { form: form.name(), source });
        }
        let mut written = vec![values_before == ValuesBefore::Count; tests.len() * trials.len()];
        let (values, zeros) = matrix.values_and_zero_rows();
        let target =
            Target::Matrix { pattern, values: &mut *values, zeros: &mut *zeros, written: &mut written };
        let mut integrals = TangentIntegrals::new(self, form, (unknowns, tests), target)?;
        let mut asked = form.tangent().iter().filter(|term| parts.contain(term.integral.dependence));
        let done = asked.try_for_each(|term| integrals.add(term));
        let done = done.and_then(|()| integrals.add_products_of_means(form, parts));
        let done = done.and_then(|()| integrals.add_rates_of_dual_functions(form, parts));
        if done.is_err() {
            // Some thread may have left its rows as they were.
            zeros.fill(false);
            return done;
        }
        for (pair, written) in written.into_iter().enumerate() {
            if !written {
                let (test, trial) = (pair / trials.len(), pair % trials.len());
                values[pattern.sparsity().pair(test, trial).values()].fill(0.0);
                zeros[pattern.sparsity().pair_rows(test, trial)].fill(true);
            }
        }
        self.add_motion_of_segments(form, (unknowns, tests), parts, pattern, matrix)
    }

    /// The element matrices of a form, cell by cell (or facet by facet), integral by integral; on interior
    /// facets one per pair of sides. Those of moving segments are at fixed points.
    ///
    /// # Errors
    /// As [`Assembler::tangent`].
    pub fn element_matrices(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<ElementMatrix>, AssemblyError> {
        let (mut found, unknowns) = (Vec::new(), views(unknowns));
        let arguments = (&unknowns[..], tests);
        let mut integrals = TangentIntegrals::new(self, form, arguments, Target::Elements(&mut found))?;
        form.tangent().iter().try_for_each(|term| integrals.add(term))?;
        integrals.add_products_of_means(form, Parts::ALL)?;
        Ok(found)
    }
}

/// Treatment of the values that a matrix has.
#[derive(Clone, Copy, PartialEq)]
#[doc(hidden)]
pub enum ValuesBefore {
    /// A tangent is added to them.
    Count,
    /// It replaces them.
    Vanish,
}

/// The contribution of one cell or facet.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementMatrix {
    /// Cell index; on an interior facet that of its first side.
    pub cell: u32,
    /// Local facet number, for a facet integral.
    pub facet: Option<u8>,
    /// An interior facet from its other side.
    pub opposite: Option<Facet>,
    /// The sides on which the test functions (rows) and the trial functions (columns) live.
    pub sides: [Side; 2],
    /// Number of rows: test nodes × components, `node * components + component`.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Row-major.
    pub values: Vec<f64>,
}

/// Targets of element matrices.
pub(super) enum Target<'a, const D: usize> {
    Matrix {
        pattern: &'a BlockPattern<D>,
        values: &'a mut [f64],
        /// Of each pair of spaces and row node, whether the values are known to be zero.
        zeros: &'a mut [bool],
        /// Of each pair of spaces, whether its values count.
        written: &'a mut [bool],
    },
    Elements(&'a mut Vec<ElementMatrix>),
}

/// The integrals of a tangent on their way to a target.
pub(super) struct TangentIntegrals<'a, const D: usize> {
    pub binding: Binding<'a, D>,
    pub quadrature: &'a Quadrature<D>,
    pub threads: Threads,
    pub degrees: Vec<usize>,
    pub tests: &'a [&'a Arc<Space<D>>],
    pub trials: Vec<&'a Arc<Space<D>>>,
    pub test_elements: Vec<usize>,
    pub trial_elements: Vec<usize>,
    pub target: Target<'a, D>,
    facets: SharedFacetGroups<D>,
}

impl<'a, const D: usize> TangentIntegrals<'a, D> {
    #[inline(never)]
    fn new(
        assembler: &'a Assembler<D>,
        form: &'a Function<D>,
        (unknowns, tests): (&[FieldView<'a, D>], &'a [&'a Arc<Space<D>>]),
        target: Target<'a, D>,
    ) -> Result<Self, AssemblyError> {
        let mut binding = assembler.bind(form, unknowns)?;
        binding.check_tests(tests, &assembler.mesh)?;
        let test_elements = tests.iter().map(|space| binding.element(space)).collect();
        let trials: Vec<&Arc<Space<D>>> = unknowns.iter().map(|view| view.space).collect();
        let trial_elements = trials.iter().map(|space| binding.element(space)).collect();
        let degrees = binding.degrees(tests);
        Ok(TangentIntegrals {
            binding,
            quadrature: &assembler.quadrature,
            threads: assembler.threads,
            degrees,
            tests,
            trials,
            test_elements,
            trial_elements,
            target,
            facets: SharedFacetGroups::default(),
        })
    }

    /// Adds the integral of a term, group by group.
    #[inline(never)]
    fn add(&mut self, term: &Term<MatrixKernel<D>>) -> Result<(), AssemblyError> {
        let (integral, constants) = (term.integral, term.kernel.constants());
        let set = self.binding.instructions;
        let [height, width] = constants.components;
        let (test, trial) = (self.tests[integral.test], self.trials[integral.trial]);
        let form = self.binding.name;
        let names = [
            self.binding.name_of(Role::Test(integral.test)),
            self.binding.name_of(Role::Unknown(integral.trial)),
        ];
        // Half of the pairs suffice when test and trial nodes are the same.
        let reading = Reading::of_arguments(constants.requirements);
        let same_nodes = Arc::ptr_eq(test, trial) && integral.test_side == integral.trial_side;
        let arguments = [(Role::Test(integral.test), &**test), (Role::Unknown(integral.trial), &**trial)];
        let groups = self.facets.groups(
            &self.binding,
            integral,
            self.quadrature,
            &self.degrees,
            constants.requirements,
            &arguments,
        )?;
        for group in groups.iter() {
            let sides = [group.side(form, integral.test_side)?, group.side(form, integral.trial_side)?];
            group.check_support(form, names[0], test, sides[0])?;
            group.check_support(form, names[1], trial, sides[1])?;
            let Requirements { test_mean, trial_mean, .. } = *constants.requirements;
            for (read, name, space) in [(test_mean, names[0], test), (trial_mean, names[1], trial)] {
                if read {
                    group.check_mean(form, name, space)?;
                }
            }
            // Element matrices that are asked for have all rows and columns.
            let seen = match self.target {
                Target::Matrix { .. } => {
                    [(0, test), (1, trial)].map(|(k, space)| seen_places(group, sides[k], space, reading[k]))
                }
                Target::Elements(_) => [None, None],
            };
            let task = ElementMatrices {
                binding: &self.binding,
                group,
                cells: Cells::Mesh(self.binding.mesh),
                sides,
                elements: [self.test_elements[integral.test], self.trial_elements[integral.trial]],
                symmetric: constants.symmetric && same_nodes && seen[0] == seen[1],
                seen,
            };
            let nodes = task.nodes();
            let size = nodes[0] * nodes[1] * height * width;
            match &mut self.target {
                Target::Elements(found) => {
                    term.kernel.compute(&task, 0..group.entities(), &mut |first, matrices| {
                        for (number, matrix) in matrices.chunks_exact(size).enumerate() {
                            found.push(element_matrix(
                                integral,
                                group,
                                first + number,
                                (test, trial),
                                matrix,
                            ));
                        }
                        Ok(())
                    })?
                }
                Target::Matrix { pattern, values, zeros, written } => {
                    let at = |space, k: usize| {
                        let nodes = GroupNodes::new(space, &group.sides[sides[k]]);
                        nodes.at_places(task.seen[k].as_deref())
                    };
                    let all = [0, 1].map(|k| group.sides[sides[k]].elements[task.elements[k]].nodes);
                    let blocks = pattern.sparsity().pair(integral.test, integral.trial);
                    let on_cells = test.facet_region().is_none() && trial.facet_region().is_none();
                    let one_sided = on_cells && integral.test_side == integral.trial_side;
                    let scatter = MatrixScatter {
                        tests: at(test, 0),
                        trials: at(trial, 1),
                        blocks,
                        block: height * width,
                        map: match (pattern.map(integral.test, integral.trial), group.pairs()) {
                            (Some(map), _) if one_sided => BlockPlaces::OfCells(map),
                            (Some(map), Some(pairs)) => {
                                let sides = [integral.test_side, integral.trial_side];
                                let (facets, blocks) = (&pairs.group.facets, nodes[0] * nodes[1]);
                                match map.starts_of_pairs(sides, reading, facets, blocks) {
                                    Some(starts) => BlockPlaces::OfPairs(map, starts),
                                    None => BlockPlaces::Unknown,
                                }
                            }
                            _ => BlockPlaces::Unknown,
                        },
                        nodes,
                        chosen: ChosenPairs::new(task.seen.each_ref().map(Option::as_deref), all),
                    };
                    let rows = pattern.sparsity().pair_rows(integral.test, integral.trial);
                    let (values, zeros) = (&mut values[blocks.values()], &mut zeros[rows]);
                    let written = &mut written[integral.test * self.trials.len() + integral.trial];
                    let partition = scatter.tests.partition(self.threads);
                    let parts = scatter.parts(&partition, (&mut *values, &mut *zeros), *written);
                    let missing = || AssemblyError::Pattern { form, test: names[0], trial: names[1] };
                    let done = self.threads.run(parts, |(entities, mut part)| {
                        term.kernel.compute(&task, entities, &mut |first, matrices| {
                            scatter.add(set, first, matrices, &mut part).ok_or_else(missing)
                        })?;
                        Ok(scatter.finish(part))
                    });
                    *written = true;
                    let deferred: Vec<_> = done.into_iter().collect::<Result<_, AssemblyError>>()?;
                    scatter.add_deferred(self.threads, &deferred, (values, zeros));
                }
            }
        }
        Ok(())
    }
}

/// The element matrix of a group's `number`-th entity, with its rows and columns in one piece.
#[inline(never)]
fn element_matrix<const D: usize>(
    integral: &Integral,
    group: &Group<D>,
    number: usize,
    (test, trial): (&Space<D>, &Space<D>),
    matrix: &[f64],
) -> ElementMatrix {
    let [a, b] = [test.components(), trial.components()];
    let seen_from = |side: usize| {
        let side = &group.sides[side];
        (side.cells[number], side.facet.map(|(local, _)| local))
    };
    let of_side = |side: Side| if side == Side::This { seen_from(0) } else { seen_from(1) };
    let count = |space: &Space<D>, (cell, facet)| space.nodes_at(cell, facet).len();
    let nodes = [count(test, of_side(integral.test_side)), count(trial, of_side(integral.trial_side))];
    let (rows, columns) = (nodes[0] * a, nodes[1] * b);
    let entry = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        let pair = row / a * nodes[1] + column / b;
        matrix[pair * a * b + row % a * b + column % b]
    };
    let values = (0..rows * columns).map(entry).collect();
    let (cell, facet) = seen_from(0);
    let opposite = (group.sides.len() == 2).then(|| {
        let (cell, local) = seen_from(1);
        Facet { cell, local: local.unwrap_or_default() }
    });
    let sides = [integral.test_side, integral.trial_side];
    ElementMatrix { cell, facet, opposite, sides, rows, columns, values }
}

instantiate!(
    tangent: TangentIntegrals::<D>::new,
    TangentIntegrals::<D>::add,
    Assembler::<D>::write_tangent,
);
