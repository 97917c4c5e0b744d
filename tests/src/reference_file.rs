//! The reader of the reference files (`tests/scikit_fem/README.md`): rebuilds their problem, compares entry by
//! entry, and insists that everything in a file is compared.

mod family;
mod format;

use std::collections::BTreeMap;

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;
use nalgebra::DMatrix;
use serde_json::Value;

use crate::dense::{assert_close, assert_same_matrix, dense};
pub use family::{Family, names};
pub use format::ReferenceFile;
use format::{FacetPoints, Triplets};

/// Largest deviation from a reference, relative to the largest entry of the matrix or vector.
pub const TOLERANCE: f64 = 1e-12;

/// The problem of a file, rebuilt, and what is still to be compared.
pub struct Reference<const D: usize> {
    /// For messages.
    pub name: String,
    /// With the file's quadrature.
    pub assembler: Assembler<D>,
    /// The file's space, in this project's numbering.
    pub space: Arc<Space<D>>,
    /// The file's numbers h_T of the contact facets.
    pub contact_diameters: Vec<(Facet, f64)>,
    /// The file's facet rule: coordinates on \[0, 1\].
    pub facet_points: Vec<[f64; 2]>,
    /// The largest deviation found so far.
    pub largest_deviation: f64,
    data: BTreeMap<String, Value>,
    u: Option<Vec<f64>>,
    second_space: Option<Arc<Space<D>>>,
    second_u: Vec<f64>,
    /// Unknown of the file → unknown here; those of the second space follow.
    number: Vec<usize>,
    matrices: BTreeMap<String, Triplets>,
    vectors: BTreeMap<String, Vec<f64>>,
    numbers: BTreeMap<String, f64>,
}

/// Facet region of the file's contact facets.
pub const CONTACT: &str = "contact";
/// Facet region where the file's criterion acts.
pub const CRITERION: &str = "criterion";

impl<const D: usize> Reference<D> {
    /// Rebuilds the mesh, the space and the quadrature of a file.
    pub fn new(file: ReferenceFile) -> Self {
        let name = file.name;
        assert_eq!(file.dimension, D, "{name}");
        let shape = CellShape::ALL.into_iter().find(|shape| shape.name() == file.shape);
        let shape = shape.unwrap_or_else(|| panic!("{name}: shape {}", file.shape));
        let nodes = file.nodes.iter().map(|node| point(node)).collect();
        let cells = file.cells.concat();
        let mut mesh = Mesh::from_parts(shape, file.geometry_degree, nodes, cells)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let facet = |&(cell, local): &(u32, u8)| Facet { cell, local };
        let contact: Vec<Facet> = file.contact_facets.iter().map(facet).collect();
        let criterion: Vec<Facet> = file.criterion_facets.iter().map(facet).collect();
        for (region, facets) in [(CONTACT, &contact), (CRITERION, &criterion)] {
            if !facets.is_empty() {
                let named = mesh.name_listed_facets(region, facets);
                named.unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
        let discontinuous = file.space_cells.is_some();
        let space = space_on(&name, &mesh, file.space_degree, file.components, discontinuous);
        let mut number = match_nodes(&name, &space, &file.space_nodes, file.space_cells.as_deref());
        let (mut second_space, mut second_u) = (None, Vec::new());
        if let Some(second) = file.second_space {
            let space = space_on(&name, &mesh, second.space_degree, second.components, false);
            let first = number.len();
            number.extend(match_nodes(&name, &space, &second.space_nodes, None).iter().map(|k| first + k));
            (second_space, second_u) = (Some(space), second.u);
        }
        let cell = QuadratureRule {
            points: file.cell_quadrature.points.iter().map(|node| point(node)).collect(),
            weights: file.cell_quadrature.weights,
        };
        // Where a file has no facet rule, an integral over facets would be an error.
        let facet =
            file.facet_quadrature.map_or(QuadratureRule { points: vec![], weights: vec![] }, |rule| {
                let points = match rule.points {
                    FacetPoints::Segment(points) => points.into_iter().map(|s| [s, 0.0]).collect(),
                    FacetPoints::Triangle(points) => points,
                };
                QuadratureRule { points, weights: rule.weights }
            });
        assert_eq!(facet.points.len(), facet.weights.len(), "{name}");
        let facet_points = facet.points.clone();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Explicit { cell, facet });
        assert_eq!(contact.len(), file.contact_diameters.len(), "{name}");
        Reference {
            assembler,
            contact_diameters: contact.into_iter().zip(file.contact_diameters).collect(),
            facet_points,
            largest_deviation: 0.0,
            data: file.data,
            u: file.u,
            second_u,
            number,
            matrices: file.matrices,
            vectors: file.vectors,
            numbers: file.numbers,
            space,
            second_space,
            name,
        }
    }

    /// A constant of the file's form.
    pub fn number(&self, name: &str) -> f64 {
        self.data[name].as_f64().unwrap_or_else(|| panic!("{}: {name}", self.name))
    }

    /// A constant vector of the file's form.
    pub fn vector(&self, name: &str) -> [f64; D] {
        std::array::from_fn(|k| {
            self.data[name][k].as_f64().unwrap_or_else(|| panic!("{}: {name}", self.name))
        })
    }

    /// A constant tensor of rank 4 of the file's form.
    pub fn tensor4(&self, name: &str) -> [[[[f64; D]; D]; D]; D] {
        let at = |i: usize, j: usize, k: usize, l: usize| {
            let entry = self.data[name][i][j][k][l].as_f64();
            entry.unwrap_or_else(|| panic!("{}: {name}", self.name))
        };
        use std::array::from_fn;
        from_fn(|i| from_fn(|j| from_fn(|k| from_fn(|l| at(i, j, k, l)))))
    }

    /// The file's state u.
    pub fn u(&self) -> Field<D> {
        let theirs = self.u.as_ref().unwrap_or_else(|| panic!("{}: u", self.name));
        self.field(&self.space, theirs, 0)
    }

    /// The space of the second unknown and the file's state of it.
    pub fn second(&self) -> (Arc<Space<D>>, Field<D>) {
        let space = self.second_space.clone().unwrap_or_else(|| panic!("{}: one space only", self.name));
        let field = self.field(&space, &self.second_u, self.space.unknowns());
        (space, field)
    }

    fn field(&self, space: &Arc<Space<D>>, theirs: &[f64], first: usize) -> Field<D> {
        assert_eq!(theirs.len(), space.unknowns(), "{}: u", self.name);
        let mut values = vec![0.0; theirs.len()];
        for (value, number) in theirs.iter().zip(&self.number[first..]) {
            values[*number - first] = *value;
        }
        Field::from_values(space, values).unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    /// Compares a matrix, also where only one side stores an entry.
    pub fn compare_matrix(&mut self, name: &str, ours: &CsrMatrix) {
        let theirs = self.matrices.get(name).unwrap_or_else(|| panic!("{}: no matrix {name}", self.name));
        let label = format!("{}: {name}", self.name);
        let size = self.number.len();
        assert_eq!((theirs.rows, theirs.columns), (size, size), "{label}");
        assert!(
            theirs.row.len() == theirs.value.len() && theirs.column.len() == theirs.value.len(),
            "{label}"
        );
        let mut all = DMatrix::zeros(size, size);
        let mut seen = std::collections::BTreeSet::new();
        for ((row, column), value) in theirs.row.iter().zip(&theirs.column).zip(&theirs.value) {
            assert!(seen.insert((row, column)), "{label}: entry ({row}, {column}) stands twice");
            all[(self.number[*row], self.number[*column])] = *value;
        }
        let found = assert_same_matrix(&label, &dense(ours), &all, TOLERANCE);
        self.record(&label, found);
        self.matrices.remove(name);
    }

    /// Compares a vector.
    pub fn compare_vector(&mut self, name: &str, ours: &[f64]) {
        let label = format!("{}: {name}", self.name);
        let theirs = self.vectors.get(name).unwrap_or_else(|| panic!("{label}: no such vector"));
        let ours: Vec<f64> = self.number.iter().map(|number| ours[*number]).collect();
        let found = assert_close(&label, &ours, theirs, TOLERANCE);
        self.record(&label, found);
        self.vectors.remove(name);
    }

    /// Compares a number.
    pub fn compare_number(&mut self, name: &str, ours: f64) {
        let label = format!("{}: {name}", self.name);
        let theirs = *self.numbers.get(name).unwrap_or_else(|| panic!("{label}: no such number"));
        let found = assert_close(&label, &[ours], &[theirs], TOLERANCE);
        self.record(&label, found);
        self.numbers.remove(name);
    }

    fn record(&mut self, label: &str, deviation: f64) {
        println!("{label} {deviation:.1e}");
        self.largest_deviation = self.largest_deviation.max(deviation);
    }

    /// Asserts that everything in the file was compared; gives the largest deviation.
    pub fn finish(self) -> f64 {
        let left: Vec<&String> =
            self.matrices.keys().chain(self.vectors.keys()).chain(self.numbers.keys()).collect();
        assert!(left.is_empty(), "{}: not compared: {left:?}", self.name);
        self.largest_deviation
    }
}

fn point<const D: usize>(coordinates: &[f64]) -> [f64; D] {
    coordinates.try_into().unwrap_or_else(|_| panic!("{coordinates:?} has not {D} coordinates"))
}

fn space_on<const D: usize>(
    name: &str,
    mesh: &Mesh<D>,
    degree: usize,
    components: usize,
    discontinuous: bool,
) -> Arc<Space<D>> {
    let space = match (components, discontinuous) {
        (1, false) => Space::scalar(mesh, degree),
        (1, true) => Space::discontinuous_scalar(mesh, degree),
        _ => {
            assert_eq!((components, discontinuous), (D, false), "{name}");
            Space::vector(mesh, degree)
        }
    };
    space.unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The number here of each unknown of the file, by the positions of the nodes; where several share a position,
/// by their cells (which are numbered as in the file).
fn match_nodes<const D: usize>(
    name: &str,
    space: &Space<D>,
    theirs: &[Vec<f64>],
    cells: Option<&[usize]>,
) -> Vec<usize> {
    let components = space.components();
    assert_eq!(theirs.len(), space.node_count(), "{name}: number of nodes");
    let extent = theirs.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let all: Vec<u32> = (0..space.node_count() as u32).collect();
    let mut taken = vec![false; theirs.len()];
    let mut number = Vec::with_capacity(theirs.len() * components);
    for (index, node) in theirs.iter().enumerate() {
        let near = |own: &&u32| {
            let x = &space.positions()[**own as usize];
            x.iter().zip(node).all(|(a, b)| (a - b).abs() < 1e-10 * extent)
        };
        let candidates = cells.map_or(&all[..], |cells| space.cell_nodes(cells[index]));
        let found = candidates.iter().find(near);
        let found = *found.unwrap_or_else(|| panic!("{name}: no node at {node:?}")) as usize;
        assert!(!std::mem::replace(&mut taken[found], true), "{name}: two nodes at {node:?}");
        number.extend((0..components).map(|component| found * components + component));
    }
    number
}
