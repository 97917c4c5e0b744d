//! Assemblers of bodies that are cut from a mesh.

use std::sync::Arc;

use super::Assembler;
use crate::cut::{Cut, CutError};
use crate::field::Field;

impl<const D: usize> Assembler<D> {
    /// This assembler on the body on which a level set function is negative ([`Cut`]).
    ///
    /// - Integrals over cells are over their parts inside, those over exterior and interior facets over the parts of these.
    /// - `#[interface]` regions are where the function vanishes in the cells of a region; `n` is the outward normal, `h` and `cell_volume`
    ///   are those of the whole cell, and `curvature` is zero; on curved interfaces it is refused.
    /// - Names of the cut's: the cells "inside" (whole) and "cut", and the interior facets "ghost" between active cells, one of them cut, which are
    ///   taken whole. Contact pairs must be whole.
    /// - Unknowns outside are held by [`Cut::hold_outside`].
    ///
    /// Histories, split facets, explicit points and values at quadrature points are refused.
    ///
    /// # Errors
    /// Those of [`Cut::by`], and [`CutError::OtherMesh`] for a function on another mesh.
    pub fn cut_by(self, phi: &Field<D>) -> Result<Self, CutError> {
        let cut = Cut::by(phi)?;
        self.with_cut(&cut)
    }

    /// This assembler on a body that was cut before, as for several assemblers, or without its islands.
    ///
    /// # Errors
    /// [`CutError::OtherMesh`] for a cut of another mesh.
    pub fn with_cut(self, cut: &Arc<Cut<D>>) -> Result<Self, CutError> {
        match cut.mesh().is_same(&self.mesh) {
            true => Ok(Assembler { cut: Some(Arc::clone(cut)), ..self }),
            false => Err(CutError::OtherMesh),
        }
    }

    /// The body that it is on, unless that is the whole mesh.
    pub fn cut(&self) -> Option<&Arc<Cut<D>>> {
        self.cut.as_ref()
    }
}
