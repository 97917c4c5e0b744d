//! Symmetric scaling of a matrix whose rows differ much in size, until their largest entries are about one
//! (Ruiz 2001), by powers of two, so that it rounds nothing.

use super::csr::CsrMatrix;
use super::error::LinearAlgebraError;

/// Rows whose largest entries differ by less than this are left as they are.
const CONTRAST: f64 = 1e6;
/// Rounds of scaling; each takes the square root of what is left.
const ROUNDS: usize = 8;

/// The diagonal S of S A S, powers of two.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibration {
    scale: Vec<f64>,
}

impl Equilibration {
    /// The scaling that a matrix asks for; none where its rows are of comparable size.
    pub fn of(matrix: &CsrMatrix) -> Option<Self> {
        let mut scale = vec![1.0; matrix.rows()];
        let of_row = |row: usize| matrix.row(row).1.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let mut largest: Vec<f64> = (0..matrix.rows()).map(of_row).collect();
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for value in largest.iter().filter(|value| **value > 0.0) {
            (least, most) = (least.min(*value), most.max(*value));
        }
        if most <= CONTRAST * least {
            return None;
        }
        for _ in 0..ROUNDS {
            let mut changed = false;
            for (scale, largest) in scale.iter_mut().zip(&largest).filter(|(_, largest)| **largest > 0.0) {
                let factor = (-0.5 * largest.log2()).round().exp2();
                changed |= factor != 1.0;
                *scale *= factor;
            }
            if !changed {
                break;
            }
            largest = row_maxima(matrix, &scale);
        }
        Some(Equilibration { scale })
    }

    /// The scaling of a symmetric saddle point, as an LU factorisation scales it: its rows of multipliers may hold entries of
    /// another size and unit than its diagonal.
    ///
    /// # Errors
    /// [`LinearAlgebraError::Singular`] with the unknown whose row is zero.
    pub fn of_saddle_point(matrix: &CsrMatrix) -> Result<Self, LinearAlgebraError> {
        Ok(Equilibration { scale: super::lu::scale(matrix)?.0 })
    }

    /// S A S.
    pub fn of_matrix(&self, matrix: &CsrMatrix) -> CsrMatrix {
        let mut scaled = matrix.clone();
        let pattern = matrix.pattern().clone();
        for (row, scale) in self.scale.iter().enumerate() {
            let range = pattern.row_range(row);
            let columns = &pattern.column_indices()[range.clone()];
            for (value, column) in scaled.values_mut()[range].iter_mut().zip(columns) {
                *value = *value * scale * self.scale[*column as usize];
            }
        }
        scaled
    }

    /// S v: the right-hand side of the scaled system from that of the original one, or the solution of the original system from that
    /// of the scaled one.
    pub fn times(&self, v: &[f64]) -> Vec<f64> {
        v.iter().zip(&self.scale).map(|(v, scale)| v * scale).collect()
    }

    /// S⁻¹ v: a residual of the system as it is from one of the scaled system.
    pub fn divided(&self, v: &[f64]) -> Vec<f64> {
        v.iter().zip(&self.scale).map(|(v, scale)| v / scale).collect()
    }
}

fn row_maxima(matrix: &CsrMatrix, scale: &[f64]) -> Vec<f64> {
    let of_row = |(row, own): (usize, &f64)| {
        let (columns, values) = matrix.row(row);
        let entries =
            columns.iter().zip(values).map(|(column, value)| (value * scale[*column as usize]).abs());
        entries.fold(0.0, f64::max) * own
    };
    scale.iter().enumerate().map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_size_are_left_alone_and_others_come_to_one() {
        let of = |k: f64, e: f64, c: f64| {
            CsrMatrix::from_triplets(2, 2, &[(0, 0, k), (0, 1, e), (1, 0, e), (1, 1, c)]).unwrap()
        };
        assert_eq!(Equilibration::of(&of(3.0, 1.0, 2000.0)), None);
        for (k, e, c) in [(1e12, 1.0, 1.0), (1e-16, 0.0, 1.0), (2e11, 1.0, 0.0), (1e200, 1.0, 1e-200)] {
            let matrix = of(k, e, c);
            let scaled = Equilibration::of(&matrix).unwrap().of_matrix(&matrix);
            for row in 0..2 {
                let largest = scaled.row(row).1.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                assert!((0.25..=4.0).contains(&largest), "{k:e} {e} {c:e}: {scaled:?}");
            }
        }
    }

    #[test]
    fn scaling_rounds_nothing() {
        let matrix = CsrMatrix::from_triplets(2, 2, &[(0, 0, 0.7e9), (1, 1, 0.3e-9)]).unwrap();
        let scaling = Equilibration::of(&matrix).unwrap();
        let v = [0.1, 0.7];
        assert_eq!(scaling.divided(&scaling.times(&v)), v);
        let mantissa = |value: f64| value.to_bits() & ((1 << 52) - 1);
        for (scaled, given) in scaling.of_matrix(&matrix).values().iter().zip(matrix.values()) {
            assert_eq!(mantissa(*scaled), mantissa(*given));
        }
    }
}
