//! The serendipity elements: 8 nodes on quadrilaterals, 20 on hexahedra.

use forms_fem::prelude::*;

use crate::shared::*;

#[test]
fn nodes_are_those_of_vertices_and_edges() -> Outcome {
    let mesh = distorted(3, CellShape::Quadrilateral, 2);
    let space = Space::of(&mesh, Elements::Serendipity, Scope::Nodes, &[])?;
    assert_eq!(space.node_count(), 16 + 24);
    assert!(largest_jump(&space) < 1e-13);
    assert!(space.local_nodes().is_empty());
    let cube = distorted_cube(2, CellShape::Hexahedron, 1);
    let space = Space::of(&cube, Elements::Serendipity, Scope::Nodes, &[])?;
    assert_eq!(space.node_count(), 27 + 54);
    assert!(largest_jump(&space) < 1e-13);
    // On the facets of a region, too.
    assert_eq!(
        Space::of(&cube, Elements::Serendipity, Scope::Facets("boundary".into()), &[])?.node_count(),
        26 + 48
    );
    Ok(())
}

#[test]
fn polynomials_are_reproduced() -> Outcome {
    let linear = |x: &[f64; 2]| 1.0 + 2.0 * x[0] - x[1];
    let quadratic = |x: &[f64; 2]| linear(x) + x[0] * x[1] - 3.0 * x[1] * x[1];
    let space = |mesh: &Mesh<2>| Space::of(mesh, Elements::Serendipity, Scope::Nodes, &[]);
    // Degree 1 on distorted cells, degree 2 on parallelograms.
    let mesh = distorted(3, CellShape::Quadrilateral, 1);
    assert!(largest_error(&space(&mesh)?, linear) < 1e-13);
    assert!(largest_error(&space(&mesh)?, quadratic) > 1e-6);
    let sheared = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Quadrilateral, 1)?;
    let nodes = sheared.nodes().iter().map(|x| [x[0] + 0.4 * x[1], x[1]]).collect();
    let sheared = Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, sheared.cells().to_vec())?;
    assert!(largest_error(&space(&sheared)?, quadratic) < 1e-13);
    let cube = cuboid([0.0; 3], [1.0, 2.0, 1.0], [2, 2, 2], CellShape::Hexahedron, 1)?;
    let space = Space::of(&cube, Elements::Serendipity, Scope::Nodes, &[])?;
    assert!(largest_error(&space, |x| x[0] * x[1] * x[2] + x[2] * x[2] - x[0] * x[0] * x[1]) < 1e-13);
    Ok(())
}

#[test]
fn poissons_problem_converges() {
    let check = |name: &str, errors: [[f64; 2]; 2], expected: [f64; 2]| {
        for k in 0..2 {
            let order = (errors[0][k] / errors[1][k]).log2();
            println!("{name}: order {order:.2} of {}, error {:.2e}", expected[k], errors[1][k]);
            assert!(order > expected[k] - 0.2, "{name}: {order} instead of {}", expected[k]);
        }
    };
    let straight = |n| rectangle([0.0; 2], [1.0; 2], [n, n], CellShape::Quadrilateral, 1).unwrap();
    check("Q8", [8, 16].map(|n| errors_of_poisson(&straight(n), &Elements::Serendipity)), [3.0, 2.0]);
    let solid = |n| cuboid([0.0; 3], [1.0; 3], [n, n, n], CellShape::Hexahedron, 1).unwrap();
    check("H20", [3, 6].map(|n| errors_of_poisson(&solid(n), &Elements::Serendipity)), [3.0, 2.0]);
}

#[test]
fn tangents_are_symmetric_and_of_second_order() {
    let mesh = distorted(3, CellShape::Quadrilateral, 2);
    check_flow(&mesh, (Elements::Serendipity, Scope::Nodes), (Elements::Lagrange(1), Scope::Nodes));
}

#[test]
fn triangles_and_quadrilaterals_share_edges() -> Outcome {
    // Two unit squares, the right one in two triangles.
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]];
    let blocks =
        [(CellShape::Quadrilateral, vec![0, 1, 4, 3]), (CellShape::Triangle, vec![1, 2, 4, 2, 5, 4])];
    let mesh = Mesh::from_blocks(1, nodes, blocks.to_vec())?;
    let space = Space::of(&mesh, Elements::Serendipity, Scope::Nodes, &[])?;
    assert_eq!(space.node_count(), 6 + 8);
    let quadratic = |x: &[f64; 2]| x[0] * x[1] - 3.0 * x[1] * x[1] + x[0];
    let field = Field::interpolate(&space, quadratic)?;
    for point in [[0.3, 0.6], [1.2, 0.3], [1.8, 0.7]] {
        assert!((field.evaluate(&point)?[0] - quadratic(&point)).abs() < 1e-13);
    }
    Ok(())
}
