//! Lagrange elements with bubbles: the MINI element, and quadratic ones for discontinuous pressures.

use forms_fem::prelude::*;

use crate::shared::*;

#[test]
fn bubbles_are_further_nodes_and_functions_stay_continuous() -> Outcome {
    let mesh = distorted(4, CellShape::Triangle, 1);
    let mini = Space::of(&mesh, Elements::Mini(1), Scope::Nodes, &[])?;
    assert_eq!((mini.node_count(), Space::scalar(&mesh, 1)?.node_count()), (25 + 32, 25));
    assert_eq!(mini.nodes_on("boundary")?.len(), 16);
    let quadratic = Space::of(&mesh, Elements::Mini(2), Scope::Nodes, &[])?;
    assert_eq!(quadratic.node_count(), 81 + 32);
    for space in [&mini, &quadratic] {
        assert!(largest_jump(space) < 1e-12);
        // The nodes of one cell only are the bubbles'.
        let local = space.local_nodes();
        assert!(local.len() == 32 && local.iter().all(|(_, nodes)| nodes.len() == 1));
    }
    let cube = distorted_cube(2, CellShape::Tetrahedron, 1);
    let faces = cube.interior_facets().len() + cube.boundary_facets().len();
    let quadratic = Space::of(&cube, Elements::Mini(2), Scope::Nodes, &[])?;
    assert_eq!(quadratic.node_count(), 125 + faces + cube.cell_count());
    assert!(largest_jump(&quadratic) < 1e-12);
    assert!(largest_jump(&Space::of(&cube, Elements::Mini(1), Scope::Nodes, &[])?) < 1e-12);
    // Traces on facets have no bubbles.
    let trace = Space::of(&mesh, Elements::Mini(1), Scope::Facets("boundary".into()), &[])?;
    assert_eq!(trace.node_count(), 16);
    Ok(())
}

#[test]
fn polynomials_are_reproduced() -> Outcome {
    let linear = |x: &[f64; 2]| 1.0 + 2.0 * x[0] - x[1];
    let quadratic = |x: &[f64; 2]| linear(x) + x[0] * x[1] - 3.0 * x[1] * x[1];
    let mesh = distorted(3, CellShape::Triangle, 1);
    assert!(largest_error(&Space::of(&mesh, Elements::Mini(1), Scope::Nodes, &[])?, linear) < 1e-13);
    assert!(largest_error(&Space::of(&mesh, Elements::Mini(2), Scope::Nodes, &[])?, quadratic) < 1e-13);
    // On curved cells quadratic elements hold what the geometry is made of.
    let curved = distorted(3, CellShape::Triangle, 2);
    assert!(largest_error(&Space::of(&curved, Elements::Mini(2), Scope::Nodes, &[])?, linear) < 1e-13);
    let cube = distorted_cube(2, CellShape::Tetrahedron, 1);
    let cubic = |x: &[f64; 3]| x[0] * x[1] + x[2] * x[2] - x[0];
    assert!(largest_error(&Space::of(&cube, Elements::Mini(2), Scope::Nodes, &[])?, cubic) < 1e-13);
    Ok(())
}

#[test]
fn stokes_flow_converges() {
    let errors = |of_u: Elements, of_p: (Elements, Scope)| {
        [12, 24].map(|n| {
            let mesh = distorted(n, CellShape::Triangle, 1);
            errors_of_stokes(&mesh, (of_u.clone(), Scope::Nodes), of_p.clone())
        })
    };
    let check = |name: &str, [coarse, fine]: [[f64; 3]; 2], expected: [f64; 3]| {
        for k in 0..3 {
            let order = (coarse[k] / fine[k]).log2();
            println!("{name}: order {order:.2} of {}, error {:.2e}", expected[k], fine[k]);
            assert!(order > expected[k] - 0.25, "{name}: {order} instead of {}", expected[k]);
        }
    };
    let mini = errors(Elements::Mini(1), (Elements::Lagrange(1), Scope::Nodes));
    check("MINI", mini, [2.0, 1.0, 1.0]);
    let quadratic = errors(Elements::Mini(2), (Elements::Lagrange(1), Scope::Cell));
    check("P2 with bubbles and discontinuous P1", quadratic, [3.0, 2.0, 2.0]);
}

#[test]
fn tangents_are_symmetric_and_of_second_order() {
    let mesh = distorted(3, CellShape::Triangle, 2);
    check_flow(&mesh, (Elements::Mini(1), Scope::Nodes), (Elements::Lagrange(1), Scope::Nodes));
    check_flow(&mesh, (Elements::Mini(2), Scope::Nodes), (Elements::Lagrange(1), Scope::Cell));
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    let mesh = distorted(2, CellShape::Quadrilateral, 1);
    let error = |elements: Elements, scope| Space::of(&mesh, elements, scope, &[]).unwrap_err().to_string();
    assert_eq!(
        error(Elements::Mini(1), Scope::Nodes),
        "there are no elements of degree 1 with bubbles on the quadrilateral; they exist on triangles and tetrahedra"
    );
    let (tree, _) = forms_fem::mesh::OctreeMesh::new(mesh.clone()).unwrap().refined(&[0]).unwrap();
    let message = Space::of(tree.mesh(), Elements::Serendipity, Scope::Nodes, &[]).unwrap_err().to_string();
    assert!(message.contains("a space of other elements than Lagrange elements"), "{message}");
}
