//! Every operator in 2D and 3D: its value against plain floating-point code, its tangent against
//! differences of the residual and by a Taylor test.

#[macro_use]
mod operators;

use operators::*;

// Sums and products.
operator! { plus: Scalar { s + u[0] + 1 } |p: &At| p.s + p.u[0] + 1.0 }
operator! { minus: Vector { s * u - grad(s) } |p: &At| -> Vec<f64> {
    (0..p.d).map(|i| p.s * p.u[i] - p.grad_s[i]).collect()
} }
operator! { negation: Tensor { -(s * grad(u)) } |p: &At| matrix(p.d, |i, j| -p.s * p.grad_u[i][j]) }
operator! { product: Scalar { s * u[1] * s } |p: &At| p.s * p.u[1] * p.s }
operator! { quotient: Scalar { u[0] / (2 + s) } |p: &At| p.u[0] / (2.0 + p.s) }
operator! { quotient_of_tensor: Tensor { grad(u) / (2 + s * s) }
|p: &At| matrix(p.d, |i, j| p.grad_u[i][j] / (2.0 + p.s * p.s)) }
operator! { numbers_are_real: Scalar { 1 / 2 * s * s + 3 / 4 } |p: &At| 0.5 * p.s * p.s + 0.75 }
operator! { matrix_times_vector: Vector { grad(u) * u } |p: &At| apply(&p.grad_u, &p.u) }
operator! { matrix_times_matrix: Tensor { grad(u) * transpose(grad(u)) * C }
|p: &At| times(&times(&p.grad_u, &transpose(&p.grad_u)), &constant_tensor(p.d)) }
operator! { dot_of_vectors: Scalar { dot(u, grad(s)) * s } |p: &At| dot(&p.u, &p.grad_s) * p.s }
operator! { dot_of_tensor_and_vector: Vector { dot(grad(u), u) } |p: &At| apply(&p.grad_u, &p.u) }
operator! { dot_of_vector_and_tensor: Vector { dot(u, grad(u)) } |p: &At| apply(&transpose(&p.grad_u), &p.u) }
operator! { inner_of_tensors: Scalar { inner(grad(u), C + outer(u, u)) }
|p: &At| inner(&p.grad_u, &matrix(p.d, |i, j| constant_tensor(p.d)[i][j] + p.u[i] * p.u[j])) }
operator! { inner_of_vectors: Scalar { inner(u, u) } |p: &At| dot(&p.u, &p.u) }
operator! { outer_product: Tensor { outer(u, s * grad(s)) } |p: &At| matrix(p.d, |i, j| p.u[i] * p.s * p.grad_s[j]) }

// Tensor algebra.
operator! { transposition: Tensor { transpose(grad(u)) * s } |p: &At| matrix(p.d, |i, j| p.grad_u[j][i] * p.s) }
operator! { trace_of_square: Scalar { tr(grad(u) * grad(u)) } |p: &At| trace(&times(&p.grad_u, &p.grad_u)) }
operator! { determinant_of: Scalar { det(I + grad(u)) } |p: &At| determinant(&deformation(p)) }
operator! { inverse_of: Tensor { inv(I + grad(u)) } |p: &At| inverse(&deformation(p)) }
operator! { cofactor_of: Tensor { cof(I + grad(u)) } |p: &At| cofactor(&deformation(p)) }
operator! { symmetric_part: Tensor { s * sym(grad(u)) }
|p: &At| matrix(p.d, |i, j| 0.5 * p.s * (p.grad_u[i][j] + p.grad_u[j][i])) }
operator! { skew_part: Tensor { s * skew(grad(u)) }
|p: &At| matrix(p.d, |i, j| 0.5 * p.s * (p.grad_u[i][j] - p.grad_u[j][i])) }
operator! { deviator: Tensor { s * dev(grad(u)) } |p: &At| matrix(p.d, |i, j| {
    p.s * (p.grad_u[i][j] - if i == j { trace(&p.grad_u) / p.d as f64 } else { 0.0 })
}) }

// Differential operators.
operator! { gradient_of_product: Tensor { grad(s * u) }
|p: &At| matrix(p.d, |i, j| p.s * p.grad_u[i][j] + p.u[i] * p.grad_s[j]) }
operator! { gradient_of_function: Vector { grad(sin(s) * x[0]) } |p: &At| -> Vec<f64> {
    (0..p.d).map(|k| p.s.cos() * p.grad_s[k] * p.x[0] + if k == 0 { p.s.sin() } else { 0.0 }).collect()
} }
operator! { divergence: Scalar { div(u) * s } |p: &At| trace(&p.grad_u) * p.s }
operator! { divergence_of_product: Scalar { div(s * u) } |p: &At| p.s * trace(&p.grad_u) + dot(&p.grad_s, &p.u) }
operator! { divergence_of_tensor: Vector { div(outer(u, u)) } |p: &At| -> Vec<f64> {
    (0..p.d).map(|i| dot(&p.grad_u[i], &p.u) + p.u[i] * trace(&p.grad_u)).collect()
} }
operator! { strain: Tensor { eps(u) * s } |p: &At| matrix(p.d, |i, j| 0.5 * p.s * (p.grad_u[i][j] + p.grad_u[j][i])) }
operator! { strain_of_product: Tensor { eps(s * u) } |p: &At| matrix(p.d, |i, j| {
    let gradient = |i: usize, j: usize| p.s * p.grad_u[i][j] + p.u[i] * p.grad_s[j];
    0.5 * (gradient(i, j) + gradient(j, i))
}) }

// Functions.
operator! { square_root: Scalar { sqrt(1.5 + s) } |p: &At| (1.5 + p.s).sqrt() }
operator! { exponential: Scalar { exp(s * u[0]) } |p: &At| (p.s * p.u[0]).exp() }
operator! { logarithm: Scalar { ln(2 + s + u[0]) } |p: &At| (2.0 + p.s + p.u[0]).ln() }
operator! { sine: Scalar { sin(s) * u[0] } |p: &At| p.s.sin() * p.u[0] }
operator! { cosine: Scalar { cos(3 * s) } |p: &At| (3.0 * p.s).cos() }
operator! { tangent_function: Scalar { tan(s) } |p: &At| p.s.tan() }
operator! { hyperbolic_tangent: Scalar { tanh(2 * s) } |p: &At| (2.0 * p.s).tanh() }
operator! { absolute_value: Scalar { abs(s) * s } |p: &At| p.s.abs() * p.s }
operator! { sign_function: Scalar { sign(s) * s * s } |p: &At| p.s.signum() * p.s * p.s }
operator! { minimum: Scalar { min(s * s, u[0]) } |p: &At| (p.s * p.s).min(p.u[0]) }
operator! { maximum: Scalar { max(s * s, u[0]) } |p: &At| (p.s * p.s).max(p.u[0]) }
operator! { positive_part: Scalar { pos_part(s) * s } |p: &At| p.s.max(0.0) * p.s }
operator! { negative_part: Scalar { neg_part(s) * u[0] } |p: &At| (-p.s).max(0.0) * p.u[0] }
operator! { heaviside_function: Scalar { heaviside(s) * s * s } |p: &At| if p.s > 0.0 { p.s * p.s } else { 0.0 } }
operator! { cube: Scalar { pow(s, 3) } |p: &At| p.s * p.s * p.s }
operator! { negative_power: Scalar { pow(2 + s, -2) } |p: &At| 1.0 / ((2.0 + p.s) * (2.0 + p.s)) }
operator! { real_power: Scalar { pow(2 + s, 2.5) } |p: &At| (2.0 + p.s).powf(2.5) }
operator! { half_power: Scalar { pow(2 + s, 1 / 2) } |p: &At| (2.0 + p.s).sqrt() }
operator! { power_with_parameter: Scalar { pow(2 + s, a) } |p: &At| (2.0 + p.s).powf(A) }
operator! { power_in_exponent: Scalar { pow(a, s) } |p: &At| A.powf(p.s) }
operator! { power_of_both: Scalar { pow(2 + s, u[0] + s) } |p: &At| (2.0 + p.s).powf(p.u[0] + p.s) }

// Control, names, indices.
operator! { choice: Scalar { if s > 0.1 { s * s } else if s < -0.1 { u[0] * s } else { u[1] } }
|p: &At| if p.s > 0.1 { p.s * p.s } else if p.s < -0.1 { p.u[0] * p.s } else { p.u[1] } }
operator! { choice_by_logic: Tensor { if (s > 0.2 && u[0] >= 0) || !(u[1] <= 0.1) { s * grad(u) } else { 0 } }
|p: &At| matrix(p.d, |i, j| {
    if (p.s > 0.2 && p.u[0] >= 0.0) || p.u[1] > 0.1 { p.s * p.grad_u[i][j] } else { 0.0 }
}) }
operator! { choice_by_equality: Scalar { if D == 2 { s * s } else { if D != 3 { 7 } else { s * u[0] } } }
|p: &At| if p.d == 2 { p.s * p.s } else { p.s * p.u[0] } }
operator! { let_names: Scalar { let F = I + grad(u); let J = det(F); let K = { let inside = J * J; inside + 1 }; J * K * s }
|p: &At| { let j = determinant(&deformation(p)); j * (j * j + 1.0) * p.s } }
operator! { array_of_scalars: Scalar { dot([u[0] * s, u[1], 2], [s, 3, u[0]]) }
|p: &At| p.u[0] * p.s * p.s + 3.0 * p.u[1] + 2.0 * p.u[0] }
operator! { array_of_vectors: Scalar { dot([grad(s), u] * u, [s, 2]) }
|p: &At| p.s * dot(&p.grad_s, &p.u) + 2.0 * dot(&p.u, &p.u) }
operator! { array_of_arrays: Scalar { det([[1 + s, u[0], 0], [u[1], 2, s], [0, 1, 3 * s]]) }
|p: &At| determinant(&[vec![1.0 + p.s, p.u[0], 0.0], vec![p.u[1], 2.0, p.s], vec![0.0, 1.0, 3.0 * p.s]]) }
operator! { indices: Scalar { grad(u)[0][1] * grad(u)[(1, 0)] + dot(grad(u)[1], u) + C[0][1] * s }
|p: &At| p.grad_u[0][1] * p.grad_u[1][0] + dot(&p.grad_u[1], &p.u) + c::<3>()[0][1] * p.s }
operator! { constants: Scalar { PI * s * s + D * tr(I) * s } |p: &At| {
    std::f64::consts::PI * p.s * p.s + (p.d * p.d) as f64 * p.s
} }

// Derivatives.
operator! { derivative_by_vector: Scalar { derivative(exp(s) * dot(u, u), u, grad(s)) }
|p: &At| p.s.exp() * 2.0 * dot(&p.u, &p.grad_s) }
operator! { derivative_by_scalar: Vector { derivative(s * s * u + grad(s), s, u[0]) } |p: &At| -> Vec<f64> {
    (0..p.d).map(|i| 2.0 * p.s * p.u[0] * p.u[i] + p.grad_u[0][i]).collect()
} }
operator! { derivative_nests: Scalar { derivative(derivative(s * s * s * u[0], s, u[0]), s, u[1]) }
|p: &At| 6.0 * p.s * p.u[0] * p.u[0] * p.u[1] }
operator! { derivative_moves_gradients: Scalar { derivative(inner(grad(u), grad(u)), u, s * b) }
|p: &At| 2.0 * inner(&p.grad_u, &matrix(p.d, |i, j| constant_vector(p.d)[i] * p.grad_s[j])) }
operator! { derivative_by_parameter: Scalar { derivative(a * a * s * s, a, u[0]) } |p: &At| 2.0 * A * p.s * p.s * p.u[0] }
operator! { derivative_of_gradient: Scalar { derivative(dot(grad(s * s), u), s, s) }
|p: &At| 4.0 * p.s * dot(&p.grad_s, &p.u) }
operator! { diff_by_argument: Scalar { diff(s * s * u[0], s) } |p: &At| 2.0 * p.s * p.u[0] }
operator! { diff_holds_gradients: Scalar { diff(s * s + dot(grad(s), grad(s)) * s, s) }
|p: &At| 2.0 * p.s + dot(&p.grad_s, &p.grad_s) }
operator! { diff_by_vector: Vector { diff(dot(u, u) * s, u) } |p: &At| scaled(2.0 * p.s, &p.u) }
operator! { diff_of_vector_by_vector: Tensor { diff(dot(u, u) * u, u) } |p: &At| matrix(p.d, |i, j| {
    2.0 * p.u[i] * p.u[j] + if i == j { dot(&p.u, &p.u) } else { 0.0 }
}) }
operator! { diff_by_scalar_name: Scalar { let J = det(I + grad(u)); diff(s * pow(J, 3) + ln(1 + J * J), J) } |p: &At| {
    let j = determinant(&deformation(p));
    3.0 * p.s * j * j + 2.0 * j / (1.0 + j * j)
} }
operator! { diff_by_vector_name: Vector { let w = u + grad(s); diff(s * dot(w, w), w) } |p: &At| -> Vec<f64> {
    (0..p.d).map(|i| 2.0 * p.s * (p.u[i] + p.grad_s[i])).collect()
} }
operator! { diff_by_tensor_name: Tensor { let F = I + grad(u); diff(det(F) + s * inner(F, F), F) } |p: &At| {
    let (f, k) = (deformation(p), cofactor(&deformation(p)));
    matrix(p.d, |i, j| k[i][j] + 2.0 * p.s * f[i][j])
} }
operator! { diff_twice: Scalar { let F = I + grad(u); diff(diff(det(F), F), F)[(0, 1, 1, 0)] }
|p: &At| if p.d == 2 { -1.0 } else { -deformation(p)[2][2] } }
operator! { diff_of_inverse: Scalar { let F = I + grad(u); diff(inv(F), F)[0][1][1][0] } |p: &At| {
    // ∂F⁻¹_ij / ∂F_kl = −F⁻¹_ik F⁻¹_lj
    let k = inverse(&deformation(p));
    -k[0][1] * k[0][1]
} }
operator! { diff_of_cofactor: Scalar { let F = I + grad(u); diff(cof(F), F)[(0, 0, 1, 1)] }
|p: &At| if p.d == 2 { 1.0 } else { deformation(p)[2][2] } }
operator! { diff_by_parameter: Scalar { diff(a * a * s * s, a) } |p: &At| 2.0 * A * p.s * p.s }
operator! { diff_by_vector_parameter: Vector { diff(dot(b, u) * dot(b, u), b) }
|p: &At| scaled(2.0 * dot(&constant_vector(p.d), &p.u), &p.u) }
operator! { diff_by_tensor_parameter: Tensor { diff(s * s * inner(C, C), C) }
|p: &At| matrix(p.d, |i, j| 2.0 * p.s * p.s * constant_tensor(p.d)[i][j]) }
operator! { diff_of_derivative: Scalar { diff(derivative(s * s * s, s, u[0]), s) } |p: &At| 6.0 * p.s * p.u[0] }
operator! { diff_of_power_by_base_and_exponent: Scalar { let t = 2 + s; diff(pow(t, t), t) } |p: &At| {
    let t = 2.0 + p.s;
    t.powf(t) * (1.0 + t.ln())
} }
