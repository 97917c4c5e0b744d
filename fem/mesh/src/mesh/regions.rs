//! Named sets of cells and exterior facets.

use std::ops::Range;

use super::{Facet, Mesh, MeshError};
use crate::instantiate;

/// The cell region that consists of all cells.
pub const EVERYWHERE: &str = "all";
/// The facet region that consists of all exterior facets.
pub const BOUNDARY: &str = "boundary";
/// The region that consists of all interior facets.
pub const INTERIOR: &str = "interior";

impl<const D: usize> Mesh<D> {
    /// The cells of a region, in ascending order.
    ///
    /// # Errors
    /// [`MeshError::UnknownCellRegion`], which lists the names that exist.
    pub fn cell_region(&self, name: &str) -> Result<&[u32], MeshError> {
        self.cell_regions.get(name).map(Vec::as_slice).ok_or_else(|| MeshError::UnknownCellRegion {
            name: name.to_owned(),
            existing: self.cell_regions.keys().cloned().collect(),
        })
    }

    /// The facets of a region, in ascending order.
    ///
    /// # Errors
    /// [`MeshError::UnknownFacetRegion`], which lists the names that exist.
    pub fn facet_region(&self, name: &str) -> Result<&[Facet], MeshError> {
        self.facet_regions.get(name).map(Vec::as_slice).ok_or_else(|| MeshError::UnknownFacetRegion {
            name: name.to_owned(),
            existing: self.facet_regions.keys().cloned().collect(),
            interior: self.interior_facet_region(name).is_ok(),
        })
    }

    /// Names of the cell regions, sorted.
    pub fn cell_region_names(&self) -> impl Iterator<Item = &str> {
        self.cell_regions.keys().map(String::as_str)
    }

    /// Names of the facet regions, sorted.
    pub fn facet_region_names(&self) -> impl Iterator<Item = &str> {
        self.facet_regions.keys().map(String::as_str)
    }

    /// A name for the cells whose centre satisfies a condition: the region of a material, or of a load.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::rectangle;
    ///
    /// // A plate of 4 × 2 cells, 4 long and 2 high, whose lower half is of rubber.
    /// let mut plate = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
    /// plate.name_cells("rubber", |centre| centre[1] < 1.0)?;
    /// assert_eq!(plate.cell_region("rubber")?, [0, 1, 2, 3]);
    /// // A form's region is bound to it by name: `Body::on("rubber")`.
    /// plate.name_cells("steel", |centre| centre[1] > 1.0)?;
    /// plate.name_interface("joint", "rubber", "steel")?;
    /// assert_eq!(plate.interior_facet_region("joint")?.len(), 4);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::RegionExists`] when a cell or facet region has this name,
    /// [`MeshError::EmptyRegion`] when no cell satisfies the condition.
    pub fn name_cells(&mut self, name: &str, condition: impl Fn(&[f64; D]) -> bool) -> Result<(), MeshError> {
        self.name_cells_where(name, &condition)
    }

    #[inline(never)]
    fn name_cells_where(
        &mut self,
        name: &str,
        condition: &dyn Fn(&[f64; D]) -> bool,
    ) -> Result<(), MeshError> {
        let cells = self.body_cells().filter(|&cell| condition(&self.cell_centre(cell)));
        let cells: Vec<u32> = cells.map(|cell| cell as u32).collect();
        self.check_name(name, "cell", cells.is_empty())?;
        self.data_mut().cell_regions.insert(name.to_owned(), cells);
        Ok(())
    }

    /// A name for the cells of a list, for example one read from a file; their order does not matter, and one that
    /// is listed twice counts once.
    ///
    /// # Errors
    /// [`MeshError::NoCell`] for a cell that does not exist, [`MeshError::RegionExists`] when a cell or facet
    /// region has this name, [`MeshError::EmptyRegion`] for an empty list.
    #[inline(never)]
    pub fn name_listed_cells(&mut self, name: &str, cells: &[u32]) -> Result<(), MeshError> {
        let count = self.body_cells().len();
        if let Some(&cell) = cells.iter().find(|&&cell| cell as usize >= count) {
            return Err(MeshError::NoCell { name: name.to_owned(), cell, count });
        }
        let mut cells = cells.to_vec();
        cells.sort_unstable();
        cells.dedup();
        self.check_name(name, "cell", cells.is_empty())?;
        self.data_mut().cell_regions.insert(name.to_owned(), cells);
        Ok(())
    }

    /// A name for the cells that own the facets of a region.
    ///
    /// # Errors
    /// [`MeshError::UnknownFacetRegion`], or [`MeshError::RegionExists`] when a cell or facet region has
    /// this name.
    #[inline(never)]
    pub fn name_cells_of_facets(&mut self, name: &str, facets: &str) -> Result<(), MeshError> {
        let mut cells: Vec<u32> = self.facet_region(facets)?.iter().map(|facet| facet.cell).collect();
        cells.sort_unstable();
        cells.dedup();
        self.check_name(name, "cell", cells.is_empty())?;
        self.data_mut().cell_regions.insert(name.to_owned(), cells);
        Ok(())
    }

    /// A name for the facets of the region `within` whose centre satisfies a condition.
    ///
    /// # Errors
    /// [`MeshError::UnknownFacetRegion`] for `within`, [`MeshError::RegionExists`] when a cell or facet
    /// region has this name, [`MeshError::EmptyRegion`] when no facet satisfies the condition.
    pub fn name_facets(
        &mut self,
        name: &str,
        within: &str,
        condition: impl Fn(&[f64; D]) -> bool,
    ) -> Result<(), MeshError> {
        self.name_facets_where(name, within, &condition)
    }

    #[inline(never)]
    fn name_facets_where(
        &mut self,
        name: &str,
        within: &str,
        condition: &dyn Fn(&[f64; D]) -> bool,
    ) -> Result<(), MeshError> {
        let facets = self.facet_region(within)?.iter().copied();
        let facets = facets.filter(|&facet| condition(&self.facet_centre(facet))).collect();
        self.insert_facets(name, facets)?;
        self.name_on_surface(name, within, condition);
        Ok(())
    }

    /// A name for the facets of a list, for example one read from a file; their order does not matter, and one
    /// that is listed twice counts once.
    ///
    /// # Errors
    /// [`MeshError::NotExterior`] for a facet that is not on the boundary (or does not exist),
    /// [`MeshError::RegionExists`] when a cell or facet region has this name, [`MeshError::EmptyRegion`] for
    /// an empty list.
    #[inline(never)]
    pub fn name_listed_facets(&mut self, name: &str, facets: &[Facet]) -> Result<(), MeshError> {
        let boundary = self.boundary_facets();
        if let Some(facet) = facets.iter().find(|facet| boundary.binary_search(facet).is_err()) {
            return Err(MeshError::NotExterior {
                name: name.to_owned(),
                cell: facet.cell,
                local: facet.local,
            });
        }
        let mut facets = facets.to_vec();
        facets.sort_unstable();
        facets.dedup();
        self.insert_facets(name, facets)
    }

    /// Names the regions of a mesh whose cells and facets these of this one are parts of, or unions: by the cells that a cell
    /// has become, and the facets that a facet has.
    pub(super) fn inherit_regions(
        &mut self,
        other: &Mesh<D>,
        cells_of: &dyn Fn(u32) -> Range<u32>,
        facets_of: &dyn Fn(Facet) -> Vec<Facet>,
    ) -> Result<(), MeshError> {
        for (name, cells) in other.cell_regions.iter().filter(|(name, _)| *name != EVERYWHERE) {
            let cells: Vec<u32> = cells.iter().flat_map(|cell| cells_of(*cell)).collect();
            self.name_listed_cells(name, &cells)?;
        }
        for (name, facets) in other.facet_regions.iter().filter(|(name, _)| *name != BOUNDARY) {
            let facets: Vec<Facet> = facets.iter().flat_map(|facet| facets_of(*facet)).collect();
            self.name_listed_facets(name, &facets)?;
        }
        let with_parts = !(self.parts.is_empty() && other.parts.is_empty());
        for (name, facets) in other.interior_regions.iter().filter(|(name, _)| *name != INTERIOR) {
            if with_parts {
                let pairs = facets.iter().flat_map(|sides| self.parts_of_both(sides, facets_of));
                let pairs: std::collections::BTreeSet<[Facet; 2]> = pairs.collect();
                self.insert_interior_facets(name, pairs.into_iter().collect())?;
                continue;
            }
            let facets: Vec<Facet> = facets.iter().flat_map(|sides| facets_of(sides[0])).collect();
            self.name_listed_interior_facets(name, &facets)?;
        }
        Ok(())
    }

    /// The interior facets whose sides are parts of, or unions of, those of another mesh's.
    fn parts_of_both(&self, sides: &[Facet; 2], facets_of: &dyn Fn(Facet) -> Vec<Facet>) -> Vec<[Facet; 2]> {
        let interior = self.interior_facets();
        let [first, second] = sides.map(facets_of);
        let pairs = first.iter().flat_map(|a| second.iter().map(move |b| [*a, *b]));
        pairs.filter(|[a, b]| interior.binary_search(&[*a.min(b), *a.max(b)]).is_ok()).collect()
    }

    #[inline(never)]
    pub(super) fn insert_facets(&mut self, name: &str, facets: Vec<Facet>) -> Result<(), MeshError> {
        self.check_name(name, "facet", facets.is_empty())?;
        self.data_mut().facet_regions.insert(name.to_owned(), facets);
        Ok(())
    }

    // One name, one region: boundary conditions accept regions of either kind.
    pub(super) fn check_name(&self, name: &str, entity: &'static str, empty: bool) -> Result<(), MeshError> {
        if self.cell_regions.contains_key(name)
            || self.facet_regions.contains_key(name)
            || self.interior_facet_region(name).is_ok()
        {
            return Err(MeshError::RegionExists { name: name.to_owned() });
        }
        // Other processes may have something of it.
        if empty && !self.is_piece() {
            return Err(MeshError::EmptyRegion { name: name.to_owned(), entity });
        }
        Ok(())
    }
}

instantiate!(
    regions:
    Mesh::<D>::name_cells_where,
    Mesh::<D>::name_facets_where,
    Mesh::<D>::name_listed_cells,
    Mesh::<D>::name_cells_of_facets,
    Mesh::<D>::name_listed_facets
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    #[test]
    fn regions_by_condition() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
        mesh.name_cells("first", |centre| centre[0] < 2.0)?;
        assert_eq!(mesh.cell_region("first")?, [0, 1, 4, 5]);
        mesh.name_facets("support", "bottom", |centre| centre[0] > 1.0)?;
        let support = mesh.facet_region("support")?;
        assert_eq!(support.iter().map(|facet| facet.cell).collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(mesh.cell_region(EVERYWHERE)?.len(), 8);
        assert_eq!(mesh.facet_region(BOUNDARY)?.len(), 12);
        Ok(())
    }

    #[test]
    fn cells_by_list() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
        mesh.name_listed_cells("steel", &[7, 2, 7])?;
        assert_eq!(mesh.cell_region("steel")?, [2, 7]);
        let error = MeshError::NoCell { name: "air".into(), cell: 8, count: 8 };
        assert_eq!(mesh.name_listed_cells("air", &[1, 8]), Err(error));
        assert_eq!(
            mesh.name_listed_cells("steel", &[1]),
            Err(MeshError::RegionExists { name: "steel".into() })
        );
        assert_eq!(
            mesh.name_listed_cells("air", &[]),
            Err(MeshError::EmptyRegion { name: "air".into(), entity: "cell" })
        );
        Ok(())
    }

    #[test]
    fn facets_by_list() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
        let (first, second) = (Facet { cell: 0, local: 3 }, Facet { cell: 7, local: 2 });
        mesh.name_listed_facets("corners", &[second, first, second])?;
        assert_eq!(mesh.facet_region("corners")?, [first, second]);
        // Between cells 0 and 1; no such local number; no such cell.
        for facet in [(0, 1), (0, 4), (8, 0)].map(|(cell, local)| Facet { cell, local }) {
            let error =
                MeshError::NotExterior { name: "inside".into(), cell: facet.cell, local: facet.local };
            assert_eq!(mesh.name_listed_facets("inside", &[first, facet]), Err(error));
        }
        let error = MeshError::EmptyRegion { name: "nothing".into(), entity: "facet" };
        assert_eq!(mesh.name_listed_facets("nothing", &[]), Err(error));
        Ok(())
    }

    #[test]
    fn errors_name_the_regions() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
        let message = |result: Result<(), MeshError>| result.err().map(|error| error.to_string());
        assert_eq!(
            message(mesh.facet_region("lid").map(|_| ())).as_deref(),
            Some(
                "there is no facet region \"lid\"; \
                 the mesh has \"bottom\", \"boundary\", \"left\", \"right\", \"top\""
            )
        );
        assert_eq!(
            message(mesh.cell_region("steel").map(|_| ())).as_deref(),
            Some("there is no cell region \"steel\"; the mesh has \"all\"")
        );
        assert_eq!(
            message(mesh.name_facets("support", "outer", |_| true)).as_deref(),
            Some(
                "there is no facet region \"outer\"; \
                 the mesh has \"bottom\", \"boundary\", \"left\", \"right\", \"top\""
            )
        );
        assert_eq!(
            message(mesh.name_facets("support", "top", |centre| centre[1] < 0.0)).as_deref(),
            Some("the region \"support\" would be empty: no facet satisfies its condition")
        );
        assert_eq!(
            message(mesh.name_cells("steel", |_| false)).as_deref(),
            Some("the region \"steel\" would be empty: no cell satisfies its condition")
        );
        assert_eq!(
            message(mesh.name_cells("left", |_| true)).as_deref(),
            Some("the mesh already has a region \"left\"")
        );
        Ok(())
    }
}
