//! The cells that an assembler owns, where several split the integrals of one mesh.

use std::borrow::Cow;
use std::sync::Arc;

use super::entities::Entities;
use crate::assemble::Assembler;
use crate::instantiate::instantiate;
use crate::mesh::{Mesh, MeshError};

/// Which cells of a mesh are owned.
#[derive(Clone, Debug)]
pub(in crate::assemble) struct OwnedCells {
    owned: Vec<bool>,
}

impl OwnedCells {
    fn new<const D: usize>(mesh: &Mesh<D>, cells: &[u32]) -> Result<Self, MeshError> {
        let mut owned = vec![false; mesh.cell_count()];
        for &cell in cells {
            let Some(mark) = owned.get_mut(cell as usize) else {
                let (name, count) = ("the owned cells".to_owned(), mesh.cell_count());
                return Err(MeshError::NoCell { name, cell, count });
            };
            *mark = true;
        }
        Ok(OwnedCells { owned })
    }

    pub fn owns(&self, cell: u32) -> bool {
        self.owned.get(cell as usize).is_some_and(|owned| *owned)
    }

    /// The owned ones among some cells or facets; all if none are given. An exterior facet belongs to the owner of its cell, an
    /// interior one to that of its first side.
    pub fn among<'a>(owned: Option<&Self>, entities: Entities<'a>) -> Entities<'a> {
        match owned {
            Some(owned) => owned.keep(entities),
            None => entities,
        }
    }

    fn keep<'a>(&self, entities: Entities<'a>) -> Entities<'a> {
        match entities {
            Entities::Cells(cells) => {
                Entities::Cells(Cow::Owned(cells.iter().copied().filter(|cell| self.owns(*cell)).collect()))
            }
            Entities::Facets(facets) => {
                let owned = facets.iter().copied().filter(|facet| self.owns(facet.cell));
                Entities::Facets(Cow::Owned(owned.collect()))
            }
            Entities::InteriorFacets(facets) => {
                let owned = facets.iter().copied().filter(|[first, _]| self.owns(first.cell));
                Entities::InteriorFacets(Cow::Owned(owned.collect()))
            }
        }
    }
}

impl<const D: usize> Assembler<D> {
    /// Whether it assembles the integrals over some cells alone.
    #[doc(hidden)]
    pub fn has_owned_cells(&self) -> bool {
        self.owned.is_some()
    }

    /// Whether the integrals over a cell are taken here.
    pub(crate) fn owns_cell(&self, cell: u32) -> bool {
        self.owned.as_ref().is_none_or(|owned| owned.owns(cell))
    }

    /// This assembler on some of the mesh's cells: integrals over cells and facets are taken over those that are owned, an exterior
    /// facet with its cell, an interior one with the cell of its first side. Vectors, matrices, actions, functionals and
    /// active sets become partial: over assemblers whose cells are a partition of the mesh's they add up to the whole. A
    /// problem made with it has the positions of its part alone. Values at points and projections stay those of the whole.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?);
    /// let area = form!(|| -> Functional { integral(cells("all"), 1) });
    /// let (first, last) = mesh.cell_order().cells().split_at(10);
    /// let mut sum = 0.0;
    /// for cells in [first, last] {
    ///     let partial = Assembler::new(&mesh).on_owned_cells(cells)?.functional(&area)?;
    ///     assert!((partial - cells.len() as f64 / 32.0).abs() < 1e-15);
    ///     sum += partial;
    /// }
    /// assert!((sum - 1.0).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::NoCell`] for a cell that the mesh does not have.
    #[inline(never)]
    pub fn on_owned_cells(self, cells: &[u32]) -> Result<Self, MeshError> {
        let owned = Some(Arc::new(OwnedCells::new(&self.mesh, cells)?));
        Ok(Assembler { owned, ..self })
    }

    /// The same on the cells of another assembler, if those are not all, and in its cut body.
    pub(crate) fn on_cells_of(self, other: &Self) -> Self {
        let owned = other.owned.clone().or(self.owned);
        let cut = self.cut.or_else(|| other.cut.clone());
        Assembler { owned, cut, ..self }
    }

    /// The same on all cells.
    #[inline(never)]
    pub(crate) fn on_all_cells(&self) -> Self {
        Assembler { owned: None, ..self.clone() }
    }
}

instantiate!(owned_cells: Assembler::<D>::on_owned_cells, Assembler::<D>::on_all_cells);
