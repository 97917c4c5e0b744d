//! Meshes from Gmsh's files: MSH 4.1 and 2.2, text and binary.

mod error;
mod kinds;
mod reader;
mod sections;
mod version_2;
mod version_4;

use std::path::Path;

use super::Mesh;
use super::imported::{self, Words};
use reader::Reader;

pub use super::imported::{FilePosition, ImportProblem, Item, Note};
pub use error::{GmshError, GmshProblem};

const WORDS: Words = Words {
    node: "node",
    element: "element",
    unnamed: |dimension, tag| format!("physical {} {tag}", imported::entity(dimension)),
    part: |surface| format!("surface {surface}"),
    advice: kinds::advice,
    bent: " (a second-order cell may bend too much: option Mesh.HighOrderOptimize, or smaller cells)",
    omitted: ". Where a model has physical groups, Gmsh saves the entities of groups only: put those of the cells into a \
              physical group, too, or save with the option Mesh.SaveAll = 1",
};

/// A mesh from a file, and remarks on it.
#[derive(Clone, Debug)]
pub struct GmshMesh<const D: usize> {
    /// The mesh. Nodes have the order of the file, and so have the cells of each shape.
    pub mesh: Mesh<D>,
    /// Notes on content of the file that the mesh does not show.
    pub notes: Vec<Note>,
}

impl<const D: usize> GmshMesh<D> {
    /// The mesh of a file, as [`Mesh::read_gmsh`] reads it.
    ///
    /// # Errors
    /// As [`Mesh::read_gmsh`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, GmshError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        match std::fs::read(path) {
            Ok(bytes) => GmshMesh::from_bytes(&file, &bytes),
            Err(error) => {
                let problem = GmshProblem::Unreadable { reason: error.to_string() };
                Err(GmshError { file, position: None, section: None, problem })
            }
        }
    }

    /// The mesh of a file's bytes, as [`Mesh::read_gmsh`] reads it; `name` is for messages.
    ///
    /// # Errors
    /// As [`Mesh::read_gmsh`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, GmshError> {
        let mut reader = Reader::new(name, bytes);
        let contents = sections::read(&mut reader)?;
        // Cells and facets are in this section.
        reader.section = Some("Elements".to_owned());
        let imported = imported::import(&contents).map_err(|flaw| match flaw.at {
            Some(at) => reader.error_at(at, flaw.problem.into()),
            None => reader.error_of_file(flaw.problem.into()),
        })?;
        Ok(GmshMesh { mesh: imported.mesh, notes: imported.notes })
    }
}

impl<const D: usize> Mesh<D> {
    /// The mesh of a Gmsh file: MSH 4.1 or 2.2, text or binary of either byte order, first or second order.
    ///
    /// Cells are the elements of dimension D: triangles, quadrilaterals, tetrahedra or hexahedra, all of one type, or
    /// triangles and quadrilaterals of one order. Nodes and cells keep the file's order, but where there are both, all
    /// cells of the shape that occurs first come first. Nodes that no cell uses are left out. A plane mesh may lie at
    /// any z.
    ///
    /// Physical groups become regions: those of dimension D regions of cells, those of dimension D − 1 regions of
    /// facets, exterior or interior. The normal on an interior facet points out of the cell from which the facet's
    /// element is seen as from inside, as Gmsh orients it. A group with facets of both kinds becomes two regions,
    /// the second one with " (interior)" behind its name. A group without a name is called as in Gmsh,
    /// "physical surface 3". In a partitioned file the cells of a partition are the region "partition 1" and so on.
    ///
    /// [`GmshMesh::read`] tells besides what was left out.
    ///
    /// ```no_run
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::mesh::Mesh;
    ///
    /// let plate = Mesh::<2>::read_gmsh("plate.msh")?;
    /// println!("{}", plate.quality());
    /// # Ok::<(), forms_fem::mesh::GmshError>(())
    /// ```
    ///
    /// # Errors
    /// A [`GmshError`] that names the line (text) or the offset (binary), the section and the node, element or group.
    pub fn read_gmsh(path: impl AsRef<Path>) -> Result<Self, GmshError> {
        GmshMesh::read(path).map(|read| read.mesh)
    }

    /// The mesh of a Gmsh file's bytes, as [`Mesh::read_gmsh`] reads it; `name` is for messages.
    ///
    /// # Errors
    /// As [`Mesh::read_gmsh`].
    pub fn read_gmsh_bytes(name: &str, bytes: &[u8]) -> Result<Self, GmshError> {
        GmshMesh::from_bytes(name, bytes).map(|read| read.mesh)
    }
}
