//! Basix's conventions as we have them against what basix itself says (`data/basix.json`, written by
//! `peers/write_basix.py`).

use std::collections::BTreeMap;

use forms_bench::basix::{
    Entities, NodeOrder, RuleError, our_facets, our_node_numbers, point_count, quadrature,
};
use forms_fem::element::{CellShape, Lagrange};
use forms_fem::quadrature::{Quadrature, QuadratureRule, cell_rule, facet_reference_rule};
use serde::Deserialize;

#[derive(Deserialize)]
struct Everything {
    shapes: BTreeMap<String, Shape>,
    rules: BTreeMap<String, Vec<WrittenRule>>,
}

#[derive(Deserialize)]
struct WrittenRule {
    points: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

#[derive(Deserialize)]
struct Shape {
    facets: Vec<Vec<usize>>,
    nodes: BTreeMap<usize, Vec<Vec<f64>>>,
    tensor_product_nodes: BTreeMap<usize, Vec<Vec<f64>>>,
}

fn everything() -> Everything {
    serde_json::from_str(include_str!("../data/basix.json")).expect("the file is JSON")
}

fn check_nodes<const D: usize>(shape: CellShape, degree: usize) {
    let everything = everything();
    let written = &everything.shapes[shape.name()];
    let ours = Lagrange::new(shape, degree).expect("it exists").node_points::<D>();
    for (order, nodes) in
        [(NodeOrder::Entities, &written.nodes), (NodeOrder::TensorProduct, &written.tensor_product_nodes)]
    {
        let Some(nodes) = nodes.get(&degree) else { continue };
        let numbers = our_node_numbers(shape, degree, order);
        assert_eq!(nodes.len(), numbers.len());
        for (node, number) in nodes.iter().zip(numbers) {
            let place = ours[number].map(|coordinate| 2.0 * coordinate).to_vec();
            assert_eq!(&place, node, "{shape:?} {degree} {order:?}");
        }
    }
}

#[test]
fn nodes_are_at_the_same_places() {
    check_nodes::<2>(CellShape::Triangle, 1);
    check_nodes::<2>(CellShape::Triangle, 2);
    check_nodes::<2>(CellShape::Quadrilateral, 1);
    check_nodes::<2>(CellShape::Quadrilateral, 2);
    check_nodes::<3>(CellShape::Tetrahedron, 1);
    check_nodes::<3>(CellShape::Tetrahedron, 2);
    check_nodes::<3>(CellShape::Hexahedron, 1);
    check_nodes::<3>(CellShape::Hexahedron, 2);
}

fn check_facets(shape: CellShape) {
    let everything = everything();
    let vertices = our_node_numbers(shape, 1, NodeOrder::Entities);
    let facets = &everything.shapes[shape.name()].facets;
    assert_eq!(facets.len(), shape.facets());
    for (facet, theirs) in facets.iter().enumerate() {
        let mut theirs: Vec<usize> = theirs.iter().map(|vertex| vertices[*vertex]).collect();
        let mut ours = shape.facet_vertices(our_facets(shape)[facet]).to_vec();
        theirs.sort_unstable();
        ours.sort_unstable();
        assert_eq!(theirs, ours, "{shape:?} facet {facet}");
    }
}

#[test]
fn facets_have_the_same_vertices() {
    CellShape::ALL.into_iter().for_each(check_facets);
}

type Points = Vec<(Vec<f64>, f64)>;

fn sorted(mut points: Points) -> Points {
    // Rounded, so that round-off does not change the order.
    let key =
        |point: &(Vec<f64>, f64)| -> Vec<i64> { point.0.iter().map(|x| (x * 1e9).round() as i64).collect() };
    points.sort_by_key(key);
    points
}

fn close(theirs: Points, ours: Points) -> bool {
    let (theirs, ours) = (sorted(theirs), sorted(ours));
    let near = |a: f64, b: f64| (a - b).abs() < 2e-14;
    theirs.len() == ours.len()
        && theirs
            .iter()
            .zip(&ours)
            .all(|((x, v), (y, w))| near(*v, *w) && x.iter().zip(y).all(|(x, y)| near(*x, *y)))
}

fn of_rule<const D: usize>(rule: &QuadratureRule<D>) -> Points {
    rule.points.iter().map(|point| point.to_vec()).zip(rule.weights.iter().copied()).collect()
}

fn of_written(rule: &WrittenRule) -> Points {
    rule.points.iter().cloned().zip(rule.weights.iter().copied()).collect()
}

#[test]
fn products_of_gauss_points_are_ours() -> Result<(), RuleError> {
    let everything = everything();
    for degree in 0..=5 {
        let rule = of_written(&everything.rules["quadrilateral"][degree]);
        assert!(close(rule, of_rule(&cell_rule::<2>(CellShape::Quadrilateral, degree)?)), "{degree}");
        let rule = of_written(&everything.rules["hexahedron"][degree]);
        assert!(close(rule, of_rule(&cell_rule::<3>(CellShape::Hexahedron, degree)?)), "{degree}");
    }
    for (degree, rule) in everything.rules["interval"].iter().enumerate() {
        let ours = facet_reference_rule(CellShape::Triangle, degree)?;
        let on_line = ours.points.iter().map(|point| vec![point[0]]).zip(ours.weights.iter().copied());
        assert!(close(of_written(rule), on_line.collect()), "{degree}");
    }
    Ok(())
}

// In which degrees the rules on simplices agree: the basket needs basix's own in the others.
#[test]
fn some_rules_on_simplices_are_ours() -> Result<(), RuleError> {
    let everything = everything();
    for degree in 0..=4 {
        let triangle = of_written(&everything.rules["triangle"][degree]);
        let same = close(triangle, of_rule(&cell_rule::<2>(CellShape::Triangle, degree)?));
        assert_eq!(same, degree != 3, "triangle {degree}");
        let tetrahedron = of_written(&everything.rules["tetrahedron"][degree]);
        let same = close(tetrahedron, of_rule(&cell_rule::<3>(CellShape::Tetrahedron, degree)?));
        assert_eq!(same, degree < 3, "tetrahedron {degree}");
    }
    Ok(())
}

// Turning the facet's vertices maps barycentric coordinates; the set of points stays.
#[test]
fn rules_on_triangles_are_symmetric() {
    for (degree, rule) in everything().rules["triangle"].iter().enumerate() {
        let points = of_written(rule);
        for turned in [|x: f64, y: f64| [y, x], |x: f64, y: f64| [1.0 - x - y, x]] {
            let image = points.iter().map(|(x, w)| (turned(x[0], x[1]).to_vec(), *w)).collect();
            assert!(close(points.clone(), image), "{degree}");
        }
    }
}

// What the generated kernels hold is compared with these by `peers/check_rules.py`.
#[test]
fn rules_sum_to_the_volume() -> Result<(), RuleError> {
    for degree in 0..=12 {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            let Quadrature::Explicit { cell, facet } = quadrature::<2>(shape, degree)? else {
                unreachable!()
            };
            assert!((cell.weights.iter().sum::<f64>() - shape.volume()).abs() < 1e-14);
            assert!((facet.weights.iter().sum::<f64>() - shape.facet_volume()).abs() < 1e-14);
            assert_eq!(cell.len(), point_count(shape, degree, Entities::Cells));
            assert_eq!(facet.len(), point_count(shape, degree, Entities::Facets));
        }
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            let Quadrature::Explicit { cell, facet } = quadrature::<3>(shape, degree)? else {
                unreachable!()
            };
            assert!((cell.weights.iter().sum::<f64>() - shape.volume()).abs() < 1e-14);
            assert!((facet.weights.iter().sum::<f64>() - shape.facet_volume()).abs() < 1e-14);
            assert_eq!(cell.len(), point_count(shape, degree, Entities::Cells));
            assert_eq!(facet.len(), point_count(shape, degree, Entities::Facets));
        }
    }
    assert_eq!(
        quadrature::<2>(CellShape::Triangle, 13),
        Err(RuleError::Degree { shape: "triangle", degree: 13 })
    );
    Ok(())
}
