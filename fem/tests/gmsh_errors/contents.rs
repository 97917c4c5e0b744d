//! Files that can be read and give no mesh: elements, tags, geometry, regions.

use super::*;

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
    // A physical group of curves only.
    let omitted = ". Where a model has physical groups, Gmsh saves the entities of groups only: put those of the cells into a \
                   physical group, too, or save with the option Mesh.SaveAll = 1";
    let grouped = lines.replace("1 1 2 0 1 1 2", "1 1 2 5 1 1 2");
    assert_eq!(message::<2>(grouped.as_bytes()), format!("square.msh: the file has no cells{omitted}"));
    // Of surfaces only, where the volume is wanted.
    let surface = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n\
                   1 2 2 5 1 1 2 3\n$EndElements\n";
    assert_eq!(
        message::<3>(surface.as_bytes()),
        format!(
            "square.msh, line 12, in $Elements: the cells have two dimensions (element 1 is a triangle of 3 nodes), but a \
             mesh in three dimensions was asked for{omitted}"
        )
    );
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
        "square.msh, line 24, in $Elements: the cells are of two types: element 2 is a quadrilateral of 8 nodes, element 3 \
         a triangle of 3 nodes; a mesh has one, or triangles and quadrilaterals of one order"
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
    // What is wrong with a cell is reported for the file's element, whichever shape comes first.
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
         in three dimensions was asked for. Where a model has physical groups, Gmsh saves the entities of groups only: put \
         those of the cells into a physical group, too, or save with the option Mesh.SaveAll = 1"
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
