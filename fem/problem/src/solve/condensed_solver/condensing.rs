//! Condensed solver for Newton's method: the shared part of the tangents, and steps on few unknowns.

use std::sync::Arc;
use std::time::Instant;

use super::{
    Condensed, CondensedSolver, CondensedSystem, Current, LinearPart, SYMMETRIC, additions, unknowns_of,
};
use crate::linear_algebra::{CsrMatrix, Entry, LinearAlgebraError};
use crate::solve::linear_solver::{LinearSolver, SolverError};
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
        self.solve_waiting();
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

impl CondensedSolver {
    /// Takes the symmetric part K that the coming matrices share: each is K plus entries on few unknowns.
    pub(in crate::solve) fn set_linear_part(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
    ) -> Result<(), SolverError> {
        self.take_linear_part(linear_part, || linear_part.asymmetry())
    }

    /// The same of a part that is symmetric, except for rounding, as is known from elsewhere.
    pub(in crate::solve) fn set_symmetric_linear_part(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
    ) -> Result<(), SolverError> {
        self.take_linear_part(linear_part, || Ok(0.0))
    }

    /// Takes as the matrix of the next solves the linear part with some of its entries replaced.
    pub(in crate::solve) fn set_changed(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
        entries: &[Entry],
    ) -> Result<(), SolverError> {
        if !self.knows(linear_part) {
            return self.set_matrix(linear_part.with_entries(entries)?);
        }
        self.set_added(linear_part, additions(linear_part, entries)?, &[])
    }

    /// Takes as the matrix of the next solves the linear part plus additions, each to another entry, which the linear part need
    /// not store. Coming matrices are likely to add to rows and columns of the unknowns `near` by.
    pub(in crate::solve) fn set_added(
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

    /// Names the entries of the linear part to which the coming matrices are likely to add, by those of one of them. The guess
    /// may be wrong; it may save a factorisation.
    pub(in crate::solve) fn expect_added(&mut self, additions: &[Entry]) {
        self.expected = unknowns_of(&self.changes(additions));
    }

    /// Names unknowns that coming matrices are likely to change, in addition to those named before.
    pub(in crate::solve) fn expect_touched(&mut self, unknowns: impl Iterator<Item = u32>) {
        self.expected.extend(unknowns);
        self.expected.sort_unstable();
        self.expected.dedup();
    }

    /// Unknowns of the dense system to which solves with the current matrix are condensed; none if they are not.
    pub(in crate::solve) fn condensed_unknowns(&self) -> Option<usize> {
        match &self.current {
            Some(Current::Condensed(_)) => self.report.condensed_unknowns,
            _ => None,
        }
    }

    /// Whether K has a factor, as far as is known.
    pub(in crate::solve) fn condenses(&self) -> bool {
        self.linear_part.is_some() && !self.refused
    }

    /// Whether the rows and columns of B's entries, and some further unknowns, are among those of a condensed system that
    /// the present factor made.
    pub(in crate::solve) fn covers(
        &self,
        system: &CondensedSystem,
        additions: &[Entry],
        further: &[u32],
    ) -> bool {
        self.condensation.as_ref().is_some_and(|condensation| {
            system.belongs_to(condensation)
                && condensation.holds(&unknowns_of(&self.changes(additions)))
                && condensation.holds(further)
        })
    }

    /// Makes a factor of K that allows systems on these unknowns. False: it is not worth it, or K has none.
    pub(in crate::solve) fn cover(
        &mut self,
        additions: &[Entry],
        further: &[u32],
    ) -> Result<bool, SolverError> {
        let mut touched = unknowns_of(&self.changes(additions));
        touched.extend_from_slice(further);
        self.condense_to(&touched)
    }

    /// K x + N(x) = b on the condensed unknowns, where N reads the `watched` unknowns only.
    pub(in crate::solve) fn condensed_system(
        &mut self,
        b: &[f64],
        watched: &[u32],
    ) -> Result<CondensedSystem, SolverError> {
        crate::linear_algebra::error::check_finite("the right-hand side", b)?;
        let start = Instant::now();
        let condensation = self.condensation.as_ref().ok_or(SolverError::NoMatrix)?;
        let system = CondensedSystem::new(condensation, b, watched)?;
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(system)
    }

    /// δ_c with (S + B) δ_c = −r. T = K + B is the matrix of the next solves.
    pub(in crate::solve) fn condensed_step(
        &mut self,
        linear_part: &Arc<CsrMatrix>,
        additions: Vec<Entry>,
        r: &[f64],
    ) -> Result<Vec<f64>, SolverError> {
        let (changes, threads) = (self.changes(&additions), self.fallback.threads());
        let condensation = self.condensation.as_ref().ok_or(SolverError::NoMatrix)?;
        let start = Instant::now();
        let earlier = match self.current.take() {
            Some(Current::Condensed(Condensed { dense, .. })) => dense.and_then(Arc::into_inner),
            _ => None,
        };
        let dense = (!changes.is_empty()).then(|| condensation.dense_factor(threads, &changes, earlier));
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
        let matrix = Arc::new(self.sum(linear_part, additions));
        self.current = Some(Current::Condensed(Condensed { matrix, dense: dense.map(Arc::new) }));
        Ok(step)
    }

    /// x of all unknowns, from those on the condensed ones.
    pub(in crate::solve) fn complete(
        &mut self,
        system: CondensedSystem,
        x_c: &[f64],
    ) -> Result<Vec<f64>, SolverError> {
        let start = Instant::now();
        let x = system.complete(x_c)?;
        self.report.solve_seconds += start.elapsed().as_secs_f64();
        Ok(x)
    }
}
