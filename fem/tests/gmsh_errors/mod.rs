//! Every mistake that a Gmsh file can have gets a message that names the line or offset and the node, element or
//! group.

mod contents;
mod format;

use forms_fem::mesh::Mesh;
use forms_fem::mesh::gmsh::{FilePosition, GmshMesh, GmshProblem};

const VERSION_4: &str = r#"$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "wall"
2 3 "body"
$EndPhysicalNames
$Entities
0 1 1 0
1 0 0 0 1 0 0 1 7 0
1 0 0 0 1 1 0 1 3 0
$EndEntities
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
1 0 0
1 1 0
0 1 0
$EndNodes
$Elements
2 3 1 3
1 1 1 1
1 1 2
2 1 2 2
2 1 2 3
3 1 3 4
$EndElements
"#;

const VERSION_2: &str = r#"$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "wall"
2 3 "body"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
$EndNodes
$Elements
3
1 1 2 7 1 1 2
2 2 2 3 1 1 2 3
3 2 2 3 1 1 3 4
$EndElements
"#;

// A square with a triangle above it.
const TWO_SHAPES: &str = r#"$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "wall"
2 3 "body"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0.5 1.5 0
$EndNodes
$Elements
3
1 1 2 7 1 1 2
2 3 2 3 1 1 2 3 4
3 2 2 3 1 4 3 5
$EndElements
"#;

fn message<const D: usize>(bytes: &[u8]) -> String {
    match GmshMesh::<D>::from_bytes("square.msh", bytes) {
        Ok(read) => format!("{} cells, {:?}", read.mesh.cell_count(), read.notes),
        Err(error) => error.to_string(),
    }
}

// The file with one fragment replaced by another.
fn changed(file: &str, from: &str, to: &str) -> String {
    assert_eq!(file.matches(from).count(), 1, "{from:?} stands once");
    message::<2>(file.replace(from, to).as_bytes())
}

#[test]
fn the_files_are_good() {
    for file in [VERSION_4, VERSION_2, TWO_SHAPES] {
        assert_eq!(message::<2>(file.as_bytes()), "2 cells, []");
        // Lines may end as on Windows, and white space is free.
        assert_eq!(message::<2>(file.replace('\n', "\r\n").as_bytes()), "2 cells, []");
        assert_eq!(message::<2>(file.replace("1 1 0\n", "1  1\n\t0\n\n").as_bytes()), "2 cells, []");
        // Comments and sections of other programs may be anywhere.
        let commented = format!("$Comments\nby hand\n$EndComments\n{file}$Periodic\n0\n$EndPeriodic\n");
        assert_eq!(message::<2>(commented.as_bytes()), "2 cells, []");
    }
}

#[test]
fn notes() {
    let notes = |text: String| -> Vec<String> {
        let read = GmshMesh::<2>::from_bytes("square.msh", text.as_bytes()).unwrap();
        read.notes.iter().map(ToString::to_string).collect()
    };
    let more = VERSION_2
        .replace("$Nodes\n4\n", "$Nodes\n6\n8 7 7 7\n9 0.25 nan 0\n")
        .replace("2\n1 7 \"wall\"", "4\n0 1 \"tip\"\n1 8 \"lid\"\n1 7 \"wall\"")
        .replace("$Elements\n3\n1", "$Elements\n5\n10 15 2 1 1 2\n11 1 2 7 1 1 3\n1");
    assert_eq!(
        notes(more),
        [
            "no cell uses 2 nodes, the first of which is node 8; they are left out",
            "the group \"wall\" has facets on the boundary and between cells; the latter are the region \"wall (interior)\"",
            "the group \"lid\" of curves has no elements",
            "the group \"tip\" of points is left out: regions hold cells and facets",
        ]
    );
    // Both cells of surface 1 run clockwise.
    let clockwise = VERSION_2.replace("1 1 2 3\n", "1 2 1 3\n").replace("1 1 3 4\n", "1 3 1 4\n");
    assert_eq!(notes(clockwise), ["the 2 cells of surface 1 ran clockwise and were turned"]);
}

#[test]
fn positions_are_values() {
    let error = Mesh::<2>::read_gmsh_bytes("square.msh", &VERSION_2.as_bytes()[..200]).unwrap_err();
    assert_eq!((error.file.as_str(), error.section.as_deref()), ("square.msh", Some("Elements")));
    assert_eq!(error.position, Some(FilePosition::Line(20)));
}
