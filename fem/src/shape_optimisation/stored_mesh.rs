//! A mesh as a checkpoint holds it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::element::CellShape;
use crate::mesh::{BOUNDARY, EVERYWHERE, Facet, INTERIOR, Mesh, MeshError};

/// A mesh with its regions, to the last bit. A descent resumes from it if the cells are no longer those of its start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredMesh {
    degree: usize,
    /// Coordinates, node after node \[length\].
    nodes: Vec<f64>,
    /// Nodes of the cells of each shape.
    cells: Vec<(String, Vec<u32>)>,
    cell_regions: BTreeMap<String, Vec<u32>>,
    /// Cells and local numbers of the facets.
    facet_regions: BTreeMap<String, Vec<(u32, u8)>>,
    interior_regions: BTreeMap<String, Vec<(u32, u8)>>,
}

impl StoredMesh {
    /// Parts to store of a mesh without rigid surfaces.
    ///
    /// # Errors
    /// A region that cannot be read, which does not happen.
    pub fn of<const D: usize>(mesh: &Mesh<D>) -> Result<Self, MeshError> {
        let cells = mesh.blocks().iter().map(|block| {
            let nodes = block.cells.clone().flat_map(|cell| mesh.cell(cell).to_vec());
            (block.shape.name().to_owned(), nodes.collect())
        });
        let place = |facet: &Facet| (facet.cell, facet.local);
        let mut stored = StoredMesh {
            degree: mesh.degree(),
            nodes: mesh.nodes().iter().flatten().copied().collect(),
            cells: cells.collect(),
            cell_regions: BTreeMap::new(),
            facet_regions: BTreeMap::new(),
            interior_regions: BTreeMap::new(),
        };
        for name in mesh.cell_region_names().filter(|name| *name != EVERYWHERE) {
            stored.cell_regions.insert(name.to_owned(), mesh.cell_region(name)?.to_vec());
        }
        for name in mesh.facet_region_names().filter(|name| *name != BOUNDARY) {
            let facets = mesh.facet_region(name)?.iter().map(place).collect();
            stored.facet_regions.insert(name.to_owned(), facets);
        }
        for name in mesh.interior_facet_region_names().filter(|name| *name != INTERIOR) {
            let facets = mesh.interior_facet_region(name)?.iter().map(|sides| place(&sides[0])).collect();
            stored.interior_regions.insert(name.to_owned(), facets);
        }
        Ok(stored)
    }

    /// The mesh.
    ///
    /// # Errors
    /// Lists that were changed since they were stored, and make no mesh.
    pub fn mesh<const D: usize>(&self) -> Result<Mesh<D>, MeshError> {
        let nodes = self.nodes.chunks_exact(D).map(|node| std::array::from_fn(|k| node[k])).collect();
        // A name that is none has no nodes, which is found below.
        let shape = |name: &str| CellShape::ALL.into_iter().find(|shape| shape.name() == name);
        let blocks =
            self.cells.iter().filter_map(|(name, cells)| Some((shape(name)?, cells.clone()))).collect();
        let mut mesh = Mesh::from_blocks(self.degree, nodes, blocks)?;
        let facets = |list: &[(u32, u8)]| -> Vec<Facet> {
            list.iter().map(|&(cell, local)| Facet { cell, local }).collect()
        };
        for (name, cells) in &self.cell_regions {
            mesh.name_listed_cells(name, cells)?;
        }
        for (name, list) in &self.facet_regions {
            mesh.name_listed_facets(name, &facets(list))?;
        }
        for (name, list) in &self.interior_regions {
            mesh.name_listed_interior_facets(name, &facets(list))?;
        }
        Ok(mesh)
    }
}
