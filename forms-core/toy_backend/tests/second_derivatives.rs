//! Second derivatives on quadratic simplices, in 2D and 3D: values against closed forms, tangents against
//! differences; what is proved of them.

use forms_core::described::Described;
use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::lanes::Four;
use toy_backend::mesh::{Mesh, determinant};
use toy_backend::operator_module;
use toy_backend::plain::{Components, Matrix, assert_values, dot, inner, matrix, trace, vector};
use toy_backend::random::Random;
use toy_backend::{Nodal, differences, expression, quadratic_state, residual, tangent};

/// The state at a point: what the independent evaluations read.
struct At {
    d: usize,
    u: Vec<f64>,
    grad_u: Matrix,
    hess_u: Vec<Matrix>,
    s: f64,
    grad_s: Vec<f64>,
    hess_s: Matrix,
    x: Vec<f64>,
}

const A: f64 = 0.8;

/// ∂_k div u
fn grad_div_u(p: &At, k: usize) -> f64 {
    (0..p.d).map(|i| p.hess_u[i][i][k]).sum()
}

/// A mesh and a random state (u, s) on it.
struct State<const D: usize> {
    mesh: Mesh<D>,
    unknowns: [Nodal; 2],
    random: Random,
}

impl<const D: usize> State<D> {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let (mesh, unknowns) = quadratic_state(&mut random);
        State { mesh, unknowns, random }
    }

    /// The state at all points of all cells, interpolated here.
    fn points(&self) -> Vec<At> {
        let mut all = Vec::new();
        for cell in self.mesh.elements(Entity::Cells, "all") {
            for point in &cell.points {
                let [u, s] = &self.unknowns;
                let sum = |field: &Nodal, component: usize, weight: &dyn Fn(usize) -> f64| -> f64 {
                    let nodes = cell.nodes.iter().enumerate();
                    nodes.map(|(i, node)| weight(i) * field.values[node * field.components + component]).sum()
                };
                let value = |field: &Nodal, c: usize| sum(field, c, &|i| point.basis[i].value);
                let slope =
                    |field: &Nodal, c: usize, k: usize| sum(field, c, &|i| point.basis[i].gradient[k]);
                let second =
                    |field: &Nodal, c: usize| matrix(D, |j, k| sum(field, c, &|i| point.hessians[i][j][k]));
                all.push(At {
                    d: D,
                    u: vector(D, |i| value(u, i)),
                    grad_u: matrix(D, |i, j| slope(u, i, j)),
                    hess_u: (0..D).map(|i| second(u, i)).collect(),
                    s: value(s, 0),
                    grad_s: vector(D, |j| slope(s, 0, j)),
                    hess_s: second(s, 0),
                    x: point.geometry.position.to_vec(),
                });
            }
        }
        all
    }

    fn check_value<R: Components>(&self, value: &Expression<D>, expected: impl Fn(&At) -> R) {
        let found = expression(&self.mesh, value, (Entity::Cells, "all"));
        assert_values(&found, self.points().iter().map(expected));
    }
}

/// One operator: a module with its value and a form that holds it next to second derivatives of the test
/// function, and the test of both.
macro_rules! operator {
    ($name:ident: Scalar { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Scalar Scalar { $($body)* } { value(u, s) * div(grad(v)) } $expected }
    };
    ($name:ident: Vector { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Vector Vector { $($body)* } { dot(value(u, s), div(grad(v))) } $expected }
    };
    ($name:ident: Tensor { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Tensor Scalar { $($body)* } { inner(value(u, s), hess(v)) } $expected }
    };
    (@ $name:ident $rank:ident $test:ident { $($body:tt)* } { $($density:tt)* } $expected:expr) => {
        operator_module! {
            $name: $rank tested by $test, on #[cells] Omega "all", seeds 31 32,
            data { a: Param } = { a: A },
            value { $($body)* } density { $($density)* } expected $expected
        }
    };
}

operator! { hessian: Tensor { s * hess(s) } |p: &At| matrix(p.d, |i, j| p.s * p.hess_s[i][j]) }
operator! { gradient_of_gradient: Tensor { grad(grad(s)) * (1 + s) }
|p: &At| matrix(p.d, |i, j| p.hess_s[i][j] * (1.0 + p.s)) }
operator! { hessian_of_vector: Tensor { hess(u)[1] + hess(u[0]) }
|p: &At| matrix(p.d, |i, j| p.hess_u[1][i][j] + p.hess_u[0][i][j]) }
operator! { square_of_hessian: Scalar { inner(hess(u), hess(u)) }
|p: &At| p.hess_u.iter().map(|h| inner(h, h)).sum::<f64>() }
operator! { laplacian: Scalar { div(grad(s)) * s } |p: &At| trace(&p.hess_s) * p.s }
operator! { laplacian_of_vector: Vector { s * div(grad(u)) } |p: &At| vector(p.d, |i| p.s * trace(&p.hess_u[i])) }
operator! { gradient_of_divergence: Vector { grad(div(u)) } |p: &At| vector(p.d, |k| grad_div_u(p, k)) }
operator! { divergence_of_stress: Vector { div(2 * a * eps(u) + tr(eps(u)) * I) }
|p: &At| vector(p.d, |i| A * trace(&p.hess_u[i]) + (A + 1.0) * grad_div_u(p, i)) }
operator! { divergence_of_flux: Scalar { div((1 + s * s) * grad(s)) }
|p: &At| (1.0 + p.s * p.s) * trace(&p.hess_s) + 2.0 * p.s * dot(&p.grad_s, &p.grad_s) }
operator! { gradient_of_convection: Tensor { grad(grad(u) * u) } |p: &At| matrix(p.d, |i, j| {
    (0..p.d).map(|k| p.hess_u[i][k][j] * p.u[k] + p.grad_u[i][k] * p.grad_u[k][j]).sum()
}) }
operator! { gradient_of_square: Vector { grad(dot(grad(s), grad(s))) }
|p: &At| vector(p.d, |i| 2.0 * dot(&p.grad_s, &p.hess_s[i])) }
operator! { gradient_of_kink: Tensor { grad(pos_part(s) * grad(s)) } |p: &At| matrix(p.d, |i, j| {
    if p.s > 0.0 { p.grad_s[i] * p.grad_s[j] + p.s * p.hess_s[i][j] } else { 0.0 }
}) }
operator! { hessian_of_product: Tensor { hess(s * u[0]) } |p: &At| matrix(p.d, |i, j| {
    p.hess_s[i][j] * p.u[0]
        + p.grad_s[i] * p.grad_u[0][j]
        + p.grad_s[j] * p.grad_u[0][i]
        + p.s * p.hess_u[0][i][j]
}) }
operator! { hessian_of_function: Tensor { hess(sin(s) * x[0]) } |p: &At| matrix(p.d, |i, j| {
    let along_x = |i: usize, j: usize| if j == 0 { p.grad_s[i] } else { 0.0 };
    (p.s.cos() * p.hess_s[i][j] - p.s.sin() * p.grad_s[i] * p.grad_s[j]) * p.x[0]
        + p.s.cos() * (along_x(i, j) + along_x(j, i))
}) }
operator! { hessian_of_tensor: Scalar { hess(outer(u, u))[(0, 1, 1, 0)] } |p: &At| {
    p.hess_u[0][1][0] * p.u[1]
        + p.grad_u[0][1] * p.grad_u[1][0]
        + p.grad_u[0][0] * p.grad_u[1][1]
        + p.u[0] * p.hess_u[1][1][0]
} }
operator! { determinant_of_hessian: Scalar { det(hess(s)) } |p: &At| determinant(&p.hess_s) }
operator! { derivative_of_hessian: Scalar { derivative(inner(hess(s), hess(s)), s, u[0]) }
|p: &At| 2.0 * inner(&p.hess_s, &p.hess_u[0]) }
operator! { derivative_moves_hessians: Scalar { derivative(div(grad(s)) * s, s, s * s) } |p: &At| {
    let laplacian = trace(&p.hess_s);
    (2.0 * p.s * laplacian + 2.0 * dot(&p.grad_s, &p.grad_s)) * p.s + laplacian * p.s * p.s
} }
operator! { diff_holds_hessians: Scalar { diff(s * s * div(grad(s)), s) } |p: &At| 2.0 * p.s * trace(&p.hess_s) }
operator! { diff_by_hessian: Tensor { let H = hess(s); diff(inner(H, H) * s, H) }
|p: &At| matrix(p.d, |i, j| 2.0 * p.s * p.hess_s[i][j]) }

#[forms(crate = toy_backend, matrix_free)]
pub mod plates {
    pub struct Data {
        a: Param,
        b: Param<Vector>,
        known: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn second_of_tensor(T: Tensor) -> Tensor {
        hess(T)[0][1]
    }
    pub fn biharmonic(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, inner(hess(u), hess(v)))
    }
    pub fn bending(u: Unknown<Scalar>) -> Energy {
        integral(Omega, inner(hess(u), hess(u)) / 2)
    }
    pub fn bending_by_derivative(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        derivative(bending(u), u, v)
    }
    /// Elasticity whose energy depends on strains and their gradients.
    pub fn strain_gradient(u: Unknown<Vector>) -> Energy {
        let e = eps(u);
        integral(Omega, inner(e, e) + pow(1 + inner(hess(u), hess(u)), 1.5) + dot(div(grad(u)), u))
    }
    pub fn with_known_hessian(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, inner(hess(known), hess(v)) * u)
    }

    /// Symmetric because ∂₀∂₁ = ∂₁∂₀.
    pub fn symmetric(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, hess(u)[0][1] * div(grad(v)) + div(grad(u)) * hess(v)[1][0])
    }
    pub fn not_symmetric(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, hess(u)[0][0] * div(grad(v)))
    }
    pub fn nothing(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, a * v + inner(skew(hess(u)), outer(b, grad(v))))
    }
    pub fn first_order(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
}

fn data<const D: usize>() -> plates::Data<D> {
    plates::data().a(A).b(std::array::from_fn(|i| 0.3 - 0.2 * i as f64)).known(0.0)
}

fn omega() -> plates::Omega {
    plates::Omega::on("all")
}

#[test]
fn second_derivatives_of_a_tensor_field() {
    let mut random = Random(33);
    let mesh = Mesh::<2>::quadratic_cube(&mut random);
    let field = random.field(mesh.nodes.len(), 4, 0.0, 1.0);
    let found = expression(&mesh, &plates::second_of_tensor(&data(), field.source()), (Entity::Cells, "all"));
    let mut expected = Vec::new();
    for cell in mesh.elements(Entity::Cells, "all") {
        for point in &cell.points {
            expected.push(matrix(2, |j, k| {
                let nodes = cell.nodes.iter().zip(&point.hessians);
                nodes.map(|(node, hessian)| hessian[j][k] * field.values[node * 4 + 1]).sum()
            }));
        }
    }
    for (found, expected) in found.iter().zip(&expected) {
        for (found, expected) in found.iter().zip(expected.concat()) {
            assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} is not {expected}");
        }
    }
}

/// K_ij = Σ_T |T| H(φ_i) : H(φ_j): second derivatives of quadratic functions are constant on a cell.
fn biharmonic_matrix<const D: usize>(mesh: &Mesh<D>) -> Matrix {
    let mut expected = vec![vec![0.0; mesh.nodes.len()]; mesh.nodes.len()];
    for cell in mesh.elements(Entity::Cells, "all") {
        let hessians = &cell.points[0].hessians;
        for (i, first) in cell.nodes.iter().enumerate() {
            for (j, second) in cell.nodes.iter().enumerate() {
                let product: f64 = (0..D).map(|k| dot(&hessians[i][k], &hessians[j][k])).sum();
                expected[*first][*second] += cell.cell.cell_volume * product;
            }
        }
    }
    expected
}

fn assert_matrix(found: &Matrix, expected: &Matrix) {
    let scale = expected.iter().flatten().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() <= 1e-12 * scale, "{found} is not {expected}");
    }
}

fn biharmonic_in<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(34);
    let mesh = Mesh::<D>::quadratic_cube(&mut random);
    let expected = biharmonic_matrix(&mesh);
    let u = [random.field(mesh.nodes.len(), 1, 0.0, 1.0)];
    assert_matrix(&tangent::<f64, D>(&mesh, &plates::biharmonic(&data(), &omega()), &u), &expected);
    assert_matrix(&tangent::<Four, D>(&mesh, &plates::biharmonic(&data(), &omega()), &u), &expected);
    assert_matrix(&tangent::<f64, D>(&mesh, &plates::bending(&data(), &omega()), &u), &expected);
    let form = plates::bending_by_derivative(&data(), &omega());
    assert_matrix(&tangent::<f64, D>(&mesh, &form, &u), &expected);
    let product: Vec<f64> = expected.iter().map(|row| dot(row, &u[0].values)).collect();
    assert_matrix(&vec![residual::<f64, D>(&mesh, &form, &u)], &vec![product]);
}

#[test]
fn biharmonic_forms_equal_their_closed_form() {
    biharmonic_in::<2>();
    biharmonic_in::<3>();
}

#[test]
fn energies_of_second_derivatives() {
    let mut random = Random(35);
    let mesh = Mesh::<2>::quadratic_cube(&mut random);
    let u = [random.field(mesh.nodes.len(), 2, 0.0, 0.2)];
    let energy = plates::strain_gradient(&data(), &omega());
    differences::check_variation(&mesh, &energy, &u);
    differences::check_tangent(&mesh, &energy, &u, &mut random);
}

#[test]
fn known_fields_have_second_derivatives() {
    let mut random = Random(36);
    let mesh = Mesh::<2>::quadratic_cube(&mut random);
    let nodes = mesh.nodes.len();
    let (known, one) = (random.field(nodes, 1, 0.0, 1.0), random.field(nodes, 1, 1.0, 0.0));
    let mut data = data::<2>();
    data.known = Given::field(std::sync::Arc::new(known.clone()) as FieldHandle);
    let form = plates::with_known_hessian(&data, &omega());
    let found = residual::<f64, 2>(&mesh, &form, &[one]);
    let expected = biharmonic_matrix(&mesh).iter().map(|row| dot(row, &known.values)).collect();
    assert_matrix(&vec![found], &vec![expected]);
}

/// The description for a backend: symmetry of the tangents, which kernels read second derivatives, degrees.
#[derive(Default)]
struct Told {
    symmetric: Vec<bool>,
    hessian: Vec<bool>,
    degrees: Vec<[usize; 3]>,
}

fn told<I: Integrals<2>>(form: &Form<2>) -> Told {
    assert!(form.has_integrals::<I>());
    let mut told = Told::default();
    for Term { integral, kernel } in I::tangent::<Described>(form.inputs().constants()) {
        told.symmetric.push(integral.symmetric);
        told.hessian.push(kernel.requirements.hessian);
        let degree = |field: usize, simplex: bool| integral.degree.of(&[field; 4], 1, simplex);
        told.degrees.push([degree(1, true), degree(3, true), degree(3, false)]);
    }
    told
}

#[test]
fn second_derivatives_are_symmetric_and_lower_the_degree_by_two() {
    let biharmonic = told::<plates::biharmonic::Kernels>(&plates::biharmonic(&data(), &omega()));
    assert_eq!((biharmonic.symmetric, biharmonic.hessian), (vec![true], vec![true]));
    assert_eq!(biharmonic.degrees, [[0, 2, 6]]);
    assert_eq!(told::<plates::symmetric::Kernels>(&plates::symmetric(&data(), &omega())).symmetric, [true]);
    assert_eq!(
        told::<plates::not_symmetric::Kernels>(&plates::not_symmetric(&data(), &omega())).symmetric,
        [false]
    );
    // The Hessian's skew part vanishes as it is built.
    assert_eq!(told::<plates::nothing::Kernels>(&plates::nothing(&data(), &omega())).symmetric, [false; 0]);
    assert_eq!(
        told::<plates::first_order::Kernels>(&plates::first_order(&data(), &omega())).hessian,
        [false]
    );
}
