//! Exact solution with tangents T = K + B whose B lives on few unknowns, as contact terms do.
//!
//! K = L D Lᵀ is factored once, with the touched unknowns c ordered last. With S = L_c D_c L_cᵀ from the trailing
//! block of L, T x = b is
//!
//! 1. y = D⁻¹ L⁻¹ b,   2. (S + B_cc) x_c = L_c D_c y_c by dense LU,   3. y_c ← L_cᵀ x_c, x = L⁻ᵀ y,
//!
//! so a Newton step costs two half solves and a small dense LU; the transposed system costs the same. D = 1 where K is positive
//! definite. D has signs where K is quasi-definite, as that of a nearly incompressible body with its pressure: both signs of
//! unknowns are then eliminated in any order, those of one cell included. If c grows, K is factored again with the larger
//! c; where that does not pay or K is neither of both, a [`TangentSolver`] takes over.

mod condensed_system;
mod condensing;
mod solves;

use std::sync::Arc;
use std::time::Instant;

pub(super) use condensed_system::CondensedSystem;
use solves::Kept;

use super::elimination::Elimination;
use super::linear_solver::{LinearSolution, LinearSolver, SolverError};
use super::solver_report::SolverReport;
use super::step_memory::StepMemory;
use super::tangent_solver::{TangentSolver, TangentSolverOptions};
use crate::linear_algebra::Transpose;
use crate::linear_algebra::equations::Side;
use crate::linear_algebra::singularity::check_regular;
use crate::linear_algebra::{
    Analysis, BlockMatrix, Condensation, CsrMatrix, DenseFactor, Entry, LinearAlgebraError, Ordering,
    SparsityPattern, SymmetricFactor,
};
use crate::threads::Threads;

/// Entries (i, j) of T − K below this part of √(K_ii K_jj) are rounding: coordinates of about 1000 cell diameters
/// lose three digits in a cell's Jacobian. If they are not, refinement makes up for it.
const ROUNDING: f64 = 1e-12;

/// Most asymmetry of a linear part that is factored as a symmetric one.
const SYMMETRIC: f64 = 1e-12;

/// A dense LU may cost as many multiplications as this many per stored number of the sparse factor:
/// about what the Krylov iterations it replaces would cost.
const DENSE_COST: f64 = 400.0;

/// A matrix with more than this part of its entries other than those of the linear part is stored by itself.
const CHANGED: usize = 8;

/// A factor with a pivot below this part of its scale is asked whether K is singular.
const DOUBTFUL: f64 = 1e-9;

/// A solver that condenses to the unknowns that change. Its fallback is a [`TangentSolver`].
///
/// Problems that are solved with it one after the other, as the adjoint states of several criteria, share the factor of K and the map
/// to their free unknowns. Affine ones share the memory of one matrix, which the solver keeps, and each is known by its difference from K:
/// what it does not change is not stored again.
#[derive(Debug, Default)]
pub struct CondensedSolver {
    fallback: TangentSolver,
    linear_part: Option<LinearPart>,
    condensation: Option<Arc<Condensation>>,
    /// Unknowns that coming matrices are expected to change.
    expected: Vec<u32>,
    /// K could not be factored: do not try again.
    refused: bool,
    current: Option<Current>,
    /// Systems that are solved together, and the solutions of earlier ones.
    kept: Kept,
    report: SolverReport,
    /// Of the problems that were solved.
    memory: StepMemory,
}

/// K and the sizes √K_ii of its unknowns.
#[derive(Debug)]
struct LinearPart {
    matrix: Arc<CsrMatrix>,
    sizes: Vec<f64>,
    /// Whether it is known to be symmetric, except for rounding.
    is_symmetric: bool,
}

impl LinearPart {
    /// Whether an addition to an entry is more than rounding, in the unit of that entry.
    fn is_changed_by(&self, row: usize, column: usize, addition: f64) -> bool {
        addition.abs() > ROUNDING * self.sizes[row] * self.sizes[column]
    }
}

/// The matrix of the next solves.
#[derive(Debug)]
enum Current {
    Fallback,
    Condensed(Condensed),
}

/// A matrix as the linear part with additions, and the dense factor of its condensed system; none where nothing is added.
#[derive(Clone, Debug)]
struct Condensed {
    matrix: Arc<Sum>,
    dense: Option<Arc<DenseFactor>>,
}

/// A matrix as a stored one and additions to some of its entries.
#[derive(Debug)]
struct Sum {
    base: Arc<CsrMatrix>,
    /// Whether the stored one is known to be symmetric, except for rounding.
    is_symmetric: bool,
    additions: Vec<Entry>,
}

impl Sum {
    /// A matrix without additions.
    fn of(matrix: CsrMatrix) -> Self {
        Sum { base: Arc::new(matrix), is_symmetric: false, additions: vec![] }
    }

    /// The equations of a solve.
    fn side(&self, transpose: Transpose) -> Side<'_> {
        let side = match self.is_symmetric {
            true => Side::of_symmetric(&self.base),
            false => Side::of(&self.base, transpose),
        };
        side.with_additions(&self.additions, transpose)
    }

    fn to_matrix(&self) -> Result<CsrMatrix, LinearAlgebraError> {
        self.base.plus(&self.additions)
    }
}

impl CondensedSolver {
    /// A solver whose fallback has these options.
    pub fn new(options: TangentSolverOptions) -> Self {
        CondensedSolver { fallback: TangentSolver::new(options), ..Self::default() }
    }

    /// The work done so far, by this solver and its fallback.
    pub fn report(&self) -> SolverReport {
        let (own, other) = (&self.report, self.fallback.report());
        SolverReport {
            analyses: own.analyses + other.analyses,
            factorisations: own.factorisations + other.factorisations,
            indefinite_factorisations: other.indefinite_factorisations,
            signed_factorisations: own.signed_factorisations + other.signed_factorisations,
            lu_factorisations: other.lu_factorisations,
            solves: own.solves + other.solves,
            iterations: own.iterations.iter().chain(&other.iterations).copied().collect(),
            analysis_seconds: own.analysis_seconds + other.analysis_seconds,
            factorisation_seconds: own.factorisation_seconds + other.factorisation_seconds,
            solve_seconds: own.solve_seconds + other.solve_seconds,
            largest_residual: own.largest_residual.max(other.largest_residual),
            factor_entries: own.factor_entries.max(other.factor_entries),
            factorisation_work: own.factorisation_work.clone().or_else(|| other.factorisation_work.clone()),
            solve_work: own.solve_work.clone().or_else(|| other.solve_work.clone()),
            orderings: if own.orderings.is_empty() { &other.orderings } else { &own.orderings }.clone(),
            condition: other.condition,
            negative_eigenvalues: other.negative_eigenvalues,
            path: match self.current {
                Some(Current::Fallback) => other.path,
                _ => own.path,
            },
            local_unknowns: None,
            condensed_unknowns: own.condensed_unknowns,
        }
    }

    /// The entries of T − K that are more than rounding; `None` when T and K do not share a pattern.
    fn difference(&self, matrix: &CsrMatrix) -> Option<Vec<Entry>> {
        let part = self.linear_part.as_ref().filter(|part| part.matrix.same_pattern(matrix))?;
        let mut entries = Vec::new();
        for row in 0..matrix.rows() {
            let (columns, values) = matrix.row(row);
            for ((column, value), base) in columns.iter().zip(values).zip(part.matrix.row(row).1) {
                if part.is_changed_by(row, *column as usize, value - base) {
                    entries.push(Entry { row: row as u32, column: *column, value: value - base });
                }
            }
        }
        Some(entries)
    }

    /// Whether a matrix is the linear part, and has a factor as far as is known.
    fn knows(&self, linear_part: &Arc<CsrMatrix>) -> bool {
        !self.refused
            && self.linear_part.as_ref().is_some_and(|known| Arc::ptr_eq(&known.matrix, linear_part))
    }

    /// The linear part with additions.
    fn sum(&self, linear_part: &Arc<CsrMatrix>, additions: Vec<Entry>) -> Sum {
        let of_known = |known: &LinearPart| known.is_symmetric && Arc::ptr_eq(&known.matrix, linear_part);
        let is_symmetric = self.linear_part.as_ref().is_some_and(of_known);
        Sum { base: linear_part.clone(), is_symmetric, additions }
    }

    /// Additions that are more than rounding.
    fn changes(&self, additions: &[Entry]) -> Vec<Entry> {
        let is_change = |entry: &&Entry| {
            let Entry { row, column, value } = **entry;
            self.linear_part
                .as_ref()
                .is_none_or(|part| part.is_changed_by(row as usize, column as usize, value))
        };
        additions.iter().filter(is_change).copied().collect()
    }

    /// Takes T = K + `additions`, which is also given as a `matrix` that is convenient for products.
    fn condense(&mut self, additions: &[Entry], matrix: Sum) -> Result<(), SolverError> {
        let changes = self.changes(additions);
        let touched = unknowns_of(&changes);
        if !self.condense_to(&touched)? {
            return self.fall_back(matrix.to_matrix()?);
        }
        let threads = self.fallback.threads();
        let Some(condensation) = &self.condensation else { return self.fall_back(matrix.to_matrix()?) };
        let start = Instant::now();
        let dense = (!changes.is_empty()).then(|| condensation.dense_factor(threads, &changes, None));
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let (matrix, dense) = (Arc::new(matrix), dense.map(Arc::new));
        self.current = Some(Current::Condensed(Condensed { matrix, dense }));
        Ok(())
    }

    /// Makes a factor of K in which the touched unknowns come last. False: it is not worth it, or K is
    /// not positive definite.
    fn condense_to(&mut self, touched: &[u32]) -> Result<bool, SolverError> {
        if self.refused {
            return Ok(false);
        }
        let Some(part) = &self.linear_part else { return Ok(false) };
        let linear_part = &part.matrix.clone();
        if let Some(known) = &self.condensation
            && known.holds(touched)
        {
            return Ok(true);
        }
        self.current = None; // it belongs to the factor
        self.solve_waiting();
        let earlier = self.condensation.take().map(|known| known.unknowns().to_vec()).unwrap_or_default();
        let expected = std::mem::take(&mut self.expected);
        let mut all = [touched, &earlier[..], &expected].concat();
        all.sort_unstable();
        all.dedup();
        let start = Instant::now();
        let (analysis, completed) =
            Analysis::of_symmetric_on(self.fallback.threads(), linear_part, &Ordering::default(), &all)?;
        self.report.orderings = analysis.candidates().to_vec();
        let (analysis, linear_part) = (Arc::new(analysis), completed.as_ref().unwrap_or(linear_part));
        self.report.analyses += 1;
        self.report.analysis_seconds += start.elapsed().as_secs_f64();
        let count = all.len();
        if (count as f64).powi(3) * 2.0 / 3.0 > DENSE_COST * analysis.factor_entries() as f64 {
            // What was expected was too much. Without it, it may be worth it.
            return if expected.is_empty() { Ok(false) } else { self.condense_to(touched) };
        }
        let start = Instant::now();
        let factor = factor_of(self.fallback.threads(), &analysis, linear_part);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let factor = match factor {
            // Rounding may hide a singular K; the fallback names it, or finds that changes make up for it.
            Ok(factor)
                if factor.smallest_pivot_ratio() < DOUBTFUL
                    && check_regular(linear_part, |y| factor.solve_in_place(y)).is_err() =>
            {
                self.refused = true;
                return Ok(false);
            }
            Ok(factor) => factor,
            Err(LinearAlgebraError::NotPositiveDefinite { .. } | LinearAlgebraError::Singular { .. }) => {
                self.refused = true;
                return Ok(false);
            }
            Err(error) => return Err(error.into()),
        };
        self.report.factorisations += 1;
        self.report.signed_factorisations += usize::from(factor.is_signed());
        self.report.factor_entries = analysis.factor_entries();
        self.report.factorisation_work = Some(analysis.factorisation_work());
        self.report.solve_work = Some(analysis.solve_work());
        self.report.condensed_unknowns = Some(count);
        drop(analysis);
        self.condensation =
            Some(Arc::new(Condensation::new(self.fallback.threads(), factor.for_solves(), count)));
        Ok(true)
    }

    fn fall_back(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.current = None;
        self.fallback.set_matrix(matrix)?;
        self.current = Some(Current::Fallback);
        Ok(())
    }
}

/// The factor LLᵀ of a positive definite matrix, or LSLᵀ of a quasi-definite one.
///
/// # Errors
/// [`LinearAlgebraError::NotPositiveDefinite`] of any other matrix.
fn factor_of(
    threads: Threads,
    analysis: &Arc<Analysis>,
    matrix: &CsrMatrix,
) -> Result<SymmetricFactor, LinearAlgebraError> {
    let diagonal = matrix.diagonal();
    if diagonal.iter().all(|value| *value > 0.0) || diagonal.contains(&0.0) {
        return SymmetricFactor::cholesky_on(threads, analysis, matrix, Vec::new());
    }
    let factor = SymmetricFactor::signed_on(threads, analysis, matrix, Vec::new())?;
    // Pivots that were replaced or have another sign than the diagonal are those of a matrix that needs pivoting.
    if factor.replaced_pivots() > 0 || factor.turned_pivots(matrix) > 0 {
        let unknown = diagonal.iter().position(|value| *value < 0.0).unwrap_or(0);
        return Err(LinearAlgebraError::NotPositiveDefinite { unknown });
    }
    Ok(factor)
}

/// Amounts that entries of T add to those of K.
pub(super) fn additions(linear_part: &CsrMatrix, entries: &[Entry]) -> Result<Vec<Entry>, SolverError> {
    let mut additions = Vec::with_capacity(entries.len());
    for Entry { row, column, value } in entries.iter().copied() {
        if !value.is_finite() {
            let (row, column) = (row as usize, column as usize);
            return Err(LinearAlgebraError::EntryNotFinite { row, column, value }.into());
        }
        let place = linear_part.find_stored(row, column)?;
        let value = value - linear_part.values()[place];
        if value != 0.0 {
            additions.push(Entry { row, column, value });
        }
    }
    Ok(additions)
}

/// Rows and columns of entries, ascending.
fn unknowns_of(entries: &[Entry]) -> Vec<u32> {
    let mut unknowns: Vec<u32> = entries.iter().flat_map(|entry| [entry.row, entry.column]).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    unknowns
}

impl LinearSolver for CondensedSolver {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.current = None;
        matrix.check_finite()?;
        match (self.difference(&matrix), &self.linear_part) {
            (Some(additions), Some(known)) => {
                // One copy of the pattern is enough.
                let matrix = CsrMatrix::from_pattern(known.matrix.pattern(), matrix.into_values())?;
                self.condense(&additions, Sum::of(matrix))
            }
            _ => self.fall_back(matrix),
        }
    }

    fn set_reduced(
        &mut self,
        matrix: &BlockMatrix,
        elimination: &mut Elimination,
    ) -> Result<(), SolverError> {
        let known = self.linear_part.as_ref().filter(|_| !self.refused && elimination.only_prescribes());
        if let Some(base) = known.map(|known| known.matrix.clone()) {
            // Where most of the matrix is the linear part, bit by bit, nothing of it is copied.
            let most = base.values().len() / CHANGED;
            let threads = self.fallback.threads();
            let found = elimination.reduce_difference_from(threads, matrix, &base, most);
            if found.is_err() {
                self.current = None;
            }
            if let Some(additions) = found? {
                return match &self.current {
                    // Another criterion at the same state.
                    Some(Current::Condensed(Condensed { matrix, .. }))
                        if Arc::ptr_eq(&matrix.base, &base) && matrix.additions == additions =>
                    {
                        Ok(())
                    }
                    _ => self.set_added(&base, additions, &[]),
                };
            }
        }
        let pattern = self.pattern().cloned();
        self.set_matrix(elimination.reduce_matrix_sharing(matrix, pattern.as_ref())?)
    }

    fn memory(&mut self) -> Option<&mut StepMemory> {
        Some(&mut self.memory)
    }

    fn pattern(&self) -> Option<&Arc<SparsityPattern>> {
        match &self.linear_part {
            Some(known) => Some(known.matrix.pattern()),
            None => self.fallback.pattern(),
        }
    }

    fn report(&self) -> Option<SolverReport> {
        Some(CondensedSolver::report(self))
    }

    fn as_condensed(&mut self) -> Option<&mut CondensedSolver> {
        Some(self)
    }

    fn judges_equations(&self) -> bool {
        true
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        self.solve_each(&[b], tolerance, transpose).map(|mut found| found.swap_remove(0))
    }

    fn solve_each(
        &mut self,
        sides: &[&[f64]],
        tolerance: f64,
        transpose: Transpose,
    ) -> Result<Vec<LinearSolution>, SolverError> {
        let system = match &self.current {
            None => return Err(SolverError::NoMatrix),
            Some(Current::Fallback) => return self.fallback.solve_each(sides, tolerance, transpose),
            Some(Current::Condensed(system)) => system.clone(),
        };
        self.solve_condensed_each(&system, sides, tolerance, transpose)
    }
}

#[cfg(test)]
mod tests;
