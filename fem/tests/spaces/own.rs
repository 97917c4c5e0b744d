//! Elements of a user's own.

use forms_fem::element::Element;
use forms_fem::prelude::*;

use crate::shared::*;

/// The element of 8 nodes on the quadrilateral, written down by hand.
fn eight_nodes() -> Element {
    let corners = CellShape::Quadrilateral.vertex_points();
    let mut points: Vec<[f64; 2]> = corners.iter().map(|x| [x[0], x[1]]).collect();
    points.extend([[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]]);
    let span: Vec<_> = [[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2], [2, 1], [1, 2]]
        .into_iter()
        .map(|exponents: [u8; 2]| vec![(exponents, 1.0)])
        .collect();
    Element::from_table("eight", CellShape::Quadrilateral, [1, 1, 0, 0], &points, &span, 2).unwrap()
}

#[test]
fn an_own_table_is_an_element_like_others() -> Outcome {
    let mesh = distorted(3, CellShape::Quadrilateral, 2);
    let own = Space::of(&mesh, Elements::own([eight_nodes()]), Scope::Nodes, &[])?;
    let known = Space::of(&mesh, Elements::Serendipity, Scope::Nodes, &[])?;
    assert_eq!(own.positions(), known.positions());
    let values = noise(own.unknowns());
    let [a, b] = [&own, &known].map(|space| Field::from_values(space, values.clone()).unwrap());
    for cell in 0..mesh.cell_count() {
        let [a, b] = [&a, &b].map(|field| field.evaluate_in(cell, &[0.3, 0.7])[0]);
        assert!((a - b).abs() < 1e-13);
    }
    // A bubble of degree two in each direction makes bilinear functions stable against constants.
    let corners = CellShape::Quadrilateral.vertex_points();
    let points: Vec<[f64; 2]> = corners.iter().map(|x| [x[0], x[1]]).chain([[0.5, 0.5]]).collect();
    let one = |x, y| vec![([x, y], 1.0)];
    let bubble = vec![([1, 1], 1.0), ([2, 1], -1.0), ([1, 2], -1.0), ([2, 2], 1.0)];
    let span = [one(0, 0), one(1, 0), one(0, 1), one(1, 1), bubble];
    let element =
        Element::from_table("Q1 and a bubble", CellShape::Quadrilateral, [1, 0, 1, 0], &points, &span, 2)?;
    let space = Space::of(&mesh, Elements::own([element]), Scope::Nodes, &[])?;
    assert_eq!(space.node_count(), 16 + 9);
    assert!(largest_jump(&space) < 1e-13);
    let message =
        Space::of(&distorted(2, CellShape::Triangle, 1), Elements::own([eight_nodes()]), Scope::Nodes, &[]);
    assert_eq!(
        message.unwrap_err().to_string(),
        "the mesh has triangle cells, for which there is no element among those given"
    );
    // Functions that neighbours do not share: x² is a function of two of the three edges of a triangle only.
    let corners: Vec<[f64; 2]> = CellShape::Triangle.vertex_points().iter().map(|x| [x[0], x[1]]).collect();
    let points: Vec<[f64; 2]> = corners.iter().copied().chain([[1.0 / 3.0; 2]]).collect();
    let span = [one(0, 0), one(1, 0), one(0, 1), one(2, 0)];
    let uneven = Element::from_table("uneven", CellShape::Triangle, [1, 0, 1, 0], &points, &span, 2)?;
    let mesh = distorted(2, CellShape::Triangle, 1);
    let refused =
        Space::of(&mesh, Elements::own([uneven.clone()]), Scope::Nodes, &[]).unwrap_err().to_string();
    assert_eq!(
        refused,
        "there is no space of elements \"uneven\" with continuous values: cells on both sides of a facet do not have the \
         same functions there"
    );
    assert_eq!(Space::of(&mesh, Elements::own([uneven]), Scope::Cell, &[])?.node_count(), 4 * 8);
    assert!(Space::of(&mesh, Elements::own([eight_nodes()]), Scope::Nodes, &[]).is_err());
    // On a mesh of two shapes both have the same functions on edges.
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]];
    let cells =
        vec![(CellShape::Quadrilateral, vec![0, 1, 4, 3]), (CellShape::Triangle, vec![1, 2, 4, 2, 5, 4])];
    let mesh = Mesh::from_blocks(1, nodes, cells)?;
    let of_degree = |degree| {
        let triangle = Elements::Mini(degree).on(CellShape::Triangle).unwrap();
        Space::of(&mesh, Elements::own([eight_nodes(), triangle]), Scope::Nodes, &[])
    };
    assert_eq!(of_degree(2)?.node_count(), 6 + 8 + 2);
    assert!(of_degree(1).unwrap_err().to_string().contains("the traces of one Lagrange element"));
    Ok(())
}
