//! Eigenvalues and eigenvectors of small dense symmetric matrices: Householder's tridiagonal form, then QL steps with
//! implicit shifts (Golub and Van Loan, Matrix Computations, sections 8.3.1 and 8.3.3).

/// Eigenvalues, and the eigenvector of each.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricEigen {
    /// The eigenvalues, in no order.
    pub values: Vec<f64>,
    /// Orthonormal eigenvectors, in the order of the values.
    pub vectors: Vec<Vec<f64>>,
}

/// Rotations until an entry beside the diagonal vanishes: three as a rule.
const STEPS: usize = 60;

impl SymmetricEigen {
    /// The decomposition of a symmetric matrix of `size` rows, row by row; its lower triangle is read. None if an entry is not
    /// finite or missing.
    pub fn of(size: usize, entries: &[f64]) -> Option<Self> {
        if entries.len() != size * size || entries.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        let entry = |i: usize, j: usize| entries[i.max(j) * size + i.min(j)];
        let matrix = (0..size).map(|i| (0..size).map(|j| entry(i, j)).collect()).collect();
        let Tridiagonal { mut diagonal, mut beside, mut basis } = Tridiagonal::of(matrix);
        diagonalise(&mut diagonal, &mut beside, &mut basis)?;
        Some(SymmetricEigen { values: diagonal, vectors: basis })
    }
}

/// QᵀAQ = T with the columns of Q as vectors.
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Entry k couples k and k + 1.
    beside: Vec<f64>,
    basis: Vec<Vec<f64>>,
}

impl Tridiagonal {
    fn of(mut a: Vec<Vec<f64>>) -> Self {
        let size = a.len();
        let unit = |k: usize| (0..size).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
        let mut basis: Vec<Vec<f64>> = (0..size).map(unit).collect();
        for k in 0..size.saturating_sub(2) {
            // v reflects what stands below the entry beside the diagonal away: H = I − 2 v vᵀ.
            let mut v = vec![0.0; size];
            for i in k + 1..size {
                v[i] = a[i][k];
            }
            let length = norm(&v);
            if norm(&v[k + 2..]) == 0.0 {
                continue;
            }
            v[k + 1] += length.copysign(v[k + 1]);
            let length = norm(&v);
            v.iter_mut().for_each(|entry| *entry /= length);
            // H A H = A − 2 v wᵀ − 2 w vᵀ with w = A v − (vᵀ A v) v.
            let mut w: Vec<f64> = a.iter().map(|row| dot(row, &v)).collect();
            let part = dot(&w, &v);
            w.iter_mut().zip(&v).for_each(|(w, v)| *w -= part * v);
            for (i, row) in a.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry -= 2.0 * (v[i] * w[j] + w[i] * v[j]);
                }
            }
            // Q ← Q H: with columns as vectors, each row of Q.
            let image: Vec<f64> =
                (0..size).map(|i| basis.iter().zip(&v).map(|(column, v)| column[i] * v).sum()).collect();
            for (column, v) in basis.iter_mut().zip(&v) {
                column.iter_mut().zip(&image).for_each(|(entry, image)| *entry -= 2.0 * image * v);
            }
        }
        let diagonal = (0..size).map(|k| a[k][k]).collect();
        let beside = (1..size).map(|k| a[k][k - 1]).collect();
        Tridiagonal { diagonal, beside, basis }
    }
}

/// QL steps until the matrix is diagonal; the basis turns with it. None if an entry does not vanish.
fn diagonalise(d: &mut [f64], e: &mut Vec<f64>, basis: &mut [Vec<f64>]) -> Option<()> {
    let size = d.len();
    e.push(0.0);
    // Beside the largest entry of the matrix smaller ones are rounding.
    let scale = d.iter().chain(e.iter()).fold(0.0_f64, |scale, entry| scale.max(entry.abs()));
    let vanishes = |d: &[f64], e: &[f64], k: usize| {
        e[k].abs() <= f64::EPSILON * (d[k].abs() + d[k + 1].abs()).max(f64::EPSILON * scale)
    };
    for first in 0..size {
        let mut steps = 0;
        loop {
            let last = (first..size.saturating_sub(1)).find(|&k| vanishes(d, e, k)).unwrap_or(size - 1);
            if last == first {
                break;
            }
            steps += 1;
            if steps > STEPS {
                return None;
            }
            // Wilkinson's shift: the eigenvalue of the leading two rows that is nearer to d[first].
            let half = (d[first + 1] - d[first]) / (2.0 * e[first]);
            let shift = d[first] - e[first] / (half + half.hypot(1.0).copysign(half));
            let (mut g, mut sine, mut cosine, mut moved) = (d[last] - shift, 1.0, 1.0, 0.0);
            let mut split = false;
            for k in (first..last).rev() {
                let (f, b) = (sine * e[k], cosine * e[k]);
                let length = f.hypot(g);
                e[k + 1] = length;
                if length == 0.0 {
                    // The matrix falls into two parts here.
                    d[k + 1] -= moved;
                    e[last] = 0.0;
                    split = true;
                    break;
                }
                (sine, cosine) = (f / length, g / length);
                g = d[k + 1] - moved;
                let turned = (d[k] - g) * sine + 2.0 * cosine * b;
                moved = sine * turned;
                d[k + 1] = g + moved;
                g = cosine * turned - b;
                let (before, after) = basis.split_at_mut(k + 1);
                for (low, high) in before[k].iter_mut().zip(after[0].iter_mut()) {
                    (*low, *high) = (cosine * *low - sine * *high, sine * *low + cosine * *high);
                }
            }
            if !split {
                d[first] -= moved;
                e[first] = g;
                e[last] = 0.0;
            }
        }
    }
    Some(())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_algebra::spectrum::irregular;

    /// A v = λ v and orthonormal vectors, for matrices full, of low rank, with equal eigenvalues, diagonal, of one row and of none.
    #[test]
    fn vectors_belong_to_their_values() {
        let product = |size: usize, rank: usize| {
            let b: Vec<f64> = irregular(size * rank).collect();
            let entry = |i: usize, j: usize| (0..rank).map(|k| b[i * rank + k] * b[j * rank + k]).sum();
            (0..size * size).map(|place| entry(place / size, place % size)).collect::<Vec<f64>>()
        };
        let plus_identity = |size: usize, mut entries: Vec<f64>| {
            (0..size).for_each(|k| entries[k * size + k] += 1.0);
            entries
        };
        let zero = |size: usize| vec![0.0; size * size];
        for (size, entries) in [
            (27, product(27, 27)),
            (54, product(54, 6)),
            (20, plus_identity(20, product(20, 2))),
            (5, plus_identity(5, zero(5))),
            (4, zero(4)),
            (2, vec![1.0, 0.0, 3.0, -1.0]),
            (1, vec![-2.0]),
            (0, vec![]),
        ] {
            let found = SymmetricEigen::of(size, &entries).unwrap();
            assert_eq!((found.values.len(), found.vectors.len()), (size, size));
            let scale = entries.iter().fold(1.0_f64, |scale, entry| scale.max(entry.abs()));
            for (value, vector) in found.values.iter().zip(&found.vectors) {
                for i in 0..size {
                    let lower = |i: usize, j: usize| entries[i.max(j) * size + i.min(j)];
                    let image: f64 = (0..size).map(|j| lower(i, j) * vector[j]).sum();
                    assert!(
                        (image - value * vector[i]).abs() < 1e-13 * scale * size as f64,
                        "{size}: {value}"
                    );
                }
            }
            for (i, a) in found.vectors.iter().enumerate() {
                for (j, b) in found.vectors.iter().enumerate() {
                    assert!((dot(a, b) - f64::from(u8::from(i == j))).abs() < 1e-13);
                }
            }
        }
        assert_eq!(SymmetricEigen::of(1, &[f64::NAN]), None);
        assert_eq!(SymmetricEigen::of(2, &[1.0]), None);
    }

    /// The matrix of second differences has the eigenvalues 2 − 2 cos(kπ/(n+1)).
    #[test]
    fn second_differences() {
        let size = 30;
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        };
        let entries: Vec<f64> = (0..size * size).map(|place| entry(place / size, place % size)).collect();
        let mut values = SymmetricEigen::of(size, &entries).unwrap().values;
        values.sort_by(f64::total_cmp);
        for (k, value) in (1_u8..).zip(values) {
            let exact = 2.0 - 2.0 * (f64::from(k) * std::f64::consts::PI / (size as f64 + 1.0)).cos();
            assert!((value - exact).abs() < 1e-14, "{value} {exact}");
        }
    }
}
