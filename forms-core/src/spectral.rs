//! Exponential, logarithm and square root of symmetric tensors, with exact derivatives of every order, also
//! where eigenvalues are equal. In a form the derivatives are those by symmetric tensors: an entry and its mirror image are
//! one variable, by which both move, and the derivative by either is half of that by both.
//!
//! The eigenvectors Q of the value are never differentiated. With N the part of QᵀAQ that carries derivatives
//! (a product of more than [`Real::ORDER`] of them is zero), the expansion in divided differences
//! f(Λ + N)_ij = f(λ_i) δ_ij + f\[λ_i, λ_j\] N_ij + Σ_k f\[λ_i, λ_k, λ_j\] N_ik N_kj + … ends and is exact
//! (Daleckii and Krein; Higham, Functions of Matrices, 2008, section 3.2). Divided differences of close points
//! are computed from closed forms and Taylor series, without cancellation.

// Rows and columns are walked by their indices, as the formulas have them.
#![allow(clippy::needless_range_loop)]

use crate::external::External;
use crate::real::Real;

/// exp A of a symmetric tensor. NaN if A is not symmetric.
pub fn tensor_exp<R: Real, const D: usize>(tensor: [[R; D]; D]) -> [[R; D]; D] {
    of_tensor::<Exponential, R, D>(tensor)
}

/// The principal logarithm of a symmetric positive definite tensor. NaN if it is not.
pub fn tensor_ln<R: Real, const D: usize>(tensor: [[R; D]; D]) -> [[R; D]; D] {
    of_tensor::<Logarithm, R, D>(tensor)
}

/// The symmetric positive square root of a symmetric positive definite tensor. NaN if it is not.
pub fn tensor_sqrt<R: Real, const D: usize>(tensor: [[R; D]; D]) -> [[R; D]; D] {
    of_tensor::<SquareRoot, R, D>(tensor)
}

/// [`tensor_exp`] in a form.
pub struct TensorExponential;
/// [`tensor_ln`] in a form.
pub struct TensorLogarithm;
/// [`tensor_sqrt`] in a form.
pub struct TensorSquareRoot;

impl External for TensorExponential {
    fn evaluate<R: Real>(inputs: &[R], outputs: &mut [R]) {
        flattened::<Exponential, R>(inputs, outputs);
    }
    fn evaluate_fixed<R: Real, const INPUTS: usize>(inputs: &[R; INPUTS], outputs: &mut [R]) {
        fixed::<Exponential, R, INPUTS>(inputs, outputs);
    }
    fn variable(input: usize, inputs: usize) -> usize {
        symmetric_variable(input, inputs)
    }
}

impl External for TensorLogarithm {
    fn evaluate<R: Real>(inputs: &[R], outputs: &mut [R]) {
        flattened::<Logarithm, R>(inputs, outputs);
    }
    fn evaluate_fixed<R: Real, const INPUTS: usize>(inputs: &[R; INPUTS], outputs: &mut [R]) {
        fixed::<Logarithm, R, INPUTS>(inputs, outputs);
    }
    fn variable(input: usize, inputs: usize) -> usize {
        symmetric_variable(input, inputs)
    }
}

impl External for TensorSquareRoot {
    fn evaluate<R: Real>(inputs: &[R], outputs: &mut [R]) {
        flattened::<SquareRoot, R>(inputs, outputs);
    }
    fn evaluate_fixed<R: Real, const INPUTS: usize>(inputs: &[R; INPUTS], outputs: &mut [R]) {
        fixed::<SquareRoot, R, INPUTS>(inputs, outputs);
    }
    fn variable(input: usize, inputs: usize) -> usize {
        symmetric_variable(input, inputs)
    }
}

/// A scalar function and what its divided differences need.
trait Spectral {
    /// f(x).
    fn value(x: f64) -> f64;
    /// f\[a, b\] = (f(b) − f(a)) / (b − a), accurate for close a and b; f′(a) for equal ones.
    fn secant(a: f64, b: f64) -> f64;
    /// The coefficients of order `first`, `first` + 1, … of the Taylor series at c.
    fn taylor(c: f64, first: usize) -> [f64; TERMS];
    /// The rate at which that series converges: the terms fall as (distance / radius)^k or faster.
    fn radius(c: f64) -> f64;
}

/// With a distance of an eighth of the radius the last term is below rounding.
const TERMS: usize = 22;

struct Exponential;

impl Spectral for Exponential {
    fn value(x: f64) -> f64 {
        x.exp()
    }
    fn secant(a: f64, b: f64) -> f64 {
        let half = (b - a) / 2.0;
        let middle = ((a + b) / 2.0).exp();
        if half.abs() < 1e-8 { middle } else { middle * half.sinh() / half }
    }
    fn taylor(c: f64, first: usize) -> [f64; TERMS] {
        let mut coefficient = c.exp() / (1..=first).map(|k| k as f64).product::<f64>();
        std::array::from_fn(|k| {
            if k > 0 {
                coefficient /= (first + k) as f64;
            }
            coefficient
        })
    }
    fn radius(_: f64) -> f64 {
        1.0
    }
}

struct Logarithm;

impl Spectral for Logarithm {
    fn value(x: f64) -> f64 {
        x.ln()
    }
    fn secant(a: f64, b: f64) -> f64 {
        let ratio = (b - a) / a;
        if ratio.abs() < 1e-16 { 1.0 / a } else { ratio.ln_1p() / (b - a) }
    }
    fn taylor(c: f64, first: usize) -> [f64; TERMS] {
        let mut power = -(-c).powi(-(first as i32));
        std::array::from_fn(|k| {
            if k > 0 {
                power /= -c;
            }
            power / (first + k) as f64
        })
    }
    fn radius(c: f64) -> f64 {
        c
    }
}

struct SquareRoot;

impl Spectral for SquareRoot {
    fn value(x: f64) -> f64 {
        x.sqrt()
    }
    fn secant(a: f64, b: f64) -> f64 {
        1.0 / (a.sqrt() + b.sqrt())
    }
    fn taylor(c: f64, first: usize) -> [f64; TERMS] {
        let step = |k: usize| (1.5 - k as f64) / (k as f64 * c);
        let mut coefficient = c.sqrt() * (1..=first).map(step).product::<f64>();
        std::array::from_fn(|k| {
            if k > 0 {
                coefficient *= step(first + k);
            }
            coefficient
        })
    }
    fn radius(c: f64) -> f64 {
        c
    }
}

/// f of three or more points in ascending order, or of fewer.
fn divided_difference<F: Spectral>(points: &[f64]) -> f64 {
    match *points {
        [x] => return F::value(x),
        [a, b] => return F::secant(a, b),
        _ => {}
    }
    let order = points.len() - 1;
    let spread = points[order] - points[0];
    let centre = points.iter().sum::<f64>() / points.len() as f64;
    if spread > F::radius(centre) / 8.0 {
        let ends = [&points[1..], &points[..order]].map(divided_difference::<F>);
        return (ends[0] - ends[1]) / spread;
    }
    // f[x_0, …, x_p] = Σ_k f⁽ᵖ⁺ᵏ⁾(c) / (p + k)! h_k(x − c), h_k the complete homogeneous symmetric polynomials.
    let mut homogeneous = [0.0; TERMS];
    homogeneous[0] = 1.0;
    for point in points {
        for k in 1..TERMS {
            homogeneous[k] += (point - centre) * homogeneous[k - 1];
        }
    }
    F::taylor(centre, order).iter().zip(homogeneous).map(|(a, h)| a * h).sum()
}

/// An entry and its mirror image are one variable: derivatives are taken along symmetric changes.
fn symmetric_variable(entry: usize, entries: usize) -> usize {
    let size = entries.isqrt();
    let (row, column) = (entry / size, entry % size);
    row.min(column) * size + row.max(column)
}

fn flattened<F: Spectral, R: Real>(inputs: &[R], outputs: &mut [R]) {
    match inputs.len() {
        1 => flattened_in::<F, R, 1>(inputs, outputs),
        4 => flattened_in::<F, R, 2>(inputs, outputs),
        9 => flattened_in::<F, R, 3>(inputs, outputs),
        16 => flattened_in::<F, R, 4>(inputs, outputs),
        // The compiler admits no other size.
        _ => outputs.fill(R::from(f64::NAN)),
    }
}

/// [`flattened`] for a size that is known where it is called: the others are not compiled.
fn fixed<F: Spectral, R: Real, const INPUTS: usize>(inputs: &[R; INPUTS], outputs: &mut [R]) {
    match const { INPUTS } {
        1 => flattened_in::<F, R, 1>(inputs, outputs),
        4 => flattened_in::<F, R, 2>(inputs, outputs),
        9 => flattened_in::<F, R, 3>(inputs, outputs),
        16 => flattened_in::<F, R, 4>(inputs, outputs),
        _ => outputs.fill(R::from(f64::NAN)),
    }
}

/// Not inlined: kernels call it, and it is compiled once for each order of derivatives, not once for each kernel and
/// instruction set. Plain loops, for every closure would be compiled for each order, too.
#[inline(never)]
fn flattened_in<F: Spectral, R: Real, const D: usize>(inputs: &[R], outputs: &mut [R]) {
    let mut tensor = [[R::zero(); D]; D];
    for i in 0..D {
        for j in 0..D {
            tensor[i][j] = inputs[i * D + j];
        }
    }
    let value = of_tensor::<F, R, D>(tensor);
    for i in 0..D {
        for j in 0..D {
            outputs[i * D + j] = value[i][j];
        }
    }
}

/// Entries that differ from their mirror image by this part of the largest are a mistake, not rounding.
const SYMMETRIC: f64 = 1e-9;

fn of_tensor<F: Spectral, R: Real, const D: usize>(tensor: [[R; D]; D]) -> [[R; D]; D] {
    let mut values = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            values[i][j] = tensor[i][j].value();
        }
    }
    if !is_symmetric(&values) {
        return [[R::from(f64::NAN); D]; D];
    }
    let (eigenvalues, q) = eigensystem(values);
    let mut result = [[R::zero(); D]; D];
    for i in 0..D {
        result[i][i] = R::from(F::value(eigenvalues[i]));
    }
    if R::ORDER > 0 {
        let (mut moving, mut transposed) = (tensor, q);
        for i in 0..D {
            for j in 0..D {
                moving[i][j] -= values[i][j];
                transposed[i][j] = q[j][i];
            }
        }
        let moving = rotate(&moving, &transposed);
        let mut path = Path { eigenvalues: &eigenvalues, moving: &moving, indices: [0; DEPTH] };
        for i in 0..D {
            path.indices[0] = i;
            path.extend::<F>(1, R::one(), &mut result[i]);
        }
    }
    rotate(&result, &q)
}

/// Finite, and symmetric up to rounding.
fn is_symmetric<const D: usize>(values: &[[f64; D]; D]) -> bool {
    let largest = values.as_flattened().iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let asymmetric = |i: usize, j: usize| (values[i][j] - values[j][i]).abs() > SYMMETRIC * largest;
    let finite = values.as_flattened().iter().all(|entry| entry.is_finite());
    finite && !(0..D).any(|i| (0..i).any(|j| asymmetric(i, j)))
}

/// The most factors of a term: derivatives above the eleventh are beyond any form.
const DEPTH: usize = 12;

/// A chain of indices i, k, …, j of a term of the expansion.
struct Path<'a, R, const D: usize> {
    eigenvalues: &'a [f64; D],
    moving: &'a [[R; D]; D],
    indices: [usize; DEPTH],
}

impl<R: Real, const D: usize> Path<'_, R, D> {
    /// Adds the terms that begin with the first `length` indices, whose product is given, to their row.
    fn extend<F: Spectral>(&mut self, length: usize, product: R, row: &mut [R; D]) {
        if length > R::ORDER || length >= DEPTH {
            return;
        }
        for next in 0..D {
            let factor = self.moving[self.indices[length - 1]][next];
            if factor.vanishes() {
                continue;
            }
            self.indices[length] = next;
            let product = product * factor;
            if product.vanishes() {
                continue;
            }
            row[next] += product * chained::<F, D>(self.eigenvalues, &self.indices[..=length]);
            self.extend::<F>(length + 1, product, row);
        }
    }
}

/// The divided difference of f at the eigenvalues of a chain of indices.
fn chained<F: Spectral, const D: usize>(eigenvalues: &[f64; D], indices: &[usize]) -> f64 {
    let mut points = [0.0; DEPTH];
    for (point, index) in points.iter_mut().zip(indices) {
        *point = eigenvalues[*index];
    }
    let points = &mut points[..indices.len()];
    points.sort_by(f64::total_cmp);
    divided_difference::<F>(points)
}

/// P A Pᵀ.
fn rotate<R: Real, const D: usize>(a: &[[R; D]; D], p: &[[f64; D]; D]) -> [[R; D]; D] {
    let (mut left, mut result) = ([[R::zero(); D]; D], [[R::zero(); D]; D]);
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                left[i][j] += a[k][j] * p[i][k];
            }
        }
    }
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                result[i][j] += left[i][k] * p[j][k];
            }
        }
    }
    result
}

/// Eigenvalues and, as columns, eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigensystem<const D: usize>(mut a: [[f64; D]; D]) -> ([f64; D], [[f64; D]; D]) {
    let mut q: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
    // Convergence is quadratic: a handful of sweeps reaches rounding level.
    for _ in 0..30 {
        let mut rotated = false;
        for row in 0..D {
            for column in row + 1..D {
                let off = a[row][column];
                // Too small to change the diagonal entries' last bits.
                if off.abs() <= f64::EPSILON * 0.25 * (a[row][row].abs().min(a[column][column].abs())) {
                    continue;
                }
                if off == 0.0 {
                    continue;
                }
                rotated = true;
                let theta = (a[column][column] - a[row][row]) / (2.0 * off);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let (cosine, sine) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
                for k in 0..D {
                    let (first, second) = (a[k][row], a[k][column]);
                    a[k][row] = cosine * first - sine * second;
                    a[k][column] = sine * first + cosine * second;
                }
                for k in 0..D {
                    let (first, second) = (a[row][k], a[column][k]);
                    a[row][k] = cosine * first - sine * second;
                    a[column][k] = sine * first + cosine * second;
                }
                (a[row][column], a[column][row]) = (0.0, 0.0);
                for line in &mut q {
                    let (first, second) = (line[row], line[column]);
                    line[row] = cosine * first - sine * second;
                    line[column] = sine * first + cosine * second;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    (std::array::from_fn(|i| a[i][i]), q)
}

#[cfg(test)]
mod tests;
