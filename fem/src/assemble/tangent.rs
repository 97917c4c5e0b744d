//! Tangent matrices: ∂R/∂u applied to every trial basis function, tested with every test basis function.

use std::sync::Arc;

use forms_core::contract::{BilinearKernel, BilinearVisitor, Form, Integral, Role, Side};

use super::batch::Cells;
use super::binding::Binding;
use super::element_matrices::ElementMatrices;
use super::walk::{Group, groups};
use super::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::field::Field;
use crate::lanes::InstructionSet;
use crate::linear_algebra::CsrMatrix;
use crate::mesh::Facet;
use crate::quadrature::Quadrature;
use crate::space::Space;

impl<const D: usize> Assembler<D> {
    /// The tangent of a form at given unknowns: rows are the test spaces' unknowns, columns those of the
    /// form's unknowns. For a form that is linear in its unknown this is its matrix.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn tangent<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<CsrMatrix, AssemblyError> {
        let trials: Vec<&Arc<Space<D>>> = unknowns.iter().map(|field| field.space()).collect();
        let pattern = BlockPattern::for_form(form, tests, &trials)?;
        let mut matrix = CsrMatrix::zero(pattern.pattern());
        self.add_tangent(form, unknowns, tests, Parts::ALL, &pattern, &mut matrix)?;
        Ok(matrix)
    }

    /// Adds some of the integrals to a matrix on the pattern, which must be of the same spaces and hold every
    /// entry that the form touches.
    ///
    /// # Errors
    /// As [`Assembler::tangent`].
    pub fn add_tangent<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
        pattern: &BlockPattern,
        matrix: &mut CsrMatrix,
    ) -> Result<(), AssemblyError> {
        self.walk_tangent(
            form,
            unknowns,
            tests,
            parts,
            Target::Matrix { pattern, values: matrix.values_mut() },
        )
    }

    /// The element matrices of a form, cell by cell (or facet by facet), integral by integral; on interior
    /// facets one per pair of sides.
    ///
    /// # Errors
    /// As [`Assembler::tangent`].
    pub fn element_matrices<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<ElementMatrix>, AssemblyError> {
        let mut found = Vec::new();
        self.walk_tangent(form, unknowns, tests, Parts::ALL, Target::Elements(&mut found))?;
        Ok(found)
    }

    fn walk_tangent<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
        target: Target,
    ) -> Result<(), AssemblyError> {
        let mut binding = Binding::new(form.name(), form.fields(), form.inputs(), &self.mesh, unknowns)?;
        binding.check_tests(tests, &self.mesh)?;
        let test_elements = tests.iter().map(|space| binding.element(space)).collect();
        let trials: Vec<&Arc<Space<D>>> = unknowns.iter().map(|field| field.space()).collect();
        let trial_elements = trials.iter().map(|space| binding.element(space)).collect();
        let degrees = binding.degrees(tests);
        let (binding, quadrature) = (&binding, &self.quadrature);
        form.tangent(&mut TangentVisitor {
            binding,
            quadrature,
            degrees,
            tests,
            trials,
            test_elements,
            trial_elements,
            target,
            parts,
            set: self.instructions,
        })
    }
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

/// Where element matrices go.
enum Target<'a> {
    Matrix { pattern: &'a BlockPattern, values: &'a mut [f64] },
    Elements(&'a mut Vec<ElementMatrix>),
}

struct TangentVisitor<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    degrees: Vec<usize>,
    tests: &'a [&'a Arc<Space<D>>],
    trials: Vec<&'a Arc<Space<D>>>,
    test_elements: Vec<usize>,
    trial_elements: Vec<usize>,
    target: Target<'a>,
    parts: Parts,
    set: InstructionSet,
}

impl<const D: usize> BilinearVisitor<D> for TangentVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        if !self.parts.contain(integral.dependence) {
            return Ok(());
        }
        self.integrate(integral, kernel)
    }
}

impl<const D: usize> TangentVisitor<'_, D> {
    fn integrate<K: BilinearKernel<D>>(
        &mut self,
        integral: &Integral,
        kernel: &K,
    ) -> Result<(), AssemblyError> {
        let (test, trial) = (self.tests[integral.test], self.trials[integral.trial]);
        let form = self.binding.name;
        let names = [
            self.binding.name_of(Role::Test(integral.test)),
            self.binding.name_of(Role::Unknown(integral.trial)),
        ];
        // Half of the pairs suffice when test and trial nodes are the same.
        let same_nodes = Arc::ptr_eq(test, trial) && integral.test_side == integral.trial_side;
        for group in groups(self.binding, integral, self.quadrature, &self.degrees, &K::REQUIREMENTS)? {
            group.check_support(form, names[0], test)?;
            group.check_support(form, names[1], trial)?;
            let task = ElementMatrices {
                binding: self.binding,
                group: &group,
                cells: Cells::Mesh(self.binding.mesh),
                sides: [group.side(form, integral.test_side)?, group.side(form, integral.trial_side)?],
                elements: [self.test_elements[integral.test], self.trial_elements[integral.trial]],
                symmetric: K::SYMMETRIC && same_nodes,
            };
            let nodes = task.nodes();
            let size = nodes[0] * nodes[1] * K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
            task.compute(kernel, self.set, 0..group.entities(), &mut |first, matrices| {
                for (number, matrix) in matrices.chunks_exact(size).enumerate() {
                    self.deliver(integral, &group, first + number, nodes, matrix)
                        .ok_or(AssemblyError::Pattern { form, test: names[0], trial: names[1] })?;
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Hands over the element matrix of the group's `number`-th entity. `None`: the pattern does not have its
    /// entries.
    fn deliver(
        &mut self,
        integral: &Integral,
        group: &Group<D>,
        number: usize,
        nodes: [usize; 2],
        matrix: &[f64],
    ) -> Option<()> {
        let (test, trial) = (self.tests[integral.test], self.trials[integral.trial]);
        let components = [test.components(), trial.components()];
        let block = components[0] * components[1];
        let seen_from = |side: usize| {
            let side = &group.sides[side];
            (side.cells[number], side.facet.map(|(local, _)| local))
        };
        let of_side = |side: Side| if side == Side::This { seen_from(0) } else { seen_from(1) };
        match &mut self.target {
            Target::Matrix { pattern, values } => {
                let (cell, facet) = of_side(integral.test_side);
                let rows = test.nodes_at(cell, facet);
                let (cell, facet) = of_side(integral.trial_side);
                let columns = trial.nodes_at(cell, facet);
                let mut blocks = matrix.chunks_exact(block);
                for row in rows {
                    for column in columns {
                        let (row, column) =
                            ((integral.test, *row as usize), (integral.trial, *column as usize));
                        let block = blocks.next()?;
                        pattern.add(values, row, column, |entry| block[entry])?;
                    }
                }
            }
            Target::Elements(found) => {
                let (rows, columns) = (nodes[0] * components[0], nodes[1] * components[1]);
                let entry = |index: usize| {
                    let (row, column) = (index / columns, index % columns);
                    let [a, b] = components;
                    let pair = row / a * nodes[1] + column / b;
                    matrix[pair * block + row % a * b + column % b]
                };
                let values = (0..rows * columns).map(entry).collect();
                let (cell, facet) = seen_from(0);
                let opposite = (group.sides.len() == 2).then(|| {
                    let (cell, local) = seen_from(1);
                    Facet { cell, local: local.unwrap_or_default() }
                });
                let sides = [integral.test_side, integral.trial_side];
                found.push(ElementMatrix { cell, facet, opposite, sides, rows, columns, values });
            }
        }
        Some(())
    }
}
