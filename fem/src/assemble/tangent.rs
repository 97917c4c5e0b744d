//! Tangent matrices: ∂R/∂u applied to every trial basis function, tested with every test basis function.

use std::sync::Arc;

use forms_core::contract::{BilinearKernel, BilinearVisitor, Form, Integral, Lane, Role, Side};

use super::batch::{Batch, WIDEST};
use super::binding::Binding;
use super::walk::{Group, groups};
use super::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::field::Field;
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
}

impl<const D: usize> BilinearVisitor<D> for TangentVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        if !self.parts.contain(integral.dependence) {
            return Ok(());
        }
        self.integrate::<K, f64>(integral, kernel)
    }
}

impl<const D: usize> TangentVisitor<'_, D> {
    fn integrate<K: BilinearKernel<D>, L: Lane>(
        &mut self,
        integral: &Integral,
        kernel: &K,
    ) -> Result<(), AssemblyError> {
        let (test, trial) = (self.tests[integral.test], self.trials[integral.trial]);
        let (test_element, trial_element) =
            (self.test_elements[integral.test], self.trial_elements[integral.trial]);
        let form = self.binding.name;
        let names = [
            self.binding.name_of(Role::Test(integral.test)),
            self.binding.name_of(Role::Unknown(integral.trial)),
        ];
        // Half of the pairs suffice when test and trial nodes are the same.
        let same_nodes = Arc::ptr_eq(test, trial) && integral.test_side == integral.trial_side;
        let symmetric = K::SYMMETRIC && same_nodes;
        for group in groups(self.binding, integral, self.quadrature, &self.degrees, &K::REQUIREMENTS)? {
            group.check_support(form, names[0], test)?;
            group.check_support(form, names[1], trial)?;
            let (test_side, trial_side) =
                (group.side(form, integral.test_side)?, group.side(form, integral.trial_side)?);
            let mut batch = Batch::<L, D>::new(self.binding, &group, K::REQUIREMENTS)?;
            let rows = group.sides[test_side].elements[test_element].nodes;
            let columns = group.sides[trial_side].elements[trial_element].nodes;
            let mut accumulators = vec![K::zero::<L>(); rows * columns];
            let mut trial_factors = Vec::with_capacity(columns);
            let mut element = ElementBatch::new([rows, columns], [test.components(), trial.components()]);
            for index in 0..batch.count() {
                let cell = kernel.cell(&batch.load(index));
                accumulators.fill(K::zero::<L>());
                for q in 0..group.points() {
                    let geometry = batch.point(q)?;
                    let point = kernel.point(&cell, &geometry, batch.fields());
                    trial_factors.clear();
                    let hessians = batch.hessians(trial_side, trial_element);
                    for (basis, hessian) in batch.basis(trial_side, trial_element).iter().zip(hessians) {
                        trial_factors.push(kernel.trial(&point, basis, hessian));
                    }
                    let hessians = batch.hessians(test_side, test_element);
                    let functions = batch.basis(test_side, test_element).iter().zip(hessians);
                    for (i, (basis, hessian)) in functions.enumerate() {
                        let factors = kernel.test(&point, basis, hessian);
                        let first = if symmetric { i } else { 0 };
                        let row = &mut accumulators[i * columns + first..(i + 1) * columns];
                        for (accumulator, trial) in row.iter_mut().zip(&trial_factors[first..]) {
                            K::pair(accumulator, &factors, trial);
                        }
                    }
                }
                for i in 0..rows {
                    for j in if symmetric { i } else { 0 }..columns {
                        let block = kernel.finish(&cell, &accumulators[i * columns + j]);
                        element.put([i, j], block.as_ref(), symmetric);
                    }
                }
                for lane in 0..batch.cells(0).len() {
                    self.deliver(integral, &group, index * L::WIDTH + lane, &element, lane)
                        .ok_or(AssemblyError::Pattern { form, test: names[0], trial: names[1] })?;
                }
            }
        }
        Ok(())
    }

    /// Hands over the element matrix of one lane, that of the group's `number`-th entity. `None`: the pattern
    /// does not have its entries.
    fn deliver(
        &mut self,
        integral: &Integral,
        group: &Group<D>,
        number: usize,
        element: &ElementBatch,
        lane: usize,
    ) -> Option<()> {
        let (test, trial) = (self.tests[integral.test], self.trials[integral.trial]);
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
                for (i, row) in rows.iter().enumerate() {
                    for (j, column) in columns.iter().enumerate() {
                        let (row, column) =
                            ((integral.test, *row as usize), (integral.trial, *column as usize));
                        pattern.add(values, row, column, |entry| element.get([i, j], entry, lane))?;
                    }
                }
            }
            Target::Elements(found) => {
                let (rows, columns) =
                    (element.nodes[0] * element.components[0], element.nodes[1] * element.components[1]);
                let entry = |index: usize| {
                    let (row, column) = (index / columns, index % columns);
                    let [a, b] = element.components;
                    element.get([row / a, column / b], row % a * b + column % b, lane)
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

/// The element matrices of a batch, block after block, lanes innermost.
struct ElementBatch {
    nodes: [usize; 2],
    components: [usize; 2],
    values: Vec<[f64; WIDEST]>,
}

impl ElementBatch {
    fn new(nodes: [usize; 2], components: [usize; 2]) -> Self {
        let count = nodes.iter().chain(&components).product();
        ElementBatch { nodes, components, values: vec![[0.0; WIDEST]; count] }
    }

    fn put<L: Lane>(&mut self, [i, j]: [usize; 2], block: &[L], symmetric: bool) {
        let size = block.len();
        let start = (i * self.nodes[1] + j) * size;
        for (lanes, entry) in self.values[start..start + size].iter_mut().zip(block) {
            entry.store(lanes);
        }
        if symmetric && i != j {
            let mirrored = (j * self.nodes[1] + i) * size;
            let count = self.components[1];
            for entry in 0..size {
                self.values[mirrored + entry % count * count + entry / count] = self.values[start + entry];
            }
        }
    }

    fn get(&self, [i, j]: [usize; 2], entry: usize, lane: usize) -> f64 {
        self.values[(i * self.nodes[1] + j) * self.components[0] * self.components[1] + entry][lane]
    }
}
