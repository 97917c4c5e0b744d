//! LU of unsymmetric matrices where it costs less than the iterations of GMRES.

use std::time::Instant;

use super::TangentSolver;
use crate::linear_algebra::CsrMatrix;
use crate::solve::lu_solver::LuSolver;

/// Cost of the checks of an LU factor and of its refined solution \[iterations of GMRES\].
const CHECKED: usize = 5;

/// Factors that were not accurate, one after the other, after which no further one is tried.
const FAILURES: usize = 2;

/// LU factors without pivoting of unsymmetric matrices for which GMRES takes longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct UnpivotedFactors {
    /// Number of unknowns.
    size: usize,
    /// Last factors that were not accurate.
    failures: usize,
}

impl TangentSolver {
    /// Iterations of GMRES that cost as much as a Cholesky factorisation. Measured in 2D: a factorisation with 85 and 168
    /// multiplications per stored number took the time of 5 and 10 iterations.
    pub(super) fn factorisation_in_iterations(&self) -> usize {
        let estimate = self.analysis.as_ref().map_or(0.0, |analysis| {
            analysis.multiplications() / (17.0 * analysis.factor_entries().max(1) as f64)
        });
        estimate as usize
    }

    /// Notes whether the next unsymmetric matrices of a size are factored by LU, after iterations with a matrix's own factor.
    pub(super) fn consider_lu(&mut self, size: usize, iterations: usize) {
        // L and U are two triangles.
        let cost = || 2 * self.factorisation_in_iterations() + CHECKED;
        let is_worthwhile = iterations > self.options.lu_after.unwrap_or_else(cost);
        if is_worthwhile && self.unpivoted.is_none_or(|known| known.size != size) {
            self.unpivoted = Some(UnpivotedFactors { size, failures: 0 });
        }
    }

    /// Factors a matrix by LU where that is preferred. False: GMRES is next.
    pub(super) fn factor_unpivoted(&mut self, matrix: &CsrMatrix) -> bool {
        let is_tried = |known: &UnpivotedFactors| {
            known.size == matrix.rows() && known.failures < FAILURES && LuSolver::may_be_unpivoted(matrix)
        };
        let Some(known) = self.unpivoted.filter(is_tried) else { return false };
        // Two triangles take the place of one.
        self.factor = None;
        let start = Instant::now();
        self.share_analysis();
        let is_done = self.lu.factor_unpivoted(matrix);
        self.report.factorisation_seconds += start.elapsed().as_secs_f64();
        let failures = if is_done { 0 } else { known.failures + 1 };
        self.unpivoted = Some(UnpivotedFactors { failures, ..known });
        if is_done {
            self.report.lu_factorisations += 1;
            (self.by_lu, self.by_signs) = (true, false);
        }
        is_done
    }

    /// Lends the analysis to LU.
    pub(super) fn share_analysis(&mut self) {
        self.analysis.iter().for_each(|analysis| self.lu.share(analysis));
    }
}
