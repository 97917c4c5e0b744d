//! Continuity at hanging nodes: the values on small facets are those of the large facet that they are parts of.

use std::sync::Arc;

use super::{Constraints, ConstraintsError};
use crate::instantiate::instantiate;
use crate::mesh::{Facet, MeshError};
use crate::space::{Scope, Space};

/// Basis functions below this are zero except for rounding.
const NOTHING: f64 = 1e-13;

impl<const D: usize> Constraints<D> {
    /// Continuity of fields where coarse cells meet fine ones, in meshes of
    /// [`Mesh::from_nonconforming_blocks`](crate::mesh::Mesh::from_nonconforming_blocks): the unknowns on each small facet are given
    /// by those on the large facet that it is a part of ([`Mesh::hanging_facets`](crate::mesh::Mesh::hanging_facets)), through the basis
    /// functions there. In the middle of an edge of degree 1 these are ½ and ½; at a quarter of one of degree 2, 3/8, 3/4 and −1/8. Polynomials of the space's
    /// degree satisfy all of it. Small facets may be any part of the large one, and facets may hang in several levels.
    ///
    /// Conditions that prescribe values come afterwards. Where they prescribe all that an unknown on a small facet depends on, it
    /// interpolates these values, whatever is prescribed for itself.
    ///
    /// Facets of bodies that share no vertex are not joined: such bodies touch and may part, as those of [`Mesh::of_bodies`](crate::mesh::Mesh::of_bodies).
    ///
    /// Such facets remain exterior ones: regions that shall not be integrated over on them, or prescribed, are named
    /// without them.
    ///
    /// # Errors
    /// [`ConstraintsError::NotContinuous`] for other than continuous spaces;
    /// [`MeshError::NotNested`] for facets of one body that lie on each other in part; [`MeshError::Piece`] on a part of a mesh after conditions that prescribe
    /// values, or of a mesh of other than trees;
    /// [`ConstraintsError::SeparateBodies`] where all that could be joined belongs to bodies that share no vertex;
    /// [`ConstraintsError::AlreadyGiven`] and [`ConstraintsError::Contradiction`] where earlier conditions say otherwise.
    #[inline(never)]
    pub fn join_hanging_nodes(&mut self) -> Result<(), ConstraintsError> {
        if !self.space.is_continuous_lagrange() {
            let (elements, scope) = (self.space.elements().clone(), self.space.scope().clone());
            return Err(ConstraintsError::NotContinuous { elements, scope });
        }
        let mesh = self.space.mesh();
        if !self.conditions.prescribed.is_empty() {
            // Other processes prescribe other values: which ones come first has to be the same for all.
            mesh.without_pieces(
                "continuity after prescribed values",
                "call `join_hanging_nodes()` before them",
            )?;
        }
        let facets = mesh.hanging_facets_of_bodies()?;
        if facets.is_empty()
            && let Some(&facets) = mesh.hanging_facets()?.first()
        {
            let position = mesh.cell_centre(facets[0].cell as usize).to_vec();
            return Err(ConstraintsError::SeparateBodies { facets, position });
        }
        let mut changed = self.clone();
        for [small, large] in facets {
            let place = format!("continuity at facet {} of cell {}", large.local, large.cell);
            changed.join(&place, small, large)?;
        }
        *self = changed;
        Ok(())
    }

    /// Relations that make a space continuous on a mesh of trees in which nodes hang; none for other spaces and meshes: bodies that
    /// touch are not joined.
    ///
    /// # Errors
    /// As [`Constraints::join_hanging_nodes`].
    #[doc(hidden)]
    pub fn joining(space: &Arc<Space<D>>) -> Result<Option<Self>, ConstraintsError> {
        if *space.scope() != Scope::Nodes || space.mesh().facet_parts().next().is_none() {
            return Ok(None);
        }
        let mut constraints = Constraints::new(space);
        constraints.join_hanging_nodes()?;
        Ok(Some(constraints))
    }

    /// Gives the unknowns on a facet by those on a larger one.
    fn join(&mut self, place: &str, small: Facet, large: Facet) -> Result<(), ConstraintsError> {
        let space = Arc::clone(&self.space);
        let (mesh, components) = (space.mesh(), space.components());
        let nodes_of = |facet: Facet| {
            let cell = facet.cell as usize;
            let local = space.cell_element(cell).facet_nodes(usize::from(facet.local));
            (space.cell_nodes(cell), local)
        };
        let (coarse, on_coarse) = nodes_of(large);
        let (fine, on_fine) = nodes_of(small);
        for node in on_fine.iter().map(|local| fine[*local] as usize) {
            if on_coarse.iter().any(|local| coarse[*local] as usize == node) {
                continue;
            }
            let position = &space.positions()[node];
            let Some(reference) = mesh.reference_on_facet(large, position) else {
                // Its vertices lie on the large facet, and it is curved otherwise.
                return Err(
                    MeshError::NotNested { facets: [small, large], position: position.to_vec() }.into()
                );
            };
            let basis = space.cell_element(large.cell as usize).tabulate(&[reference]).value;
            let terms = on_coarse.iter().filter(|local| basis[**local].abs() > NOTHING);
            let terms: Vec<(usize, f64)> =
                terms.map(|local| (coarse[*local] as usize, basis[*local])).collect();
            for component in 0..components {
                let dependent = node * components + component;
                let of_component: Vec<(usize, f64)> =
                    terms.iter().map(|(master, a)| (master * components + component, *a)).collect();
                Arc::make_mut(&mut self.conditions).hanging.insert(dependent);
                match self.add_relation(place, dependent, &of_component, 0.0) {
                    // An edge of a facet that hangs on two larger ones: the relation of one may determine another unknown of the other.
                    Err(ConstraintsError::AlreadyGiven { .. }) => {
                        let others = of_component.iter().map(|(master, a)| (*master, -a));
                        let equation: Vec<(usize, f64)> =
                            [(dependent, 1.0)].into_iter().chain(others).collect();
                        self.add_equation(place, &equation, 0.0)?;
                    }
                    outcome => outcome?,
                }
            }
        }
        Ok(())
    }
}

instantiate!(hanging_nodes: Constraints::<D>::join_hanging_nodes);
