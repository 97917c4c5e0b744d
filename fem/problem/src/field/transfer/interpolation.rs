//! Interpolation: the values of a field at the nodes of another space.

use super::places::{in_parts, place};
use super::{Transfer, TransferError};
use crate::assemble::AssemblyError;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::space::Scope;

/// Part of the way from a node to the centre of its cell at which the node is located. It is large enough for the point to lie in one cell of a mesh
/// whose edges go through the node, and small enough not to leave that cell.
const INWARD: f64 = 1e-6;

impl<const D: usize> Transfer<'_, D> {
    /// The field of the space with this field's values at its nodes. What the target space contains is reproduced.
    ///
    /// Each cell of a discontinuous target takes the values from its own side of a jump. At a node that several cells of the
    /// target share, a field that jumps there has the value of one of its cells.
    ///
    /// # Errors
    /// [`TransferError`]: spaces on facets or of different components, a node too far from the field's mesh (names it).
    #[inline(never)]
    pub fn interpolated(&self) -> Result<Field<D>, TransferError> {
        let reach = self.checked_reach()?;
        if self.space.mesh().is_same(self.field.space().mesh()) {
            return self.embedded();
        }
        let (mesh, space) = (self.space.mesh(), self.space);
        // Nodes of cells that carry rigid surfaces are nowhere near the bodies: they keep zero.
        let mut sources: Vec<Option<u32>> = vec![None; space.node_count()];
        for cell in mesh.cells_of_bodies() {
            for &node in space.cell_nodes(cell) {
                sources[node as usize].get_or_insert(cell as u32);
            }
        }
        let jumps = *space.scope().sharing() == Scope::Cell;
        let locator = self.field.space().locator();
        let components = space.components();
        let parts = in_parts(self.threads, sources.len(), |range| {
            let mut values = vec![0.0; range.len() * components];
            for (node, value) in range.zip(values.chunks_mut(components)) {
                let Some(cell) = sources[node] else { continue };
                let point = &space.positions()[node];
                let outside = || TransferError::Outside { point: point.to_vec(), reach };
                let (found, reference) = if jumps {
                    let centre = mesh.cell_centre(cell as usize);
                    let inside = std::array::from_fn(|k| point[k] + INWARD * (centre[k] - point[k]));
                    let (found, near) = place(locator, &inside, reach).ok_or_else(outside)?;
                    (found, locator.reference_in(found as usize, point).unwrap_or(near))
                } else {
                    place(locator, point, reach).ok_or_else(outside)?
                };
                self.field.add_value_in(found as usize, &reference, value);
                if value.iter().any(|value| !value.is_finite()) {
                    return Err(TransferError::NotFinite { point: point.to_vec() });
                }
            }
            Ok(values)
        });
        let values = parts.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
        Ok(Field::of_known(space, values))
    }

    /// The interpolation on the field's own mesh, where nothing has to be found.
    fn embedded(&self) -> Result<Field<D>, TransferError> {
        let matrix = self.space.embedding(self.field.space())?;
        let components = self.space.components();
        let mut values = vec![0.0; self.space.unknowns()];
        for component in 0..components {
            let of_field: Vec<f64> =
                self.field.values().iter().skip(component).step_by(components).copied().collect();
            let found = matrix.multiply(&of_field).map_err(|source| AssemblyError::LinearAlgebra {
                form: "interpolation between spaces",
                source,
            })?;
            for (value, found) in values.iter_mut().skip(component).step_by(components).zip(found) {
                *value = found;
            }
        }
        Ok(Field::from_values(self.space, values)?)
    }
}

instantiate!(interpolation: Transfer::<D>::interpolated);
