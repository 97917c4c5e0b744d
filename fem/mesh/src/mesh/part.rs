//! Meshes of some cells of another mesh.

use super::{BOUNDARY, EVERYWHERE, Facet, INTERIOR, Mesh, MeshError};
use crate::element::CellShape;
use crate::instantiate;

/// A mesh of some cells of another mesh, its parent, with the numbers that its cells and nodes have there. [`Mesh::part`] makes it.
#[derive(Clone, Debug)]
pub struct PartOfMesh<const D: usize> {
    /// The part.
    pub mesh: Mesh<D>,
    /// The parent's cell of each cell, ascending.
    pub cells: Vec<u32>,
    /// The parent's node of each node, ascending.
    pub nodes: Vec<u32>,
}

impl<const D: usize> Mesh<D> {
    /// The mesh of the cells of a region: a body by itself, a layer, the cells of one material. Cells and nodes keep their order and
    /// their places, facets their numbers in their cells.
    ///
    /// Regions keep their names where something of them is left: cells, exterior facets, interior facets whose two cells are
    /// there. Of an interior facet region at the edge of the part the facets with one cell there are an exterior region of the same name,
    /// if no facet of it is left inside. "all", "boundary" and "interior" are the part's own.
    ///
    /// A field of the parent is carried to a space on the part by `Field::onto`.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::rectangle;
    ///
    /// let mut plate = rectangle([0.0, 0.0], [3.0, 1.0], [6, 2], CellShape::Quadrilateral, 1)?;
    /// plate.name_cells("steel", |centre| centre[0] < 1.0)?;
    /// plate.name_cells("rubber", |centre| centre[0] > 1.0)?;
    /// plate.name_interface("joint", "steel", "rubber")?;
    ///
    /// let rubber = plate.part("rubber")?;
    /// assert_eq!(rubber.mesh.cell_count(), 8);
    /// assert_eq!(rubber.mesh.facet_region("joint")?.len(), 2);
    /// assert!(rubber.mesh.facet_region("left").is_err());
    /// // The part's first cell, in the plate.
    /// assert_eq!(rubber.cells[0], 2);
    /// assert_eq!(rubber.mesh.cell_centre(0), plate.cell_centre(2));
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::UnknownCellRegion`]; [`MeshError::RigidSurface`] and [`MeshError::FacetParts`], for meshes with rigid surfaces, and
    /// those with hanging nodes on facets that are parts of others.
    pub fn part(&self, region: &str) -> Result<PartOfMesh<D>, MeshError> {
        let cells = self.cell_region(region)?.to_vec();
        self.without_facet_parts("a part of a mesh")?;
        self.part_of_cells(cells)
    }

    /// The mesh of some cells, in ascending order. Facets that are parts of larger ones, or have such parts, are exterior ones there.
    ///
    /// # Errors
    /// [`MeshError::RigidSurface`].
    #[doc(hidden)]
    #[inline(never)]
    pub fn part_of_cells(&self, cells: Vec<u32>) -> Result<PartOfMesh<D>, MeshError> {
        self.without_rigid_surfaces("a part of a mesh")?;
        let mut nodes: Vec<u32> = cells.iter().flat_map(|cell| self.cell(*cell as usize)).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |list: &[u32], parent: u32| list.binary_search(&parent).ok().map(|index| index as u32);
        let mut blocks: Vec<(CellShape, Vec<u32>)> = Vec::new();
        for (shape, run) in self.runs_of_shape(&cells) {
            let own = run.iter().flat_map(|cell| self.cell(*cell as usize));
            blocks.push((shape, own.filter_map(|node| number(&nodes, *node)).collect()));
        }
        let places = nodes.iter().map(|node| self.nodes[*node as usize]).collect();
        // The parent may have hanging nodes, where it was asked for.
        let mut mesh = Mesh::of_sound_cells(self.degree, places, blocks)?;
        let of_facet =
            |facet: Facet| number(&cells, facet.cell).map(|cell| Facet { cell, local: facet.local });
        for (name, all) in self.cell_regions.iter().filter(|(name, _)| *name != EVERYWHERE) {
            let left: Vec<u32> = all.iter().filter_map(|cell| number(&cells, *cell)).collect();
            if !left.is_empty() {
                mesh.name_listed_cells(name, &left)?;
            }
        }
        for (name, all) in self.facet_regions.iter().filter(|(name, _)| *name != BOUNDARY) {
            let left: Vec<Facet> = all.iter().filter_map(|facet| of_facet(*facet)).collect();
            if !left.is_empty() {
                mesh.name_listed_facets(name, &left)?;
            }
        }
        for (name, all) in self.interior_regions.iter().filter(|(name, _)| *name != INTERIOR) {
            let (mut inside, mut at_edge) = (Vec::new(), Vec::new());
            for sides in all {
                match sides.map(of_facet) {
                    [Some(first), Some(second)] => inside.push([first, second]),
                    [Some(only), None] | [None, Some(only)] => at_edge.push(only),
                    [None, None] => {}
                }
            }
            if !inside.is_empty() {
                mesh.insert_interior_facets(name, inside)?;
            } else if !at_edge.is_empty() {
                mesh.name_listed_facets(name, &at_edge)?;
            }
        }
        Ok(PartOfMesh { mesh, cells, nodes })
    }
}

instantiate!(part: Mesh::<D>::part_of_cells);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::measures::{close, surface, volume};
    use crate::mesh::{annulus, cuboid};

    fn check<const D: usize>(parent: &Mesh<D>, region: &str) -> Result<PartOfMesh<D>, MeshError> {
        let part = parent.part(region)?;
        assert_eq!(part.cells, parent.cell_region(region)?);
        for (cell, &own) in part.cells.iter().enumerate() {
            assert_eq!(part.mesh.cell_shape(cell), parent.cell_shape(own as usize));
            let numbers = part.mesh.cell(cell).iter().map(|node| part.nodes[*node as usize]);
            assert_eq!(numbers.collect::<Vec<_>>(), parent.cell(own as usize));
        }
        close(surface(&part.mesh, "boundary")?.1, D as f64 * volume(&part.mesh), 1e-12);
        Ok(part)
    }

    #[test]
    fn a_layer_of_a_ring() -> Result<(), MeshError> {
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            let mut ring = annulus(1.0, 2.0, 4, 12, shape, 2)?;
            ring.name_cells("lining", |x| x[0].hypot(x[1]) < 1.25)?;
            ring.name_cells("wall", |x| x[0].hypot(x[1]) > 1.25)?;
            ring.name_cells("right", |x| x[0] > 0.0)?;
            ring.name_interface("bond", "lining", "wall")?;
            ring.name_interior_facets("spokes", INTERIOR, |x| {
                let turn = x[1].atan2(x[0]) / std::f64::consts::TAU * 12.0;
                (turn - turn.round()).abs() < 1e-9
            })?;
            let lining = check(&ring, "lining")?.mesh;
            assert_eq!(lining.facet_region("bond")?.len(), 12);
            assert_eq!(lining.facet_region("inner")?.len(), 12);
            assert!(lining.facet_region("outer").is_err() && lining.cell_region("wall").is_err());
            assert_eq!(lining.interior_facet_region("spokes")?.len(), 12);
            assert_eq!(lining.cell_region("right")?.len(), lining.cell_count() / 2);
            assert_eq!(lining.boundary_facets().len(), 24);
            // The two add up to the whole.
            let wall = check(&ring, "wall")?.mesh;
            close(volume(&lining) + volume(&wall), volume(&ring), 1e-13);
        }
        Ok(())
    }

    #[test]
    fn parts_in_space_and_of_all_cells() -> Result<(), MeshError> {
        for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
            let mut block = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], shape, 2)?;
            block.name_cells("half", |x| x[0] < 1.0)?;
            let half = check(&block, "half")?.mesh;
            close(volume(&half), 1.0, 1e-14);
            close(surface(&half, "bottom")?.0, 1.0, 1e-14);
            let all = check(&block, EVERYWHERE)?.mesh;
            assert_eq!((all.nodes(), all.cells()), (block.nodes(), block.cells()));
            assert_eq!(all.boundary_facets(), block.boundary_facets());
        }
        let block = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Hexahedron, 1)?;
        assert!(matches!(block.part("core"), Err(MeshError::UnknownCellRegion { .. })));
        Ok(())
    }

    // A body of bodies that share no node.
    #[test]
    fn bodies_come_apart() -> Result<(), MeshError> {
        let cube = |z: f64| cuboid([0.0, 0.0, z], [1.0, 1.0, z + 1.0], [1; 3], CellShape::Hexahedron, 1);
        let both = Mesh::of_bodies(&[("lower", &cube(0.0)?), ("upper", &cube(1.0)?)])?;
        let upper = check(&both, "upper")?;
        assert_eq!(upper.mesh.cell_count(), 1);
        assert_eq!(upper.mesh.facet_region("upper bottom")?.len(), 1);
        assert!(upper.mesh.facet_region("lower top").is_err());
        Ok(())
    }
}
