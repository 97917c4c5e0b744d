//! Several bodies as one mesh.

use super::facet_parts::FacetParts;
use super::{EVERYWHERE, Facet, Mesh, MeshError};
use crate::element::CellShape;
use crate::instantiate;

impl<const D: usize> Mesh<D> {
    /// Bodies as one mesh, so that one field lives on all of them. They share no node, wherever they touch: contact pairs join
    /// them, `Pairing::between("slab top", "punch bottom")` below. A body's name names its cells, and its regions are found as "body region": "slab boundary", "slab top".
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{Mesh, rectangle};
    ///
    /// let slab = rectangle([0.0, 0.0], [3.0, 1.0], [6, 2], CellShape::Quadrilateral, 1)?;
    /// let punch = rectangle([1.0, 1.0], [2.0, 2.0], [3, 3], CellShape::Quadrilateral, 1)?;
    /// let mesh = Mesh::of_bodies(&[("slab", &slab), ("punch", &punch)])?;
    /// assert_eq!(mesh.cell_region("punch")?.len(), 9);
    /// assert_eq!(mesh.facet_region("slab top")?.len(), 6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Bodies`] for geometries of different degrees and for a name that is given twice; those of [`Mesh::from_blocks`] except for
    /// hanging nodes.
    #[inline(never)]
    pub fn of_bodies(bodies: &[(&str, &Mesh<D>)]) -> Result<Self, MeshError> {
        let Some((_, first)) = bodies.first() else {
            return Err(MeshError::Bodies { why: "no bodies were given".to_owned() });
        };
        let mut nodes: Vec<[f64; D]> = Vec::new();
        let mut blocks: Vec<(CellShape, Vec<u32>)> = Vec::new();
        for (index, (name, body)) in bodies.iter().enumerate() {
            body.without_rigid_surfaces("a mesh of several bodies")?;
            if body.degree != first.degree {
                let (own, others) = (body.degree, first.degree);
                let why =
                    format!("the geometry of \"{name}\" has degree {own}, that of the first body {others}");
                return Err(MeshError::Bodies { why });
            }
            if bodies[..index].iter().any(|(other, _)| other == name) {
                return Err(MeshError::Bodies { why: format!("two bodies have the name \"{name}\"") });
            }
            let start = nodes.len() as u32;
            nodes.extend(&body.nodes);
            for block in &body.blocks {
                let cells = block.cells.clone().flat_map(|cell| body.cell(cell)).map(|node| node + start);
                blocks.push((block.shape, cells.collect()));
            }
        }
        let mut mesh = Mesh::from_nonconforming_blocks(first.degree, nodes, blocks)?;
        let mut parts = FacetParts::default();
        let mut start = 0;
        for (_, body) in bodies {
            parts.extend_shifted(&body.parts, start);
            start += body.cell_count() as u32;
        }
        mesh.join_parts(parts);
        let mut start = 0;
        for (name, body) in bodies {
            let region = |own: &str| match own {
                EVERYWHERE => (*name).to_owned(),
                own => format!("{name} {own}"),
            };
            for (own, cells) in &body.cell_regions {
                let cells: Vec<u32> = cells.iter().map(|cell| cell + start).collect();
                mesh.name_listed_cells(&region(own), &cells)?;
            }
            let moved = |facet: &Facet| Facet { cell: facet.cell + start, ..*facet };
            for (own, facets) in &body.facet_regions {
                mesh.name_listed_facets(&region(own), &facets.iter().map(moved).collect::<Vec<_>>())?;
            }
            for (own, facets) in &body.interior_regions {
                let facets: Vec<_> = facets.iter().map(|sides| sides.each_ref().map(moved)).collect();
                // A body of one cell has none, as its own mesh does.
                mesh.check_name(&region(own), "interior facet", false)?;
                mesh.data_mut().interior_regions.insert(region(own), facets);
            }
            start += body.cell_count() as u32;
        }
        Ok(mesh)
    }
}

instantiate!(bodies: Mesh::<D>::of_bodies);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{INTERIOR, cuboid, rectangle};

    #[test]
    fn bodies_of_one_cell() -> Result<(), MeshError> {
        let check = |tool: &Mesh<2>| -> Result<(), MeshError> {
            let slab = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, tool.degree())?;
            let mesh = Mesh::of_bodies(&[("slab", &slab), ("tool", tool)])?;
            assert_eq!(mesh.cell_region("tool")?.len(), 1);
            assert_eq!(mesh.facet_region("tool boundary")?.len(), tool.boundary_facets().len());
            assert!(mesh.interior_facet_region("tool interior")?.is_empty());
            assert!(tool.interior_facet_region(INTERIOR)?.is_empty());
            Ok(())
        };
        for degree in 1..=2 {
            check(&rectangle([0.0, 2.0], [1.0, 3.0], [1, 1], CellShape::Quadrilateral, degree)?)?;
        }
        let nodes = vec![[0.0, 2.0], [1.0, 2.0], [0.0, 3.0]];
        check(&Mesh::from_parts(CellShape::Triangle, 1, nodes, vec![0, 1, 2])?)?;
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let corner = Mesh::from_parts(CellShape::Tetrahedron, 1, nodes, vec![0, 1, 2, 3])?;
        let moved = corner.with_nodes(corner.nodes().iter().map(|x| x.map(|x| x + 2.0)).collect())?;
        assert_eq!(Mesh::of_bodies(&[("one", &corner), ("other", &moved)])?.cell_count(), 2);
        let cube = cuboid([0.0, 0.0, 2.0], [1.0, 1.0, 3.0], [1; 3], CellShape::Hexahedron, 2)?;
        assert_eq!(Mesh::of_bodies(&[("cube", &cube)])?.facet_region("cube top")?.len(), 1);
        Ok(())
    }
}
