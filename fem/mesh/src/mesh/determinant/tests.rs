//! The sign of determinants whose least value is known, and of random cells compared with samples.

use super::*;

fn element(shape: CellShape, degree: usize) -> Lagrange {
    Lagrange { shape, degree }
}

/// Numbers in [-1, 1) by Marsaglia's xorshift.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn jacobian<const D: usize>(element: &Lagrange, nodes: &[[f64; D]], point: [f64; D]) -> f64 {
    let slopes = element.tabulate(&[point]).gradient;
    let entry = |i: usize, j: usize| nodes.iter().zip(&slopes).map(|(x, slope)| x[i] * slope[j]).sum();
    determinant::<D>(&std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}

// The expansion and its halves have the determinant's values at vertices of the parts.
fn check_expansion<const D: usize>(element: Lagrange) {
    let mut random = Random(7);
    let mut nodes = element.node_points::<D>();
    nodes.iter_mut().flatten().for_each(|x| *x += 0.3 * random.next());
    let tested = JacobianDeterminant::<D>::new(&element);
    let expansion = tested.expand();
    let columns: [Vec<[f64; D]>; D] = std::array::from_fn(|axis| {
        let sum = |terms: &Vec<(usize, f64)>| -> [f64; D] {
            std::array::from_fn(|i| terms.iter().map(|(node, weight)| weight * nodes[*node][i]).sum())
        };
        tested.controls[axis].iter().map(sum).collect()
    });
    let mut coefficients = vec![0.0; expansion.length];
    for (factors, place, weight) in &expansion.terms {
        let matrix = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][usize::from(factors[j])][i]));
        coefficients[usize::from(*place)] += weight * determinant::<D>(&matrix);
    }
    let vertices = match element.shape.is_simplex() {
        true => element.shape.vertex_points().iter().map(|x| std::array::from_fn(|k| x[k])).collect(),
        false => vec![[0.0; D], [1.0; D]],
    };
    let mut parts = vec![Part { coefficients, vertices, depth: 0 }];
    for _ in 0..4 {
        for part in &parts {
            for (place, ends) in &expansion.corners {
                let expected = jacobian(&element, &nodes, part.corner(ends));
                assert!((part.coefficients[*place] - expected).abs() < 1e-12, "{element:?}");
            }
        }
        parts = parts.iter().flat_map(|part| part.halves(&expansion)).collect();
    }
}

#[test]
fn coefficients_at_vertices_are_values() {
    for degree in 1..=2 {
        check_expansion::<2>(element(CellShape::Triangle, degree));
        check_expansion::<2>(element(CellShape::Quadrilateral, degree));
        check_expansion::<3>(element(CellShape::Tetrahedron, degree));
        check_expansion::<3>(element(CellShape::Hexahedron, degree));
    }
}

// Whatever is called positive is so on a fine grid of samples; whatever is called folded is so at the point named.
fn compare_with_samples<const D: usize>(element: Lagrange, distortion: f64, steps: usize) {
    // Long sweeps run where they are asked for.
    let count = if std::env::var("FORMS_SWEEPS").is_ok_and(|value| value == "1") { 200_000 } else { 300 };
    let mut random = Random(11);
    let tested = JacobianDeterminant::<D>::new(&element);
    let numbers: Vec<u32> = (0..element.nodes() as u32).collect();
    let samples: Vec<[f64; D]> = (0..(steps + 1).pow(D as u32))
        .map(|index| {
            std::array::from_fn(|k| (index / (steps + 1).pow(k as u32) % (steps + 1)) as f64 / steps as f64)
        })
        .filter(|point| element.shape.contains(point, 1e-15))
        .collect();
    let tables = element.tabulate(&samples);
    let (mut positive, mut folded) = (0, 0);
    for number in 0..count {
        let mut nodes = element.node_points::<D>();
        // From cells that are nearly affine to cells that are nearly all folded.
        let distortion = distortion * 0.2 * f64::from(1 + number % 10);
        nodes.iter_mut().flatten().for_each(|x| *x += distortion * random.next());
        match tested.sign(&numbers, &nodes) {
            Sign::Positive => {
                positive += 1;
                for slopes in tables.gradient.chunks(tables.nodes) {
                    let entry = |i: usize, j: usize| nodes.iter().zip(slopes).map(|(x, s)| x[i] * s[j]).sum();
                    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
                    assert!(determinant::<D>(&matrix) > 0.0, "{element:?} {nodes:?}");
                }
            }
            Sign::Folded { reference, determinant } => {
                folded += 1;
                assert!(element.shape.contains(&reference, 1e-15) && determinant <= 1e-12);
                assert!((jacobian(&element, &nodes, reference) - determinant).abs() < 1e-12);
            }
            Sign::Undecided { .. } => panic!("{element:?} {nodes:?}"),
        }
    }
    assert!(positive > 30 && folded > 30, "{element:?}: {positive} positive, {folded} folded");
}

#[test]
fn random_cells_agree_with_samples() {
    compare_with_samples::<2>(element(CellShape::Triangle, 2), 0.17, 20);
    compare_with_samples::<2>(element(CellShape::Quadrilateral, 1), 0.6, 10);
    compare_with_samples::<2>(element(CellShape::Quadrilateral, 2), 0.15, 20);
    compare_with_samples::<3>(element(CellShape::Tetrahedron, 2), 0.1, 10);
    compare_with_samples::<3>(element(CellShape::Hexahedron, 1), 0.3, 8);
    compare_with_samples::<3>(element(CellShape::Hexahedron, 2), 0.09, 6);
}

#[test]
fn a_determinant_that_is_least_between_the_nodes() {
    let element = element(CellShape::Quadrilateral, 2);
    let tested = JacobianDeterminant::<2>::new(&element);
    let numbers: Vec<u32> = (0..9).collect();
    // x = ξ, y = η (c + (ξ − s)²): det J = c + (ξ − s)², least at ξ = s, far from nodes and Gauss points.
    for (least, is_positive) in [(1e-6, true), (0.0, false), (-1e-6, false)] {
        for s in [0.3, 1.0 / 3.0, 0.71] {
            let map = |p: [f64; 2]| [p[0], p[1] * (least + (p[0] - s) * (p[0] - s))];
            let nodes: Vec<[f64; 2]> = element.node_points::<2>().into_iter().map(map).collect();
            let sign = tested.sign(&numbers, &nodes);
            assert_eq!(sign == Sign::Positive, is_positive, "{least} {s}: {sign:?}");
            if let Sign::Folded { reference, .. } = sign {
                assert!((reference[0] - s).abs() < 1e-2);
            }
        }
    }
}

// A determinant that nearly vanishes along a curve is refused by name, after bounded work.
#[test]
fn what_cannot_be_decided_is_said() {
    let element = element(CellShape::Hexahedron, 2);
    let tested = JacobianDeterminant::<3>::new(&element);
    let numbers: Vec<u32> = (0..27).collect();
    // det J = c + (ξ + η − 0.9)², on a plane through the cell.
    let map = |p: [f64; 3]| {
        let across = p[0] + p[1] - 0.9;
        [p[0], p[1], p[2] * (1e-9 + across * across)]
    };
    let nodes: Vec<[f64; 3]> = element.node_points::<3>().into_iter().map(map).collect();
    let sign = tested.sign(&numbers, &nodes);
    assert!(matches!(sign, Sign::Undecided { .. }), "{sign:?}");
}
