//! Gmsh's files: what Gmsh wrote, compared with what meshio reads in it; the orders of nodes; mistakes by their messages.

use std::path::PathBuf;

use forms_fem::element::{CellShape, Lagrange};
use forms_fem::mesh::gmsh::{GmshMesh, Note};
use forms_fem::mesh::{Facet, Mesh, MeshError};
use forms_fem::quadrature::cell_rule;

pub fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name)
}

// Number of members, and sum of the coordinates of their vertices.
pub fn sums<const D: usize>(mesh: &Mesh<D>, region: &str) -> Result<(usize, [f64; 3]), MeshError> {
    let shape = |cell: u32| mesh.cell_shape(cell as usize);
    let mut total = [0.0; 3];
    let mut add = |cell: usize, vertices: &mut dyn Iterator<Item = usize>| {
        for vertex in vertices {
            let node = mesh.nodes()[mesh.cell(cell)[vertex] as usize];
            for k in 0..D {
                total[k] += node[k];
            }
        }
    };
    if let Ok(cells) = mesh.cell_region(region) {
        cells.iter().for_each(|&cell| add(cell as usize, &mut (0..shape(cell).vertices())));
        return Ok((cells.len(), total));
    }
    let facets: Vec<Facet> = match mesh.facet_region(region) {
        Ok(facets) => facets.to_vec(),
        Err(_) => mesh.interior_facet_region(region)?.iter().map(|sides| sides[0]).collect(),
    };
    for facet in &facets {
        let mut vertices = shape(facet.cell).facet_vertices(facet.local.into()).iter().copied();
        add(facet.cell as usize, &mut vertices);
    }
    Ok((facets.len(), total))
}

fn check_file<const D: usize>(name: &str, expected: &[(&str, usize, [f64; 3])]) {
    let mesh = Mesh::<D>::read_gmsh(path(&format!("{name}.msh"))).unwrap_or_else(|error| panic!("{error}"));
    for (region, count, total) in expected {
        let (found, sum) = sums(&mesh, region).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(found, *count, "{name} {region}");
        for k in 0..3 {
            // The page of expectations has 12 digits.
            assert!((sum[k] - total[k]).abs() <= 1e-11 * total[k].abs(), "{name} {region} {sum:?}");
        }
    }
}

#[test]
fn regions_as_meshio_reads_them() {
    let text = std::fs::read_to_string(path("expected.txt")).unwrap();
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
    let mut files = 0;
    for lines in lines.chunk_by(|a, b| a[0] == b[0]) {
        let expected: Vec<_> = lines
            .iter()
            .map(|line| {
                let sum = [3, 4, 5].map(|k: usize| line[k].parse::<f64>().unwrap());
                (line[1], line[2].parse().unwrap(), sum)
            })
            .collect();
        match lines[0][0] {
            name if ["plate", "quarter", "house"].iter().any(|plane| name.starts_with(plane)) => {
                check_file::<2>(name, &expected);
            }
            name => check_file::<3>(name, &expected),
        }
        files += 1;
    }
    assert_eq!(files, 12);
}

// The straight map of the vertices at the reference coordinates of each node.
fn straight<const D: usize>(mesh: &Mesh<D>, cell: usize) -> Vec<[f64; D]> {
    let linear = Lagrange { shape: mesh.cell_shape(cell), degree: 1 };
    let tables = linear.tabulate(&mesh.cell_element(cell).node_points::<D>());
    let vertices = &mesh.cell(cell)[..tables.nodes];
    let position = |values: &[f64]| {
        let nodes = vertices.iter().zip(values).map(|(&node, value)| (mesh.nodes()[node as usize], value));
        nodes.fold([0.0; D], |sum, (x, value)| std::array::from_fn(|k| sum[k] + value * x[k]))
    };
    tables.value.chunks(tables.nodes).map(position).collect()
}

fn largest_bend<const D: usize>(mesh: &Mesh<D>) -> f64 {
    let mut largest = 0.0_f64;
    for cell in 0..mesh.cell_count() {
        for (&node, straight) in mesh.cell(cell).iter().zip(straight(mesh, cell)) {
            let node = mesh.nodes()[node as usize];
            largest = (0..D).map(|k| (node[k] - straight[k]).abs()).fold(largest, f64::max);
        }
    }
    largest
}

// On cells with straight edges every node is where the geometry map has it.
#[test]
fn nodes_stand_in_our_order() {
    for (name, cells) in [("hexahedra_2.2.msh", 2), ("tetrahedra_4.1.msh", 12)] {
        let mesh = Mesh::<3>::read_gmsh(path(name)).unwrap();
        assert_eq!((mesh.cell_count(), mesh.degree()), (cells, 2));
        // Gmsh places nodes on curves to about 1e-12 of their length.
        assert!(largest_bend(&mesh) < 1e-11, "{name}: {}", largest_bend(&mesh));
        // The base is a general quadrilateral, extruded by (0.5, 0.25, 1).
        assert!((volume(&mesh) - 2.25).abs() < 1e-11, "{}", volume(&mesh));
    }
    let plate = Mesh::<2>::read_gmsh(path("plate_4.1_binary.msh")).unwrap();
    for &cell in plate.cell_region("right part").unwrap() {
        for (&node, straight) in plate.cell(cell as usize).iter().zip(straight(&plate, cell as usize)) {
            let node = plate.nodes()[node as usize];
            assert!((node[0] - straight[0]).abs() < 1e-15 && (node[1] - straight[1]).abs() < 1e-15);
        }
    }
    // Quadrilaterals: one step in angle and radius; the arcs' midpoints are off their chords.
    let quarter = Mesh::<2>::read_gmsh(path("quarter_4.1.msh")).unwrap();
    assert_eq!((quarter.cell_shape(0), quarter.degree()), (CellShape::Quadrilateral, 2));
    let sagitta = 2.0 * (1.0 - (std::f64::consts::PI / 8.0).cos());
    assert!(largest_bend(&quarter) < sagitta + 1e-9);
}

pub fn volume<const D: usize>(mesh: &Mesh<D>) -> f64 {
    let cell = |cell| -> f64 {
        let rule = cell_rule::<D>(mesh.cell_shape(cell), 8).unwrap();
        let points = rule.points.iter().zip(&rule.weights);
        points.map(|(point, weight)| weight * determinant(&mesh.map(cell, point).1)).sum()
    };
    (0..mesh.cell_count()).map(cell).sum()
}

fn determinant<const D: usize>(a: &[[f64; D]; D]) -> f64 {
    if D == 2 {
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    }
    (0..3)
        .map(|k| a[0][k] * (a[1][(k + 1) % 3] * a[2][(k + 2) % 3] - a[1][(k + 2) % 3] * a[2][(k + 1) % 3]))
        .sum()
}

// Arcs become parabolas through their ends and midpoints: a triangle to the centre, and 2/3 of chord times sagitta.
pub fn disk_of_parabolas(radius: f64, arcs: usize, angle: f64) -> f64 {
    let half = 0.5 * angle / arcs as f64;
    let (sine, cosine) = half.sin_cos();
    radius * radius * arcs as f64 * (sine * cosine + 4.0 / 3.0 * sine * (1.0 - cosine))
}

#[test]
fn curved_cells_have_the_volume_of_their_parabolas() {
    let ring = |arcs| {
        let right_angle = std::f64::consts::FRAC_PI_2;
        disk_of_parabolas(2.0, arcs, right_angle) - disk_of_parabolas(1.0, arcs, right_angle)
    };
    // Gmsh places nodes on curves to about 1e-8 of their length.
    let quarter = Mesh::<2>::read_gmsh(path("quarter_4.1.msh")).unwrap();
    assert!((volume(&quarter) - ring(2)).abs() < 1e-7, "{} {}", volume(&quarter), ring(2));
    let cylinder = Mesh::<3>::read_gmsh(path("cylinder_4.1_binary.msh")).unwrap();
    assert_eq!((cylinder.cell_shape(0), cylinder.degree()), (CellShape::Hexahedron, 2));
    assert!((volume(&cylinder) - ring(1)).abs() < 1e-7, "{} {}", volume(&cylinder), ring(1));
    for name in ["ball_2.2_binary.msh", "ball_4.1.msh"] {
        let ball = Mesh::<3>::read_gmsh(path(name)).unwrap();
        assert_eq!((ball.cell_shape(0), ball.degree()), (CellShape::Tetrahedron, 2));
        for facet in ball.facet_region("sphere").unwrap() {
            for node in ball.cell_element(facet.cell as usize).facet_nodes(facet.local.into()) {
                let x = ball.nodes()[ball.cell(facet.cell as usize)[node] as usize];
                assert!((x[0].hypot(x[1]).hypot(x[2]) - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn the_plate_is_the_same_in_every_format() {
    let read = |name: &str| GmshMesh::<2>::read(path(name)).unwrap_or_else(|error| panic!("{error}"));
    let first = read("plate_2.2.msh");
    for name in ["plate_4.1_binary.msh", "plate_partitioned_2.2.msh", "plate_partitioned_4.1.msh"] {
        let other = read(name);
        let (a, b) = (&first.mesh, &other.mesh);
        assert_eq!((a.cell_count(), a.node_count()), (b.cell_count(), b.node_count()), "{name}");
        assert!((volume(a) - volume(b)).abs() < 1e-14);
        let partitions = b.cell_region_names().filter(|name| name.starts_with("partition "));
        let partitions: Vec<usize> = partitions.map(|name| b.cell_region(name).unwrap().len()).collect();
        if name.contains("partitioned") {
            assert_eq!((partitions.len(), partitions.iter().sum()), (3, b.cell_count()), "{name}");
        } else {
            assert!(partitions.is_empty());
        }
        let point = Note::GroupLeftOut { name: "corner".into(), dimension: 0 };
        assert_eq!(other.notes, [point], "{name}");
    }
    // The curve between the two parts runs upward: what is inside is to its left.
    let [[inside, outside]] = first.mesh.interior_facet_region("seam").unwrap() else { panic!("one facet") };
    assert!(first.mesh.cell_region("left part").unwrap().contains(&inside.cell));
    assert!(first.mesh.cell_region("right part").unwrap().contains(&outside.cell));
}

#[test]
fn triangles_beside_quadrilaterals() {
    let read = |name: &str| GmshMesh::<2>::read(path(name)).unwrap_or_else(|error| panic!("{error}"));
    let (first, second) = (read("house_2.2_binary.msh"), read("house_4.1.msh"));
    // The files list the surfaces in different orders; the shape that comes first is the first block.
    assert_eq!(first.mesh.shapes(), [CellShape::Triangle, CellShape::Quadrilateral]);
    assert_eq!(second.mesh.shapes(), [CellShape::Quadrilateral, CellShape::Triangle]);
    assert_eq!((first.mesh.node_count(), first.mesh.degree()), (second.mesh.node_count(), 2));
    for GmshMesh { mesh, notes } in [first, second] {
        assert_eq!(notes, []);
        let of_shape = |wanted: CellShape| -> Vec<u32> {
            (0..mesh.cell_count())
                .filter(|cell| mesh.cell_shape(*cell) == wanted)
                .map(|cell| cell as u32)
                .collect()
        };
        assert_eq!(mesh.cell_region("roof").unwrap(), of_shape(CellShape::Triangle));
        assert_eq!(mesh.cell_region("walls").unwrap(), of_shape(CellShape::Quadrilateral));
        assert_eq!(mesh.cell_region("house").unwrap().len(), mesh.cell_count());
        // A square of width 2, and half a disk of four parabolas.
        let area = 4.0 + disk_of_parabolas(1.0, 4, std::f64::consts::PI);
        assert!((volume(&mesh) - area).abs() < 1e-7, "{}", volume(&mesh));
        for sides in mesh.interior_facet_region("ceiling").unwrap() {
            let shapes = sides.map(|facet| mesh.cell_shape(facet.cell as usize));
            assert!(shapes.contains(&CellShape::Triangle) && shapes.contains(&CellShape::Quadrilateral));
        }
    }
}

#[test]
fn groups_without_names_and_unused_nodes() {
    let read = GmshMesh::<2>::read(path("quarter_4.1.msh")).unwrap();
    let mesh = &read.mesh;
    assert_eq!(mesh.cell_region_names().collect::<Vec<_>>(), ["all", "physical surface 1"]);
    assert_eq!(mesh.facet_region_names().collect::<Vec<_>>(), ["boundary", "physical curve 1"]);
    assert_eq!(mesh.facet_region("physical curve 1").unwrap().len(), 2);
}
