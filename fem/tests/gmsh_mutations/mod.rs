//! Meshes written in every encoding are read back; of 400,000 mutated files none makes the reader panic or think long, and
//! every mesh that it accepts is valid, as code that shares nothing with it finds.

mod independent;
pub mod mutate;
mod write;

use std::path::PathBuf;

use forms_fem::element::CellShape;
use forms_fem::mesh::gmsh::GmshMesh;
use forms_fem::mesh::{BOUNDARY, CellBlock, Facet, INTERIOR, Mesh, MeshError, cuboid, rectangle};
use write::Format;

/// With `FORMS_SWEEPS=1`; a tenth as a rule, and as many as `FORMS_MUTATIONS` says where it is set.
const MUTATIONS: u64 = 20_000;

pub fn plane(shape: CellShape, degree: usize) -> Result<Mesh<2>, MeshError> {
    let mut mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 2], shape, degree)?;
    mesh.name_cells("left part", |centre| centre[0] < 1.0)?;
    mesh.name_cells("right part", |centre| centre[0] > 1.0)?;
    mesh.name_interface("seam", "left part", "right part")?;
    Ok(mesh)
}

// The shapes of the blocks, each with the nodes of its cells.
fn blocks<const D: usize>(mesh: &Mesh<D>) -> Vec<(CellShape, Vec<u32>)> {
    let of_block = |block: &CellBlock| {
        (block.shape, block.cells.clone().flat_map(|cell| mesh.cell(cell)).copied().collect())
    };
    mesh.blocks().iter().map(of_block).collect()
}

// Quadrilaterals on the left, triangles on the right.
pub fn of_two_shapes(degree: usize) -> Result<Mesh<2>, MeshError> {
    let [triangles, squares] =
        [CellShape::Triangle, CellShape::Quadrilateral].map(|shape| plane(shape, degree).expect("a mesh"));
    let nodes = |mesh: &Mesh<2>, region: &str| -> Result<Vec<u32>, MeshError> {
        // Both grids have the same points.
        let number = |node: &u32| {
            let wanted = mesh.nodes()[*node as usize];
            squares.nodes().iter().position(|x| *x == wanted).expect("a node there") as u32
        };
        Ok(mesh.cell_region(region)?.iter().flat_map(|&cell| mesh.cell(cell as usize)).map(number).collect())
    };
    let left = (CellShape::Quadrilateral, nodes(&squares, "left part")?);
    let right = (CellShape::Triangle, nodes(&triangles, "right part")?);
    let all: Vec<u32> = left.1.iter().chain(&right.1).copied().collect();
    // A file's nodes that no cell uses are left out: the centres of squares that are triangles.
    let used: Vec<u32> = (0..squares.node_count() as u32).filter(|node| all.contains(node)).collect();
    let renumbered = |(shape, cells): (CellShape, Vec<u32>)| {
        let number = |node: u32| used.binary_search(&node).expect("it is used") as u32;
        (shape, cells.into_iter().map(number).collect())
    };
    let points = used.iter().map(|&node| squares.nodes()[node as usize]).collect();
    let mut mesh = Mesh::from_blocks(degree, points, vec![renumbered(left), renumbered(right)])?;
    mesh.name_cells("left part", |centre| centre[0] < 1.0)?;
    mesh.name_cells("upper part", |centre| centre[1] > 0.5)?;
    mesh.name_facets("top", BOUNDARY, |centre| centre[1] > 1.0 - 1e-9)?;
    mesh.name_interior_facets("seam", INTERIOR, |centre| (centre[0] - 1.0).abs() < 1e-9)?;
    Ok(mesh)
}

pub fn solid(shape: CellShape, degree: usize) -> Result<Mesh<3>, MeshError> {
    let mut mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1], shape, degree)?;
    mesh.name_cells("left part", |centre| centre[0] < 1.0)?;
    Ok(mesh)
}

// Facets by the positions of their vertices: numbers may change, places do not.
fn places<const D: usize>(mesh: &Mesh<D>, facets: impl Iterator<Item = Facet>) -> Vec<Vec<[u64; D]>> {
    let place = |facet: Facet| {
        let nodes = mesh.cell(facet.cell as usize);
        let vertices = mesh.cell_shape(facet.cell as usize).facet_vertices(facet.local.into()).iter();
        vertices.map(|&vertex| mesh.nodes()[nodes[vertex] as usize].map(f64::to_bits)).collect()
    };
    let mut all: Vec<Vec<[u64; D]>> = facets.map(place).collect();
    all.sort();
    all
}

fn check_round_trip<const D: usize>(mesh: &Mesh<D>) -> Result<(), Box<dyn std::error::Error>> {
    for format in Format::ALL {
        let bytes = write::write(mesh, format);
        let read = GmshMesh::<D>::from_bytes(&format!("{format:?}"), &bytes)?;
        assert_eq!(read.notes, []);
        let read = read.mesh;
        assert_eq!((read.nodes(), read.cells()), (mesh.nodes(), mesh.cells()), "{format:?}");
        assert_eq!(read.blocks(), mesh.blocks(), "{format:?}");
        assert!(read.cell_region_names().eq(mesh.cell_region_names()), "{format:?}");
        for name in mesh.cell_region_names() {
            assert_eq!(read.cell_region(name)?, mesh.cell_region(name)?, "{format:?} {name}");
        }
        assert!(read.facet_region_names().eq(mesh.facet_region_names()), "{format:?}");
        for name in mesh.facet_region_names() {
            assert_eq!(read.facet_region(name)?, mesh.facet_region(name)?, "{format:?} {name}");
        }
        for name in mesh.interior_facet_region_names() {
            // The first sides, from which the normals point.
            let first = |mesh: &Mesh<D>| -> Result<_, MeshError> {
                Ok(places(mesh, mesh.interior_facet_region(name)?.iter().map(|sides| sides[0])))
            };
            assert_eq!(first(&read)?, first(mesh)?, "{format:?} {name}");
        }
    }
    Ok(())
}

#[test]
fn meshes_come_back_in_every_encoding() -> Result<(), Box<dyn std::error::Error>> {
    for degree in 1..=2 {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            check_round_trip(&plane(shape, degree)?)?;
        }
        check_round_trip(&of_two_shapes(degree)?)?;
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            check_round_trip(&solid(shape, degree)?)?;
        }
    }
    Ok(())
}

// Small valid files: those that Gmsh wrote, and meshes of every shape and degree in every encoding.
fn corpus() -> Vec<Vec<u8>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "msh"))
        .collect();
    files.sort();
    assert!(files.len() >= 10);
    let mut corpus: Vec<Vec<u8>> =
        files.iter().map(|path| std::fs::read(path).expect("it can be read")).collect();
    for (index, format) in Format::ALL.into_iter().enumerate() {
        let degree = 1 + index % 2;
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            corpus.push(write::write(&plane(shape, degree).expect("a mesh"), format));
        }
        corpus.push(write::write(&of_two_shapes(degree).expect("a mesh"), format));
        let shape = [CellShape::Tetrahedron, CellShape::Hexahedron][index / 2 % 2];
        corpus.push(write::write(&solid(shape, 1).expect("a mesh"), format));
    }
    corpus
}

// What a mesh promises, checked again.
pub fn check_valid<const D: usize>(mesh: &Mesh<D>) {
    let again = Mesh::from_nonconforming_blocks(mesh.degree(), mesh.nodes().to_vec(), blocks(mesh));
    let again = again.unwrap_or_else(|error| panic!("an invalid mesh was accepted: {error}"));
    let ascending = |names: &[u32]| names.windows(2).all(|pair| pair[0] < pair[1]);
    for name in mesh.cell_region_names() {
        let cells = mesh.cell_region(name).expect("the name is listed");
        assert!(
            !cells.is_empty() && ascending(cells) && (cells[cells.len() - 1] as usize) < mesh.cell_count()
        );
    }
    for name in mesh.facet_region_names() {
        let facets = mesh.facet_region(name).expect("the name is listed");
        assert!(facets.iter().all(|facet| again.boundary_facets().binary_search(facet).is_ok()));
    }
    for name in mesh.interior_facet_region_names() {
        for [a, b] in mesh.interior_facet_region(name).expect("the name is listed") {
            let (first, second) = (*a.min(b), *a.max(b));
            assert!(again.interior_facets().binary_search(&[first, second]).is_ok());
        }
    }
    let mut used = vec![false; mesh.node_count()];
    mesh.cells().iter().for_each(|&node| used[node as usize] = true);
    assert!(used.iter().all(|&used| used), "a node that no cell uses");
    independent::check_unfolded(mesh);
}

// Whether the reader takes the file as a mesh in D dimensions.
fn survives<const D: usize>(bytes: &[u8]) -> bool {
    match GmshMesh::<D>::from_bytes("mutated.msh", bytes) {
        Ok(read) => {
            check_valid(&read.mesh);
            assert!(read.notes.iter().all(|note| !note.to_string().is_empty()));
            true
        }
        Err(error) => {
            assert!(error.to_string().starts_with("mutated.msh"), "{error}");
            false
        }
    }
}

#[test]
fn mutated_files_are_read_or_refused() {
    let corpus = corpus();
    for file in &corpus {
        assert!(survives::<2>(file) != survives::<3>(file), "the files of the corpus are good");
    }
    let count = mutate::count(MUTATIONS);
    let accepted = mutate::accepted(&corpus, count, |file| survives::<2>(file) | survives::<3>(file));
    // Some changes harm nothing, such as those of a digit of a coordinate, and most do.
    assert!(accepted > count / 100 && accepted < count / 2);
}
