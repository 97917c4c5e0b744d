//! A derived field at the quadrature points of all cells of bodies, some cells at a time.

use std::ops::Range;

use super::further;
use crate::assemble::binding::Binding;
use crate::assemble::element_loops::point_values::PointBuffers;
use crate::assemble::groups::{Group, Places};
use crate::assemble::{Assembler, AssemblyError};
use crate::contract::Expression;
use crate::mesh::EVERYWHERE;

/// A derived field whose data have been checked.
pub(in crate::assemble) struct ValuesOnCells<'a, const D: usize> {
    expression: &'a Expression<D>,
    binding: Binding<'a, D>,
    /// One for each block of the bodies' cells.
    groups: Vec<Group<D>>,
}

impl<const D: usize> Assembler<D> {
    /// A derived field for the points of cells of a rule, of some degree where the choice of quadrature is the compiler's estimate.
    ///
    /// # Errors
    /// A function that needs a facet, cut bodies, or data that do not fit.
    pub(in crate::assemble) fn values_on_cells<'a>(
        &'a self,
        expression: &'a Expression<D>,
        degree: usize,
    ) -> Result<ValuesOnCells<'a, D>, AssemblyError> {
        let form = expression.name();
        self.expect_whole_cells(form, EVERYWHERE)?;
        let mut binding = Binding::new(expression, &self.mesh, &[])?;
        binding.instructions = self.instructions;
        let mut groups = vec![];
        for block in self.mesh.body_blocks() {
            let quadrature = |source| AssemblyError::Quadrature { form, source };
            let rule = self.quadrature.rule_on_cells(&self.mesh.shapes(), block.shape, degree);
            let rule = rule.map_err(quadrature)?;
            let places = Places { points: rule.points, facet: None };
            let cells = (block.shape, block.cells.map(|cell| cell as u32).collect());
            let place = super::place(EVERYWHERE);
            let group = Group::new(&binding, place, cells, &places, rule.weights, further(expression));
            groups.push(group.map_err(quadrature)?);
        }
        Ok(ValuesOnCells { expression, binding, groups })
    }
}

impl<const D: usize> ValuesOnCells<'_, D> {
    /// The values at the points of some cells of a block, cell by cell: `receive(value, quadrature weight times measure)` is called with each.
    ///
    /// # Errors
    /// A value that is not finite, or data that cannot be evaluated.
    pub fn at_cells(
        &self,
        block: usize,
        cells: Range<usize>,
        receive: &mut dyn FnMut(&[f64], f64),
    ) -> Result<(), AssemblyError> {
        let (form, mut buffers) = (self.binding.name, PointBuffers::default());
        for term in self.expression.densities() {
            let task = term.kernel.at_points(&self.binding, &self.groups[block]);
            term.kernel.each_point(&task, &mut buffers, cells.clone(), &mut |value, weight, position| {
                if !value.iter().all(|entry| entry.is_finite()) {
                    return Err(AssemblyError::ValueNotFinite { form, position: position.to_vec() });
                }
                receive(value, weight);
                Ok(())
            })?;
        }
        Ok(())
    }
}
