//! Determinants and inverses of 2 × 2 and 3 × 3 matrices.

/// The determinant of a 2 × 2 or 3 × 3 matrix.
pub fn determinant<const D: usize>(a: &[[f64; D]; D]) -> f64 {
    if D == 2 {
        a[0][0] * a[1][1] - a[0][1] * a[1][0]
    } else {
        (0..D)
            .map(|k| {
                let (i, j) = ((k + 1) % D, (k + 2) % D);
                a[0][k] * (a[1][i] * a[2][j] - a[1][j] * a[2][i])
            })
            .sum()
    }
}

/// The inverse of a 2 × 2 or 3 × 3 matrix; `None` when it is singular.
pub fn inverse<const D: usize>(a: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
    let whole = determinant(a);
    let cofactor = |i: usize, j: usize| {
        if D == 2 {
            let sign = if i == j { 1.0 } else { -1.0 };
            sign * a[1 - i][1 - j]
        } else {
            let ([i1, i2], [j1, j2]) = ([(i + 1) % D, (i + 2) % D], [(j + 1) % D, (j + 2) % D]);
            a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1]
        }
    };
    let inverse: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / whole));
    inverse.iter().flatten().all(|entry| entry.is_finite()).then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_inverses() {
        let a = [[2.0, 1.0, 0.0], [0.0, 3.0, 1.0], [1.0, 0.0, 1.0]];
        assert_eq!(determinant(&a), 7.0);
        let scaled = inverse(&a).map(|inverse| inverse.map(|row| row.map(|entry| (7.0 * entry).round())));
        assert_eq!(scaled, Some([[3.0, -1.0, 1.0], [1.0, 2.0, -2.0], [-3.0, 1.0, 6.0]]));
        assert_eq!(inverse(&[[1.0, 2.0], [3.0, 5.0]]), Some([[-5.0, 2.0], [3.0, -1.0]]));
        assert_eq!(inverse(&[[1.0, 2.0], [2.0, 4.0]]), None);
    }
}
