//! Named sets of interior facets, and how the two sides of one face each other.

use super::{Facet, Facing, Mesh, MeshError};
use crate::instantiate;

impl<const D: usize> Mesh<D> {
    /// The facets of a region between cells, each with its two sides. What a form calls the outward normal
    /// points out of the first one.
    ///
    /// # Errors
    /// [`MeshError::UnknownInteriorRegion`], which lists the names that exist.
    pub fn interior_facet_region(&self, name: &str) -> Result<&[[Facet; 2]], MeshError> {
        self.interior_regions.get(name).map(Vec::as_slice).ok_or_else(|| MeshError::UnknownInteriorRegion {
            name: name.to_owned(),
            existing: self.interior_regions.keys().cloned().collect(),
            exterior: self.facet_regions.contains_key(name),
        })
    }

    /// Names of the regions of interior facets, sorted.
    pub fn interior_facet_region_names(&self) -> impl Iterator<Item = &str> {
        self.interior_regions.keys().map(String::as_str)
    }

    /// A name for the interior facets of the region `within` ("interior" for all) whose centre satisfies a
    /// condition.
    ///
    /// # Errors
    /// [`MeshError::UnknownInteriorRegion`] for `within`, [`MeshError::RegionExists`] when a region has this
    /// name, [`MeshError::EmptyRegion`] when no facet satisfies the condition.
    pub fn name_interior_facets(
        &mut self,
        name: &str,
        within: &str,
        condition: impl Fn(&[f64; D]) -> bool,
    ) -> Result<(), MeshError> {
        self.name_interior_facets_where(name, within, &condition)
    }

    #[inline(never)]
    fn name_interior_facets_where(
        &mut self,
        name: &str,
        within: &str,
        condition: &dyn Fn(&[f64; D]) -> bool,
    ) -> Result<(), MeshError> {
        let facets = self.interior_facet_region(within)?.iter().copied();
        let facets = facets.filter(|sides| condition(&self.facet_centre(self.smaller_side(sides)))).collect();
        self.insert_interior_facets(name, facets)
    }

    /// A name for the interior facets of a list; each is given from one of its cells, which becomes its first
    /// side. Their order does not matter, and a facet that is listed twice counts once, with its first side. A facet with smaller ones on its
    /// other side represents all of them.
    ///
    /// # Errors
    /// [`MeshError::NotInterior`] for a facet that is not between two cells (or does not exist),
    /// [`MeshError::RegionExists`] when a region has this name, [`MeshError::EmptyRegion`] for an empty list.
    #[inline(never)]
    pub fn name_listed_interior_facets(&mut self, name: &str, facets: &[Facet]) -> Result<(), MeshError> {
        let mut sides: Vec<(Facet, Facet)> =
            self.interior_facets().iter().flat_map(|&[a, b]| [(a, b), (b, a)]).collect();
        sides.sort_unstable();
        let mut pairs: Vec<[Facet; 2]> = Vec::with_capacity(facets.len());
        let mut known = std::collections::HashSet::new();
        for &facet in facets {
            let start = sides.partition_point(|(first, _)| *first < facet);
            let of_facet = sides[start..].iter().take_while(|(first, _)| *first == facet);
            let mut found = 0;
            for &(_, other) in of_facet {
                found += 1;
                if known.insert([facet.min(other), facet.max(other)]) {
                    pairs.push([facet, other]);
                }
            }
            if found == 0 {
                let (cell, local) = (facet.cell, facet.local);
                return Err(MeshError::NotInterior { name: name.to_owned(), cell, local });
            }
        }
        self.insert_interior_facets(name, pairs)
    }

    /// A name for the interior facets between the cells of two regions; the normal points out of the first one.
    ///
    /// # Errors
    /// [`MeshError::UnknownCellRegion`], [`MeshError::RegionExists`] when a region has this name,
    /// [`MeshError::EmptyRegion`] when the two do not touch.
    #[inline(never)]
    pub fn name_interface(&mut self, name: &str, from: &str, to: &str) -> Result<(), MeshError> {
        let (from, to) = (self.cell_region(from)?, self.cell_region(to)?);
        let lies = |facet: Facet, cells: &[u32]| cells.binary_search(&facet.cell).is_ok();
        let oriented = |&[a, b]: &[Facet; 2]| {
            if lies(a, from) && lies(b, to) {
                Some([a, b])
            } else if lies(b, from) && lies(a, to) {
                Some([b, a])
            } else {
                None
            }
        };
        let facets = self.interior_facets().iter().filter_map(oriented).collect();
        self.insert_interior_facets(name, facets)
    }

    pub(super) fn insert_interior_facets(
        &mut self,
        name: &str,
        mut facets: Vec<[Facet; 2]>,
    ) -> Result<(), MeshError> {
        self.check_name(name, "interior facet", facets.is_empty())?;
        facets.sort_unstable();
        self.data_mut().interior_regions.insert(name.to_owned(), facets);
        Ok(())
    }

    /// The sides of each facet of an exterior or interior facet region: one or two.
    ///
    /// # Errors
    /// [`MeshError::UnknownRegion`].
    #[doc(hidden)]
    pub fn sides_of(&self, region: &str) -> Result<Vec<Vec<Facet>>, MeshError> {
        if let Ok(facets) = self.facet_region(region) {
            return Ok(facets.iter().map(|facet| vec![*facet]).collect());
        }
        match self.interior_facet_region(region) {
            Ok(facets) => Ok(facets.iter().map(|sides| sides.to_vec()).collect()),
            Err(_) => Err(self.unknown_region(region)),
        }
    }

    #[doc(hidden)]
    pub fn unknown_region(&self, name: &str) -> MeshError {
        let owned = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect();
        MeshError::UnknownRegion {
            name: name.to_owned(),
            cells: owned(&mut self.cell_region_names()),
            facets: owned(&mut self.facet_region_names()),
            interior: owned(&mut self.interior_facet_region_names()),
        }
    }

    /// Correspondence of the vertices of the two sides.
    ///
    /// # Errors
    /// [`MeshError::TwistedFacet`] with both cells.
    #[doc(hidden)]
    pub fn facing(&self, sides: &[Facet; 2]) -> Result<Facing, MeshError> {
        if let Some(in_part) = self.facing_in_part(sides) {
            return Ok(in_part);
        }
        let others: Vec<u32> = self.facet_vertices(sides[1]).collect();
        let mut places = [0; 4];
        for (place, vertex) in places.iter_mut().zip(self.facet_vertices(sides[0])) {
            *place = others.iter().position(|&other| other == vertex).unwrap_or(0) as u8;
        }
        // Around a quadrilateral, neighbours must be neighbours from either side.
        let count = others.len();
        let twisted = |k: usize| {
            let step = (usize::from(places[(k + 1) % count]) + count - usize::from(places[k])) % count;
            step != 1 && step != count - 1
        };
        if count == 4 && (0..count).any(twisted) {
            return Err(MeshError::TwistedFacet { cells: sides.map(|facet| facet.cell) });
        }
        Ok(Facing::Whole(places))
    }
}

instantiate!(
    interior:
    Mesh::<D>::name_interior_facets_where,
    Mesh::<D>::name_listed_interior_facets,
    Mesh::<D>::name_interface
);

#[cfg(test)]
mod tests {
    use crate::element::CellShape;
    use crate::mesh::{Facet, Facing, INTERIOR, Mesh, MeshError, cuboid, rectangle};

    #[test]
    fn interior_facets_by_condition_list_and_interface() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
        assert_eq!(mesh.interior_facet_region(INTERIOR)?.len(), 3 * 2 + 4);
        mesh.name_interior_facets("middle", INTERIOR, |centre| centre[1] == 1.0)?;
        assert_eq!(mesh.interior_facet_region("middle")?.len(), 4);
        mesh.name_cells("left half", |centre| centre[0] < 2.0)?;
        mesh.name_cells("right half", |centre| centre[0] > 2.0)?;
        mesh.name_interface("interface", "right half", "left half")?;
        let [first, second] = mesh.interior_facet_region("interface")? else { panic!("two facets") };
        assert_eq!([first, second].map(|sides| sides.map(|facet| facet.cell)), [[2, 1], [6, 5]]);
        let seen = Facet { cell: 1, local: 3 };
        let again = Facet { cell: 0, local: 1 };
        mesh.name_listed_interior_facets("one", &[seen, again])?;
        assert_eq!(mesh.interior_facet_region("one")?, [[seen, again]]);
        Ok(())
    }

    #[test]
    fn errors_tell_interior_from_exterior() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?;
        let message = |error: Option<MeshError>| error.map(|error| error.to_string()).unwrap_or_default();
        assert_eq!(
            message(mesh.facet_region("interior").err()),
            "there is no facet region \"interior\"; the mesh has \"bottom\", \"boundary\", \"left\", \"right\", \
             \"top\" (\"interior\" consists of interior facets, which have two sides)"
        );
        assert_eq!(
            message(mesh.interior_facet_region("top").err()),
            "there is no region \"top\" of interior facets; the mesh has \"interior\" (\"top\" consists of \
             exterior facets, which have one side only)"
        );
        assert_eq!(
            message(mesh.name_listed_interior_facets("x", &[Facet { cell: 0, local: 3 }]).err()),
            "region \"x\": facet 3 of cell 0 does not exist or is not between two cells"
        );
        assert_eq!(
            message(mesh.name_cells("interior", |_| true).err()),
            "the mesh already has a region \"interior\""
        );
        Ok(())
    }

    // The two sides of a facet list the same vertices, in whatever order the cells have them.
    #[test]
    fn the_two_sides_face_each_other() -> Result<(), MeshError> {
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2], shape, 1)?;
            for sides in mesh.interior_facets() {
                let Facing::Whole(places) = mesh.facing(sides)? else { panic!("whole facets") };
                let [first, second] = sides.map(|facet| {
                    let cell = mesh.cell(facet.cell as usize);
                    shape
                        .facet_vertices(usize::from(facet.local))
                        .iter()
                        .map(|&v| cell[v])
                        .collect::<Vec<_>>()
                });
                for (vertex, place) in first.iter().zip(places) {
                    assert_eq!(*vertex, second[usize::from(place)]);
                }
            }
        }
        Ok(())
    }

    #[test]
    fn a_twisted_facet_is_found() -> Result<(), MeshError> {
        // The upper cube names the vertices of the common square in a crossed order: it is inverted as a map,
        // so the mesh is refused before the facet is asked for; the facet itself is checked here.
        let mesh = cuboid([0.0; 3], [1.0, 1.0, 2.0], [1, 1, 2], CellShape::Hexahedron, 1)?;
        let mut cells = mesh.cells().to_vec();
        cells.swap(8, 9);
        let crossed = Mesh(std::sync::Arc::new(super::super::MeshData { cells, ..(*mesh.0).clone() }));
        let sides = crossed.interior_facets()[0];
        assert!(matches!(crossed.facing(&sides), Err(MeshError::TwistedFacet { cells: [0, 1] })));
        Ok(())
    }
}
