//! Files that are no Gmsh files, or break the format: sections, numbers, counts.

use super::*;

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
