//! VTK's files: what meshio and VTK wrote, compared with the meshes of Gmsh that they wrote them from; what we wrote ourselves;
//! a problem on a mesh that was read.

use std::path::Path;

use forms_fem::mesh::gmsh::GmshMesh;
use forms_fem::mesh::vtk::Note;
use forms_fem::mesh::{
    MeshError, PerforatedAnnulus, VtkError, VtkMesh, VtkReader, annulus, ball, cuboid, hollow_cylinder,
    rectangle,
};
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;

use crate::gmsh::{disk_of_parabolas, path, sums, volume};
use crate::gmsh_mutations::{of_two_shapes, plane, solid};

fn read<const D: usize>(reader: &VtkReader, name: &str) -> VtkMesh<D> {
    reader.read(path(name)).unwrap_or_else(|error| panic!("{error}"))
}

// The same cells and regions as in Gmsh's file; in text meshio writes 12 digits of XML, VTK 11.
fn check_beside_gmsh<const D: usize>(name: &str, gmsh: &str, reader: &VtkReader, names: &[&str]) {
    let (found, expected) = (read::<D>(reader, name), GmshMesh::<D>::read(path(gmsh)).unwrap().mesh);
    let found = found.mesh;
    assert_eq!((found.cells(), found.blocks()), (expected.cells(), expected.blocks()), "{name}");
    let tolerance = match name {
        "house_vtk_text.vtk" => 1e-10,
        "plate_meshio_text.vtu" => 1e-11,
        _ => 0.0,
    };
    for (x, y) in found.nodes().iter().zip(expected.nodes()) {
        assert!((0..D).all(|k| (x[k] - y[k]).abs() <= tolerance * (1.0 + y[k].abs())), "{name} {x:?} {y:?}");
    }
    for region in names {
        let ((count, a), (wanted, b)) = (sums(&found, region).unwrap(), sums(&expected, region).unwrap());
        assert_eq!(count, wanted, "{name} {region}");
        assert!((0..D).all(|k| (a[k] - b[k]).abs() <= tolerance * 100.0), "{name} {region} {a:?} {b:?}");
    }
}

#[test]
fn plates_of_meshio_are_those_of_gmsh() {
    let reader = VtkReader::new()
        .name_cells(10, "left part")
        .name_cells(11, "right part")
        .name_cells(12, "whole")
        .name_facets(1, "hole")
        .name_facets(2, "outer")
        .name_facets(3, "seam");
    let names = ["left part", "right part", "whole", "hole", "outer", "seam"];
    for name in ["text.vtu", "base64.vtu", "zlib.vtu", "42.vtk", "51.vtk"] {
        let name = format!("plate_meshio_{name}");
        check_beside_gmsh::<2>(&name, "plate_2.2.msh", &reader, &names);
        let plate = read::<2>(&VtkReader::new(), &name);
        let point = Note::GroupLeftOut { name: "number 1".into(), dimension: 0 };
        assert_eq!(plate.notes, [point], "{name}");
        let regions: Vec<&str> = plate.mesh.cell_region_names().collect();
        assert_eq!(regions, ["all", "region 10", "region 11", "region 12"]);
        assert_eq!(plate.mesh.facet_region("facets 2").unwrap().len(), 6);
        assert_eq!(plate.mesh.interior_facet_region("facets 3").unwrap().len(), 1);
        let physical = plate.cell_data.iter().find(|array| array.name == "gmsh:physical").unwrap();
        assert_eq!((physical.components, physical.values.len()), (1, plate.mesh.cell_count()));
        // If a cell occurs twice, the first one counts.
        assert!(physical.values.iter().all(|&number| number == 10.0 || number == 11.0));
    }
}

// VTK writes each cell of a group once, and of several groups of a cell meshio keeps one.
#[test]
fn what_vtk_wrote() {
    let reader = VtkReader::new();
    for name in ["house_vtk_raw.vtu", "house_vtk_base64.vtu", "house_vtk_text.vtk"] {
        check_beside_gmsh::<2>(name, "house_4.1.msh", &reader, &["all", "boundary"]);
        let house = read::<2>(&reader, name).mesh;
        assert_eq!(house.shapes(), [CellShape::Quadrilateral, CellShape::Triangle]);
        let area = 4.0 + disk_of_parabolas(1.0, 4, std::f64::consts::PI);
        assert!((volume(&house) - area).abs() < 1e-7, "{name} {}", volume(&house));
    }
    let box_and_front = reader.name_cells(1, "box").name_facets(2, "front");
    for name in ["hexahedra_vtk_big.vtu", "hexahedra_vtk_binary.vtk"] {
        check_beside_gmsh::<3>(name, "hexahedra_2.2.msh", &VtkReader::new(), &["all"]);
    }
    check_beside_gmsh::<3>(
        "tetrahedra_meshio_zlib.vtu",
        "tetrahedra_4.1.msh",
        &box_and_front,
        &["box", "front"],
    );
}

// VTK's own source of a cube of Lagrange cells: a wrong order of nodes folds cells.
#[test]
fn lagrange_cells_of_second_order() {
    let reader = VtkReader::new();
    for name in ["tetrahedra_vtk_lagrange.vtu", "hexahedra_vtk_lagrange.vtu"] {
        let cube = read::<3>(&reader, name).mesh;
        assert_eq!(cube.degree(), 2);
        assert!((volume(&cube) - 1.0).abs() < 1e-6, "{name} {}", volume(&cube));
        assert_eq!(cube.facet_region("boundary").unwrap().len() % 6, 0);
    }
    for name in ["triangles_vtk_lagrange.vtu", "quadrilaterals_vtk_lagrange.vtu"] {
        let square = read::<2>(&reader, name).mesh;
        assert_eq!(square.degree(), 2);
        assert!((volume(&square) - 1.0).abs() < 1e-6, "{name} {}", volume(&square));
    }
}

fn written_and_read<const D: usize>(
    file: &VtuFile<'_, D>,
    what: &str,
    read: impl Fn(&Path) -> Result<VtkMesh<D>, VtkError>,
) -> VtkMesh<D> {
    let path = std::env::temp_dir().join(format!("forms-fem {} {what}.vtu", std::process::id()));
    file.write(&path).unwrap();
    let found = read(&path);
    std::fs::remove_file(&path).unwrap();
    found.unwrap_or_else(|error| panic!("{what}: {error}"))
}

// Two regions by halves, an array of numbers and a field come back as they were.
fn check_round_trip<const D: usize>(what: &str, mesh: Result<Mesh<D>, MeshError>) {
    let mut mesh = mesh.unwrap_or_else(|error| panic!("{what}: {error}"));
    let count = mesh.cell_count() as u32;
    let halves: [Vec<u32>; 2] =
        [(0..count / 2).collect(), (count / 2 + u32::from(count > 2)..count).collect()];
    mesh.name_listed_cells("first half", &halves[0]).unwrap();
    mesh.name_listed_cells("second half", &halves[1]).unwrap();
    let numbers: Vec<f64> = (0..count).map(|cell| f64::from(cell).sqrt()).collect();
    let file = VtuFile::new(&mesh).regions(&["first half", "second half"]).unwrap();
    let file = file.cell_data("root", 1, &numbers).unwrap();
    let file = file.point_values("position", D, mesh.nodes().as_flattened()).unwrap();
    let reader = VtkReader::new().name_cells(1, "first half").name_cells(2, "second half");
    let found = written_and_read(&file, what, |path| reader.read::<D>(path));
    assert_eq!(found.notes, [], "{what}");
    assert_eq!((found.mesh.nodes(), found.mesh.cells()), (mesh.nodes(), mesh.cells()), "{what}");
    assert_eq!((found.mesh.blocks(), found.mesh.degree()), (mesh.blocks(), mesh.degree()), "{what}");
    for region in ["first half", "second half"] {
        assert_eq!(found.mesh.cell_region(region), mesh.cell_region(region), "{what}");
    }
    let root = found.cell_data.iter().find(|array| array.name == "root").unwrap();
    assert_eq!((root.components, &root.values), (1, &numbers), "{what}");
    let position = &found.point_data[0];
    assert_eq!((position.name.as_str(), position.components), ("position", 3), "{what}");
    for (written, node) in position.values.chunks(3).zip(mesh.nodes()) {
        assert_eq!(&written[..D], node, "{what}");
    }
}

#[test]
fn meshes_of_all_generators_come_back() {
    let pi = std::f64::consts::PI;
    for degree in 1..=2 {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            check_round_trip("rectangle", rectangle([0.0; 2], [2.0, 1.0], [3, 2], shape, degree));
            check_round_trip("annulus", annulus(1.0, 2.0, 2, 8, shape, degree));
            check_round_trip("plane", plane(shape, degree));
            let bent = |x: [f64; 2]| [x[0] + 0.1 * (pi * x[1]).sin(), x[1] + 0.05 * x[0]];
            check_round_trip("structured", forms_fem::mesh::structured([3, 2], shape, degree, bent));
        }
        check_round_trip("two shapes", of_two_shapes(degree));
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            check_round_trip("cuboid", cuboid([0.0; 3], [1.0, 2.0, 1.0], [2, 2, 1], shape, degree));
            check_round_trip("cylinder", hollow_cylinder(1.0, 2.0, 1.0, [1, 6, 1], shape, degree));
            check_round_trip("ball", ball(1.0, [false, true, true], 2, 1, shape, degree));
            check_round_trip("solid", solid(shape, degree));
        }
    }
    let ring = PerforatedAnnulus {
        inner_radius: 1.0,
        outer_radius: 2.0,
        rows: 1,
        holes_around: 6,
        hole_radius: 0.2,
        cells_per_side: 1,
        layers: 1,
        shape: CellShape::Quadrilateral,
        degree: 2,
    };
    check_round_trip("perforated annulus", ring.mesh());
}

// The points of each cell by themselves are joined again, and told of if they are not.
#[test]
fn points_of_fields_that_jump_are_joined() {
    let mesh = rectangle([-1.0, 0.0], [1.0, 1.0], [2, 1], CellShape::Quadrilateral, 2).unwrap();
    let jump = Field::zero(&Space::discontinuous_scalar(&mesh, 1).unwrap());
    let file = VtuFile::new(&mesh).point_data("jump", &jump).unwrap();
    let apart = written_and_read(&file, "apart", |path| VtkReader::new().read::<2>(path));
    assert_eq!((apart.mesh.node_count(), apart.mesh.interior_facets().len()), (18, 0));
    assert_eq!(
        apart.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        [
            "the mesh has cracks: facets of cell 0 and cell 1 coincide and are not shared; pairs of such facets: 1",
            "3 points stand where another one does, as point 9 where point 1 does, and cells do not share them"
        ]
    );
    let joined = written_and_read(&file, "joined", |path| VtkReader::new().join_points().read::<2>(path));
    assert_eq!((joined.mesh.node_count(), joined.mesh.interior_facets().len()), (15, 1));
    assert!((volume(&joined.mesh) - 2.0).abs() < 1e-15);
}

#[forms(dimension = 2)]
mod problems {
    #[cells]
    pub struct Omega;

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) + div(u) * div(v))
    }
}

#[test]
fn linear_displacements_are_exact_on_what_was_read() {
    let exact = |x: &[f64; 2]| [0.1 + 0.3 * x[0] - 0.2 * x[1], 0.05 * x[0] + 0.4 * x[1] - 0.3];
    for name in ["house_vtk_raw.vtu", "plate_meshio_zlib.vtu", "plate_meshio_51.vtk"] {
        let mesh = Mesh::<2>::read_vtk(path(name)).unwrap();
        let (assembler, space) = (Assembler::new(&mesh), Space::vector(&mesh, 2).unwrap());
        let form = problems::elasticity(&problems::Omega::on("all"));
        let mut constraints = Constraints::new(&space);
        constraints.fix("boundary", exact).unwrap();
        let problem = Problem::new(&form, &space).assembler(&assembler);
        let u = problem.constrained(&constraints).solve().unwrap().into_field();
        for (node, x) in space.positions().iter().enumerate() {
            for (found, expected) in u.at_node(node).iter().zip(exact(x)) {
                assert!((found - expected).abs() < 1e-12, "{name} at {x:?}: {found} not {expected}");
            }
        }
    }
}
