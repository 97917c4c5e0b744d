//! Every mistake that a Gmsh file can have gets a message that names the line or offset and the node, element or
//! group.

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
        // Comments and sections of other programs may stand anywhere.
        let commented = format!("$Comments\nby hand\n$EndComments\n{file}$Periodic\n0\n$EndPeriodic\n");
        assert_eq!(message::<2>(commented.as_bytes()), "2 cells, []");
    }
}

#[test]
fn what_is_no_gmsh_file() {
    let missing = Mesh::<2>::read_gmsh("no/such/file.msh").unwrap_err();
    assert!(matches!(missing.problem, GmshProblem::Unreadable { .. }));
    assert!(missing.to_string().starts_with("no/such/file.msh: "));
    assert_eq!(
        message::<2>(b"solid cube\nfacet"),
        "square.msh: this is no Gmsh mesh: it begins with \"solid cube\", not with $MeshFormat"
    );
    assert_eq!(
        message::<2>(b""),
        "square.msh: this is no Gmsh mesh: it begins with \"\", not with $MeshFormat"
    );
    assert!(message::<2>(&[0xff; 100]).starts_with("square.msh: this is no Gmsh mesh: it begins with"));
    assert!(message::<2>(b"$Nodes\n0\n$EndNodes\n").starts_with("square.msh: this is no Gmsh mesh"));
}

#[test]
fn headers() {
    assert_eq!(
        changed(VERSION_4, "4.1 0 8", "4.0 0 8"),
        "square.msh, line 2, in $MeshFormat: version 4.0 of the MSH format is not read; write 4.1 or 2.2 (option \
         Mesh.MshFileVersion)"
    );
    assert_eq!(
        changed(VERSION_4, "4.1 0 8", "4.1 2 8"),
        "square.msh, line 2, in $MeshFormat: file-type = 2 is not possible: it is 0 for text and 1 for binary"
    );
    assert_eq!(
        changed(VERSION_2, "2.2 0 8", "2.2 0 4"),
        "square.msh, line 2, in $MeshFormat: data-size = 4 is not possible: it is 8, or 4 where version 4.1 counts \
         with 32 bits"
    );
    // What should be the number 1 is "$End".
    assert_eq!(
        changed(VERSION_4, "4.1 0 8", "4.1 1 8"),
        "square.msh, byte 20, in $MeshFormat: byte order = 1684948260 is not possible: the number 1 should stand there"
    );
}

#[test]
fn sections() {
    assert_eq!(
        changed(VERSION_4, "$EndNodes\n", "$EndElements\n"),
        "square.msh, line 25, in $Nodes: expected $EndNodes, found \"$EndElements\""
    );
    assert_eq!(
        message::<2>(VERSION_2.split("$Elements").next().unwrap_or_default().as_bytes()),
        "square.msh: there is no section $Elements"
    );
    assert_eq!(
        message::<2>(format!("{VERSION_2}$Nodes\n0\n$EndNodes\n").as_bytes()),
        "square.msh, line 22: there is a second section $Nodes"
    );
    assert_eq!(
        changed(VERSION_2, "$Nodes\n", "$ParametricNodes\n"),
        "square.msh, line 9, in $ParametricNodes: version 2.2 with parameters of nodes is not read (option \
         Mesh.SaveParametric = 0)"
    );
    assert_eq!(
        message::<2>(format!("{VERSION_2}the end\n").as_bytes()),
        "square.msh, line 22: expected a section, which begins with $, found \"the end\""
    );
    assert_eq!(
        message::<2>(format!("{VERSION_2}$NodeData\n1\n").as_bytes()),
        "square.msh, line 24, in $NodeData: the file ends where $EndNodeData should follow"
    );
}

#[test]
fn numbers_and_counts() {
    assert_eq!(
        changed(VERSION_4, "1 1 0\n0 1 0", "1 one 0\n0 1 0"),
        "square.msh, line 23, in $Nodes: expected a coordinate, found \"one\""
    );
    assert_eq!(
        changed(VERSION_4, "1 4 1 4", "1 4000000000000000000 1 4"),
        "square.msh, line 15, in $Nodes: 4000000000000000000 nodes are announced, but only 124 bytes are left"
    );
    assert_eq!(
        changed(VERSION_4, "2 1 0 4", "2 1 0 99"),
        "square.msh, line 16, in $Nodes: 99 nodes are announced, but only 112 bytes are left"
    );
    assert_eq!(
        changed(VERSION_4, "2 1 0 4\n1\n2\n3\n4\n0 0 0\n", "2 1 0 3\n2\n3\n4\n"),
        "square.msh, line 15, in $Nodes: 4 nodes are announced, but the blocks hold 3"
    );
    assert_eq!(
        changed(VERSION_2, "$Nodes\n4\n", "$Nodes\n-4\n"),
        "square.msh, line 10, in $Nodes: expected the number of nodes, found \"-4\""
    );
    assert_eq!(
        changed(VERSION_2, "$Nodes\n4\n", "$Nodes\n5\n"),
        "square.msh, line 15, in $Nodes: expected a node's tag, found \"$EndNodes\""
    );
    assert_eq!(
        changed(VERSION_2, "$Nodes\n4\n", "$Nodes\n3\n"),
        "square.msh, line 14, in $Nodes: expected $EndNodes, found \"4\""
    );
    assert_eq!(
        changed(VERSION_2, "2 2 2 3 1 1 2 3", "2 2 1000000 3 1 1 2 3"),
        "square.msh, line 19, in $Elements: 1000000 tags are announced, but only 40 bytes are left"
    );
    assert_eq!(
        changed(VERSION_4, "1 7 \"wall\"", "1 7 wall"),
        "square.msh, line 6, in $PhysicalNames: expected a dimension, a tag and a name in quotation marks, found \
         \"1 7 wall\""
    );
    assert_eq!(
        changed(VERSION_4, "2 1 0 4\n", "4 1 0 4\n"),
        "square.msh, line 16, in $Nodes: expected a dimension from 0 to 3, found \"4\""
    );
    assert_eq!(
        changed(VERSION_4, "2 1 0 4\n", "2 1 5 4\n"),
        "square.msh, line 16, in $Nodes: expected 0 or 1 (whether the nodes have parameters), found \"5\""
    );
    assert_eq!(
        changed(VERSION_2, "1 0 0 0\n", "1 0 nan 0\n"),
        "square.msh, line 11, in $Elements: node 1 has a coordinate that is not finite: [0.0, NaN, 0.0]"
    );
}

// Wherever a file breaks off, the message says so, or that something is missing; nothing is read.
#[test]
fn truncated_files() {
    for file in [VERSION_4, VERSION_2] {
        // The last line break is not missed.
        for length in 0..file.len() - 1 {
            let error = Mesh::<2>::read_gmsh_bytes("square.msh", &file.as_bytes()[..length]).unwrap_err();
            assert!(
                matches!(
                    error.problem,
                    GmshProblem::Truncated { .. }
                        | GmshProblem::NotGmsh { .. }
                        | GmshProblem::MissingSection { .. }
                        | GmshProblem::Count { .. }
                        | GmshProblem::Unexpected { .. }
                        | GmshProblem::Version { .. }
                ),
                "{length}: {error}"
            );
        }
    }
    assert_eq!(
        message::<2>(&VERSION_4.as_bytes()[..VERSION_4.len() - 40]),
        "square.msh, line 28, in $Elements: 1 elements are announced, but only 4 bytes are left"
    );
}

#[test]
fn elements() {
    assert_eq!(
        changed(VERSION_4, "2 1 2 2\n", "2 1 21 2\n"),
        "square.msh, line 30, in $Elements: elements of type 21 are not known; lines, triangles, quadrilaterals, \
         tetrahedra, hexahedra, prisms and pyramids of first and second order are"
    );
    assert_eq!(
        changed(VERSION_4, "2 1 2 2\n", "2 1 1 2\n"),
        "square.msh, line 30, in $Elements: the block belongs to surface 1, but holds elements of one dimension (line of \
         2 nodes)"
    );
    assert_eq!(
        changed(VERSION_4, "2 1 2 2\n", "2 9 2 2\n"),
        "square.msh, line 30, in $Elements: the block belongs to surface 9, which neither $Entities nor \
         $PartitionedEntities lists"
    );
    let prism = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 0 1\n6 0 1 1\n\
                 $EndNodes\n$Elements\n1\n5 6 2 0 1 1 2 3 4 5 6\n$EndElements\n";
    assert_eq!(
        message::<3>(prism.as_bytes()),
        "square.msh, line 15, in $Elements: element 5 is a prism of 6 nodes; a mesh consists of triangles, quadrilaterals, \
         tetrahedra or hexahedra"
    );
    let lines = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 1 0 0\n$EndNodes\n$Elements\n1\n\
                 1 1 2 0 1 1 2\n$EndElements\n";
    assert_eq!(message::<2>(lines.as_bytes()), "square.msh: the file has no cells");
}

#[test]
fn elements_of_several_types() {
    let house = |from: &str, to: &str| changed(TWO_SHAPES, from, to);
    let six = TWO_SHAPES.replace("5\n1 0 0 0\n", "6\n6 0 2 0\n1 0 0 0\n");
    assert_eq!(
        changed(&six, "3 2 2 3 1 4 3 5", "3 9 2 3 1 4 3 5 1 2 6"),
        "square.msh, line 22, in $Elements: the cells are of two types: element 2 is a quadrilateral of 4 nodes, element 3 \
         a triangle of 6 nodes; a mesh has one, or triangles and quadrilaterals of one order"
    );
    let eight = TWO_SHAPES.replace("5\n1 0 0 0\n", "8\n6 0 2 0\n7 1 2 0\n8 2 2 0\n1 0 0 0\n");
    assert_eq!(
        changed(&eight, "2 3 2 3 1 1 2 3 4", "2 16 2 3 1 1 2 3 4 5 6 7 8"),
        "square.msh, line 23, in $Elements: element 2 is a quadrilateral of 8 nodes; second-order cells need all their \
         nodes (option Mesh.SecondOrderIncomplete = 0), and a mesh consists of triangles, quadrilaterals, tetrahedra or \
         hexahedra"
    );
    assert_eq!(
        message::<3>(
            eight
                .replace("3 2 2 3 1 4 3 5", "3 4 2 3 1 1 2 4 8\n4 6 2 3 1 1 2 3 5 6 7")
                .replace("\n3\n1 1 2 7", "\n4\n1 1 2 7")
                .as_bytes()
        ),
        "square.msh, line 25, in $Elements: the cells are of two types: element 3 is a tetrahedron of 4 nodes, element 4 \
         a prism of 6 nodes; a mesh has one, or triangles and quadrilaterals of one order"
    );
    // What is wrong with a cell is told of the file's element, whichever shape comes first.
    assert_eq!(
        house("3 2 2 3 1 4 3 5", "3 2 2 3 1 4 3 9"),
        "square.msh, line 21, in $Elements: element 3 names node 9, which the file does not have"
    );
    for (from, to, line, element) in
        [("2 3 2 3 1 1 2 3 4", "2 3 2 3 1 1 3 2 4", 20, 2), ("4 3 5", "4 5 3", 21, 3)]
    {
        let found = house(from, to);
        let start = format!("square.msh, line {line}, in $Elements: element {element} is ");
        assert!(found.starts_with(&start), "{found}");
    }
    let three = TWO_SHAPES.replace("\n3\n1 1 2 7", "\n4\n1 1 2 7");
    assert_eq!(
        changed(&three, "3 2 2 3 1 4 3 5", "3 2 2 3 1 4 3 5\n4 2 2 3 1 3 5 4"),
        "square.msh, line 22, in $Elements: elements 3 and 4 are the same cell"
    );
    assert_eq!(
        changed(&three, "3 2 2 3 1 4 3 5", "3 2 2 3 1 4 3 5\n4 2 2 3 1 4 2 3"),
        "square.msh, line 22, in $Elements: elements [2, 3, 4] share one facet, with the nodes [3, 4]; two can"
    );
}

#[test]
fn dimensions() {
    assert_eq!(
        message::<3>(VERSION_4.as_bytes()),
        "square.msh, line 31, in $Elements: the cells have two dimensions (element 2 is a triangle of 3 nodes), but a mesh \
         in three dimensions was asked for"
    );
    let tetrahedron = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
                       $Elements\n2\n1 2 2 7 1 1 2 3\n2 4 2 0 1 1 2 3 4\n$EndElements\n";
    assert_eq!(
        message::<2>(tetrahedron.as_bytes()),
        "square.msh, line 14, in $Elements: the cells have three dimensions (element 2 is a tetrahedron of 4 nodes), but a \
         mesh in two dimensions was asked for"
    );
    assert_eq!(message::<3>(tetrahedron.as_bytes()), "1 cells, []");
    assert_eq!(
        changed(VERSION_2, "3 1 1 0", "3 1 1 0.5"),
        "square.msh, line 13, in $Elements: nodes 1 and 3 of a plane mesh have z = 0 and z = 0.5; all must be equal"
    );
}

#[test]
fn tags() {
    assert_eq!(
        changed(VERSION_2, "4 0 1 0\n", "2 0 1 0\n"),
        "square.msh, line 14, in $Elements: there are two nodes with the tag 2"
    );
    assert_eq!(
        changed(VERSION_2, "3 2 2 3 1 1 3 4", "2 2 2 3 1 1 3 4"),
        "square.msh, line 20, in $Elements: there are two elements with the tag 2"
    );
    assert_eq!(
        changed(VERSION_2, "3 2 2 3 1 1 3 4", "3 2 2 3 1 1 3 5"),
        "square.msh, line 20, in $Elements: element 3 names node 5, which the file does not have"
    );
    assert_eq!(
        changed(VERSION_2, "3 2 2 3 1 1 3 4", "3 2 2 3 1 1 3 3"),
        "square.msh, line 20, in $Elements: element 3 names node 3 twice"
    );
    assert_eq!(
        changed(VERSION_2, "3 2 2 3 1 1 3 4", "3 2 2 3 1 2 3 1"),
        "square.msh, line 20, in $Elements: elements 2 and 3 are the same cell"
    );
    assert_eq!(
        changed(
            VERSION_4,
            "0 1 1 0\n1 0 0 0 1 0 0 1 7 0\n",
            "0 2 1 0\n1 0 0 0 1 0 0 1 7 0\n1 0 0 0 1 0 0 1 7 0\n"
        ),
        "square.msh, line 12, in $Entities: curve 1 is listed twice"
    );
    assert_eq!(
        changed(VERSION_4, "2\n1 7 \"wall\"\n", "3\n1 7 \"wall\"\n1 7 \"floor\"\n"),
        "square.msh, line 7, in $PhysicalNames: the group 7 of curves has two names"
    );
}

#[test]
fn geometry() {
    assert_eq!(
        changed(VERSION_2, "3 2 2 3 1 1 3 4", "3 2 2 3 1 1 4 3"),
        "square.msh, line 20, in $Elements: element 3 is inverted or degenerate: its Jacobian determinant is -1e0 near \
         [0.3333333333333333, 0.6666666666666666]"
    );
    // The middle of an edge too near to its end: the map folds.
    let bent = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0.125 0 0\n5 0.5 0.5 0\n6 0 0.5 0\n\
                $EndNodes\n$Elements\n1\n5 9 2 0 1 1 2 3 4 5 6\n$EndElements\n";
    assert_eq!(
        message::<2>(bent.as_bytes()),
        "square.msh, line 15, in $Elements: element 5 is inverted or degenerate: its Jacobian determinant is -5e-1 near \
         [0.0, 0.0] (a second-order cell may bend too much: option Mesh.HighOrderOptimize, or smaller cells)"
    );
    let three = VERSION_2
        .replace("$Nodes\n4\n", "$Nodes\n5\n9 0.25 0.875 0\n")
        .replace("$Elements\n3\n", "$Elements\n4\n8 2 2 3 1 1 3 9\n");
    assert_eq!(
        message::<2>(three.as_bytes()),
        "square.msh, line 22, in $Elements: elements [8, 2, 3] share one facet, with the nodes [1, 3]; two can"
    );
}

#[test]
fn regions() {
    assert_eq!(
        changed(VERSION_2, "1 1 2 7 1 1 2", "1 1 2 7 1 2 4"),
        "square.msh, line 18, in $Elements: element 1 of the group \"wall\" is not a facet of any cell"
    );
    assert_eq!(
        changed(VERSION_2, "\"wall\"", "\"body\""),
        "square.msh: \"body\" names a group of surfaces and one of curves; the name of a region stands for one of them"
    );
    assert_eq!(
        changed(VERSION_2, "\"wall\"", "\"boundary\""),
        "square.msh: the mesh already has a region \"boundary\""
    );
    // It is all cells.
    assert_eq!(changed(VERSION_2, "\"body\"", "\"all\""), "2 cells, []");
    let mesh = Mesh::<2>::read_gmsh_bytes("square.msh", VERSION_2.as_bytes()).unwrap();
    assert_eq!(
        mesh.facet_region("lid").unwrap_err().to_string(),
        "there is no facet region \"lid\"; the mesh has \"boundary\", \"wall\""
    );
    assert_eq!(
        mesh.cell_region("wall").unwrap_err().to_string(),
        "there is no cell region \"wall\"; the mesh has \"all\", \"body\""
    );
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

// A file's own numbers tell where cells overlap; cracks and hanging nodes are read, and told of.
#[test]
fn cells_that_do_not_fit_each_other() {
    assert_eq!(
        changed(VERSION_2, "3 2 2 3 1 1 3 4", "3 2 2 3 1 1 2 4"),
        "square.msh, line 20, in $Elements: element 2 and element 3 overlap: they lie on the same side of the facet with \
         the nodes [1, 2]"
    );
    let more = VERSION_2.replace("$Nodes\n4\n", "$Nodes\n6\n5 0 0 0\n6 1 1 0\n");
    assert_eq!(
        message::<2>(more.replace("3 2 2 3 1 1 3 4", "3 2 2 3 1 5 6 4").as_bytes()),
        "2 cells, [Cracks { count: 1, first: [Item { what: \"element\", tag: 2 }, Item { what: \"element\", tag: 3 }] }]"
    );
    // The same triangle on nodes of its own, a corner elsewhere.
    let again = more.replace("5 0 0 0", "5 1 0.1 0").replace("3 2 2 3 1 1 3 4", "3 2 2 3 1 1 5 3");
    assert!(message::<2>(again.as_bytes()).contains("element 2 and element 3 overlap"));
    // A triangle that begins half way along the diagonal.
    let half = more.replace("5 0 0 0", "5 0.5 0.5 0").replace("3 2 2 3 1 1 3 4", "3 2 2 3 1 5 3 4");
    let read = GmshMesh::<2>::from_bytes("square.msh", half.as_bytes()).unwrap();
    assert_eq!(
        read.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        [
            "no cell uses 1 nodes, the first of which is node 6; they are left out",
            "the mesh has hanging nodes: node 5 lies on a facet of element 2, which does not have it; such nodes: 1"
        ]
    );
}

#[test]
fn positions_are_values() {
    let error = Mesh::<2>::read_gmsh_bytes("square.msh", &VERSION_2.as_bytes()[..200]).unwrap_err();
    assert_eq!((error.file.as_str(), error.section.as_deref()), ("square.msh", Some("Elements")));
    assert_eq!(error.position, Some(FilePosition::Line(20)));
}
