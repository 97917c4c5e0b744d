//! Basis functions against polynomials and differences.

use super::*;

fn elements() -> impl Iterator<Item = Lagrange> {
    CellShape::ALL
        .into_iter()
        .flat_map(|shape| (1..=4).map(move |degree| Lagrange::new(shape, degree).expect("degrees 1 to 4")))
}

// A few points, some outside the cell: the identities hold everywhere.
fn samples<const D: usize>() -> Vec<[f64; D]> {
    [[0.1, 0.2, 0.3], [0.7, 0.05, 0.15], [0.0, 1.0, 0.25], [1.3, -0.4, 0.6]]
        .iter()
        .map(|point| std::array::from_fn(|k| point[k]))
        .collect()
}

fn check_nodes<const D: usize>(element: Lagrange) {
    let points = element.node_points::<D>();
    assert_eq!(points.len(), element.nodes());
    let tables = element.tabulate(&points);
    for q in 0..points.len() {
        for i in 0..element.nodes() {
            // Exact except for thirds, which are rounded.
            let tolerance = if element.degree == 3 { 1e-14 } else { 0.0 };
            let difference = tables.value[q * tables.nodes + i] - f64::from(u8::from(i == q));
            assert!(difference.abs() <= tolerance, "{element:?}");
        }
    }
}

// Interpolates a polynomial of the element's space and compares values and gradients.
fn check_reproduction<const D: usize>(element: Lagrange) {
    let coefficient = [0.3, -1.7, 0.9];
    // (1 + c·x)^degree is in P_k; for the tensor elements Π (1 + c_k x_k)^degree is in Q_k.
    let p = element.degree as i32;
    let simplex = element.shape.is_simplex();
    let function = |x: &[f64; D]| -> (f64, [f64; D]) {
        if simplex {
            let s = 1.0 + (0..D).map(|k| coefficient[k] * x[k]).sum::<f64>();
            (s.powi(p), std::array::from_fn(|k| f64::from(p) * s.powi(p - 1) * coefficient[k]))
        } else {
            let s: [f64; D] = std::array::from_fn(|k| 1.0 + coefficient[k] * x[k]);
            let value = s.iter().map(|s| s.powi(p)).product();
            let gradient = std::array::from_fn(|k| {
                let others: f64 = (0..D).filter(|&j| j != k).map(|j| s[j].powi(p)).product();
                f64::from(p) * s[k].powi(p - 1) * coefficient[k] * others
            });
            (value, gradient)
        }
    };
    let nodal: Vec<f64> = element.node_points::<D>().iter().map(|x| function(x).0).collect();
    let points = samples::<D>();
    let tables = element.tabulate(&points);
    for (q, point) in points.iter().enumerate() {
        let row = q * tables.nodes..(q + 1) * tables.nodes;
        let value: f64 = tables.value[row.clone()].iter().zip(&nodal).map(|(phi, u)| phi * u).sum();
        let (expected, slope) = function(point);
        // Round-off is that of the largest summands; at a point outside these grow with the degree.
        let sizes = || tables.value[row.clone()].iter().zip(&nodal);
        let size = sizes().map(|(phi, u)| (phi * u).abs()).fold(1.0, f64::max);
        assert!((value - expected).abs() < 1e-13 * size, "{element:?}");
        let unity: f64 = tables.value[row.clone()].iter().sum();
        let size = sizes().map(|(phi, _)| phi.abs()).fold(1.0, f64::max);
        assert!((unity - 1.0).abs() < 1e-14 * size, "{element:?}");
        for k in 0..D {
            let derivative: f64 =
                tables.gradient[row.clone()].iter().zip(&nodal).map(|(g, u)| g[k] * u).sum();
            let summands = tables.gradient[row.clone()].iter().zip(&nodal).map(|(g, u)| (g[k] * u).abs());
            let size = summands.fold(1.0, f64::max);
            assert!((derivative - slope[k]).abs() < 1e-12 * size, "{element:?}");
        }
    }
}

// Central differences of fourth order are exact for the degrees that exist, up to round-off.
fn check_differences<const D: usize>(element: Lagrange) {
    let step = 0.1;
    for point in samples::<D>() {
        let centre = element.tabulate_with_hessians(&[point]);
        for k in 0..D {
            let around = [-2.0, -1.0, 1.0, 2.0].map(|steps| {
                let mut moved = point;
                moved[k] += steps * step;
                moved
            });
            let tables = element.tabulate(&around);
            let weights = [1.0, -8.0, 8.0, -1.0].map(|weight| weight / (12.0 * step));
            let largest = |found: &dyn Fn(usize) -> f64| {
                (0..tables.nodes * 4).fold(1.0_f64, |largest, index| largest.max(found(index).abs()))
            };
            let check = |found: &dyn Fn(usize) -> f64, node: usize, expected: f64| {
                let products =
                    weights.iter().enumerate().map(|(q, weight)| weight * found(q * tables.nodes + node));
                let difference = products.sum::<f64>() - expected;
                assert!(difference.abs() < 1e-13 * largest(found), "{element:?}: {difference}");
            };
            for i in 0..tables.nodes {
                check(&|index| tables.value[index], i, centre.gradient[i][k]);
                for l in 0..D {
                    check(&|index| tables.gradient[index][l], i, centre.hessian[i][k][l]);
                }
            }
        }
    }
}

#[test]
fn basis_is_one_at_its_node_and_zero_at_the_others() {
    for element in elements() {
        if element.shape.dimension() == 2 { check_nodes::<2>(element) } else { check_nodes::<3>(element) }
    }
}

#[test]
fn polynomials_of_the_space_are_reproduced() {
    for element in elements() {
        if element.shape.dimension() == 2 {
            check_reproduction::<2>(element);
            check_differences::<2>(element);
        } else {
            check_reproduction::<3>(element);
            check_differences::<3>(element);
        }
    }
}

#[test]
fn facet_nodes_are_those_on_the_facet() {
    for element in elements().filter(|element| element.shape.dimension() == 3) {
        let points = element.node_points::<3>();
        for local in 0..element.shape.facets() {
            let on_facet = |x: &[f64; 3]| match (element.shape, local) {
                (CellShape::Tetrahedron, 0) => x.iter().sum::<f64>() == 1.0,
                (CellShape::Tetrahedron, f) => x[f - 1] == 0.0,
                (_, f) => [x[2] == 0.0, x[2] == 1.0, x[1] == 0.0, x[0] == 1.0, x[1] == 1.0, x[0] == 0.0][f],
            };
            let expected: Vec<usize> = (0..points.len()).filter(|&i| on_facet(&points[i])).collect();
            let mut nodes = element.facet_nodes(local);
            nodes.sort_unstable();
            assert_eq!(nodes, expected, "{element:?} facet {local}");
        }
    }
    let quadratic = Lagrange { shape: CellShape::Quadrilateral, degree: 2 };
    assert_eq!(quadratic.facet_nodes(3), [3, 0, 7]);
}

#[test]
fn other_degrees_are_errors() {
    let message = Lagrange::new(CellShape::Triangle, 5).map_err(|error| error.to_string());
    assert_eq!(
        message,
        Err("there is no Lagrange element of degree 5 on the triangle; the degrees are 1 to 4".into())
    );
    assert!(Lagrange::new(CellShape::Hexahedron, 0).is_err());
}
