//! Systems [K c; r d] by the factor of K, also where K is singular.
//!
//! Two solves with one factor per system (block elimination), and refinement against the whole matrix. At a limit point K is singular:
//! one diagonal entry of K, of an unknown that K does not determine, is then made stiffer, and a second border of one row and one column
//! takes the change out again (Woodbury).

use std::sync::Arc;

use super::inertia::Inertia;
use crate::linear_algebra::backward_error::Refinement;
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::vector::{dot, norm};
use crate::linear_algebra::{
    CsrMatrix, Entry, LinearAlgebraError, SparsityPattern, Transpose, determinant_sign,
};
use crate::solve::{LinearSolution, LinearSolver, SolverError, SolverReport, TangentSolver};
use crate::threads::Threads;

/// Most steps of refinement of a whole solution.
const REFINEMENTS: usize = 4;
/// Part of its terms by which an equation is off after rounding.
const ROUNDING: f64 = 1e-15;

/// A solver of bordered systems.
#[derive(Default)]
pub(super) struct BorderedSolver {
    /// With K, or K made stiffer.
    pub inner: TangentSolver,
    current: Option<Current>,
    patterns: Option<(Arc<SparsityPattern>, Arc<SparsityPattern>)>,
}

/// The matrix, taken apart.
struct Current {
    whole: CsrMatrix,
    core: CsrMatrix,
    /// Columns and rows of the borders, and what is between them.
    columns: Vec<Vec<f64>>,
    rows: Vec<Vec<f64>>,
    corner: Vec<f64>,
    is_stiffened: bool,
}

impl BorderedSolver {
    /// A solver with the factors of another one.
    pub fn new(inner: TangentSolver) -> Self {
        BorderedSolver { inner, current: None, patterns: None }
    }

    /// The signs of K's eigenvalues.
    ///
    /// # Errors
    /// [`SolverError`]: no matrix, or a determinant that could not be computed.
    pub fn inertia(&mut self) -> Result<Inertia, SolverError> {
        let current = self.current.as_ref().ok_or(SolverError::NoMatrix)?;
        if current.is_stiffened {
            return Ok(Inertia::Singular);
        }
        if self.inner.negative_eigenvalues().is_none() && self.inner.is_symmetric() {
            // A matrix that was nearly singular sends the next ones to LU, too.
            let mut anew = self.inner.anew();
            if anew.set_matrix(current.core.clone()).is_ok() {
                self.inner = anew;
            }
        }
        if let Some(count) = self.inner.negative_eigenvalues() {
            return Ok(Inertia::NegativeEigenvalues(count));
        }
        match determinant_sign(&current.core) {
            Ok(sign) => Ok(Inertia::Determinant(sign)),
            Err(LinearAlgebraError::Singular { .. }) => Ok(Inertia::Singular),
            Err(error) => Err(error.into()),
        }
    }

    /// The part of a bordered matrix before the last row and column.
    fn core(&mut self, whole: &CsrMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        let size = whole.rows() - 1;
        let pattern = match &self.patterns {
            Some((known, inner)) if Arc::ptr_eq(known, whole.pattern()) => Arc::clone(inner),
            _ => {
                let mut pointers = vec![0];
                let mut columns = vec![];
                for row in 0..size {
                    let inside = whole.row(row).0.iter().filter(|column| (**column as usize) < size);
                    columns.extend(inside);
                    pointers.push(columns.len());
                }
                let made = Arc::new(SparsityPattern::new(size, size, pointers, columns)?);
                // The solver's analysis is of its own pattern, if that is the same.
                let inner = match LinearSolver::pattern(&self.inner) {
                    Some(known) if **known == *made => Arc::clone(known),
                    _ => made,
                };
                self.patterns = Some((Arc::clone(whole.pattern()), Arc::clone(&inner)));
                inner
            }
        };
        let mut values = Vec::with_capacity(pattern.entries());
        for row in 0..size {
            let (columns, entries) = whole.row(row);
            values.extend(
                columns.iter().zip(entries).filter(|(c, _)| (**c as usize) < size).map(|(_, value)| value),
            );
        }
        CsrMatrix::from_pattern(&pattern, values)
    }

    /// Makes the diagonal entry of an unknown stiffer.
    fn stiffen(&mut self, unknown: usize) -> Result<(), SolverError> {
        let current = self.current.as_mut().ok_or(SolverError::NoMatrix)?;
        let sizes = current.core.row(unknown).1.iter();
        let stiffness = sizes.fold(0.0_f64, |most, value| most.max(value.abs()));
        let stiffness = if stiffness > 0.0 { stiffness } else { current.core.row_sum_norm().max(1.0) };
        let entry = Entry { row: unknown as u32, column: unknown as u32, value: stiffness };
        self.inner.set_matrix(current.core.plus(&[entry])?)?;
        let size = current.core.rows();
        let unit = |value: f64| {
            let mut unit = vec![0.0; size];
            unit[unknown] = value;
            unit
        };
        current.columns.push(unit(-1.0));
        current.rows.push(unit(1.0));
        // Two borders: [d 0; 0 −1/σ].
        current.corner = vec![current.corner[0], 0.0, 0.0, -1.0 / stiffness];
        current.is_stiffened = true;
        Ok(())
    }

    /// An approximate solution by block elimination.
    fn eliminate(&mut self, b: &[f64], transpose: Transpose) -> Result<Vec<f64>, SolverError> {
        let current = self.current.as_ref().ok_or(SolverError::NoMatrix)?;
        let (size, count) = (current.core.rows(), current.columns.len());
        let (columns, rows) = match transpose {
            Transpose::No => (&current.columns, &current.rows),
            Transpose::Yes => (&current.rows, &current.columns),
        };
        let sides: Vec<&[f64]> = [&b[..size]].into_iter().chain(columns.iter().map(Vec::as_slice)).collect();
        let found = self.inner.solve_each(&sides, 0.0, transpose).map_err(SolverError::of_any_side)?;
        let mut by_columns: Vec<_> = found.into_iter().map(|found| found.solution).collect();
        let mut x = by_columns.remove(0);
        let corner = |i: usize, j: usize| current.corner[i * count + j];
        let rest = |i: usize| if i == 0 { b[size] } else { 0.0 } - dot(&rows[i], &x);
        let entry = |i: usize, j: usize| corner(i, j) - dot(&rows[i], &by_columns[j]);
        let y = match count {
            1 => vec![rest(0) / entry(0, 0)],
            _ => {
                let (a, b, c, d) = (entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1));
                let determinant = a * d - b * c;
                vec![(rest(0) * d - b * rest(1)) / determinant, (a * rest(1) - c * rest(0)) / determinant]
            }
        };
        for (y, column) in y.iter().zip(&by_columns) {
            x.iter_mut().zip(column).for_each(|(x, column)| *x -= y * column);
        }
        x.push(y[0]);
        match x.iter().position(|value| !value.is_finite()) {
            None => Ok(x),
            Some(_) => Err(LinearAlgebraError::Singular { unknown: size, ratio: 0.0 }.into()),
        }
    }

    fn solve_refined(&mut self, b: &[f64], transpose: Transpose) -> Result<LinearSolution, SolverError> {
        let x = self.eliminate(b, transpose)?;
        let whole = self.current.as_ref().ok_or(SolverError::NoMatrix)?.whole.clone();
        let side = Side::of(&whole, transpose);
        let mut found = Refinement::new(&side, Threads::ONE, b, x)?;
        let mut solve = |change: &mut Vec<f64>| -> Result<(), SolverError> {
            *change = self.eliminate(change, transpose)?;
            Ok(())
        };
        for _ in 0..REFINEMENTS {
            if found.residual.worst().error <= ROUNDING {
                break;
            }
            found.step(&mut solve)?;
            if found.next.worst().error >= found.residual.worst().error {
                break;
            }
            found.accept();
        }
        found.finish(&mut solve)?;
        let scale = norm(b);
        let relative_residual = if scale == 0.0 { 0.0 } else { norm(&found.residual.rest) / scale };
        Ok(LinearSolution { solution: found.x, relative_residual, iterations: 0 })
    }

    /// The unknown that the core determines least, by a solve with it where its factor exists.
    fn least_determined(&mut self) -> usize {
        let Some(current) = &self.current else { return 0 };
        let found = self.inner.solve(&current.columns[0], 0.0).map(|found| found.solution);
        let vector = found.unwrap_or_else(|_| current.rows[0].clone());
        let larger = |best: usize, k: usize| if vector[k].abs() > vector[best].abs() { k } else { best };
        (0..vector.len()).fold(0, larger)
    }
}

/// The unknown that a singular matrix does not determine.
fn undetermined(error: &SolverError) -> Option<usize> {
    match error {
        SolverError::LinearAlgebra(
            LinearAlgebraError::Singular { unknown, .. }
            | LinearAlgebraError::IllConditioned { unknown, .. }
            | LinearAlgebraError::Inaccurate { row: unknown, .. },
        ) => Some(*unknown),
        _ => None,
    }
}

impl LinearSolver for BorderedSolver {
    fn set_matrix(&mut self, whole: CsrMatrix) -> Result<(), SolverError> {
        if self.current.as_ref().is_some_and(|current| current.whole == whole) {
            return Ok(());
        }
        self.current = None;
        whole.check_finite()?;
        let size = whole.rows().saturating_sub(1);
        let core = self.core(&whole)?;
        let column = (0..size).map(|row| whole.get(row, size)).collect();
        let row = (0..size).map(|column| whole.get(size, column)).collect();
        let corner = vec![whole.get(size, size)];
        let result = self.inner.set_matrix(core.clone());
        let (columns, rows) = (vec![column], vec![row]);
        self.current = Some(Current { whole, core, columns, rows, corner, is_stiffened: false });
        match result {
            Ok(()) => Ok(()),
            Err(error) => {
                let stiffened = match undetermined(&error).filter(|unknown| *unknown < size) {
                    Some(unknown) => self.stiffen(unknown),
                    None => Err(error),
                };
                if stiffened.is_err() {
                    self.current = None;
                }
                stiffened
            }
        }
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        _absolute_tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        match self.solve_refined(b, transpose) {
            Err(error) if self.current.as_ref().is_some_and(|current| !current.is_stiffened) => {
                let size = b.len() - 1;
                let unknown = match undetermined(&error) {
                    Some(unknown) if unknown < size => unknown,
                    Some(_) => self.least_determined(),
                    None => return Err(error),
                };
                self.stiffen(unknown)?;
                self.solve_refined(b, transpose)
            }
            found => found,
        }
    }

    fn judges_equations(&self) -> bool {
        true
    }

    fn report(&self) -> Option<SolverReport> {
        LinearSolver::report(&self.inner)
    }
}
