//! Exactness on all monomials, for every shape, degree and facet.

use super::*;

// ∫ x^a y^b z^c over the reference cell.
fn exact(shape: CellShape, powers: [usize; 3]) -> f64 {
    if shape.is_simplex() {
        // a! b! c! / (a + b + c + D)!
        let mut result = 1.0;
        let mut next = 1;
        for power in powers {
            for k in 1..=power {
                result *= k as f64 / next as f64;
                next += 1;
            }
        }
        for _ in 0..shape.dimension() {
            result /= next as f64;
            next += 1;
        }
        result
    } else {
        powers.iter().map(|&power| 1.0 / (power + 1) as f64).product()
    }
}

// All monomials up to the degree: total on simplices, per direction on the others.
fn monomials(shape: CellShape, degree: usize) -> Vec<[usize; 3]> {
    let last = if shape.dimension() == 3 { degree } else { 0 };
    let mut result = Vec::new();
    for a in 0..=degree {
        for b in 0..=degree {
            for c in 0..=last {
                if !shape.is_simplex() || a + b + c <= degree {
                    result.push([a, b, c]);
                }
            }
        }
    }
    result
}

fn check_cell<const D: usize>(shape: CellShape) {
    for degree in 0..=20 {
        let rule = cell_rule::<D>(shape, degree).expect("degrees to 20 exist");
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            assert!(shape.contains(point, 0.0) && *weight > 0.0, "{shape:?} {degree}");
        }
        // powers[q][k][p] = x_k^p
        let powers: Vec<[Vec<f64>; D]> = rule
            .points
            .iter()
            .map(|point| point.map(|x| (0..=degree).map(|p| x.powi(p as i32)).collect()))
            .collect();
        for monomial in monomials(shape, degree) {
            let sum: f64 = powers
                .iter()
                .zip(&rule.weights)
                .map(|(x, weight)| weight * (0..D).map(|k| x[k][monomial[k]]).product::<f64>())
                .sum();
            let error = (sum - exact(shape, monomial)).abs();
            assert!(error < 1e-13, "{shape:?} degree {degree} monomial {monomial:?}: {error:e}");
        }
    }
}

#[test]
fn cell_rules_integrate_all_monomials() {
    check_cell::<2>(CellShape::Triangle);
    check_cell::<2>(CellShape::Quadrilateral);
    check_cell::<3>(CellShape::Tetrahedron);
    check_cell::<3>(CellShape::Hexahedron);
}

// Gauss's theorem on the reference cell: the sum over the facets of ∫ x_j^(p+1) x_k^q n_j equals
// (p + 1) ∫ x_j^p x_k^q. It checks points, weights, tangents and orientation at once.
fn check_facets<const D: usize>(shape: CellShape) {
    for degree in 0..=20 {
        for j in 0..D {
            let k = (j + 1) % D;
            for p in 0..degree {
                let q = degree - 1 - p;
                let mut flux = 0.0;
                for local in 0..shape.facets() {
                    let rule = facet_rule::<D>(shape, local, degree).expect("degrees to 20 exist");
                    let [s, t] = rule.tangents;
                    let (a, b) = ((j + 1) % D, (j + 2) % D);
                    // n_j times the surface element.
                    let normal = match (D, j) {
                        (2, 0) => s[1],
                        (2, _) => -s[0],
                        _ => s[a] * t[b] - s[b] * t[a],
                    };
                    for (x, weight) in rule.points.iter().zip(&rule.weights) {
                        flux += weight * x[j].powi(p as i32 + 1) * x[k].powi(q as i32) * normal;
                    }
                }
                let mut powers = [0; 3];
                (powers[j], powers[k]) = (p, q);
                let expected = (p + 1) as f64 * exact(shape, powers);
                assert!((flux - expected).abs() < 1e-13, "{shape:?} degree {degree}: {flux} {expected}");
            }
        }
    }
}

#[test]
fn facet_rules_satisfy_the_theorem_of_gauss() {
    check_facets::<2>(CellShape::Triangle);
    check_facets::<2>(CellShape::Quadrilateral);
    check_facets::<3>(CellShape::Tetrahedron);
    check_facets::<3>(CellShape::Hexahedron);
}

#[test]
fn numbers_of_points() {
    let count = |shape, degree| cell_rule::<2>(shape, degree).map(|rule| rule.len());
    assert_eq!(count(CellShape::Quadrilateral, 8), Ok(25));
    let triangle = [1, 2, 4, 5, 6, 7, 8, 9].map(|d| count(CellShape::Triangle, d));
    assert_eq!(triangle, [1, 3, 6, 7, 12, 15, 16, 19].map(Ok));
    let count = |degree| cell_rule::<3>(CellShape::Tetrahedron, degree).map(|rule| rule.len());
    assert_eq!([1, 2, 3, 5, 6, 7].map(count), [1, 4, 8, 14, 24, 35].map(Ok));
    assert_eq!(facet_rule::<3>(CellShape::Hexahedron, 5, 3).map(|rule| rule.points.len()), Ok(4));
}

fn explicit(points: &[[f64; 2]], weights: &[f64], facet: &[(f64, f64)]) -> Quadrature<2> {
    Quadrature::Explicit {
        cell: QuadratureRule { points: points.to_vec(), weights: weights.to_vec() },
        facet: QuadratureRule::on_segment(facet),
    }
}

#[test]
fn explicit_rules_are_mapped_to_each_facet() {
    let rule = explicit(&[[0.25, 0.5]], &[1.0], &[(0.25, 1.0)]);
    assert_eq!(rule.cell_rule(CellShape::Quadrilateral, 9).map(|rule| rule.points), Ok(vec![[0.25, 0.5]]));
    let point = |shape, local| rule.facet_rule(shape, local, 9).map(|rule| rule.points[0]);
    let points: Vec<_> = (0..4).map(|local| point(CellShape::Quadrilateral, local)).collect();
    assert_eq!(points, [Ok([0.25, 0.0]), Ok([1.0, 0.25]), Ok([0.75, 1.0]), Ok([0.0, 0.75])]);
    assert_eq!(point(CellShape::Triangle, 1), Ok([0.75, 0.25]));
}

#[test]
fn bad_rules_are_named() {
    let message = |rule: Quadrature<2>| {
        let cell = rule.cell_rule(CellShape::Triangle, 1).err();
        cell.or(rule.facet_rule(CellShape::Triangle, 0, 1).err()).map(|error| error.to_string())
    };
    let good = [(0.5, 1.0)];
    assert_eq!(message(explicit(&[[0.2, 0.2]], &[0.5], &good)), None);
    assert_eq!(
        message(explicit(&[[0.7, 0.7]], &[0.5], &good)).as_deref(),
        Some("point 0 of the explicit cell rule, [0.7, 0.7], lies outside the reference triangle")
    );
    assert_eq!(
        message(explicit(&[[0.2, 0.2]], &[f64::NAN], &good)).as_deref(),
        Some("point 0 of the explicit cell rule has a coordinate or weight that is not finite")
    );
    assert_eq!(
        message(explicit(&[[0.2, 0.2]], &[], &good)).as_deref(),
        Some("the explicit cell rule has 1 points and 0 weights")
    );
    assert_eq!(
        message(explicit(&[[0.2, 0.2]], &[0.5], &[])).as_deref(),
        Some("the explicit facet rule has no points")
    );
    assert_eq!(
        message(explicit(&[[0.2, 0.2]], &[0.5], &[(1.5, 1.0)])).as_deref(),
        Some("point 0 of the explicit facet rule, [1.5, 0.0], lies outside the reference segment")
    );
    assert_eq!(
        message(Quadrature::Degree(101)).as_deref(),
        Some("quadrature degree 101 is too high; the highest is 100")
    );
    assert_eq!(
        cell_rule::<3>(CellShape::Triangle, 1).map_err(|error| error.to_string()),
        Err("a triangle has 2 reference coordinates, not 3".into())
    );
    assert_eq!(
        facet_rule::<2>(CellShape::Triangle, 3, 1).map_err(|error| error.to_string()),
        Err("a triangle has no facet 3; its facets are 0 to 2".into())
    );
}
