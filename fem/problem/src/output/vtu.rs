//! `.vtu` files (VTK unstructured grid, XML), which ParaView and VisIt read.

mod error;
mod pieces;
mod xml;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::write_whole;
use crate::element::CellShape;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::Mesh;
use crate::mesh::vtk::kinds::nodes_in_order;
use crate::solve::communicator::agreed_or;
use crate::solve::{CommunicationError, Communicator, Processes};
use crate::space::Scope;
use crate::threads::Threads;

pub use error::VtuError;

/// A mesh and data on it, to be written as a `.vtu` file.
///
/// Cells keep their degree: quadratic cells are written as VTK's quadratic cells. Vectors get three
/// components and tensors nine (row-major); the missing ones are zero. Values with other numbers of components
/// are written as they are. Once a discontinuous field is among the data, each cell has points of its own.
#[derive(Clone, Debug)]
pub struct VtuFile<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    points: Vec<Array>,
    /// One value per cell and node of it: fields that jump between cells.
    corners: Vec<Array>,
    cells: Vec<Array>,
    /// The processes that write the file together.
    processes: Processes<'a>,
    threads: Threads,
}

/// A data array.
#[derive(Clone, Debug)]
struct Array {
    name: String,
    components: usize,
    values: Vec<f64>,
    /// Written as integers.
    whole: bool,
}

impl<'a, const D: usize> VtuFile<'a, D> {
    /// A file with the mesh and no data yet.
    pub fn new(mesh: &'a Mesh<D>) -> Self {
        let [points, corners, cells] = [const { Vec::new() }; 3];
        VtuFile { mesh, points, corners, cells, processes: Processes::default(), threads: Threads::default() }
    }

    /// The number of threads in place of all, on which fields are evaluated and numbers are coded. The file is the same on any number.
    pub fn threads(mut self, threads: Threads) -> Self {
        self.threads = threads;
        self
    }

    /// The file of several processes. All call [`VtuFile::write`], and the first one writes where each has the whole mesh. Of pieces of a
    /// mesh each writes one file, and the first a list of them: `block.vtu` becomes `block.pvtu` with `block_p0000.vtu`, `block_p0001.vtu`
    /// and so on, which readers open as one mesh.
    pub fn on(mut self, communicator: &'a dyn Communicator) -> Self {
        self.processes = Processes::new(Some(communicator), None);
        self
    }

    /// The values of a field at the mesh's nodes, as one more array. The field's degree need not be the mesh's: the
    /// field is evaluated at the nodes. A discontinuous field has its value of each cell there; one of degree
    /// 0 becomes data of the cells.
    ///
    /// # Errors
    /// [`VtuError`] if the field lives on another mesh or on facets alone, is not finite, or the name is taken.
    #[inline(never)]
    pub fn point_data(mut self, name: &str, field: &Field<D>) -> Result<Self, VtuError> {
        if !super::lives_on(field, self.mesh) {
            return Err(VtuError::OtherMesh { name: name.into() });
        }
        let (space, components) = (field.space(), field.space().components());
        let jumps = *space.scope() == Scope::Cell || !space.has_traces();
        match space.scope() {
            Scope::Facets(region) | Scope::EachFacet(region) => {
                Err(VtuError::OnFacets { name: name.into(), region: region.clone() })
            }
            Scope::Cell if space.is_constant() => self.cell_data(name, components, field.values()),
            Scope::Body | Scope::Point | Scope::Within(..) => Err(VtuError::Scope {
                name: name.into(),
                elements: space.elements().clone(),
                scope: space.scope().clone(),
            }),
            // Crouzeix and Raviart's elements are continuous in their nodes only.
            Scope::Cell | Scope::Nodes if jumps => {
                let values = super::values_at_cell_nodes(self.threads, self.mesh, field);
                let others = self.points.iter().chain(&self.corners);
                let array = Array::new::<D>(name, components, &values, self.mesh.cells().len(), others)?;
                self.corners.push(array);
                Ok(self)
            }
            Scope::Cell | Scope::Nodes => {
                // Cells agree at the nodes that they share; nodes of no cell stay zero.
                let of_cells = super::values_at_cell_nodes(self.threads, self.mesh, field);
                let mut values = vec![0.0; self.mesh.node_count() * components];
                for (&node, value) in self.mesh.cells().iter().zip(of_cells.chunks(components)) {
                    values[node as usize * components..][..components].copy_from_slice(value);
                }
                self.point_values(name, components, &values)
            }
        }
    }

    /// Values at the mesh's nodes, `values[node * components + component]`.
    ///
    /// # Errors
    /// [`VtuError`] if there is not one value per node and component, a value is not finite, or the
    /// name is taken.
    #[inline(never)]
    pub fn point_values(mut self, name: &str, components: usize, values: &[f64]) -> Result<Self, VtuError> {
        let others = self.points.iter().chain(&self.corners);
        let array = Array::new::<D>(name, components, values, self.mesh.nodes().len(), others)?;
        self.points.push(array);
        Ok(self)
    }

    /// Values of the cells, `values[cell * components + component]`.
    ///
    /// # Errors
    /// [`VtuError`] if there is not one value per cell and component, a value is not finite, or the
    /// name is taken.
    #[inline(never)]
    pub fn cell_data(mut self, name: &str, components: usize, values: &[f64]) -> Result<Self, VtuError> {
        let array = Array::new::<D>(name, components, values, self.mesh.cell_count(), &self.cells)?;
        self.cells.push(array);
        Ok(self)
    }

    /// Regions of cells as an array "region" of whole numbers: 1 for the cells of the first region in the list, 2
    /// for those of the second and so on, −1 for the cells of none. [`VtkReader`](crate::mesh::VtkReader) makes
    /// regions of it again.
    ///
    /// # Errors
    /// [`VtuError::Region`] if there is no such region of cells, or a cell belongs to two;
    /// [`VtuError::Twice`] if there is an array "region".
    #[inline(never)]
    pub fn regions(mut self, names: &[&str]) -> Result<Self, VtuError> {
        let mut numbers = vec![-1.0; self.mesh.cell_count()];
        for (region, number) in names.iter().zip(1_u32..) {
            let problem = |reason: String| VtuError::Region { region: (*region).to_owned(), reason };
            let cells = self.mesh.cell_region(region).map_err(|error| problem(error.to_string()))?;
            for &cell in cells {
                let before = std::mem::replace(&mut numbers[cell as usize], f64::from(number));
                if before > 0.0 {
                    let other = names[before as usize - 1];
                    return Err(problem(format!("cell {cell} belongs to \"{other}\" too")));
                }
            }
        }
        let mut array = Array::new::<D>("region", 1, &numbers, self.mesh.cell_count(), &self.cells)?;
        array.whole = true;
        self.cells.push(array);
        Ok(self)
    }

    /// The file, written whole or not at all.
    ///
    /// # Errors
    /// [`VtuError`] if the file cannot be written, on all processes that write it together.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), VtuError> {
        self.write_by_all(path.as_ref()).map(|_| ())
    }

    /// Writes the file, and gives the name of the one to be opened.
    pub(super) fn write_by_all(&self, path: &Path) -> Result<PathBuf, VtuError> {
        let Some(all) = self.processes.communicator() else {
            self.mesh
                .without_pieces("a .vtu file of one process", "write `.on(&part)` before `.write(..)`")?;
            self.write_here(path)?;
            return Ok(path.to_owned());
        };
        if !self.mesh.is_piece() {
            self.by_first(|| self.write_here(path))?;
            return Ok(path.to_owned());
        }
        let named = |rank: usize| pieces::name(path, rank);
        let written = named(all.rank()).and_then(|own| self.write_here(&path.with_file_name(own)));
        let names =
            self.all(written.and_then(|()| (0..all.size()).map(named).collect::<Result<Vec<_>, _>>()))?;
        let grid = self.grid()?;
        let arrays = all.gather(grid.fingerprint()).map_err(|source| VtuError::Processes { source })?;
        if arrays.iter().any(|other| *other != arrays[0]) {
            let source = CommunicationError::Different { what: "the data arrays of a file".to_owned() };
            return Err(VtuError::Processes { source });
        }
        let list = path.with_extension("pvtu");
        let write = || write_whole(&list, |writer| pieces::write_list(&grid, &names, writer));
        self.by_first(|| write().map_err(|source| VtuError::Write { source }))?;
        Ok(list)
    }

    /// Something that all processes do: an error on all where one fails.
    fn all<T>(&self, own: Result<T, VtuError>) -> Result<T, VtuError> {
        let Some(all) = self.processes.communicator() else { return own };
        agreed_or(all, own, |source| VtuError::Processes { source })
    }

    /// Something that the first process does.
    pub(super) fn by_first(&self, write: impl FnOnce() -> Result<(), VtuError>) -> Result<(), VtuError> {
        let is_first = self.processes.communicator().is_none_or(|all| all.rank() == 0);
        self.all(if is_first { write() } else { Ok(()) })
    }

    fn write_here(&self, path: &Path) -> Result<(), VtuError> {
        let grid = self.grid()?;
        write_whole(path, |writer| grid.write(self.threads, writer))
            .map_err(|source| VtuError::Write { source })
    }

    /// The points, cells and arrays of the file.
    #[inline(never)]
    fn grid(&self) -> Result<xml::Grid<'_>, VtuError> {
        let cell_count = self.mesh.body_cells().len();
        let separate = !self.corners.is_empty();
        // Cells that carry rigid surfaces are the last ones, and their nodes too.
        let (node_count, corner_count) = self.mesh.body_nodes();
        let at_points = match separate {
            // Points of the cells, one after the other, in place of the nodes that they share.
            true => Places::Of(&self.mesh.cells()[..corner_count]),
            false => Places::First(node_count),
        };
        let (nodes, name) = (self.mesh.nodes(), "coordinates");
        let coordinates = Array::new::<D>(name, D, nodes.as_flattened(), nodes.len(), [])?;
        let values = xml::Values::Reals(Cow::Owned(coordinates.values_at(&at_points).into_owned()));
        let points = xml::Array { name, components: coordinates.components, values };
        let (at_corners, at_cells) = (Places::First(corner_count), Places::First(cell_count));
        let at_corners = self.corners.iter().map(|array| array.written(&at_corners));
        let point_data =
            self.points.iter().map(|array| array.written(&at_points)).chain(at_corners).collect();
        let cell_data = self.cells.iter().map(|array| array.written(&at_cells)).collect();
        let mut connectivity = Vec::with_capacity(self.mesh.cells().len());
        let (mut offsets, mut types) = (Vec::with_capacity(cell_count), Vec::with_capacity(cell_count));
        for block in self.mesh.body_blocks() {
            let (cell_type, order) = cell_type(block.shape, self.mesh.degree());
            for cell in block.cells.clone() {
                let (nodes, start) = (self.mesh.cell(cell), connectivity.len());
                let number =
                    |node: usize| if separate { (start + node) as u64 } else { u64::from(nodes[node]) };
                connectivity.extend(order.iter().map(|&node| number(node)));
                offsets.push(connectivity.len() as u64);
                types.push(cell_type);
            }
        }
        Ok(xml::Grid { points, connectivity, offsets, types, point_data, cell_data })
    }
}

/// The places of an array that a file holds.
enum Places<'p> {
    /// This many from the first one on.
    First(usize),
    /// Those of nodes.
    Of(&'p [u32]),
}

impl Array {
    /// Checks the values and pads vectors to 3 and tensors to 9 components.
    fn new<'a, const D: usize>(
        name: &str,
        components: usize,
        values: &[f64],
        count: usize,
        others: impl IntoIterator<Item = &'a Array>,
    ) -> Result<Array, VtuError> {
        let padded = match components {
            0 => return Err(VtuError::Components { name: name.into(), components }),
            _ if components == D => 3,
            _ if components == D * D => 9,
            _ => components,
        };
        if values.len() != count * components {
            return Err(VtuError::Length {
                name: name.into(),
                expected: count * components,
                found: values.len(),
            });
        }
        if others.into_iter().any(|other| other.name == name) {
            return Err(VtuError::Twice { name: name.into() });
        }
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            let index = place / components;
            return Err(VtuError::NotFinite { name: name.into(), index, value: values[place] });
        }
        let mut all = vec![0.0; count * padded];
        for (source, target) in values.chunks(components).zip(all.chunks_mut(padded)) {
            for (k, &value) in source.iter().enumerate() {
                let place = if components == D * D { 3 * (k / D) + k % D } else { k };
                target[place] = value;
            }
        }
        Ok(Array { name: name.into(), components: padded, values: all, whole: false })
    }

    /// The array as the file holds it.
    fn written(&self, places: &Places<'_>) -> xml::Array<'_> {
        let values = self.values_at(places);
        let values = match self.whole {
            true => xml::Values::Integers(values.iter().map(|&value| value as i32).collect()),
            false => xml::Values::Reals(values),
        };
        xml::Array { name: &self.name, components: self.components, values }
    }

    fn values_at(&self, places: &Places<'_>) -> Cow<'_, [f64]> {
        let count = self.components;
        match places {
            Places::First(places) => Cow::Borrowed(&self.values[..places * count]),
            Places::Of(nodes) => {
                let values = nodes.iter().flat_map(|node| &self.values[*node as usize * count..][..count]);
                Cow::Owned(values.copied().collect())
            }
        }
    }
}

/// The number of VTK's type of cell, and for each of its points the number of our node.
fn cell_type(shape: CellShape, degree: usize) -> (u8, Vec<usize>) {
    let number = match (shape, degree) {
        (CellShape::Triangle, 1) => 5,
        (CellShape::Triangle, _) => 22,
        (CellShape::Quadrilateral, 1) => 9,
        (CellShape::Quadrilateral, _) => 28,
        (CellShape::Tetrahedron, 1) => 10,
        (CellShape::Tetrahedron, _) => 24,
        (CellShape::Hexahedron, 1) => 12,
        (CellShape::Hexahedron, _) => 29,
    };
    (number, nodes_in_order(number))
}

instantiate!(
    vtu:
    VtuFile::<D>::point_data,
    VtuFile::<D>::point_values,
    VtuFile::<D>::cell_data,
    VtuFile::<D>::regions,
    VtuFile::<D>::write_by_all,
    VtuFile::<D>::grid
);

#[cfg(test)]
mod tests {
    use vtkio::model::{Attribute, CellType, DataSet, UnstructuredGridPiece, Vtk};

    use super::*;
    use crate::element::Lagrange;
    use crate::mesh;
    use crate::space::Space;

    fn grid(file: &VtuFile<'_, 2>) -> UnstructuredGridPiece {
        let mut text = vec![];
        file.grid().unwrap().write(file.threads, &mut text).unwrap();
        let vtk = Vtk::parse_xml(&text[..]).unwrap();
        let DataSet::UnstructuredGrid { mut pieces, .. } = vtk.data else { panic!("{:?}", vtk.data) };
        pieces.remove(0).into_loaded_piece_data(None).unwrap()
    }

    fn array(attribute: &Attribute) -> (String, usize, Vec<f64>) {
        let Attribute::DataArray(array) = attribute else { panic!("{attribute:?}") };
        (array.name.clone(), array.elem.num_comp() as usize, array.data.cast_into().unwrap())
    }

    #[test]
    fn arrays_come_back() {
        let mesh = mesh::annulus(1.0, 2.0, 1, 4, CellShape::Quadrilateral, 2).unwrap();
        let space = Space::tensor(&mesh, 2).unwrap();
        let tensor = Field::interpolate(&space, |x| [[x[0], x[1]], [3.0, 4.0]]).unwrap();
        let numbers: Vec<f64> = (0..4).map(f64::from).collect();
        let file = VtuFile::new(&mesh).point_data("σ", &tensor).unwrap();
        let file = file.point_values("x", 2, mesh.nodes().as_flattened()).unwrap();
        let grid = grid(&file.cell_data("number", 1, &numbers).unwrap());
        assert_eq!(grid.cells.types, vec![CellType::BiquadraticQuad; 4]);
        let (connectivity, _) = grid.cells.cell_verts.into_xml();
        assert_eq!(connectivity, mesh.cells().iter().map(|&n| u64::from(n)).collect::<Vec<_>>());
        let padded: Vec<f64> = mesh.nodes().iter().flat_map(|x| [x[0], x[1], 0.0]).collect();
        assert_eq!(grid.points.cast_into::<f64>().unwrap(), padded);
        let tensors: Vec<f64> =
            mesh.nodes().iter().flat_map(|x| [x[0], x[1], 0.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0]).collect();
        assert_eq!(array(&grid.data.point[0]), ("σ".into(), 9, tensors));
        assert_eq!(array(&grid.data.point[1]), ("x".into(), 3, padded));
        assert_eq!(array(&grid.data.cell[0]), ("number".into(), 1, numbers));
    }

    #[test]
    fn files_are_the_same_on_any_number_of_threads() {
        let mesh = mesh::rectangle([0.0, 0.0], [2.0, 1.0], [50, 40], CellShape::Quadrilateral, 2).unwrap();
        let field =
            Field::interpolate(&Space::tensor(&mesh, 1).unwrap(), |x| [[x[0], x[1]], [3.0, 4.0]]).unwrap();
        let text = |threads| {
            let file = VtuFile::new(&mesh).threads(Threads::new(threads)).point_data("σ", &field).unwrap();
            let mut text = vec![];
            file.grid().unwrap().write(file.threads, &mut text).unwrap();
            text
        };
        let on_one = text(1);
        assert!([2, 3, 7, 16].into_iter().all(|threads| text(threads) == on_one));
    }

    /// A field of degree 2 on a mesh of degree 1: x² at the mesh's nodes.
    #[test]
    fn fields_of_another_degree_are_evaluated() {
        let mesh = mesh::rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], CellShape::Triangle, 1).unwrap();
        let field = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), |x| x[0] * x[0]).unwrap();
        let file = VtuFile::new(&mesh).point_data("square", &field).unwrap();
        for (value, x) in array(&grid(&file).data.point[0]).2.iter().zip(mesh.nodes()) {
            assert!((value - x[0] * x[0]).abs() < 1e-14);
        }
        let other = mesh::rectangle([0.0, 0.0], [1.0, 1.0], [1, 1], CellShape::Triangle, 1).unwrap();
        assert!(matches!(VtuFile::new(&other).point_data("u", &field), Err(VtuError::OtherMesh { .. })));
    }

    /// A field that jumps between two cells, and a continuous one.
    #[test]
    fn discontinuous_fields_have_points_of_their_own() {
        let mesh = mesh::rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1).unwrap();
        let jump = Field::from_values(
            &Space::discontinuous_scalar(&mesh, 1).unwrap(),
            vec![1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0],
        );
        let constant =
            Field::from_values(&Space::discontinuous_vector(&mesh, 0).unwrap(), vec![1.0, 2.0, 3.0, 4.0]);
        let smooth = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), |x| x[0] + x[1]).unwrap();
        let file = VtuFile::new(&mesh).point_data("smooth", &smooth).unwrap();
        let file =
            file.point_data("jump", &jump.unwrap()).unwrap().point_data("constant", &constant.unwrap());
        let grid = grid(&file.unwrap());
        assert_eq!(grid.cells.cell_verts.into_xml().0, (0..8).collect::<Vec<u64>>());
        let points: Vec<f64> = grid.points.cast_into().unwrap();
        let (_, _, sums) = array(&grid.data.point[0]);
        for (x, sum) in points.chunks(3).zip(sums) {
            assert!((x[0] + x[1] - sum).abs() < 1e-14);
        }
        assert_eq!(array(&grid.data.point[1]).2, [1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0]);
        assert_eq!(array(&grid.data.cell[0]), ("constant".into(), 3, vec![1.0, 2.0, 0.0, 3.0, 4.0, 0.0]));
        let trace = Field::zero(&Space::on_facets(&mesh, "top", 1).unwrap());
        assert_eq!(
            VtuFile::new(&mesh).point_data("trace", &trace).unwrap_err().to_string(),
            "the field \"trace\" lives on the facets of \"top\" alone, and the file shows cells"
        );
    }

    /// VTK states the parametric coordinates of the face nodes: x = 0, x = 1, y = 0, y = 1, z = 0, z = 1.
    #[test]
    fn faces_of_hexahedra_stand_in_the_order_of_vtk() {
        let (_, order) = cell_type(CellShape::Hexahedron, 2);
        let points = Lagrange::new(CellShape::Hexahedron, 2).unwrap().node_points::<3>();
        let faces: Vec<[f64; 3]> = order[20..].iter().map(|&node| points[node]).collect();
        let expected = [
            [0.0, 0.5, 0.5],
            [1.0, 0.5, 0.5],
            [0.5, 0.0, 0.5],
            [0.5, 1.0, 0.5],
            [0.5, 0.5, 0.0],
            [0.5, 0.5, 1.0],
            [0.5, 0.5, 0.5],
        ];
        assert_eq!(faces, expected);
    }

    #[test]
    fn bad_data_are_named() {
        let mesh = mesh::rectangle([0.0, 0.0], [1.0, 1.0], [1, 1], CellShape::Quadrilateral, 1).unwrap();
        let error = VtuFile::new(&mesh).point_values("u", 2, &[0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(error.unwrap_err().to_string(), "value 1 of \"u\" is NaN");
        let file = VtuFile::new(&mesh);
        assert!(matches!(file.clone().cell_data("p", 1, &[]), Err(VtuError::Length { expected: 1, .. })));
        assert!(matches!(file.clone().cell_data("p", 0, &[]), Err(VtuError::Components { .. })));
        assert_eq!(
            file.clone().regions(&["all", "all"]).unwrap_err().to_string(),
            "the region \"all\" has no number of its own: cell 0 belongs to \"all\" too"
        );
        assert_eq!(
            file.clone().regions(&["steel"]).unwrap_err().to_string(),
            "the region \"steel\" has no number of its own: there is no cell region \"steel\"; the mesh has \"all\""
        );
        let twice = file.clone().cell_data("p", 1, &[0.0]).unwrap().cell_data("p", 1, &[0.0]);
        assert!(matches!(twice, Err(VtuError::Twice { .. })));
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml").join("mesh.vtu");
        assert!(file.write(&path).unwrap_err().to_string().contains("mesh.vtu"));
    }
}
