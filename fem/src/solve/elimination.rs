//! Elimination of prescribed unknowns, and linear problems with them.

use std::collections::BTreeMap;
use std::ops::Range;

use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use crate::linear_algebra::error::{check_finite, check_size};
use crate::linear_algebra::{BlockMatrix, CsrMatrix, Entry, LinearAlgebraError, Restriction};

/// The free unknowns of a problem whose other unknowns are prescribed, and the passage between full and
/// reduced vectors and matrices. The map between matrices is computed at the first one.
#[derive(Debug)]
pub struct Elimination {
    size: usize,
    prescribed: BTreeMap<usize, f64>,
    free: Vec<usize>,
    restriction: Option<Restriction>,
}

impl Elimination {
    /// Elimination of `prescribed` (unknown → value) from `size` unknowns.
    ///
    /// # Errors
    /// If an unknown lies outside 0..size or a value is not finite.
    pub fn new(size: usize, prescribed: &BTreeMap<usize, f64>) -> Result<Self, LinearAlgebraError> {
        for (&index, &value) in prescribed {
            if index >= size {
                return Err(LinearAlgebraError::IndexOutOfRange { what: "prescribed unknown", index, size });
            }
            if !value.is_finite() {
                let what = "the prescribed values";
                return Err(LinearAlgebraError::VectorNotFinite { what, index, value });
            }
        }
        let free = (0..size).filter(|unknown| !prescribed.contains_key(unknown)).collect();
        Ok(Self { size, prescribed: prescribed.clone(), free, restriction: None })
    }

    /// Number of all unknowns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Free unknowns, ascending.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Writes the prescribed values into a full vector.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn impose(&self, full: &mut [f64]) -> Result<(), LinearAlgebraError> {
        check_size("the vector of all unknowns", self.size, full.len())?;
        for (&unknown, &value) in &self.prescribed {
            full[unknown] = value;
        }
        Ok(())
    }

    /// The free entries of a full vector.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn reduce(&self, full: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector of all unknowns", self.size, full.len())?;
        Ok(self.free.iter().map(|&unknown| full[unknown]).collect())
    }

    /// A full vector with the given free entries, and zero where unknowns are prescribed.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn extend_by_zero(&self, reduced: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector of free unknowns", self.free.len(), reduced.len())?;
        let mut full = vec![0.0; self.size];
        for (&unknown, &value) in self.free.iter().zip(reduced) {
            full[unknown] = value;
        }
        Ok(full)
    }

    /// The free rows and columns of a full matrix.
    ///
    /// # Errors
    /// If the matrix has the wrong size.
    pub fn reduce_matrix(&mut self, matrix: &BlockMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        self.restriction(matrix)?.apply(matrix)
    }

    /// The entries of the reduced matrix whose values stand at some places of the full one, as ranges of whole
    /// blocks. It takes a time proportional to their number, once a matrix of these positions has been reduced.
    ///
    /// # Errors
    /// If the matrix has the wrong size.
    pub fn reduce_places(
        &mut self,
        matrix: &BlockMatrix,
        places: &[Range<usize>],
    ) -> Result<Vec<Entry>, LinearAlgebraError> {
        self.restriction(matrix)?.apply_to_places(matrix, places)
    }

    fn restriction(&mut self, matrix: &BlockMatrix) -> Result<&Restriction, LinearAlgebraError> {
        check_size("the set of rows", self.size, matrix.rows())?;
        check_size("the set of columns", self.size, matrix.columns())?;
        let restriction = match self.restriction.take().filter(|restriction| restriction.fits(matrix)) {
            Some(restriction) => restriction,
            None => Restriction::new(matrix.sparsity(), &self.free, &self.free)?,
        };
        Ok(self.restriction.insert(restriction))
    }
}

/// Solves A u = b with the prescribed unknowns eliminated: on free rows A u = b, elsewhere u is as prescribed.
/// The solver keeps the reduced matrix and its factor for further solves.
///
/// # Errors
/// If sizes disagree, a value is not finite, or the solver fails.
pub fn solve_linear(
    matrix: &BlockMatrix,
    b: &[f64],
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
) -> Result<LinearSolution, SolverError> {
    let lifted = lift(elimination)?;
    let rest = difference(b, &matrix.multiply(&lifted)?)?;
    finish(matrix, rest, lifted, elimination, solver, |solver, rest| solver.solve(rest, 0.0))
}

/// Solves Aᵀ u = b in the same way.
///
/// # Errors
/// As [`solve_linear`].
pub fn solve_linear_transposed(
    matrix: &BlockMatrix,
    b: &[f64],
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
) -> Result<LinearSolution, SolverError> {
    let lifted = lift(elimination)?;
    let rest = difference(b, &matrix.multiply_transposed(&lifted)?)?;
    finish(matrix, rest, lifted, elimination, solver, |solver, rest| solver.solve_transposed(rest, 0.0))
}

/// The vector of prescribed values, zero on free unknowns.
fn lift(elimination: &Elimination) -> Result<Vec<f64>, LinearAlgebraError> {
    let mut lifted = vec![0.0; elimination.size()];
    elimination.impose(&mut lifted)?;
    Ok(lifted)
}

fn difference(b: &[f64], product: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
    check_size("the right-hand side", product.len(), b.len())?;
    check_finite("the right-hand side", b)?;
    Ok(b.iter().zip(product).map(|(given, value)| given - value).collect())
}

fn finish(
    matrix: &BlockMatrix,
    rest: Vec<f64>,
    mut lifted: Vec<f64>,
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
    solve: impl FnOnce(&mut dyn LinearSolver, &[f64]) -> Result<LinearSolution, SolverError>,
) -> Result<LinearSolution, SolverError> {
    let reduced = elimination.reduce(&rest)?;
    solver.set_matrix(elimination.reduce_matrix(matrix)?)?;
    let mut result = solve(solver, &reduced)?;
    for (&unknown, &value) in elimination.free().iter().zip(&result.solution) {
        lifted[unknown] = value;
    }
    result.solution = lifted;
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::TangentSolver;

    /// Rows of −u'' on 0..=n with unit spacing (the end rows as they come), plus an unsymmetric entry.
    fn line(n: usize, extra: f64) -> BlockMatrix {
        let mut triplets = Vec::new();
        for i in 0..n {
            triplets.extend([(i, i, 1.0), (i + 1, i + 1, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0)]);
        }
        triplets.push((1, 2, extra));
        CsrMatrix::from_triplets(n + 1, n + 1, &triplets).unwrap().into()
    }

    #[test]
    fn a_line_between_two_prescribed_ends() {
        let prescribed = BTreeMap::from([(0, 3.0), (10, 8.0)]);
        let mut elimination = Elimination::new(11, &prescribed).unwrap();
        let mut solver = TangentSolver::default();
        let found = solve_linear(&line(10, 0.0), &[0.0; 11], &mut elimination, &mut solver).unwrap();
        for (i, value) in found.solution.iter().enumerate() {
            assert!((value - (3.0 + 0.5 * i as f64)).abs() < 1e-13);
        }
    }

    #[test]
    fn the_transposed_problem_is_the_problem_of_the_transposed_matrix() {
        let prescribed = BTreeMap::from([(0, 1.0), (5, -2.0)]);
        let mut elimination = Elimination::new(11, &prescribed).unwrap();
        let mut solver = TangentSolver::default();
        let b: Vec<f64> = (0..11).map(|i| f64::from(i) * 0.1).collect();
        let matrix = line(10, 0.4);
        let one = solve_linear_transposed(&matrix, &b, &mut elimination, &mut solver).unwrap().solution;
        let residual = matrix.multiply_transposed(&one).unwrap();
        for i in 0..11 {
            if let Some(value) = prescribed.get(&i) {
                assert_eq!(one[i], *value);
            } else {
                assert!((residual[i] - b[i]).abs() < 1e-12);
            }
        }
        let transposed = matrix.to_csr().transpose().into();
        let two = solve_linear(&transposed, &b, &mut elimination, &mut solver).unwrap().solution;
        assert!(one.iter().zip(&two).all(|(a, b)| (a - b).abs() < 1e-11));
    }

    #[test]
    fn bad_prescriptions_are_refused() {
        assert!(matches!(
            Elimination::new(3, &BTreeMap::from([(3, 0.0)])),
            Err(LinearAlgebraError::IndexOutOfRange { index: 3, .. })
        ));
        assert!(matches!(
            Elimination::new(3, &BTreeMap::from([(1, f64::NAN)])),
            Err(LinearAlgebraError::VectorNotFinite { index: 1, .. })
        ));
        let elimination = Elimination::new(3, &BTreeMap::from([(1, 4.0)])).unwrap();
        assert_eq!(elimination.free(), [0, 2]);
        assert!(elimination.reduce(&[1.0]).is_err());
        assert_eq!(elimination.extend_by_zero(&[5.0, 6.0]).unwrap(), [5.0, 0.0, 6.0]);
    }
}
