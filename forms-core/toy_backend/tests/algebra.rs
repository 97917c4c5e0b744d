//! Tensor algebra in 2D and 3D: products of any rank, norms, curls, slices, functions.

#[macro_use]
mod operators;

use operators::*;
use toy_backend::contract::{Dim, Dimension};

fn sum(terms: impl Iterator<Item = f64>) -> f64 {
    terms.sum()
}
fn delta(i: usize, j: usize) -> f64 {
    if i == j { 1.0 } else { 0.0 }
}
// Products of any rank. `outer(outer(..), ..)` gives indices ijkl in the order of the factors.
operator! { dot_of_tensors: Tensor { dot(grad(u), C) * s }
|p: &At| matrix(p.d, |i, j| p.s * times(&p.grad_u, &constant_tensor(p.d))[i][j]) }
operator! { dot_of_rank_4_and_vector: Tensor { dot(dot(outer(C, grad(u)), u), b) }
|p: &At| matrix(p.d, |i, j| constant_tensor(p.d)[i][j] * dot(&apply(&transpose(&p.grad_u), &constant_vector(p.d)), &p.u)) }
operator! { dot_of_vector_and_rank_3: Tensor { dot(u, outer(grad(u), b)) }
|p: &At| matrix(p.d, |i, j| apply(&transpose(&p.grad_u), &p.u)[i] * constant_vector(p.d)[j]) }
operator! { ddot_of_tensors: Scalar { ddot(grad(u), transpose(grad(u))) }
|p: &At| inner(&p.grad_u, &transpose(&p.grad_u)) }
operator! { ddot_of_rank_4_and_tensor: Tensor { ddot(a * outer(I, I) + s * sym_identity4 + identity4, grad(u)) }
|p: &At| matrix(p.d, |i, j| {
    let g = &p.grad_u;
    A * trace(g) * delta(i, j) + 0.5 * p.s * (g[i][j] + g[j][i]) + g[i][j]
}) }
operator! { ddot_of_tensor_and_rank_4: Tensor { ddot(grad(u), outer(C, grad(u))) }
|p: &At| matrix(p.d, |i, j| inner(&p.grad_u, &constant_tensor(p.d)) * p.grad_u[i][j]) }
operator! { ddot_of_rank_4: Scalar { let E = outer(C, grad(u)); inner(ddot(E, E), outer(grad(u), C)) }
|p: &At| {
    let (c, g) = (constant_tensor(p.d), &p.grad_u);
    inner(g, &c) * inner(&c, g) * inner(g, &c)
} }
operator! { elasticity_tensor: Tensor { let E: Tensor4 = a * outer(I, I) + 2 * s * sym_identity4; ddot(E, eps(u)) }
|p: &At| matrix(p.d, |i, j| {
    A * trace(&p.grad_u) * delta(i, j) + p.s * (p.grad_u[i][j] + p.grad_u[j][i])
}) }
operator! { inner_of_rank_4: Scalar { inner(outer(C, grad(u)), outer(grad(u), C)) * s }
|p: &At| p.s * inner(&constant_tensor(p.d), &p.grad_u) * inner(&p.grad_u, &constant_tensor(p.d)) }
operator! { outer_of_three: Scalar { outer(outer(u, grad(s)), u)[1][0][1] } |p: &At| p.u[1] * p.grad_s[0] * p.u[1] }
operator! { rectangular_products: Vector { let M = [u, b, grad(s)]; transpose(M) * (M * u) } |p: &At| -> Vec<f64> {
    let rows = [p.u.clone(), constant_vector(p.d), p.grad_s.clone()];
    (0..p.d).map(|i| sum(rows.iter().map(|row| row[i] * dot(row, &p.u)))).collect()
} }
operator! { rectangular_square: Scalar { let M = [u, grad(s)]; det(M * transpose(M)) }
|p: &At| dot(&p.u, &p.u) * dot(&p.grad_s, &p.grad_s) - dot(&p.u, &p.grad_s).powi(2) }

// Cross products and curls.
operator! { cross_of_three_components: Scalar { dot(cross([u[0], s, 2], [s, u[1], u[0]]), [1, 2, s]) } |p: &At| {
    let (a, b) = ([p.u[0], p.s, 2.0], [p.s, p.u[1], p.u[0]]);
    (a[1] * b[2] - a[2] * b[1]) + 2.0 * (a[2] * b[0] - a[0] * b[2]) + p.s * (a[0] * b[1] - a[1] * b[0])
} }
operator! { cross_of_two_components: Scalar { cross([u[0], s], [s, u[1]]) } |p: &At| p.u[0] * p.u[1] - p.s * p.s }
operator! { cross_in_the_plane: Scalar { dot(cross(s, [u[0], u[1]]) + cross([s, 1], u[1]), [u[1], 3]) } |p: &At| {
    let first = [-p.s * p.u[1], p.s * p.u[0]];
    let second = [p.u[1], -p.s * p.u[1]];
    (first[0] + second[0]) * p.u[1] + (first[1] + second[1]) * 3.0
} }
operator! { perpendicular: Scalar { dot(perp([u[0], s]), [s, u[1]]) } |p: &At| -p.s * p.s + p.u[0] * p.u[1] }
operator! { axial_part: Scalar { if D == 2 { s * (grad(u)[1][0] - grad(u)[0][1]) } else { s * grad(u)[0][1] } }
|p: &At| p.s * if p.d == 2 { p.grad_u[1][0] - p.grad_u[0][1] } else { p.grad_u[0][1] } }

#[forms(crate = toy_backend, dimension = 2)]
pub mod plane {
    pub fn of_vector(u: Vector, s: Scalar) -> Scalar {
        curl(s * u)
    }
    pub fn of_scalar(u: Vector, s: Scalar) -> Vector {
        curl(s * u[0])
    }
}
#[forms(crate = toy_backend, matrix_free, dimension = 3)]
pub mod space {
    #[cells]
    pub struct Omega;
    pub fn of_vector(u: Vector, s: Scalar) -> Vector {
        curl(s * u)
    }
    pub fn product(u: Vector, s: Scalar) -> Vector {
        cross(u, grad(s))
    }
    pub fn form(u: Unknown<Vector>, s: Unknown<Scalar>, v: Test<Vector>) -> Form {
        integral(Omega, s * dot(curl(u), curl(v)) + dot(cross(u, grad(s)), v))
    }
}
#[test]
fn curls_in_2d() {
    let state = State::<2>::new(41);
    let [u, s] = &state.unknowns;
    let gradient = |p: &At, i: usize, j: usize| p.s * p.grad_u[i][j] + p.u[i] * p.grad_s[j];
    state.check_value(&plane::of_vector(u.source(), s.source()), |p| gradient(p, 1, 0) - gradient(p, 0, 1));
    state.check_value(&plane::of_scalar(u.source(), s.source()), |p| {
        vec![gradient(p, 0, 1), -gradient(p, 0, 0)]
    });
}
#[test]
fn curls_in_3d() {
    let mut state = State::<3>::new(42);
    let [u, s] = &state.unknowns;
    let gradient = |p: &At, i: usize, j: usize| p.s * p.grad_u[i][j] + p.u[i] * p.grad_s[j];
    state.check_value(&space::of_vector(u.source(), s.source()), |p| -> Vec<f64> {
        (0..3)
            .map(|i| gradient(p, (i + 2) % 3, (i + 1) % 3) - gradient(p, (i + 1) % 3, (i + 2) % 3))
            .collect()
    });
    state.check_value(&space::product(u.source(), s.source()), |p| -> Vec<f64> {
        (0..3)
            .map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                p.u[j] * p.grad_s[k] - p.u[k] * p.grad_s[j]
            })
            .collect()
    });
    state.check_tangent(&space::form(&space::Omega::on("all")));
}

// Norms.
operator! { norm_of_vector: Scalar { norm(u) * s } |p: &At| p.s * dot(&p.u, &p.u).sqrt() }
operator! { norm_of_tensor: Scalar { norm(I + grad(u)) }
|p: &At| inner(&deformation(p), &deformation(p)).sqrt() }
operator! { norm_of_rank_4: Scalar { norm(outer(I + grad(u), C)) }
|p: &At| (inner(&deformation(p), &deformation(p)) * inner(&constant_tensor(p.d), &constant_tensor(p.d))).sqrt() }
operator! { norm_of_scalar: Scalar { norm(2 + s) * s } |p: &At| (2.0 + p.s) * p.s }
operator! { normalized: Vector { normalize(u + grad(s)) } |p: &At| -> Vec<f64> {
    let w: Vec<f64> = (0..p.d).map(|i| p.u[i] + p.grad_s[i]).collect();
    scaled(1.0 / dot(&w, &w).sqrt(), &w)
} }
operator! { slope_of_norm: Vector { diff(norm(u), u) }
|p: &At| scaled(1.0 / dot(&p.u, &p.u).sqrt(), &p.u) }
operator! { curvature_of_norm: Tensor { let w = u + 3 * b; diff(diff(norm(w), w), w) } |p: &At| {
    let w: Vec<f64> = (0..p.d).map(|i| p.u[i] + 3.0 * constant_vector(p.d)[i]).collect();
    let norm = dot(&w, &w).sqrt();
    matrix(p.d, |i, j| delta(i, j) / norm - w[i] * w[j] / norm.powi(3))
} }

// Diagonals, identities, fixed sizes.
operator! { diagonal_of_tensor: Vector { diag(grad(u)) * s } |p: &At| -> Vec<f64> {
    (0..p.d).map(|i| p.s * p.grad_u[i][i]).collect()
} }
operator! { tensor_of_diagonal: Tensor { diag(s * u) } |p: &At| matrix(p.d, |i, j| p.s * p.u[i] * delta(i, j)) }
operator! { fixed_identity: Scalar { inner(identity(3), [[s, 0, 1], [2, u[0], 0], [0, 0, u[1] * s]]) + tr(identity(D)) }
|p: &At| p.s + p.u[0] + p.u[1] * p.s + p.d as f64 }
operator! { one_by_one: Scalar { det([[s]]) * s + cof([[s]])[0][0] + inv([[2 + s]])[0][0] }
|p: &At| p.s * p.s + 1.0 + 1.0 / (2.0 + p.s) }
operator! { fixed_deviator: Scalar { let A = [[s, u[0], 1], [2, u[1], s], [0, 1, s * s]]; inner(dev(A), A) + inner(skew(A), A) }
|p: &At| {
    let a = vec![vec![p.s, p.u[0], 1.0], vec![2.0, p.u[1], p.s], vec![0.0, 1.0, p.s * p.s]];
    inner(&a, &a) - trace(&a).powi(2) / 3.0 + 0.5 * (inner(&a, &a) - inner(&a, &transpose(&a)))
} }
operator! { fixed_inverse: Scalar { inv([[2 + s, u[0], 0], [u[1], 2, s], [0, 1, 3]])[(0, 1)] } |p: &At| {
    let a = vec![vec![2.0 + p.s, p.u[0], 0.0], vec![p.u[1], 2.0, p.s], vec![0.0, 1.0, 3.0]];
    inverse(&a)[0][1]
} }

// Indices, slices, arrays.
operator! { four_indices: Scalar { let E = outer(C, grad(u)); E[0][1][1][0] * s + E[(1, 0, 0, 1)] }
|p: &At| constant_tensor(p.d)[0][1] * p.grad_u[1][0] * p.s + constant_tensor(p.d)[1][0] * p.grad_u[0][1] }
operator! { column: Vector { grad(u)[(.., 1)] * s } |p: &At| -> Vec<f64> {
    (0..p.d).map(|i| p.s * p.grad_u[i][1]).collect()
} }
operator! { row: Vector { grad(u)[(0, ..)] + grad(u)[1] } |p: &At| -> Vec<f64> {
    (0..p.d).map(|j| p.grad_u[0][j] + p.grad_u[1][j]).collect()
} }
operator! { part_of_vector: Scalar { dot(u[0..2], [s, 1]) + u[1..][0] * u[..=0][0] }
|p: &At| p.u[0] * p.s + p.u[1] + p.u[1] * p.u[0] }
operator! { block: Scalar { det((s * C + grad(u))[(0..2, 0..2)]) } |p: &At| {
    let entry = |i: usize, j: usize| p.s * constant_tensor(p.d)[i][j] + p.grad_u[i][j];
    entry(0, 0) * entry(1, 1) - entry(0, 1) * entry(1, 0)
} }
operator! { slice_of_rank_4: Tensor { outer(grad(u), C)[(.., 0, 1, ..)] }
|p: &At| matrix(p.d, |i, l| p.grad_u[i][0] * constant_tensor(p.d)[1][l]) }
operator! { repeated: Vector { s * [u[0]; D] + [[1, 2]; 3][0][1] * [0; D] } |p: &At| vec![p.s * p.u[0]; p.d] }
operator! { zero_among_vectors: Scalar { inner([grad(s), 0], [u, u]) } |p: &At| dot(&p.grad_s, &p.u) }
operator! { rank_4_by_hand: Scalar {
    let E = outer(I, I);
    let F = [[[[s, 1], [2, 3]], [[4, 5], [6, u[0]]]], [[[7, 8], [9, s * s]], [[1, u[1]], [2, s]]]];
    F[0][1][1][1] * F[1][1][0][1] + E[0][0][1][1] * F[(0, 0, 0, 0)] + F[1][0][1][1]
} |p: &At| p.u[0] * p.u[1] + p.s + p.s * p.s }
operator! { choice_of_rank_4: Tensor {
    let E = if s > 0.1 && !(u[0] > 0.3) || u[1] < 0 { s * outer(C, grad(u)) } else { 2 * identity4 };
    ddot(E, grad(u))
} |p: &At| {
    let first = (p.s > 0.1 && p.u[0] <= 0.3) || p.u[1] < 0.0;
    matrix(p.d, |i, j| match first {
        true => p.s * constant_tensor(p.d)[i][j] * inner(&p.grad_u, &p.grad_u),
        false => 2.0 * p.grad_u[i][j],
    })
} }
operator! { diff_by_rank_4: Scalar {
    let E = outer(I, I) * s;
    let W = inner(grad(u), ddot(E, grad(u)));
    inner(diff(W, E), outer(grad(u), C))
} |p: &At| inner(&p.grad_u, &p.grad_u) * inner(&p.grad_u, &constant_tensor(p.d)) }
operator! { diff_of_tensor_by_rank_4: Scalar {
    let E = s * outer(C, I);
    ddot(diff(ddot(E, grad(u)), E)[(0, 1)], outer(u, b))[(0, 1)] + diff(ddot(E, grad(u)), E)[(1, 0, 1, 0, 0, 1)]
} |p: &At| {
    // ∂(E_ijkl G_kl)/∂E_mnop = δ_im δ_jn G_op
    sum((0..p.d).flat_map(|k| (0..p.d).map(move |l| (k, l))).map(|(k, l)| p.grad_u[k][l] * p.u[k] * constant_vector(p.d)[l]))
        + p.grad_u[0][1]
} }
operator! { diff_by_fixed_vector: Scalar { let w = [s, u[0], u[1] * s]; dot(diff(dot(w, w) * w[1], w), [1, s, 2]) } |p: &At| {
    let w = [p.s, p.u[0], p.u[1] * p.s];
    let square = dot(&w, &w);
    2.0 * w[0] * w[1] + p.s * (2.0 * w[1] * w[1] + square) + 4.0 * w[2] * w[1]
} }
operator! { gradient_of_norm: Vector { grad(norm(2 * b + s * u)) } |p: &At| -> Vec<f64> {
    let w: Vec<f64> = (0..p.d).map(|i| 2.0 * constant_vector(p.d)[i] + p.s * p.u[i]).collect();
    let norm = dot(&w, &w).sqrt();
    (0..p.d).map(|k| sum((0..p.d).map(|i| w[i] / norm * (p.s * p.grad_u[i][k] + p.u[i] * p.grad_s[k])))).collect()
} }
// Functions.
operator! { arcsine: Scalar { asin(s) * u[0] } |p: &At| p.s.asin() * p.u[0] }
operator! { arccosine: Scalar { acos(s / 2) } |p: &At| (p.s / 2.0).acos() }
operator! { arctangent: Scalar { atan(3 * s) } |p: &At| (3.0 * p.s).atan() }
operator! { angle: Scalar { atan2(u[1], s - 2) * s } |p: &At| p.u[1].atan2(p.s - 2.0) * p.s }
operator! { hyperbolic_sine: Scalar { sinh(s * u[0]) } |p: &At| (p.s * p.u[0]).sinh() }
operator! { hyperbolic_cosine: Scalar { cosh(2 * s) } |p: &At| (2.0 * p.s).cosh() }
operator! { inverse_hyperbolic_sine: Scalar { asinh(4 * s) } |p: &At| (4.0 * p.s).asinh() }
operator! { inverse_hyperbolic_cosine: Scalar { acosh(2 + s) } |p: &At| (2.0 + p.s).acosh() }
operator! { inverse_hyperbolic_tangent: Scalar { atanh(s) * s } |p: &At| p.s.atanh() * p.s }
operator! { decimal_logarithm: Scalar { log10(2 + s) * s } |p: &At| (2.0 + p.s).log10() * p.s }
// erf by its Taylor series, erfc by its complement: good to rounding for |x| < 2.
fn error_function(x: f64) -> f64 {
    let mut term = x;
    let mut sum = x;
    for k in 1..60 {
        term *= -x * x / k as f64;
        sum += term / (2 * k + 1) as f64;
    }
    sum * std::f64::consts::FRAC_2_SQRT_PI
}
operator! { error_function_of: Scalar { erf(2 * s) * u[0] } |p: &At| error_function(2.0 * p.s) * p.u[0] }
operator! { complementary_error_function: Scalar { erfc(s + u[0]) } |p: &At| 1.0 - error_function(p.s + p.u[0]) }
operator! { square: Scalar { sqr(s + 1) } |p: &At| (p.s + 1.0).powi(2) }
operator! { hypotenuse: Scalar { hypot(u[0], 1 + s) } |p: &At| p.u[0].hypot(1.0 + p.s) }

#[forms(crate = toy_backend, matrix_free)]
pub mod replaced {
    #[cells]
    pub struct Omega;

    fn first(u: Vector, s: Scalar, v: Vector) -> Form {
        integral(Omega, dot(u, v) * s + inner(grad(u), grad(v)))
    }
    /// By a test function: the direction takes its place, and the other test function's terms vanish.
    pub fn by_derivative(u: Unknown<Vector>, s: Unknown<Scalar>, v: Test<Vector>, t: Test<Scalar>) -> Form {
        derivative(first(u, s, v) + integral(Omega, s * s * t), v, 3 * v + t * u)
    }
    pub fn by_hand(u: Unknown<Vector>, s: Unknown<Scalar>, v: Test<Vector>, t: Test<Scalar>) -> Form {
        first(u, s, 3 * v) + first(u, s, t * u)
    }
}
#[test]
fn derivative_by_a_test_function() {
    fn check<const D: usize>()
    where
        Dim: Dimension<D>,
    {
        let mut state = State::<D>::new(43);
        let omega = replaced::Omega::on("all");
        let (found, expected) = (replaced::by_derivative(&omega), replaced::by_hand(&omega));
        let of_found = residual::<f64, D>(&state.mesh, &found, &state.unknowns);
        let of_expected = residual::<f64, D>(&state.mesh, &expected, &state.unknowns);
        assert!(of_expected.iter().any(|entry| entry.abs() > 1e-3));
        for (found, expected) in of_found.iter().zip(&of_expected) {
            assert!((found - expected).abs() <= 1e-13, "{found} is not {expected}");
        }
        state.check_tangent(&found);
    }
    check::<2>();
    check::<3>();
}
