//! Means over cells on quadratic simplices, in 2D and 3D: values against weights of the nodes in closed form, tangents against
//! differences.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::{Mesh, determinant};
use toy_backend::operator_module;
use toy_backend::plain::{Components, Matrix, assert_values, dot, matrix, trace, vector};
use toy_backend::random::Random;
use toy_backend::{Nodal, differences, expression, quadratic_state};

/// The state at a point, with means over its cell.
struct At {
    d: usize,
    s: f64,
    grad_u: Matrix,
    mean_u: Vec<f64>,
    mean_s: f64,
    mean_grad_u: Matrix,
    mean_grad_s: Vec<f64>,
}

const A: f64 = 0.8;

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

    fn points(&self) -> Vec<At> {
        // (1/|T|) ∫ of the quadratic function of a vertex and of an edge.
        let [vertex, edge] = if D == 2 { [0.0, 1.0 / 3.0] } else { [-0.05, 0.2] };
        let mut all = Vec::new();
        for cell in self.mesh.elements(Entity::Cells, "all") {
            let [u, s] = &self.unknowns;
            let sum = |field: &Nodal, component: usize, weight: &dyn Fn(usize) -> f64| -> f64 {
                let nodes = cell.nodes.iter().enumerate();
                nodes.map(|(i, node)| weight(i) * field.values[node * field.components + component]).sum()
            };
            let mean = |field: &Nodal, component: usize| {
                sum(field, component, &|i| if i <= D { vertex } else { edge })
            };
            // A gradient is linear: its mean is that of points with equal weights.
            let slope = |field: &Nodal, c: usize, k: usize| {
                let of_point = |i: usize| cell.points.iter().map(move |point| point.basis[i].gradient[k]);
                sum(field, c, &|i| of_point(i).sum::<f64>() / cell.points.len() as f64)
            };
            for point in &cell.points {
                all.push(At {
                    d: D,
                    s: sum(s, 0, &|i| point.basis[i].value),
                    grad_u: matrix(D, |a, k| sum(u, a, &|i| point.basis[i].gradient[k])),
                    mean_u: vector(D, |a| mean(u, a)),
                    mean_s: mean(s, 0),
                    mean_grad_u: matrix(D, |a, k| slope(u, a, k)),
                    mean_grad_s: vector(D, |k| slope(s, 0, k)),
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

/// I + a matrix.
fn deformation(gradient: &Matrix) -> Matrix {
    matrix(gradient.len(), |i, j| gradient[i][j] + if i == j { 1.0 } else { 0.0 })
}

/// One operator: a module with its value and a form that holds it next to means of the test function, and the test of both.
macro_rules! operator {
    ($name:ident: Scalar { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Scalar Vector { $($body)* } { value(u, s) * (mean(div(v)) + v[0]) } $expected }
    };
    ($name:ident: Vector { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Vector Scalar { $($body)* } { dot(value(u, s), mean(grad(v)) - mean(a * v) * grad(s)) } $expected }
    };
    ($name:ident: Tensor { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Tensor Vector { $($body)* } { inner(value(u, s), mean(grad(v)) + outer(mean(v), u)) } $expected }
    };
    (@ $name:ident $rank:ident $test:ident { $($body:tt)* } { $($density:tt)* } $expected:expr) => {
        operator_module! {
            $name: $rank tested by $test, on #[cells] Omega "all", seeds 41 42,
            data { a: Param } = { a: A },
            value { $($body)* } density { $($density)* } expected $expected
        }
    };
}

operator! { of_a_scalar: Scalar { sin(mean(s)) * s } |p: &At| p.mean_s.sin() * p.s }
operator! { of_a_gradient: Vector { mean(grad(s)) * (1 + s * mean(s)) }
|p: &At| vector(p.d, |i| p.mean_grad_s[i] * (1.0 + p.s * p.mean_s)) }
operator! { of_a_vector: Vector { mean(u) * det(mean(I + grad(u))) }
|p: &At| vector(p.d, |i| p.mean_u[i] * determinant(&deformation(&p.mean_grad_u))) }
operator! { of_a_stress: Tensor { mean(2 * a * eps(u) / h + tr(grad(u)) * I * cell_volume / cell_volume) * h - mean(div(u)) * h * I }
|p: &At| matrix(p.d, |i, j| A * (p.mean_grad_u[i][j] + p.mean_grad_u[j][i])) }
operator! { f_bar: Tensor {
    let F = I + grad(u);
    pow(det(mean(F)) / det(F), 1 / D) * F
} |p: &At| {
    let (own, mean) = (deformation(&p.grad_u), deformation(&p.mean_grad_u));
    let factor = (determinant(&mean) / determinant(&own)).powf(1.0 / p.d as f64);
    matrix(p.d, |i, j| factor * own[i][j])
} }
operator! { of_a_mean: Scalar { mean(mean(s) * s + mean(grad(s))[0] + [div(u), s][1]) + div(mean(u)) }
|p: &At| p.mean_s * p.mean_s + p.mean_grad_s[0] + p.mean_s }
operator! { along_a_direction: Scalar { derivative(pow(mean(s), 2) * s, s, a * div(u)) }
|p: &At| A * (2.0 * p.mean_s * trace(&p.mean_grad_u) * p.s + p.mean_s * p.mean_s * trace(&p.grad_u)) }
operator! { by_a_name: Vector { let g = mean(grad(s)); diff(dot(g, g) * s, g) }
|p: &At| vector(p.d, |i| 2.0 * p.mean_grad_s[i] * p.s) }
operator! { of_a_choice: Scalar { mean(if a < 1 { 2 * s } else { div(u) }) * dot(mean(u), mean(u)) }
|p: &At| 2.0 * p.mean_s * dot(&p.mean_u, &p.mean_u) }
