//! Folds and overlaps of a mesh's cells, found from only nodes and numbers: basis functions, quadrature and facets are written a second time, from
//! the public description of the order of nodes.

use forms_fem::element::CellShape;
use forms_fem::mesh::Mesh;

/// In how many random points of each cell the determinant is sampled.
const SAMPLES: usize = 40;

/// Gauss's rule with four points on [0, 1], exact up to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Positions of a cell's nodes on the reference cell, in halves: vertices, middles of edges and faces, and of the cell.
fn node_halves(shape: CellShape, degree: usize) -> Vec<[i32; 3]> {
    let vertices: Vec<[i32; 3]> = match shape {
        CellShape::Triangle => vec![[0, 0, 0], [2, 0, 0], [0, 2, 0]],
        CellShape::Quadrilateral => vec![[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]],
        CellShape::Tetrahedron => vec![[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]],
        CellShape::Hexahedron => {
            let square = [[0, 0], [2, 0], [2, 2], [0, 2]];
            [0, 2].iter().flat_map(|z| square.map(|[x, y]| [x, y, *z])).collect()
        }
    };
    if degree == 1 {
        return vertices;
    }
    let groups: &[&[usize]] = match shape {
        CellShape::Triangle => &[&[0, 1], &[1, 2], &[2, 0]],
        CellShape::Quadrilateral => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 1, 2, 3]],
        CellShape::Tetrahedron => &[&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]],
        CellShape::Hexahedron => &[
            &[0, 1],
            &[1, 2],
            &[2, 3],
            &[3, 0],
            &[4, 5],
            &[5, 6],
            &[6, 7],
            &[7, 4],
            &[0, 4],
            &[1, 5],
            &[2, 6],
            &[3, 7],
            &[0, 1, 2, 3],
            &[4, 5, 6, 7],
            &[0, 1, 4, 5],
            &[1, 2, 5, 6],
            &[2, 3, 6, 7],
            &[0, 3, 4, 7],
            &[0, 1, 2, 3, 4, 5, 6, 7],
        ],
    };
    let middle = |group: &&[usize]| -> [i32; 3] {
        std::array::from_fn(|k| group.iter().map(|v| vertices[*v][k]).sum::<i32>() / group.len() as i32)
    };
    vertices.iter().copied().chain(groups.iter().map(middle)).collect()
}

/// Value and slope at t of the polynomial of degree 1 or 2 that is 1 at `half`/2 and 0 at the other nodes.
fn on_axis(degree: usize, half: i32, t: f64) -> (f64, f64) {
    match (degree, half) {
        (1, 0) => (1.0 - t, -1.0),
        (1, _) => (t, 1.0),
        (_, 0) => ((1.0 - t) * (1.0 - 2.0 * t), 4.0 * t - 3.0),
        (_, 1) => (4.0 * t * (1.0 - t), 4.0 - 8.0 * t),
        _ => (t * (2.0 * t - 1.0), 4.0 * t - 1.0),
    }
}

/// Value and gradient of a basis function.
fn basis(shape: CellShape, degree: usize, halves: [i32; 3], x: [f64; 3]) -> (f64, [f64; 3]) {
    if matches!(shape, CellShape::Quadrilateral | CellShape::Hexahedron) {
        let plane = shape == CellShape::Quadrilateral;
        let axis: Vec<(f64, f64)> = (0..3)
            .map(|k| if plane && k == 2 { (1.0, 0.0) } else { on_axis(degree, halves[k], x[k]) })
            .collect();
        let slope = |k: usize| (0..3).map(|l| if l == k { axis[l].1 } else { axis[l].0 }).product();
        return (axis.iter().map(|(value, _)| value).product(), std::array::from_fn(slope));
    }
    // Barycentric coordinates, the vertex at the origin last.
    let lambda = [x[0], x[1], x[2], 1.0 - x[0] - x[1] - x[2]];
    let slope = |b: usize, k: usize| {
        if b == k {
            1.0
        } else if b == 3 {
            -1.0
        } else {
            0.0
        }
    };
    let weights = [halves[0], halves[1], halves[2], 2 - halves[0] - halves[1] - halves[2]];
    let full = weights.iter().position(|weight| *weight == 2);
    match (degree, full) {
        (1, Some(b)) => (lambda[b], std::array::from_fn(|k| slope(b, k))),
        (_, Some(b)) => {
            let factor = 4.0 * lambda[b] - 1.0;
            (lambda[b] * (2.0 * lambda[b] - 1.0), std::array::from_fn(|k| factor * slope(b, k)))
        }
        _ => {
            let ends: Vec<usize> = (0..4).filter(|b| weights[*b] == 1).collect();
            let [a, b] = [ends[0], ends[1]];
            let gradient = |k| 4.0 * (lambda[a] * slope(b, k) + lambda[b] * slope(a, k));
            (4.0 * lambda[a] * lambda[b], std::array::from_fn(gradient))
        }
    }
}

/// A cell's map: position and columns of the Jacobian. The third axis is one of its own in the plane.
fn map<const D: usize>(mesh: &Mesh<D>, cell: usize, at: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let (shape, degree) = (mesh.cell_shape(cell), mesh.degree());
    let (mut x, mut columns) = ([0.0; 3], [[0.0; 3]; 3]);
    // Relative to a node, so that a mesh far from the origin is judged by its own digits.
    let origin = mesh.nodes()[mesh.cell(cell)[0] as usize];
    for (&node, halves) in mesh.cell(cell).iter().zip(node_halves(shape, degree)) {
        let (value, slope) = basis(shape, degree, halves, at);
        for i in 0..D {
            let from = mesh.nodes()[node as usize][i] - origin[i];
            x[i] += value * from;
            (0..D).for_each(|j| columns[j][i] += slope[j] * from);
        }
    }
    if D == 2 {
        columns[2] = [0.0, 0.0, 1.0];
    }
    (x, columns)
}

fn triple([a, b, c]: [[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// Points and weights on the unit square or cube, collapsed to the simplex where one is asked for.
fn rule(dimension: usize, simplex: bool) -> Vec<([f64; 3], f64)> {
    let mut points = vec![([0.0; 3], 1.0)];
    for k in 0..dimension {
        let with = |(mut x, weight): ([f64; 3], f64), (t, own): (f64, f64)| {
            x[k] = t;
            (x, weight * own)
        };
        points = points.iter().flat_map(|point| GAUSS.map(|gauss| with(*point, gauss))).collect();
    }
    if simplex {
        for (x, weight) in &mut points {
            match dimension {
                2 => {
                    *weight *= 1.0 - x[0];
                    x[1] *= 1.0 - x[0];
                }
                3 => {
                    let left = 1.0 - x[0];
                    *weight *= left * left * (1.0 - x[1]);
                    (x[1], x[2]) = (x[1] * left, x[2] * left * (1.0 - x[1]));
                }
                _ => {}
            }
        }
    }
    points
}

/// ∫ det J over a cell.
fn volume<const D: usize>(mesh: &Mesh<D>, cell: usize) -> f64 {
    let simplex = matches!(mesh.cell_shape(cell), CellShape::Triangle | CellShape::Tetrahedron);
    rule(D, simplex).into_iter().map(|(at, weight)| weight * triple(map(mesh, cell, at).1)).sum()
}

/// ∫ (x − o)·n / D over a facet given by its corners on the reference cell, which run around it seen from outside.
fn flux<const D: usize>(mesh: &Mesh<D>, cell: usize, corners: &[[f64; 3]], origin: [f64; D]) -> f64 {
    let shift: [f64; 3] = std::array::from_fn(|i| {
        if i < D { mesh.nodes()[mesh.cell(cell)[0] as usize][i] - origin[i] } else { 0.0 }
    });
    let [first, next, last] = [corners[0], corners[1], corners[corners.len() - 1]];
    let along = |to: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| to[k] - first[k]) };
    let mut sum = 0.0;
    for (s, weight) in rule(D - 1, corners.len() == 3) {
        let at: [f64; 3] = std::array::from_fn(|k| {
            first[k] + s[0] * along(next)[k] + if D == 3 { s[1] * along(last)[k] } else { 0.0 }
        });
        let (x, columns) = map(mesh, cell, at);
        let image =
            |t: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| (0..D).map(|j| columns[j][i] * t[j]).sum()) };
        // In the plane the second tangent is the third axis: t × e₃ points out.
        let second = if D == 2 { [0.0, 0.0, 1.0] } else { image(along(last)) };
        let from = std::array::from_fn(|i| x[i] + shift[i]);
        sum += weight * triple([from, image(along(next)), second]) / D as f64;
    }
    sum
}

/// Determinants in random points, and the sum of volumes compared with the integral of x·n/D over the boundary: both of every
/// facet that belongs to one cell only, found here by its vertices, and exact, so that neighbours on one side of their
/// facet, or with different nodes on it, leave a difference.
pub fn check_unfolded<const D: usize>(mesh: &Mesh<D>) {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let origin = mesh.nodes()[mesh.cell(0)[0] as usize];
    let (mut volumes, mut absolute) = (0.0, 0.0_f64);
    let mut facets: std::collections::BTreeMap<Vec<u32>, (u32, f64)> = std::collections::BTreeMap::new();
    for cell in 0..mesh.cell_count() {
        let shape = mesh.cell_shape(cell);
        let simplex = matches!(shape, CellShape::Triangle | CellShape::Tetrahedron);
        for _ in 0..SAMPLES {
            let mut at = [random(), random(), if D == 3 { random() } else { 0.0 }];
            if simplex && at.iter().sum::<f64>() > 1.0 {
                let sum: f64 = at.iter().sum();
                at = at.map(|x| x / sum * random());
            }
            let columns = map(mesh, cell, at).1;
            assert!(triple(columns) > 0.0, "cell {cell} is folded at {at:?}: {}", triple(columns));
        }
        let own = volume(mesh, cell);
        assert!(own > 0.0);
        volumes += own;
        let corners = node_halves(shape, 1);
        let around: &[&[usize]] = match shape {
            CellShape::Triangle => &[&[0, 1], &[1, 2], &[2, 0]],
            CellShape::Quadrilateral => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
            CellShape::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
            CellShape::Hexahedron => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
        };
        for facet in around {
            let places: Vec<[f64; 3]> =
                facet.iter().map(|v| corners[*v].map(|h| 0.5 * f64::from(h))).collect();
            let own = flux(mesh, cell, &places, origin);
            absolute += own.abs();
            let mut key: Vec<u32> = facet.iter().map(|v| mesh.cell(cell)[*v]).collect();
            key.sort_unstable();
            let entry = facets.entry(key).or_insert((0, 0.0));
            *entry = (entry.0 + 1, entry.1 + own);
        }
    }
    let boundary: f64 = facets.values().filter(|(cells, _)| *cells == 1).map(|(_, flux)| flux).sum();
    // A corner at 1e308 is legal, and then these sums may be beyond all numbers.
    if !absolute.is_finite() {
        return;
    }
    let difference = (volumes - boundary).abs();
    assert!(difference <= 1e-9 * absolute, "volumes {volumes}, boundary integral {boundary} of {absolute}");
}
