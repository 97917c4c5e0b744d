//! Pairs of displaced surfaces: the motion of the opposite point in tangents, second derivatives of energies and
//! derivatives by the shape, against differences of what rays find.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, differences, functional, residual, tangent};

#[forms(crate = toy_backend, matrix_free)]
pub mod rubber {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[pairs]
    pub struct Touch;

    fn first_piola(u: Vector) -> Tensor {
        let F = I + grad(u);
        diff(mu / 2 * (inner(F, F) - D - 2 * ln(det(F))) + lambda / 2 * pow(ln(det(F)), 2), F)
    }
    fn turned(w: Vector) -> Vector {
        normalize(cof(I + grad(w)) * n)
    }
    fn ball(q: Vector, s: Scalar) -> Vector {
        if s <= 0 {
            0 * q
        } else if dot(q, q) <= s * s {
            q
        } else {
            s / norm(q) * q
        }
    }
    fn contact(u: Vector) -> Vector {
        let t = this(first_piola(u) * n);
        let gamma = gamma0 / this(h);
        let P = dot(t, toward) + gamma * gap;
        let slip = jump(u - old) + gap * (toward - this(turned(old)));
        let q = t - gamma * slip;
        ball(q - dot(q, toward) * toward, kappa * neg_part(P)) - neg_part(P) * toward
    }
    /// Nitsche's method with Coulomb friction at large sliding.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        -integral(Touch(u), dot(contact(u), jump(v)) / 2)
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(balance(u, p), u, q)
    }
    /// Both bodies' normals and places, and a field seen from the other side.
    pub fn everything(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(
            Touch(u),
            dot(toward, jump(v)) * gap
                + dot(other(turned(u)), other(v)) * dot(other(x), toward)
                + inner(other(grad(u)), other(grad(v))) * dot(other(n), toward) * other(h),
        )
    }
    pub fn penalty(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), gamma0 / this(h) / 2 * pow(gap, 2) * (1 + dot(other(u), other(u))))
    }
    /// The surfaces are displaced by a sum of fields.
    pub fn onward(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u + old), gap * dot(jump(u), toward) * dot(jump(v), toward))
    }
    pub fn measured(u: State<Vector>) -> Functional {
        integral(
            Touch(u),
            gap * gap + dot(other(u), toward) * dot(other(x), toward) + inner(other(grad(u)), this(grad(u))),
        )
    }
    pub fn shape_gradient(u: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(measured(u), shape, Theta)
    }
}

fn data<const D: usize>(old: Nodal) -> rubber::Data<D> {
    let old = Given::field(std::sync::Arc::new(old) as FieldHandle);
    rubber::data().lambda(1.3).mu(0.7).gamma0(5.0).kappa(0.4).old(old)
}

fn touch() -> rubber::Touch {
    rubber::Touch::on("skin")
}

/// Tangents on linear and quadratic cells, whose opposite facets are bent by the displacement.
fn tangents_in<const D: usize>(mesh: &Mesh<D>, random: &mut Random)
where
    Dim: Dimension<D>,
{
    let nodes = mesh.nodes.len();
    let (u, old) = ([random.field(nodes, D, 0.0, 0.05)], random.field(nodes, D, 0.0, 0.02));
    let data = data(old);
    differences::check_tangent(mesh, &rubber::balance(&data, &touch()), &u, random);
    differences::check_tangent(mesh, &rubber::everything(&data, &touch()), &u, random);
    differences::check_tangent(mesh, &rubber::onward(&data, &touch()), &u, random);
    let matrix = tangent::<f64, D>(mesh, &rubber::balance(&data, &touch()), &u);
    let adjoint = rubber::adjoint(&data, &touch(), u[0].source());
    let transposed = tangent::<f64, D>(mesh, &adjoint, &u);
    let scale = matrix.iter().flatten().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (row, entries) in matrix.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            assert!((transposed[column][row] - entry).abs() <= 1e-12 * scale);
        }
    }
}

#[test]
fn the_opposite_point_moves_in_the_tangent() {
    let mut random = Random(71);
    tangents_in(&Mesh::<2>::cube(&mut random), &mut random);
    tangents_in(&Mesh::<2>::quadratic_cube(&mut random), &mut random);
    tangents_in(&Mesh::<3>::cube(&mut random), &mut random);
}

/// First and second derivatives of an energy of the gap; the tangent as a whole is symmetric.
fn energies_in<const D: usize>(mesh: &Mesh<D>, random: &mut Random)
where
    Dim: Dimension<D>,
{
    let nodes = mesh.nodes.len();
    let u = [random.field(nodes, D, 0.0, 0.05)];
    let energy = rubber::penalty(&data(random.field(nodes, D, 0.0, 0.02)), &touch());
    differences::check_variation(mesh, &energy, &u);
    differences::check_tangent(mesh, &energy, &u, random);
    let matrix = tangent::<f64, D>(mesh, &energy, &u);
    let scale = matrix.iter().flatten().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (row, entries) in matrix.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            let difference = entry - matrix[column][row];
            assert!(difference.abs() <= 1e-12 * scale, "({row}, {column}): {difference}");
        }
    }
}

#[test]
fn energies_of_the_gap_have_second_derivatives() {
    let mut random = Random(72);
    energies_in(&Mesh::<2>::cube(&mut random), &mut random);
    energies_in(&Mesh::<2>::quadratic_cube(&mut random), &mut random);
    energies_in(&Mesh::<3>::cube(&mut random), &mut random);
}

/// The derivative by the shape against differences over moved meshes with the same nodal values.
fn shapes_in<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(73);
    let mesh = Mesh::<D>::cube(&mut random);
    let nodes = mesh.nodes.len();
    let u = random.field(nodes, D, 0.0, 0.05);
    let data = data(random.field(nodes, D, 0.0, 0.02));
    let gradient = residual::<f64, D>(&mesh, &rubber::shape_gradient(&data, &touch(), u.source()), &[]);
    let scale = gradient.iter().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (entry, found) in gradient.iter().enumerate() {
        let at = |step: f64| {
            let mut by = vec![[0.0; D]; nodes];
            by[entry / D][entry % D] = step;
            functional(&mesh.moved(&by), &rubber::measured(&data, &touch(), u.source()))
        };
        let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((found - difference).abs() <= 1e-7 * scale, "{entry}: {found}, by differences {difference}");
    }
}

#[test]
fn pairs_move_with_the_shape() {
    shapes_in::<2>();
    shapes_in::<3>();
}
