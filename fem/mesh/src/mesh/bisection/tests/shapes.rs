//! Shapes of bisected cells: angles in the plane, classes of similar tetrahedra.

use super::*;

/// The least angle of the triangle, by its vertices.
pub(super) fn least_angle(mesh: &Mesh<2>, cell: usize) -> f64 {
    let x: Vec<[f64; 2]> = mesh.cell_vertices(cell).iter().map(|node| mesh.nodes[*node as usize]).collect();
    let angle = |k: usize| {
        let [a, b] = [1, 2].map(|next| {
            let other = x[(k + next) % 3];
            [other[0] - x[k][0], other[1] - x[k][1]]
        });
        (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
    };
    (0..3).map(angle).fold(f64::INFINITY, f64::min)
}

/// The shape of a tetrahedron except for its size, place and handedness: squares of its edges, which are exact in meshes whose
/// nodes have coordinates of few binary digits.
pub(super) fn similarity_class(x: &[[f64; 3]; 4]) -> Vec<u64> {
    let squared = |a: usize, b: usize| -> f64 { (0..3).map(|k| (x[a][k] - x[b][k]).powi(2)).sum() };
    let edges = |order: [usize; 4]| {
        [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|[a, b]| squared(order[a], order[b]))
    };
    let mut best = [0.0; 6];
    for a in 0..4 {
        for b in (0..4).filter(|b| *b != a) {
            for c in (0..4).filter(|c| *c != a && *c != b) {
                let lengths = edges([a, b, c, 6 - a - b - c]);
                if lengths > best {
                    best = lengths;
                }
            }
        }
    }
    // Squares halve, or stay: relative to a power of two the numbers are whole.
    let whole: Vec<u64> = best.iter().map(|square| (square * (1_u64 << 40) as f64) as u64).collect();
    assert!(best.iter().zip(&whole).all(|(square, whole)| square * (1_u64 << 40) as f64 == *whole as f64));
    let divisor = whole.iter().fold(0, |a, b| greatest_common_divisor(a, *b));
    whole.into_iter().map(|square| square / divisor).collect()
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// All descendants of tetrahedra without symmetry: 36 classes where the first marked edges lie in a plane (J. Maubach,
/// Local bisection refinement for n-simplicial grids, 1995), and otherwise its own and 36 of each half.
#[test]
fn similar_to_one_of_finitely_many() {
    let shape = CellShape::Tetrahedron;
    let mut random = Random(3);
    let (mut planar, count) = (0, markings(200, 12));
    for _ in 0..count {
        let x: [[f64; 3]; 4] =
            std::array::from_fn(|_| std::array::from_fn(|_| 2.0 * random.below(500) as f64));
        let lengths =
            shape.edges().iter().map(|&[a, b]| -> f64 { (0..3).map(|k| (x[a][k] - x[b][k]).powi(2)).sum() });
        let lengths: Vec<f64> = lengths.collect();
        let marks = MarkedEdges::longest(shape, |edge| (lengths[edge], edge));
        let mut generation = vec![(x, marks)];
        let mut classes = BTreeSet::from([similarity_class(&x)]);
        let mut after_nine = 0;
        for number in 1..=11 {
            let mut next = Vec::with_capacity(2 * generation.len());
            for (x, marks) in &generation {
                let [a, b] = shape.edges()[marks.refinement_edge()];
                let middle = std::array::from_fn(|k| 0.5 * (x[a][k] + x[b][k]));
                for part in Part::BOTH {
                    let mut of_part = *x;
                    of_part[part.kept_and_new([a, b])[1]] = middle;
                    classes.insert(similarity_class(&of_part));
                    next.push((of_part, marks.of_part(shape, part)));
                }
            }
            generation = next;
            if number == 9 {
                after_nine = classes.len();
            }
        }
        assert_eq!(classes.len(), after_nine);
        match marks.lie_in_a_plane() {
            true => assert_eq!(classes.len(), 36),
            false => assert!(classes.len() <= 73, "{}", classes.len()),
        }
        planar += usize::from(marks.lie_in_a_plane());
    }
    assert!(planar > 0 && planar < count);
}

/// Kuhn's tetrahedra and right isosceles triangles keep their shapes: 3 classes, and 1.
#[test]
fn grids_keep_their_shapes() -> Result<(), MeshError> {
    let mut cube = BisectedMesh::new(cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Tetrahedron, 1)?)?;
    let mut square = BisectedMesh::new(rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?)?;
    let mut classes = BTreeSet::new();
    for generation in 1..=9 {
        let all: Vec<u32> = (0..cube.mesh.cell_count() as u32).collect();
        cube = cube.refined(&all)?.0;
        // Every cell once: nothing else had to be bisected.
        assert_eq!(cube.mesh.cell_count(), 6 << generation);
        for cell in 0..cube.mesh.cell_count() {
            let vertices = cube.mesh.cell_vertices(cell);
            classes.insert(similarity_class(&std::array::from_fn(|k| cube.mesh.nodes[vertices[k] as usize])));
        }
        let all: Vec<u32> = (0..square.mesh.cell_count() as u32).collect();
        square = square.refined(&all)?.0;
        assert_eq!(square.mesh.cell_count(), 8 << generation);
        for cell in 0..square.mesh.cell_count() {
            close(least_angle(&square.mesh, cell), std::f64::consts::FRAC_PI_4, 1e-12);
        }
    }
    assert_eq!(classes.len(), 3);
    Ok(())
}
