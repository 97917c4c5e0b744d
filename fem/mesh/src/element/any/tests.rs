//! Elements of all kinds: values at nodes, what is seen on facets, derivatives, refusals.

use super::*;
use crate::element::Elements;

/// All elements that are no Lagrange elements, by kind.
fn tables() -> Vec<Element> {
    let kinds = [
        Elements::Mini(1),
        Elements::Mini(2),
        Elements::CrouzeixRaviart,
        Elements::Serendipity,
        Elements::LinearInSpace,
    ];
    let on_shapes = |kind: &Elements| CellShape::ALL.map(|shape| kind.on(shape).ok());
    kinds.iter().flat_map(on_shapes).flatten().filter(|element| element.as_table().is_some()).collect()
}

fn check<const D: usize>(element: &Element) {
    let nodes = element.node_points::<D>();
    assert_eq!(nodes.len(), element.nodes());
    let at_nodes = element.tabulate(&nodes);
    for (q, values) in at_nodes.value.chunks(nodes.len()).enumerate() {
        for (i, value) in values.iter().enumerate() {
            assert!((value - f64::from(u8::from(i == q))).abs() < 1e-12, "{} {i} {q}", element.name());
        }
    }
    // Gradients and second derivatives against differences.
    let (point, step): ([f64; D], f64) = (std::array::from_fn(|k| 0.2 + 0.07 * k as f64), 1e-5);
    let tables = element.tabulate_with_hessians(&[point]);
    for k in 0..D {
        let moved = |sign: f64| {
            element
                .tabulate::<D>(&[std::array::from_fn(|l| point[l] + if l == k { sign * step } else { 0.0 })])
        };
        let (plus, minus) = (moved(1.0), moved(-1.0));
        for i in 0..nodes.len() {
            let slope = (plus.value[i] - minus.value[i]) / (2.0 * step);
            assert!((slope - tables.gradient[i][k]).abs() < 1e-6 * 100.0, "{} {i} {k}", element.name());
            for l in 0..D {
                let second = (plus.gradient[i][l] - minus.gradient[i][l]) / (2.0 * step);
                assert!(
                    (second - tables.hessian[i][k][l]).abs() < 1e-5 * 100.0,
                    "{} {i} {k} {l}",
                    element.name()
                );
            }
        }
    }
    // Functions add up to one.
    assert!((tables.value.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn functions_are_one_at_their_node() {
    assert_eq!(tables().len(), 2 + 2 + 2 + 2 + 4);
    for element in tables() {
        if element.shape().dimension() == 2 { check::<2>(&element) } else { check::<3>(&element) }
    }
}

#[test]
fn counts_are_those_of_the_entities() {
    let counts = |kind: Elements| -> Vec<usize> {
        CellShape::ALL
            .iter()
            .filter_map(|shape| kind.on(*shape).ok())
            .map(|element| element.nodes())
            .collect()
    };
    assert_eq!(counts(Elements::Mini(1)), [4, 5]);
    assert_eq!(counts(Elements::Mini(2)), [7, 15]);
    assert_eq!(counts(Elements::CrouzeixRaviart), [3, 4]);
    assert_eq!(counts(Elements::Serendipity), [6, 8, 10, 20]);
    assert_eq!(counts(Elements::LinearInSpace), [3, 3, 4, 4]);
    for shape in CellShape::ALL {
        for degree in 0..=4 {
            let lagrange = Element::Lagrange(Lagrange { shape, degree });
            let [vertex, edge, face, cell] = lagrange.of_entity();
            let faces = if shape.dimension() == 2 { face } else { shape.facets() * face + cell };
            assert_eq!(shape.vertices() * vertex + shape.edges().len() * edge + faces, lagrange.nodes());
        }
    }
}

#[test]
fn bubbles_and_inner_nodes_are_not_seen_on_facets() {
    let seen = |kind: Elements, shape: CellShape| -> Vec<usize> {
        let element = kind.on(shape).unwrap();
        (0..shape.facets()).map(|local| element.seen(local).len()).collect()
    };
    assert_eq!(seen(Elements::Mini(1), CellShape::Triangle), [2; 3]);
    assert_eq!(seen(Elements::Mini(2), CellShape::Tetrahedron), [7; 4]);
    assert_eq!(seen(Elements::Serendipity, CellShape::Hexahedron), [8; 6]);
    // All functions of Crouzeix and Raviart's element are seen on all facets, though each has one node.
    assert_eq!(seen(Elements::CrouzeixRaviart, CellShape::Triangle), [3; 3]);
    let element = Elements::CrouzeixRaviart.on(CellShape::Tetrahedron).unwrap();
    assert_eq!((element.facet_nodes(2), element.has_traces()), (vec![2], false));
    assert!(Elements::Mini(2).on(CellShape::Tetrahedron).unwrap().has_traces());
    let traces =
        |kind: Elements, shape: CellShape| kind.on(shape).unwrap().traces().map(|traces| traces.degree);
    assert_eq!(traces(Elements::Mini(1), CellShape::Tetrahedron), Some(1));
    assert_eq!(traces(Elements::Mini(2), CellShape::Triangle), Some(2));
    assert_eq!(traces(Elements::Mini(2), CellShape::Tetrahedron), None);
    assert_eq!(traces(Elements::Serendipity, CellShape::Quadrilateral), Some(2));
    assert_eq!(traces(Elements::Serendipity, CellShape::Hexahedron), None);
    assert_eq!(traces(Elements::CrouzeixRaviart, CellShape::Triangle), None);
}

#[test]
fn nodes_of_facets_are_at_their_places() {
    for element in tables().into_iter().filter(|element| element.has_traces()) {
        let table = element.as_table().unwrap();
        for local in 0..element.shape().facets() {
            let nodes = element.facet_nodes(local);
            for (node, place) in nodes.iter().zip(element.facet_node_points()) {
                let (found, expected) = (table.layout.on_facet(local, place), table.layout.points[*node]);
                assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-14), "{} {local}", element.name());
            }
        }
    }
}

#[test]
fn refusals_name_the_element() {
    let message = |kind: Elements, shape| kind.on(shape).unwrap_err().to_string();
    assert_eq!(
        message(Elements::CrouzeixRaviart, CellShape::Quadrilateral),
        "there are no Crouzeix-Raviart elements on the quadrilateral; they exist on triangles and tetrahedra"
    );
    assert_eq!(
        message(Elements::Mini(3), CellShape::Triangle),
        "there are no elements of degree 3 with bubbles; the degrees are 1 and 2"
    );
    let own = |of_entity, points: &[[f64; 2]], span: &[Vec<([u8; 2], f64)>]| {
        Element::from_table("mine", CellShape::Triangle, of_entity, points, span, 1).unwrap_err().to_string()
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let one = |x, y| vec![([x, y], 1.0)];
    // 1, x and x² cannot tell the first corner from the last.
    assert_eq!(
        own([1, 0, 0, 0], &corners, &[one(0, 0), one(1, 0), one(2, 0)]),
        "values at the nodes of the element \"mine\" on the triangle do not determine its polynomials"
    );
    assert!(own([1, 1, 0, 0], &corners, &[]).contains("number of points"));
    assert!(own([0, 1, 0, 0], &corners, &[]).contains("in their middle"));
    let message = Elements::own([]).on(CellShape::Triangle).unwrap_err().to_string();
    assert_eq!(message, "the mesh has triangle cells, for which there is no element among those given");
}
