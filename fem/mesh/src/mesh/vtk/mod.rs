//! Meshes from VTK's files: unstructured grids as XML (`.vtu`) and in the legacy format (`.vtk`).

mod array;
mod bytes;
mod contents;
mod error;
mod grid;
#[doc(hidden)]
pub mod kinds;
mod legacy;
mod legacy_reader;
mod markup;
mod regions;
mod xml;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::Mesh;
use super::imported::{self, Imported};
use grid::Grid;

pub use super::imported::{FilePosition, ImportProblem, Item, Note};
pub use array::VtkArray;
pub use error::{VtkError, VtkProblem};

/// A mesh from a file, its data, and remarks on it.
#[derive(Clone, Debug)]
pub struct VtkMesh<const D: usize> {
    /// The mesh. Nodes have the order of the file's points, and so have the cells of each shape.
    pub mesh: Mesh<D>,
    /// The file's arrays at points, for the nodes of the mesh.
    pub point_data: Vec<VtkArray>,
    /// The file's arrays on cells, for the cells of the mesh.
    pub cell_data: Vec<VtkArray>,
    /// Notes on content of the file that the mesh does not show.
    pub notes: Vec<Note>,
}

/// Choices in reading a file: the array that holds the regions, and their names. [`VtkReader::read`] reads a file,
/// [`VtkReader::from_bytes`] what is in memory; both give the mesh with the file's other arrays and notes, [`VtkMesh`].
/// A cell array is a field that is constant on each cell by `Field::from_cell_values`.
///
/// The numbers of an integer array on the cells become regions: of the cells of dimension D "region 3" and so on, of
/// those of dimension D − 1 "facets 3", unless they are given names; a cell with a negative number is in none. The array
/// is the one that the caller names, or else the first of "region", "gmsh:physical", "CellEntityIds" and "medit:ref"
/// that the file has; without any there are no regions. A cell that occurs twice with different numbers, as where meshio
/// converts Gmsh's files, is one cell in two regions.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::mesh::VtkReader;
///
/// let file = b"# vtk DataFile Version 3.0
/// two triangles and an edge
/// ASCII
/// DATASET UNSTRUCTURED_GRID
/// POINTS 4 double
/// 0 0 0  1 0 0  1 1 0  0 1 0
/// CELLS 3 11
/// 3 0 1 2  3 0 2 3  2 0 1
/// CELL_TYPES 3
/// 5 5 3
/// CELL_DATA 3
/// SCALARS material int 1
/// LOOKUP_TABLE default
/// 1 2 7
/// ";
/// let reader = VtkReader::new().region_array("material").name_cells(1, "steel").name_facets(7, "floor");
/// let read = reader.from_bytes::<2>("square.vtk", file)?;
/// assert_eq!(read.mesh.cell_region("steel")?, [0]);
/// assert_eq!(read.mesh.cell_region("region 2")?, [1]);
/// assert_eq!(read.mesh.facet_region("floor")?.len(), 1);
/// assert_eq!(read.cell_data[0].values, [1.0, 2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct VtkReader {
    array: Option<String>,
    cells: BTreeMap<i64, String>,
    facets: BTreeMap<i64, String>,
    join: bool,
}

impl VtkReader {
    /// A reader that takes regions from an array with a usual name, and points as they are.
    pub fn new() -> Self {
        VtkReader::default()
    }

    /// Name of the array on cells whose numbers are the regions. A file without it is an error.
    #[must_use]
    pub fn region_array(mut self, name: &str) -> Self {
        self.array = Some(name.to_owned());
        self
    }

    /// Name of the region of the cells of dimension D that have a number; numbers may share a name.
    #[must_use]
    pub fn name_cells(mut self, number: i64, name: &str) -> Self {
        self.cells.insert(number, name.to_owned());
        self
    }

    /// Name of the region of the facets that are cells of dimension D − 1 with a number; numbers may share a name.
    #[must_use]
    pub fn name_facets(mut self, number: i64, name: &str) -> Self {
        self.facets.insert(number, name.to_owned());
        self
    }

    /// One node in place of points with equal coordinates, to the last bit. Programs write the points of each cell by
    /// themselves where data jump between cells, and so do the files that `VtuFile` writes.
    #[must_use]
    pub fn join_points(mut self) -> Self {
        self.join = true;
        self
    }

    /// The mesh of a file, XML or legacy as it begins.
    ///
    /// # Errors
    /// As [`Mesh::read_vtk`].
    pub fn read<const D: usize>(&self, path: impl AsRef<Path>) -> Result<VtkMesh<D>, VtkError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        match std::fs::read(path) {
            Ok(bytes) => self.from_bytes(&file, &bytes),
            Err(error) => {
                Err(VtkError { file, problem: VtkProblem::Unreadable { reason: error.to_string() } })
            }
        }
    }

    /// Reads the bytes of a file; `name` is for messages.
    ///
    /// # Errors
    /// As [`Mesh::read_vtk`].
    // The bytes are converted, and the reader says how.
    #[allow(clippy::wrong_self_convention)]
    pub fn from_bytes<const D: usize>(&self, name: &str, bytes: &[u8]) -> Result<VtkMesh<D>, VtkError> {
        self.mesh(bytes).map_err(|problem| VtkError { file: name.to_owned(), problem })
    }

    fn mesh<const D: usize>(&self, bytes: &[u8]) -> Result<VtkMesh<D>, VtkProblem> {
        let mut grid = grid_of(bytes)?;
        if self.join {
            grid.join_points();
        }
        let (contents, counted) = contents::contents::<D>(&grid, self)?;
        let Imported { mesh, mut notes, nodes, completed, cells } =
            imported::import::<D>(&contents).map_err(|flaw| flaw.problem)?;
        notes.extend(counted);
        notes.extend(coincident(&mesh, &nodes));
        let of = |arrays: &[array::RawArray], places: &[usize]| {
            arrays.iter().map(|array| array.at(places)).collect()
        };
        let (mut point_data, cell_data): (Vec<VtkArray>, _) =
            (of(&grid.point_data, &nodes), of(&grid.cell_data, &cells));
        for array in &mut point_data {
            let added = completed.iter().flat_map(|added| added.sum(&array.values, array.components));
            let added: Vec<f64> = added.collect();
            array.values.extend(added);
        }
        Ok(VtkMesh { mesh, point_data, cell_data, notes })
    }
}

/// The grid of a file in the format that its first byte shows.
fn grid_of(bytes: &[u8]) -> Result<Grid, VtkProblem> {
    let start = bytes.trim_ascii_start();
    match start.first() {
        Some(b'<') => xml::read(bytes),
        Some(b'#') => legacy::read(bytes),
        _ => Err(grid::not_vtk(start)),
    }
}

// Cells do not share points that are merely at one place.
fn coincident<const D: usize>(mesh: &Mesh<D>, places: &[usize]) -> Option<Note> {
    let mut known = HashMap::with_capacity(mesh.node_count());
    let (mut first, mut count) = (None, 0);
    for (position, &place) in mesh.nodes().iter().zip(places) {
        if let Some(other) = known.insert(grid::bits(position), place) {
            count += 1;
            first.get_or_insert([other, place]);
        }
    }
    first.map(|pair| Note::Coincident { count, first: pair.map(contents::point) })
}

impl<const D: usize> Mesh<D> {
    /// The mesh of an unstructured grid of VTK: XML (`.vtu`; text, base64 or appended, also compressed by zlib) or legacy
    /// (`.vtk`; text or binary).
    ///
    /// Cells are those of dimension D: triangles, quadrilaterals, tetrahedra or hexahedra of first or second order, all
    /// of one type, or triangles and quadrilaterals of one order; VTK's Lagrange cells of these orders, pixels and voxels
    /// are read as such. Points and cells keep the file's order, but where there are both, all cells of the shape that
    /// occurs first come first. Points that no cell uses are left out. A plane mesh may lie at any z.
    ///
    /// Regions come from an integer array on the cells; [`VtkReader`] says from which, names them, and gives the other
    /// data besides.
    ///
    /// ```no_run
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::mesh::Mesh;
    ///
    /// let plate = Mesh::<2>::read_vtk("plate.vtu")?;
    /// println!("{}", plate.quality());
    /// # Ok::<(), forms_fem::mesh::VtkError>(())
    /// ```
    ///
    /// # Errors
    /// A [`VtkError`] that names the cell, the point or the array, or the line where the file breaks its format.
    pub fn read_vtk(path: impl AsRef<Path>) -> Result<Self, VtkError> {
        VtkReader::new().read(path).map(|read| read.mesh)
    }
}
