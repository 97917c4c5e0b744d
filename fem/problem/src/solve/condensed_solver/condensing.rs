//! Condensed solver as a [`CondensingSolver`]: the shared part of the tangents, and Newton's steps on few unknowns.

use std::sync::Arc;
use std::time::Instant;

use super::{CondensedSolver, CondensedSystem, Current, LinearPart, SYMMETRIC, additions, unknowns_of};
use crate::linear_algebra::{CsrMatrix, Entry, LinearAlgebraError};
use crate::solve::linear_solver::{CondensingSolver, LinearSolver, SolverError};
use crate::solve::solver_report::SolverPath;

impl CondensedSolver {
    /// Takes another linear part. `asymmetry` measures how far it is from a symmetric one.
    fn take_linear_part(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
        asymmetry: impl FnOnce() -> Result<f64, LinearAlgebraError>,
    ) -> Result<(), SolverError> {
        linear_part.check_finite()?;
        if let Some(known) = &mut self.linear_part
            && *known.matrix == **linear_part
        {
            known.matrix = linear_part.clone();
            return Ok(());
        }
        (self.condensation, self.current, self.refused) = (None, None, false);
        self.expected.clear();
        // An unsymmetric linear part has no Cholesky factor.
        let asymmetry = asymmetry()?;
        self.refused = asymmetry > SYMMETRIC || asymmetry.is_nan();
        let (sizes, is_symmetric) = (linear_part.sizes_of_unknowns(), asymmetry == 0.0);
        self.linear_part = Some(LinearPart { matrix: linear_part.clone(), sizes, is_symmetric });
        Ok(())
    }
}

impl CondensingSolver for CondensedSolver {
    fn set_linear_part(&mut self, linear_part: &Arc<CsrMatrix>) -> Result<(), SolverError> {
        self.take_linear_part(linear_part, || linear_part.asymmetry())
    }

    fn set_symmetric_linear_part(&mut self, linear_part: &Arc<CsrMatrix>) -> Result<(), SolverError> {
        self.take_linear_part(linear_part, || Ok(0.0))
    }

    fn set_changed(&mut self, linear_part: &Arc<CsrMatrix>, entries: &[Entry]) -> Result<(), SolverError> {
        if !self.knows(linear_part) {
            return self.set_matrix(linear_part.with_entries(entries)?);
        }
        self.set_added(linear_part, additions(linear_part, entries)?, &[])
    }

    fn set_added(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
        additions: Vec<Entry>,
        near: &[u32],
    ) -> Result<(), SolverError> {
        if !self.knows(linear_part) {
            return self.set_matrix(linear_part.plus(&additions)?);
        }
        self.current = None;
        self.expected.extend_from_slice(near);
        let condensed = self.condense(&additions.clone(), self.sum(linear_part, additions));
        if !near.is_empty() {
            self.expected.clear();
        }
        condensed
    }

    fn expect_changed(&mut self, linear_part: &Arc<CsrMatrix>, entries: &[Entry]) -> Result<(), SolverError> {
        self.expected = unknowns_of(&self.changes(&additions(linear_part, entries)?));
        Ok(())
    }

    fn condensed_unknowns(&self) -> Option<usize> {
        match &self.current {
            Some(Current::Condensed { .. }) => self.report.condensed_unknowns,
            _ => None,
        }
    }

    fn condenses(&self) -> bool {
        self.linear_part.is_some() && !self.refused
    }

    fn covers(&self, system: &CondensedSystem, additions: &[Entry], further: &[u32]) -> bool {
        self.condensation.as_ref().is_some_and(|condensation| {
            system.belongs_to(condensation)
                && condensation.holds(&unknowns_of(&self.changes(additions)))
                && condensation.holds(further)
        })
    }

    fn cover(&mut self, additions: &[Entry], further: &[u32]) -> Result<bool, SolverError> {
        let mut touched = unknowns_of(&self.changes(additions));
        touched.extend_from_slice(further);
        self.condense_to(&touched)
    }

    fn condensed_system(&mut self, b: &[f64], watched: &[u32]) -> Result<CondensedSystem, SolverError> {
        crate::linear_algebra::error::check_finite("the right-hand side", b)?;
        let start = Instant::now();
        let condensation = self.condensation.as_ref().ok_or(SolverError::NoMatrix)?;
        let system = CondensedSystem::new(condensation, b, watched)?;
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(system)
    }

    fn condensed_step(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
        additions: Vec<Entry>,
        r: &[f64],
    ) -> Result<Vec<f64>, SolverError> {
        let changes = self.changes(&additions);
        let condensation = self.condensation.as_ref().ok_or(SolverError::NoMatrix)?;
        let start = Instant::now();
        let earlier = match self.current.take() {
            Some(Current::Condensed { dense, .. }) => dense,
            _ => None,
        };
        let dense = (!changes.is_empty()).then(|| condensation.dense_factor(&changes, earlier));
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
        let matrix = self.sum(linear_part, additions);
        self.current = Some(Current::Condensed { matrix, dense });
        Ok(step)
    }

    fn complete(&mut self, system: CondensedSystem, x_c: &[f64]) -> Result<Vec<f64>, SolverError> {
        let start = Instant::now();
        let x = system.complete(x_c)?;
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(x)
    }
}
