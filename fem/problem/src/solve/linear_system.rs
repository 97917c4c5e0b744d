//! Linear systems with unknowns that are prescribed or given by others.

use super::elimination::Elimination;
use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use crate::linear_algebra::Transpose;
use crate::linear_algebra::backward_error::Residual;
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::error::{check_finite, check_size};
use crate::linear_algebra::{BlockMatrix, LinearAlgebraError};
use crate::threads::Threads;

/// Solution of A u = b with the prescribed unknowns eliminated: on free rows A u = b, elsewhere u is as prescribed.
/// The solver keeps the reduced matrix and its factor for further solves.
///
/// # Errors
/// If sizes disagree, a value is not finite, the solver fails, or an equation does not hold with what it found.
pub fn solve_linear(
    matrix: &BlockMatrix,
    b: &[f64],
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
) -> Result<LinearSolution, SolverError> {
    let lifted = elimination.lifted()?;
    let rest = difference(b, &matrix.multiply(&lifted)?)?;
    finish(matrix, rest, lifted, elimination, solver, Transpose::No)
}

/// Solution of Aᵀ u = b in the same way.
///
/// # Errors
/// As [`solve_linear`].
pub fn solve_linear_transposed(
    matrix: &BlockMatrix,
    b: &[f64],
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
) -> Result<LinearSolution, SolverError> {
    let lifted = elimination.lifted()?;
    let rest = difference(b, &matrix.multiply_transposed(&lifted)?)?;
    finish(matrix, rest, lifted, elimination, solver, Transpose::Yes)
}

/// An equation that is off by more than this part of its terms has not been solved, whatever the solver's own measure.
pub const HOLDS: f64 = 1e-3;

/// Cᵀ A C, or its transposed, by products with A.
#[derive(Debug)]
struct ReducedEquations<'a> {
    matrix: &'a BlockMatrix,
    elimination: &'a Elimination,
    transpose: Transpose,
}

impl Equations for ReducedEquations<'_> {
    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        let full = self.elimination.extend_by_zero(x)?;
        let (sums, sizes) = match self.transpose {
            Transpose::No => self.matrix.products(&full)?,
            Transpose::Yes => {
                let (mut sums, mut sizes) = (vec![0.0; full.len()], vec![0.0; full.len()]);
                for (row, factor) in full.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                    for (column, value) in self.matrix.row(row) {
                        sums[column] += value * factor;
                        sizes[column] += (value * factor).abs();
                    }
                }
                (sums, sizes)
            }
        };
        Ok((self.elimination.reduce(&sums)?, self.elimination.reduce_amounts(&sizes)?))
    }

    fn diagonal(&self) -> Vec<f64> {
        self.elimination.free().iter().map(|&unknown| self.matrix.get(unknown, unknown)).collect()
    }
}

fn difference(b: &[f64], product: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
    check_size("the right-hand side", product.len(), b.len())?;
    check_finite("the right-hand side", b)?;
    Ok(b.iter().zip(product).map(|(given, value)| given - value).collect())
}

/// Solves the reduced system for a reduced right-hand side. The solver keeps matrix and factor.
pub(super) fn solve_reduced(
    matrix: &BlockMatrix,
    load: &[f64],
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
    transpose: Transpose,
) -> Result<LinearSolution, SolverError> {
    solver.set_reduced(matrix, elimination)?;
    solver.solve_with(load, 0.0, transpose)
}

/// Whether each equation holds, of a solver that does not see to it by itself.
pub(super) fn check_equations(
    matrix: &BlockMatrix,
    load: &[f64],
    elimination: &Elimination,
    solver: &dyn LinearSolver,
    found: &LinearSolution,
    transpose: Transpose,
) -> Result<(), SolverError> {
    if !solver.judges_equations() {
        let equations = ReducedEquations { matrix, elimination, transpose };
        let residual = Residual::of(&equations, Threads::ONE, &found.solution, load)?;
        residual.check(&equations, (&found.solution, load), HOLDS)?;
    }
    Ok(())
}

fn finish(
    matrix: &BlockMatrix,
    rest: Vec<f64>,
    mut lifted: Vec<f64>,
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
    transpose: Transpose,
) -> Result<LinearSolution, SolverError> {
    let reduced = elimination.reduce(&rest)?;
    let mut result = solve_reduced(matrix, &reduced, elimination, solver, transpose)?;
    check_equations(matrix, &reduced, elimination, solver, &result, transpose)?;
    for (&unknown, &value) in elimination.free().iter().zip(&result.solution) {
        lifted[unknown] = value;
    }
    elimination.impose(&mut lifted)?;
    result.solution = lifted;
    Ok(result)
}
