//! Projections: the field of a space that is nearest in L², and the nearest of those with the same integral.

use super::places::{Lately, in_parts};
use super::{Transfer, TransferError};
use crate::assemble::Assembler;
use crate::assemble::degree_on_all_cells;
use crate::assemble::projection::ValuesAtPoints;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::EVERYWHERE;
use crate::mesh::small_matrices::determinant;
use crate::norms::basis_integrals;

/// Its name in messages.
const NAME: &str = "projection between meshes";

impl<const D: usize> Transfer<'_, D> {
    /// The field of the space that is nearest in L², integrated by the quadrature of the target's cells, of the degree of both
    /// fields together: exact where each cell of the target lies in one cell of the field's mesh, as after refinement. Where nodes
    /// hang in a mesh of trees, it is the nearest of the continuous fields.
    ///
    /// # Errors
    /// [`TransferError`]: spaces on facets or of different components, a quadrature point too far from the field's mesh
    /// (names it), a mass matrix that cannot be factored.
    pub fn projected(&self) -> Result<Field<D>, TransferError>
    where
        Dim: Dimension<D>,
    {
        let assembler = Assembler::new(self.space.mesh()).with_threads(self.threads);
        let product = self.field.space().degree() + self.space.degree();
        let degree = degree_on_all_cells(self.space.mesh(), product);
        let degree = degree.max(assembler.degree_of_mass(self.space));
        let (values, weights) = self.at_quadrature_points(degree)?;
        let known = ValuesAtPoints { name: NAME, degree, values: &values, weights: &weights };
        Ok(assembler.project_values(&known, self.space)?)
    }

    /// The field of the space that is nearest in L² among those with this field's integrals, one for each component.
    ///
    /// A multiplier λ for ∫ w = ∫ u adds λ∫v to the equations of the projection; as the space contains the constants, the
    /// result is the projection plus one constant for each component, (∫ u − ∫ w)/|Ω|. It corrects what quadrature on cells that
    /// cut each other misses. Integrals are those of the two meshes: where their boundaries differ, their volumes do.
    ///
    /// # Errors
    /// As [`Transfer::projected`].
    pub fn conserved(&self) -> Result<Field<D>, TransferError>
    where
        Dim: Dimension<D>,
    {
        let projected = self.projected()?;
        let of_field = basis_integrals(self.field.space(), EVERYWHERE)?;
        let of_space = basis_integrals(self.space, EVERYWHERE)?;
        Ok(with_integrals_of(self.field, &of_field, projected, &of_space))
    }

    /// Values of the field and weights at the quadrature points of the target's cells, cell by cell.
    #[inline(never)]
    fn at_quadrature_points(&self, degree: usize) -> Result<(Vec<f64>, Vec<f64>), TransferError> {
        let reach = self.checked_reach()?;
        let (mesh, components) = (self.space.mesh(), self.space.components());
        let locator = self.field.space().locator();
        let quadrature = Assembler::new(mesh).quadrature().clone();
        let (mut values, mut weights) = (vec![], vec![]);
        for block in mesh.body_blocks() {
            let rule = quadrature
                .rule_on_cells(&mesh.shapes(), block.shape, degree)
                .map_err(|source| crate::assemble::AssemblyError::Quadrature { form: NAME, source })?;
            let geometry = mesh.element_of(block.shape).tabulate(&rule.points);
            let parts = in_parts(self.threads, block.cells.len(), |range| {
                let count = range.len() * rule.len();
                let (mut values, mut weights) = (vec![0.0; count * components], Vec::with_capacity(count));
                let mut lately = Lately::new(locator);
                let mut of_points = values.chunks_mut(components);
                for cell in block.cells.start + range.start..block.cells.start + range.end {
                    for (q, (weight, value)) in rule.weights.iter().zip(&mut of_points).enumerate() {
                        let at = q * geometry.nodes..(q + 1) * geometry.nodes;
                        let (position, jacobian) =
                            mesh.map_by(cell, &geometry.value[at.clone()], &geometry.gradient[at]);
                        let (found, reference) = lately
                            .place(&position, reach)
                            .ok_or_else(|| TransferError::Outside { point: position.to_vec(), reach })?;
                        self.field.add_value_in(found as usize, &reference, value);
                        if value.iter().any(|value| !value.is_finite()) {
                            return Err(TransferError::NotFinite { point: position.to_vec() });
                        }
                        weights.push(weight * determinant(&jacobian));
                    }
                }
                Ok((values, weights))
            });
            for part in parts {
                let (of_part, their_weights) = part?;
                values.extend(of_part);
                weights.extend(their_weights);
            }
        }
        Ok((values, weights))
    }
}

/// A field shifted, component by component, to the integrals of another; the integrals of the basis functions are given.
#[inline(never)]
fn with_integrals_of<const D: usize>(
    wanted: &Field<D>,
    of_wanted: &[f64],
    field: Field<D>,
    of_field: &[f64],
) -> Field<D> {
    let components = field.space().components();
    let volume: f64 = of_field.iter().sum();
    let integral = |field: &Field<D>, of_basis: &[f64], component: usize| -> f64 {
        let values = field.values().iter().skip(component).step_by(components);
        values.zip(of_basis).map(|(value, integral)| value * integral).sum()
    };
    let missing = |component| integral(wanted, of_wanted, component) - integral(&field, of_field, component);
    let shifts: Vec<f64> = (0..components).map(|component| missing(component) / volume).collect();
    let shifted = field.values().iter().zip(shifts.iter().cycle()).map(|(value, shift)| value + shift);
    Field::of_known(field.space(), shifted.collect())
}

instantiate!(transfer_projection: Transfer::<D>::at_quadrature_points, with_integrals_of::<D>);
