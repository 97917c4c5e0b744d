//! Unknowns that belong to no active cell: integrals do not reach them, and a matrix would be singular.

use super::{Cut, CutError};
use crate::constraints::Constraints;
use crate::instantiate::instantiate;

impl<const D: usize> Cut<D> {
    /// Zero for all unknowns of a space that no active cell has. Those that are prescribed or given by relations already stay as they are.
    ///
    /// # Errors
    /// [`CutError`]: constraints of a space on another mesh or on facets.
    #[inline(never)]
    pub fn hold_outside(&self, constraints: &mut Constraints<D>) -> Result<(), CutError> {
        let space = constraints.space().clone();
        if !space.mesh().is_same(self.mesh()) {
            return Err(CutError::OtherMesh);
        }
        if space.facet_region().is_some() {
            return Err(CutError::OnFacets);
        }
        let mut active = vec![false; space.node_count()];
        // Cells that carry rigid surfaces are no part of the background.
        let carriers = self.mesh().body_cells().end..self.mesh().cell_count();
        let own = (0..self.mesh().cell_count() as u32)
            .filter(|cell| self.is_active(*cell) || carriers.contains(&(*cell as usize)));
        for cell in own {
            space.cell_nodes(cell as usize).iter().for_each(|node| active[*node as usize] = true);
        }
        let components = space.components();
        for node in (0..active.len()).filter(|node| !active[*node]) {
            for component in 0..components {
                let unknown = node * components + component;
                if constraints.is_prescribed(unknown) || constraints.relations().contains_key(&unknown) {
                    continue;
                }
                let held = constraints.fix_node(node, component, 0.0);
                held.map_err(|error| CutError::Constraints { text: error.to_string() })?;
            }
        }
        Ok(())
    }
}

instantiate!(cut_holding: Cut::<D>::hold_outside);
