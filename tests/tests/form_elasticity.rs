//! a(u, v): element matrices in closed form, rigid motions, patch energies.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_tests::bodies::{Body, LAMBDA, MU, data, plane_bodies, solid_bodies};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::{assert_close, assert_same_matrix, dense};
use nalgebra::DMatrix;

fn element_matrix<const D: usize>(shape: CellShape, nodes: Vec<[f64; D]>) -> DMatrix<f64>
where
    Dim: Dimension<D>,
{
    let cells = (0..nodes.len() as u32).collect();
    let mesh = Mesh::from_parts(shape, 1, nodes, cells).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let form = forms::elasticity(&data::<D>(0.0), &forms::Omega::on("all"));
    let found = Assembler::new(&mesh).element_matrices(&form, &[&Field::zero(&space)], &[&space]).unwrap();
    assert_eq!(found.len(), 1);
    DMatrix::from_row_slice(found[0].rows, found[0].columns, &found[0].values)
}

/// λ ∫∂_aφ_i ∂_bφ_j + μ (∫∂_bφ_i ∂_aφ_j + δ_ab ∫∇φ_i·∇φ_j) from S[a][b][i][j] = ∫∂_aφ_i ∂_bφ_j.
fn from_slopes<const D: usize>(count: usize, s: impl Fn(usize, usize, usize, usize) -> f64) -> DMatrix<f64> {
    DMatrix::from_fn(count * D, count * D, |row, column| {
        let (i, a, j, b) = (row / D, row % D, column / D, column % D);
        let same = if a == b { (0..D).map(|k| s(k, k, i, j)).sum() } else { 0.0 };
        LAMBDA * s(a, b, i, j) + MU * (s(b, a, i, j) + same)
    })
}

#[test]
fn linear_triangle_and_tetrahedron() {
    // Gradients of the barycentric coordinates of the triangle (0,0) (2,0) (1,3), area 3.
    let slopes = [[-0.5, -1.0 / 6.0], [0.5, -1.0 / 6.0], [0.0, 1.0 / 3.0]];
    let exact = from_slopes::<2>(3, |a, b, i, j| 3.0 * slopes[i][a] * slopes[j][b]);
    let found = element_matrix(CellShape::Triangle, vec![[0.0, 0.0], [2.0, 0.0], [1.0, 3.0]]);
    assert_same_matrix("triangle", &found, &exact, 1e-14);
    // The tetrahedron with the vertices 0, 2e₁, 4e₂, 5e₃, volume 40/6.
    let slopes = [[-0.5, -0.25, -0.2], [0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.2]];
    let exact = from_slopes::<3>(4, |a, b, i, j| 40.0 / 6.0 * slopes[i][a] * slopes[j][b]);
    let nodes = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 5.0]];
    assert_same_matrix("tetrahedron", &element_matrix(CellShape::Tetrahedron, nodes), &exact, 1e-14);
}

#[test]
fn bilinear_square_and_trilinear_box() {
    // On an interval of length l: ∫φφ = l/6 (1 + δ), ∫φ′φ′ = ±1/l, ∫φ′_iφ_j = ∓1/2; cells are products.
    fn line(length: f64, i: usize, j: usize, derived_i: bool, derived_j: bool) -> f64 {
        let sign = |end: usize| if end == 0 { -1.0 } else { 1.0 };
        match (derived_i, derived_j) {
            (false, false) => length / 6.0 * if i == j { 2.0 } else { 1.0 },
            (true, true) => sign(i) * sign(j) / length,
            (true, false) => sign(i) / 2.0,
            (false, true) => sign(j) / 2.0,
        }
    }
    fn product<const D: usize>(lengths: [f64; D], ends: &[[f64; 3]]) -> DMatrix<f64> {
        from_slopes::<D>(ends.len(), |a, b, i, j| {
            let end = |node: usize, axis: usize| ends[node][axis] as usize;
            (0..D).map(|k| line(lengths[k], end(i, k), end(j, k), a == k, b == k)).product()
        })
    }
    fn check<const D: usize>(shape: CellShape, lengths: [f64; D])
    where
        Dim: Dimension<D>,
    {
        let ends = shape.vertex_points();
        let nodes = ends.iter().map(|end| std::array::from_fn(|k| lengths[k] * end[k])).collect();
        let found = element_matrix(shape, nodes);
        assert_same_matrix(shape.name(), &found, &product(lengths, ends), 1e-14);
    }
    check(CellShape::Quadrilateral, [1.0, 1.0]);
    check(CellShape::Quadrilateral, [2.0, 0.7]);
    check(CellShape::Hexahedron, [1.5, 0.7, 2.0]);
}

fn check_body<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    let (assembler, space) = (&body.assembler, &body.space);
    let form = forms::elasticity(&data::<D>(0.0), &forms::Omega::on("all"));
    let zero = Field::zero(space);
    let matrix = assembler.tangent(&form, &[&zero], &[space]).unwrap();
    let all = dense(&matrix);
    assert_same_matrix(body.name, &all, &ByLoops::new(body, 0.0).stiffness, 1e-13);
    assert!(matrix.is_symmetric(1e-14).unwrap(), "{}", body.name);
    // Rigid motions have no energy: translations and the rotations in every plane.
    let size = matrix.row_sum_norm();
    for a in 0..D {
        for b in 0..D {
            let rigid = Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
                std::array::from_fn(|k| match (k == a, k == b) {
                    (true, true) => 1.0,
                    (true, false) => -x[b],
                    (false, true) => x[a],
                    (false, false) => 0.0,
                })
            });
            let force = matrix.multiply(rigid.unwrap().values()).unwrap();
            let largest = force.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            assert!(largest < 1e-14 * size, "{}: {a}, {b}: {:.1e}", body.name, largest / size);
        }
    }
    // A uniform strain e₁ ⊗ e₁ has the energy (λ + 2μ) |Ω|; (λ + 2μ)|Ω| = a(x₁e₁, x₁e₁).
    let stretch = Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| if k == 0 { x[0] } else { 0.0 })
    })
    .unwrap();
    let force = matrix.multiply(stretch.values()).unwrap();
    let energy: f64 = force.iter().zip(stretch.values()).map(|(f, u)| f * u).sum();
    let mesh = space.mesh();
    let rule = forms_fem::quadrature::cell_rule::<D>(mesh.cell_shape(0), 6).unwrap();
    let mut volume = 0.0;
    for cell in 0..mesh.cell_count() {
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let (_, jacobian) = mesh.map(cell, point);
            volume += weight * DMatrix::from_fn(D, D, |i, j| jacobian[i][j]).determinant();
        }
    }
    assert_close(body.name, &[energy], &[(LAMBDA + 2.0 * MU) * volume], 1e-13);
}

#[test]
fn every_body_has_rigid_motions_and_the_energy_of_a_uniform_strain() {
    plane_bodies().iter().for_each(check_body);
    solid_bodies().iter().for_each(check_body);
}
