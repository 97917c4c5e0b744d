//! Files with quadrilaterals of 8 nodes and hexahedra of 20: read as meshes of 9 and 27, with the same map.

use std::fmt::Write;

use forms_fem::element::Element;
use forms_fem::prelude::*;

use crate::shared::*;

/// The places of Gmsh's nodes among ours.
const GMSH: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14];

/// The map of a cell by the serendipity element, from its nodes at vertices and edges.
fn map<const D: usize>(element: &Element, nodes: &[[f64; D]], point: &[f64; D]) -> [f64; D] {
    let mut value = vec![0.0; element.nodes()];
    element.evaluate_values(point, &mut value);
    std::array::from_fn(|k| value.iter().zip(nodes).map(|(phi, x)| phi * x[k]).sum())
}

/// The points of a mesh as lines with three coordinates, and the nodes at vertices and edges of each cell.
fn listed<const D: usize>(mesh: &Mesh<D>, per_cell: usize) -> (Vec<String>, Vec<Vec<u32>>) {
    let line = |x: &[f64; D]| format!("{:e} {:e} {:e}", x[0], x[1], if D == 3 { x[2] } else { 0.0 });
    let cells = (0..mesh.cell_count()).map(|cell| mesh.cell(cell)[..per_cell].to_vec());
    (mesh.nodes().iter().map(line).collect(), cells.collect())
}

fn vtk<const D: usize>(mesh: &Mesh<D>, code: usize, per_cell: usize) -> String {
    let (points, cells) = listed(mesh, per_cell);
    let mut text = String::from("# vtk DataFile Version 3.0\ncells\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    writeln!(text, "POINTS {} double\n{}", points.len(), points.join("\n")).unwrap();
    writeln!(text, "CELLS {} {}", cells.len(), cells.len() * (per_cell + 1)).unwrap();
    for cell in &cells {
        let nodes: Vec<String> = cell.iter().map(u32::to_string).collect();
        writeln!(text, "{per_cell} {}", nodes.join(" ")).unwrap();
    }
    writeln!(text, "CELL_TYPES {}\n{}", cells.len(), vec![code.to_string(); cells.len()].join(" ")).unwrap();
    // A function of degree 1 at the points.
    writeln!(text, "POINT_DATA {}\nSCALARS t double 1\nLOOKUP_TABLE default", points.len()).unwrap();
    mesh.nodes().iter().for_each(|x| writeln!(text, "{:e}", 1.0 + x[0] - 2.0 * x[1]).unwrap());
    text
}

fn gmsh<const D: usize>(mesh: &Mesh<D>, code: usize, per_cell: usize) -> String {
    let (points, cells) = listed(mesh, per_cell);
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n");
    writeln!(text, "{}", points.len()).unwrap();
    points.iter().enumerate().for_each(|(k, point)| writeln!(text, "{} {point}", k + 1).unwrap());
    writeln!(text, "$EndNodes\n$Elements\n{}", cells.len()).unwrap();
    for (number, cell) in cells.iter().enumerate() {
        let place = |k: usize| if per_cell == 20 { cell[GMSH[k]] } else { cell[k] };
        let nodes: Vec<String> = (0..per_cell).map(|k| (place(k) + 1).to_string()).collect();
        writeln!(text, "{} {code} 2 1 1 {}", number + 1, nodes.join(" ")).unwrap();
    }
    text.push_str("$EndElements\n");
    text
}

fn check<const D: usize>(written: &Mesh<D>, read: &Mesh<D>) {
    let shape = written.cell_shape(0);
    let element = Elements::Serendipity.on(shape).unwrap();
    assert_eq!((read.cell_count(), read.degree(), read.cell_shape(0)), (written.cell_count(), 2, shape));
    assert_eq!(read.cell(0).len(), if D == 2 { 9 } else { 27 });
    assert_eq!(read.interior_facets().len(), written.interior_facets().len());
    for cell in 0..read.cell_count() {
        let nodes: Vec<[f64; D]> =
            written.cell(cell).iter().map(|node| written.nodes()[*node as usize]).collect();
        for point in [[0.3, 0.8, 0.1], [0.5, 0.5, 0.5], [0.9, 0.2, 0.6]] {
            let point = std::array::from_fn(|k| point[k]);
            let (expected, (found, _)) =
                (map(&element, &nodes[..element.nodes()], &point), read.map(cell, &point));
            assert!((0..D).all(|k| (expected[k] - found[k]).abs() < 1e-14), "{expected:?} {found:?}");
        }
    }
}

#[test]
fn cells_are_completed_without_a_change_of_their_map() -> Outcome {
    let plane = distorted(3, CellShape::Quadrilateral, 2);
    let solid = distorted_cube(2, CellShape::Hexahedron, 2);
    let reader = forms_fem::mesh::VtkReader::new();
    let of_plane = reader.from_bytes::<2>("plane.vtk", vtk(&plane, 23, 8).as_bytes())?;
    check(&plane, &of_plane.mesh);
    let of_solid = reader.from_bytes::<3>("solid.vtk", vtk(&solid, 25, 20).as_bytes())?;
    check(&solid, &of_solid.mesh);
    // Data at points have values at the nodes that were added; degree 1 is kept.
    let values = &of_solid.point_data[0].values;
    assert_eq!(values.len(), of_solid.mesh.node_count());
    for (x, value) in of_solid.mesh.nodes().iter().zip(values) {
        assert!((value - (1.0 + x[0] - 2.0 * x[1])).abs() < 1e-14);
    }
    let file = tempfile::tempdir()?;
    let path = file.path().join("cells.msh");
    std::fs::write(&path, gmsh(&plane, 16, 8))?;
    check(&plane, &Mesh::<2>::read_gmsh(&path)?);
    std::fs::write(&path, gmsh(&solid, 17, 20))?;
    let of_solid = Mesh::<3>::read_gmsh(&path)?;
    check(&solid, &of_solid);
    // Serendipity fields on these cells are isoparametric: they hold the position.
    let space = Space::of(&Arc::new(of_solid), Elements::Serendipity, Scope::Nodes, &[])?;
    assert!(largest_error(&space, |x| x[0] - 2.0 * x[1] + 3.0 * x[2]) < 1e-13);
    Ok(())
}
