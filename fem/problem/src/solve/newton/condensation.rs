//! Newton's method where the nonlinearity touches few unknowns: K is factored once, and most iterates are computed on these
//! unknowns ([`FewUnknowns`]), which is a small nonlinear problem of its own. Iterates on all free unknowns end it.

mod changes;
mod few_unknowns;

use std::sync::Arc;

use self::changes::{Reduced, differences, nonlinear_changes};
use self::few_unknowns::FewUnknowns;
use super::free_equations::FreeEquations;
use super::line_search::check_potential;
use super::{Change, Equations, LineSearch, LinearSolver, NewtonFailure, Verdict, iterate};

/// Enters the start as the first iterate. The linear part on the free unknowns, if a condensing solver has it now.
///
/// # Errors
/// [`NewtonFailure`].
pub(super) fn begin(free: &mut FreeEquations<'_>) -> Result<Option<Reduced>, NewtonFailure> {
    let given = free.impose()?;
    // A problem that can be taken apart computes its residuals by parts from here on.
    // Held rows and columns are taken out of the whole tangent.
    let linear_part = if free.bounds.is_some() { None } else { share_linear_part(free)? };
    free.enter_start(&given)?;
    Ok(linear_part)
}

/// Gives a condensing solver the part that all tangents share, reduced; none where there is no such solver or part.
fn share_linear_part(free: &mut FreeEquations<'_>) -> Result<Option<Reduced>, NewtonFailure> {
    let FreeEquations { problem, elimination, solver, .. } = free;
    let Some(solver) = solver.as_condensed() else { return Ok(None) };
    let Some(problem) = problem.partly_linear() else { return Ok(None) };
    let Some(part) = problem.linear_part()? else { return Ok(None) };
    let reduced = Arc::new(elimination.reduce_matrix(part.matrix)?);
    // Its rows and columns are the same ones of the whole, which is compared block by block.
    match part.is_symmetric || part.matrix.equals_transposed() {
        true => solver.set_symmetric_linear_part(&reduced)?,
        false => solver.set_linear_part(&reduced)?,
    }
    // Adjoint problems with this solver take it from there.
    if let (Some(memory), Some(map)) = (solver.memory(), elimination.known_restriction()) {
        memory.restriction = Some(map);
    }
    let full = (!elimination.only_prescribes()).then(|| part.matrix.clone());
    Ok(Some(Reduced { matrix: reduced, full }))
}

/// Equations on the free unknowns whose tangents share a linear part K. A condensing solver knows it.
pub(super) struct WithLinearPart<'f, 'a> {
    pub free: &'f mut FreeEquations<'a>,
    /// K, reduced.
    pub linear_part: Reduced,
}

impl WithLinearPart<'_, '_> {
    /// Iterates from the first iterate to the solution.
    ///
    /// # Errors
    /// [`NewtonFailure`].
    pub fn iterate_from(mut self, guess: Option<Vec<f64>>, expected: &[usize]) -> Result<(), NewtonFailure> {
        if let Verdict::GoOn = self.judge()? {
            self.iterate_on_few(guess, expected)?;
        }
        iterate(&mut self)
    }

    /// Iterates on the unknowns that the nonlinearity touches, as far as that goes, and completes the last iterate.
    fn iterate_on_few(&mut self, guess: Option<Vec<f64>>, expected: &[usize]) -> Result<(), NewtonFailure> {
        let FreeEquations { problem, elimination, solver, iterates, residuals, .. } = &mut *self.free;
        let (Some(problem), Some(solver)) = (problem.partly_linear(), solver.as_condensed()) else {
            return Ok(());
        };
        // Where positions follow the iterate, a guess tells nothing of them.
        let follows = problem.nonlinear_tangent(&iterates.u)?.is_some();
        if let Some(guess) = guess.filter(|_| !follows) {
            let tangent = problem.tangent(&guess)?;
            let places = tangent.changed.unwrap_or_default();
            let additions = differences(elimination, &self.linear_part, &tangent.matrix, places)?;
            solver.expect_added(&additions);
        }
        if !expected.is_empty() {
            let weights = elimination.weights();
            let reduced = expected.iter().flat_map(|unknown| weights.of(*unknown));
            solver.expect_touched(reduced.map(|(number, _)| *number));
        }
        if iterates.options.line_search != LineSearch::Off || !solver.condenses() {
            return Ok(());
        }
        let mut few =
            FewUnknowns::new(problem, elimination, solver, (&self.linear_part, &residuals.full), iterates)?;
        iterate(&mut few)?;
        few.complete()?;
        if self.free.iterates.history.len() > 1 {
            self.free.residuals = self.free.residuals_at_last()?;
            let FreeEquations { elimination, iterates, residuals, .. } = &mut *self.free;
            iterates.replace_last_residual(elimination, &residuals.reduced);
        }
        Ok(())
    }

    /// Gives the tangent at the last iterate to the solver: what differs from the linear part, or the whole.
    fn set_tangent(&mut self) -> Result<(), NewtonFailure> {
        let FreeEquations { problem, elimination, solver, iterates, .. } = &mut *self.free;
        if let (Some(problem), Some(solver)) = (problem.partly_linear(), solver.as_condensed())
            && solver.condenses()
            && iterates.options.line_search != LineSearch::OnPotential
            && let Some(changes) = nonlinear_changes(problem, elimination, &iterates.u)?
        {
            return Ok(solver.set_added(&self.linear_part.matrix, changes.additions, &changes.near)?);
        }
        let tangent = problem.tangent(&iterates.u)?;
        check_potential(iterates.options.line_search, elimination, &tangent.matrix)?;
        if let (Some(changed), Some(solver)) = (tangent.changed, solver.as_condensed()) {
            if self.linear_part.full.is_some() {
                let additions = differences(elimination, &self.linear_part, &tangent.matrix, changed)?;
                return Ok(solver.set_added(&self.linear_part.matrix, additions, &[])?);
            }
            let entries = elimination.reduce_places(&tangent.matrix, changed)?;
            return Ok(solver.set_changed(&self.linear_part.matrix, &entries)?);
        }
        let reduced = elimination.reduce_matrix(&tangent.matrix)?;
        drop(tangent);
        Ok(solver.set_matrix(reduced)?)
    }
}

impl Equations for WithLinearPart<'_, '_> {
    fn judge(&mut self) -> Result<Verdict, NewtonFailure> {
        self.free.judge()
    }

    fn newton_change(&mut self) -> Result<Change, NewtonFailure> {
        self.set_tangent()?;
        self.free.change_by_solver()
    }

    fn take(&mut self, change: Change) -> Result<(), NewtonFailure> {
        self.free.take(change)
    }
}
