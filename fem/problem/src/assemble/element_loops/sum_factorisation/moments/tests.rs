//! Sums by moments against plain sums over the points, and the grids that have none.

use super::*;
use crate::element::{CellShape, Lagrange};
use crate::quadrature::cell_rule;

/// Numbers in [−1, 1] that are the same each time.
fn noise(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Sums by moments of any coefficients against sums over the points of tabulated basis functions.
fn compare<const D: usize>(
    shape: CellShape,
    degree: usize,
    components: [usize; 2],
    value: bool,
    symmetric: bool,
) {
    let element = Lagrange::new(shape, degree).unwrap();
    let rule = cell_rule::<D>(shape, 2 * degree + 1).unwrap();
    let tables = ProductTables::new(&element, &rule.points).unwrap();
    let derivatives = Derivatives { value, gradient: true };
    let moments = Moments::new::<D>(&tables, derivatives, components, symmetric).unwrap();
    let (kinds, points, entries) =
        (derivatives.count::<D>(), rule.points.len(), components[0] * components[1]);
    // Coefficients of derivatives on the reference cell: of pairs (s, t), entries and points.
    let place = |s: usize, t: usize, entry: usize, q: usize| ((s * kinds + t) * entries + entry) * points + q;
    let transposed = |entry: usize| entry % components[1] * components[1] + entry / components[1];
    let mut state = 3;
    let mut coefficients: Vec<f64> =
        (0..kinds * kinds * entries * points).map(|_| noise(&mut state)).collect();
    if symmetric {
        for (s, t) in (0..kinds).flat_map(|s| (s..kinds).map(move |t| (s, t))) {
            for (entry, q) in (0..entries).flat_map(|entry| (0..points).map(move |q| (entry, q))) {
                coefficients[place(t, s, transposed(entry), q)] = coefficients[place(s, t, entry, q)];
            }
        }
    }
    let mut numbers = vec![];
    for (s, t) in (0..kinds).flat_map(|s| (if symmetric { s } else { 0 }..kinds).map(move |t| (s, t))) {
        // The kernel is asked for functions whose derivative in u is one, which on the reference cell have another.
        let orders = [s, t].into_iter().filter(|k| derivatives.kind(*k) > 0).count();
        for entry in 0..entries {
            let start = numbers.len();
            numbers.resize(start + points, 0.0);
            for q in 0..points {
                numbers[start + tables.place_of[q] as usize] =
                    coefficients[place(s, t, entry, q)] * moments.slope.powi(orders as i32);
            }
        }
    }
    let mut sums = vec![f64::NAN; moments.length::<D>()];
    moments.sum::<f64, D>(&numbers, &mut vec![], &mut sums);
    let table = element.tabulate(&rule.points);
    let function = |node: usize, kind: usize, q: usize| match derivatives.kind(kind) {
        0 => table.value[q * table.nodes + node],
        axis => table.gradient[q * table.nodes + node][axis - 1],
    };
    let nodes = table.nodes;
    let pairs = if symmetric { nodes * (nodes + 1) / 2 } else { nodes * nodes };
    let computed = Order::new((0..(pairs * entries) as u32).collect(), 1);
    let mut places = moments.order::<D>(&tables, &computed, 1).places().collect::<Vec<_>>().into_iter();
    for i in 0..nodes {
        for j in if symmetric { i } else { 0 }..nodes {
            for entry in 0..entries {
                let mut expected = 0.0;
                for s in 0..kinds {
                    for t in 0..kinds {
                        for q in 0..points {
                            expected +=
                                coefficients[place(s, t, entry, q)] * function(i, s, q) * function(j, t, q);
                        }
                    }
                }
                let found = sums[places.next().unwrap() as usize];
                assert!((found - expected).abs() < 1e-12, "{i} {j} {entry}: {found} is not {expected}");
            }
        }
    }
}

#[test]
fn sums_by_moments_are_sums_over_the_points() {
    for degree in [1, 2] {
        for value in [false, true] {
            for (components, symmetric) in [([1, 1], true), ([2, 2], true), ([2, 2], false), ([2, 1], false)]
            {
                compare::<2>(CellShape::Quadrilateral, degree, components, value, symmetric);
            }
        }
        compare::<3>(CellShape::Hexahedron, degree, [3, 3], false, true);
        compare::<3>(CellShape::Hexahedron, degree, [3, 1], true, false);
    }
}

#[test]
fn other_rules_and_degrees_have_no_moments() {
    let quadrilateral = |degree: usize| Lagrange::new(CellShape::Quadrilateral, degree).unwrap();
    let rule = |degree: usize| cell_rule::<2>(CellShape::Quadrilateral, degree).unwrap().points;
    let derivatives = Derivatives { value: false, gradient: true };
    for (degree, points, has) in [(1, 3, true), (1, 5, false), (2, 3, false), (2, 5, true), (3, 7, false)] {
        let tables = ProductTables::new(&quadrilateral(degree), &rule(points)).unwrap();
        assert_eq!(
            Moments::new::<2>(&tables, derivatives, [1, 1], true).is_some(),
            has,
            "{degree}, {points}"
        );
    }
}
