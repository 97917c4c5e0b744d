//! The test of one operator: its value against plain floating-point code, its tangent against differences of
//! the residual and by a Taylor test, in two and three dimensions.

// Each test program uses a part of it.
#![allow(dead_code, unused_imports)]

pub use forms_core::forms;
pub use toy_backend::contract::*;

pub use toy_backend::mesh::{Mesh, determinant, inverse};
pub use toy_backend::operator_module;
pub use toy_backend::plain::{Components, Matrix, assert_values, dot, inner, matrix, trace};
pub use toy_backend::random::Random;
pub use toy_backend::{Nodal, differences, expression, residual, tangent};

/// The state at a point: what the independent evaluations read.
pub struct At {
    pub d: usize,
    pub u: Vec<f64>,
    pub grad_u: Matrix,
    pub s: f64,
    pub grad_s: Vec<f64>,
    pub x: Vec<f64>,
}

/// Parameters of every module below: `a`, `b`, `C`.
pub const A: f64 = 0.8;
pub fn b<const D: usize>() -> [f64; D] {
    std::array::from_fn(|i| 0.3 - 0.45 * i as f64)
}
pub fn c<const D: usize>() -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| 0.2 + 0.3 * i as f64 - 0.1 * (j * j) as f64))
}

pub fn transpose(a: &Matrix) -> Matrix {
    matrix(a.len(), |i, j| a[j][i])
}
pub fn times(a: &Matrix, b: &Matrix) -> Matrix {
    matrix(a.len(), |i, j| (0..a.len()).map(|k| a[i][k] * b[k][j]).sum())
}
pub fn apply(a: &Matrix, v: &[f64]) -> Vec<f64> {
    a.iter().map(|row| dot(row, v)).collect()
}
pub fn scaled(factor: f64, v: &[f64]) -> Vec<f64> {
    v.iter().map(|value| factor * value).collect()
}
/// I + grad u
pub fn deformation(p: &At) -> Matrix {
    matrix(p.d, |i, j| p.grad_u[i][j] + if i == j { 1.0 } else { 0.0 })
}
pub fn cofactor(a: &Matrix) -> Matrix {
    let (inverse, determinant) = (inverse(a), determinant(a));
    matrix(a.len(), |i, j| determinant * inverse[j][i])
}

/// A mesh and a random state (u, s) on it.
pub struct State<const D: usize> {
    pub mesh: Mesh<D>,
    pub unknowns: [Nodal; 2],
    pub random: Random,
}

impl<const D: usize> State<D> {
    pub fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let mesh = Mesh::<D>::cube(&mut random);
        let nodes = mesh.nodes.len();
        let unknowns = [random.field(nodes, D, 0.1, 0.25), random.field(nodes, 1, 0.15, 0.4)];
        State { mesh, unknowns, random }
    }

    /// The state at all points of all cells, interpolated here.
    pub fn points(&self) -> Vec<At> {
        let mut all = Vec::new();
        for cell in self.mesh.elements(Entity::Cells, "all") {
            for point in &cell.points {
                let interpolate = |field: &Nodal, component: usize, axis: Option<usize>| -> f64 {
                    let weight = |i: usize| match axis {
                        Some(axis) => point.basis[i].gradient[axis],
                        None => point.basis[i].value,
                    };
                    let nodes = cell.nodes.iter().enumerate();
                    nodes.map(|(i, node)| weight(i) * field.values[node * field.components + component]).sum()
                };
                let [u, s] = &self.unknowns;
                all.push(At {
                    d: D,
                    u: (0..D).map(|i| interpolate(u, i, None)).collect(),
                    grad_u: matrix(D, |i, j| interpolate(u, i, Some(j))),
                    s: interpolate(s, 0, None),
                    grad_s: (0..D).map(|j| interpolate(s, 0, Some(j))).collect(),
                    x: point.geometry.position.to_vec(),
                });
            }
        }
        all
    }

    pub fn check_value<R: Components>(&self, value: &Expression<D>, expected: impl Fn(&At) -> R) {
        let found = expression(&self.mesh, value, (Entity::Cells, "all"));
        assert_values(&found, self.points().iter().map(expected));
    }

    pub fn check_tangent(&mut self, form: &Form<D>) {
        differences::check_tangent(&self.mesh, form, &self.unknowns, &mut self.random);
    }
}

pub fn constant_tensor(d: usize) -> Matrix {
    matrix(d, |i, j| c::<3>()[i][j])
}
pub fn constant_vector(d: usize) -> Vec<f64> {
    b::<3>()[..d].to_vec()
}

/// One operator: a module with its value and a form that holds it, and the test of both.
macro_rules! operator {
    ($name:ident: Scalar { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Scalar Scalar { $($body)* } { value(u, s) * v } $expected }
    };
    ($name:ident: Vector { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Vector Vector { $($body)* } { dot(value(u, s), v) } $expected }
    };
    ($name:ident: Tensor { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Tensor Vector { $($body)* } { inner(value(u, s), grad(v)) } $expected }
    };
    (@ $name:ident $rank:ident $test:ident { $($body:tt)* } { $($density:tt)* } $expected:expr) => {
        operator_module! {
            $name: $rank tested by $test, on #[cells] Omega "all", seeds 11 12,
            data { a: Param, b: Param<Vector>, C: Param<Tensor> } = { a: A, b: b(), C: c() },
            value { $($body)* } density { $($density)* } expected $expected
        }
    };
}
