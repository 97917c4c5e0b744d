//! The system K x + N(x) = b on the condensed unknowns c alone, for Newton's method: with y = L⁻¹ b,
//!
//!   R_c(x) = S x_c + N_c(x) − L_c y_c,   (S + dN) δ_c = −R_c,   x = L⁻ᵀ (y_f, L_cᵀ x_c).
//!
//! Rows outside of c hold for every x_c. One half solve begins the iteration and one ends it; between them a step
//! costs a dense system, and a back-substitution for the unknowns that N reads.

use std::sync::Arc;
use std::time::Instant;

use super::condensation::Condensation;
use super::{CondensedSolver, Current, Sum, unknowns_of};
use crate::linear_algebra::vector::norm;
use crate::linear_algebra::{CsrMatrix, Entry, LinearAlgebraError, PartialBackSubstitution};
use crate::solve::linear_solver::SolverError;
use crate::solve::solver_report::SolverPath;

/// The state of such an iteration. It belongs to one factor of a [`CondensedSolver`].
#[derive(Debug)]
pub struct FewUnknowns {
    y: Vec<f64>,
    /// L_c y_c.
    load: Vec<f64>,
    /// The unknowns that N reads, and how to get at them.
    watched: Vec<u32>,
    substitution: PartialBackSubstitution,
    /// c, in elimination order.
    unknowns: Vec<u32>,
}

impl FewUnknowns {
    /// c, in the order of the vectors on it.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknowns
    }

    /// The entries of c in a vector of all unknowns.
    pub fn condensed(&self, x: &[f64]) -> Vec<f64> {
        self.unknowns.iter().map(|unknown| x[*unknown as usize]).collect()
    }

    /// The norm of a vector of all unknowns without its entries in c.
    pub fn norm_outside(&self, x: &[f64]) -> f64 {
        let mut rest = x.to_vec();
        self.unknowns.iter().for_each(|unknown| rest[*unknown as usize] = 0.0);
        norm(&rest)
    }

    /// Brings the entries of x that N reads up to date with x_c.
    ///
    /// # Errors
    /// If the factor is not the one that the iteration began with.
    pub fn update(
        &mut self,
        solver: &CondensedSolver,
        x_c: &[f64],
        x: &mut [f64],
    ) -> Result<(), SolverError> {
        let condensation = factored(solver)?;
        let first = self.y.len() - x_c.len();
        self.y[first..].copy_from_slice(&condensation.shifted(x_c));
        let values = self.substitution.solve(condensation.factor(), &self.y)?;
        let watched = self.watched.iter().zip(values);
        watched.for_each(|(unknown, value)| x[*unknown as usize] = value);
        Ok(())
    }

    /// x of all unknowns.
    ///
    /// # Errors
    /// As [`FewUnknowns::update`].
    pub fn finish(mut self, solver: &mut CondensedSolver, x_c: &[f64]) -> Result<Vec<f64>, SolverError> {
        let start = Instant::now();
        let condensation = factored(solver)?;
        let first = self.y.len() - x_c.len();
        self.y[first..].copy_from_slice(&condensation.shifted(x_c));
        let x = condensation.factor().solve_upper(self.y)?;
        solver.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(x)
    }

    /// R_c for the x_c and N of all unknowns.
    ///
    /// # Errors
    /// As [`FewUnknowns::update`].
    pub fn residual(
        &self,
        solver: &CondensedSolver,
        x_c: &[f64],
        nonlinear: &[f64],
    ) -> Result<Vec<f64>, SolverError> {
        let product = factored(solver)?.schur_times(x_c);
        let nonlinear = self.condensed(nonlinear);
        Ok(product.iter().zip(nonlinear).zip(&self.load).map(|((s, n), load)| s + n - load).collect())
    }
}

fn factored(solver: &CondensedSolver) -> Result<&Condensation, SolverError> {
    solver.condensation.as_ref().ok_or(SolverError::NoMatrix)
}

impl CondensedSolver {
    /// Whether the rows and columns of B's entries, and some further unknowns, are among the c of an iteration.
    pub fn holds_as(&self, few: &FewUnknowns, additions: &[Entry], further: &[u32]) -> bool {
        self.condensation.as_ref().is_some_and(|condensation| {
            condensation.unknowns().len() == few.unknowns.len()
                && condensation.holds(&unknowns_of(&self.changes(additions)))
                && condensation.holds(further)
        })
    }

    /// Sees to it that they are among c. False: it is not worth it, or K has no factor.
    ///
    /// # Errors
    /// As [`super::LinearSolver::set_changed`].
    pub fn hold(&mut self, additions: &[Entry], further: &[u32]) -> Result<bool, SolverError> {
        let mut touched = unknowns_of(&self.changes(additions));
        touched.extend_from_slice(further);
        self.condense_to(&touched)
    }

    /// Begins an iteration for K x + N(x) = b where N reads the `watched` unknowns only.
    ///
    /// # Errors
    /// If there is no factor, or b does not fit.
    pub fn few_unknowns(&mut self, b: &[f64], watched: &[u32]) -> Result<FewUnknowns, SolverError> {
        crate::linear_algebra::error::check_finite("the right-hand side", b)?;
        let start = Instant::now();
        let condensation = factored(self)?;
        let y = condensation.factor().solve_lower(b)?;
        let few = FewUnknowns {
            load: condensation.condensed_load(&y),
            y,
            watched: watched.to_vec(),
            substitution: PartialBackSubstitution::new(condensation.factor(), watched)?,
            unknowns: condensation.unknowns().to_vec(),
        };
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(few)
    }

    /// δ_c with (S + B) δ_c = −r. T = K + B is the matrix of the next solves.
    ///
    /// # Errors
    /// If there is no factor, or the system is singular.
    pub fn few_step(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
        additions: Vec<Entry>,
        r: &[f64],
    ) -> Result<Vec<f64>, SolverError> {
        let changes = self.changes(&additions);
        let condensation = factored(self)?;
        let start = Instant::now();
        let dense = (!changes.is_empty()).then(|| condensation.dense_factor(&changes));
        let factored_in = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let mut step = condensation.dense_solve(r, dense.as_ref());
        step.iter_mut().for_each(|value| *value = -*value);
        if let Some(place) = step.iter().position(|value| !value.is_finite()) {
            let unknown = condensation.unknowns()[place] as usize;
            return Err(LinearAlgebraError::Singular { unknown, ratio: 0.0 }.into());
        }
        self.report.factorisation_seconds += factored_in;
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        self.report.solves += 1;
        self.report.iterations.push(0);
        self.report.path = Some(SolverPath::Condensed);
        let matrix = Sum { base: linear_part.clone(), additions };
        self.current = Some(Current::Condensed { matrix, dense });
        Ok(step)
    }
}
