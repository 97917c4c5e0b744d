//! Pieces of a mesh that is divided among processes: cells that one process has of a larger mesh.

use std::collections::BTreeMap;

use super::{BOUNDARY, EVERYWHERE, Facet, Mesh, MeshError};

/// The extent of a mesh's cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Extent {
    /// They are all cells of the body.
    #[default]
    Whole,
    /// Other processes have further ones.
    Piece,
}

/// Advice for what needs the whole mesh.
#[doc(hidden)]
pub const TAKE_THE_WHOLE: &str = "take the whole mesh on each process";

/// Names of the regions of the mesh that is divided.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct RegionNames<'a> {
    pub cells: &'a [String],
    pub facets: &'a [String],
}

impl<const D: usize> Mesh<D> {
    /// This mesh as a piece of a larger one. `cut` are its facets to cells of other processes, ascending: they are on no boundary. It has the
    /// regions of the larger mesh, empty ones where nothing of them is here, and no interior facets, because no process has both sides of those
    /// between pieces.
    #[doc(hidden)]
    #[must_use]
    pub fn into_piece(mut self, cut: &[Facet], names: RegionNames<'_>) -> Self {
        let data = self.data_mut();
        let mut facets: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
        for name in names.facets.iter().map(String::as_str).chain([BOUNDARY]) {
            let mut own = data.facet_regions.remove(name).unwrap_or_default();
            own.retain(|facet| cut.binary_search(facet).is_err());
            facets.insert(name.to_owned(), own);
        }
        let mut cells: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for name in names.cells.iter().map(String::as_str).chain([EVERYWHERE]) {
            let own = data.cell_regions.remove(name).unwrap_or_default();
            cells.entry(name.to_owned()).or_insert(own);
        }
        (data.facet_regions, data.cell_regions) = (facets, cells);
        data.interior_regions.clear();
        data.extent = Extent::Piece;
        self
    }

    /// Whether it is one process's piece of a larger mesh. What needs the whole mesh refuses it.
    #[inline]
    pub fn is_piece(&self) -> bool {
        self.extent == Extent::Piece
    }

    /// Check that the mesh is no piece of a larger one, for functions that need all of it, with what to do instead.
    ///
    /// # Errors
    /// [`MeshError::Piece`].
    #[doc(hidden)]
    pub fn without_pieces(&self, what: &'static str, instead: &'static str) -> Result<(), MeshError> {
        if self.is_piece() { Err(MeshError::Piece { what, instead }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    #[test]
    fn a_piece_has_the_regions_of_the_whole_and_no_boundary_at_its_cut() -> Result<(), MeshError> {
        let half = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
        let (cut, facets) = (half.facet_region("right")?.to_vec(), ["left", "right", "top", "bottom"]);
        let names = RegionNames { cells: &["steel".to_owned()], facets: &facets.map(str::to_owned) };
        let mut piece = half.into_piece(&cut, names);
        let count = |name: &str| piece.facet_region(name).map(<[Facet]>::len);
        assert_eq!([count("left")?, count("right")?, count("boundary")?], [2, 0, 6]);
        assert!(piece.cell_region("steel")?.is_empty() && piece.cell_region(EVERYWHERE)?.len() == 4);
        assert!(piece.interior_facets().is_empty() && piece.interior_facet_region("interior").is_err());
        // On this process a region may have nothing.
        piece.name_facets("support", "right", |_| true)?;
        assert!(piece.facet_region("support")?.is_empty() && piece.is_piece());
        let said = piece.refined().map(|_| ()).unwrap_err().to_string();
        let text =
            "refinement is not available on a mesh that is divided among processes; take the whole mesh";
        assert!(said.starts_with(text), "{said}");
        Ok(())
    }
}
