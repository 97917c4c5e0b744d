//! Condensed Newton iteration, where the nonlinearity lives on few unknowns: the same iterates as on all unknowns, but
//! between the first and the last one only what the nonlinearity reads and touches is computed.

use std::sync::Arc;

use super::convergence::{Norms, mark};
use super::{Iteration, LineSearch, NewtonFailure, NonlinearProblem, Residuals, Step};
use crate::linear_algebra::vector::{add_scaled, norm};
use crate::linear_algebra::{CsrMatrix, Entry};
use crate::solve::condensed_solver::{CondensedSystem, additions};
use crate::solve::elimination::Elimination;
use crate::solve::linear_solver::{CondensingSolver, LinearSolver, SolverError};

/// The tangent at some u less the linear part, reduced.
pub(super) struct Changes {
    pub additions: Vec<Entry>,
    /// The unknowns that the nonlinearity reads.
    watched: Vec<u32>,
    /// Unknowns at which coming tangents may add.
    pub near: Vec<u32>,
}

/// The entries of the tangent at u, reduced, at the places where it may differ from the linear part.
fn changed_entries(
    problem: &mut dyn NonlinearProblem,
    elimination: &mut Elimination,
    u: &[f64],
) -> Result<Vec<Entry>, NewtonFailure> {
    let tangent = problem.tangent(u)?;
    let places = tangent.changed.unwrap_or_default();
    Ok(elimination.reduce_places(&tangent.matrix, places)?)
}

/// The tangent of the nonlinear part, reduced, where the problem has it by itself.
pub(super) fn nonlinear_changes(
    problem: &mut dyn NonlinearProblem,
    elimination: &Elimination,
    u: &[f64],
) -> Result<Option<Changes>, NewtonFailure> {
    let Some(tangent) = problem.nonlinear_tangent(u)? else {
        return Ok(None);
    };
    let mut places = vec![u32::MAX; elimination.size()];
    elimination.free().iter().enumerate().for_each(|(place, unknown)| places[*unknown] = place as u32);
    let is_free = |place: &u32| *place != u32::MAX;
    let (mut additions, mut near) = (Vec::new(), Vec::new());
    for &row in tangent.rows.iter().filter(|row| is_free(&places[**row])) {
        let first = additions.len();
        for (column, value) in tangent.matrix.row(row).filter(|(_, value)| *value != 0.0) {
            if is_free(&places[column]) {
                additions.push(Entry { row: places[row], column: places[column], value });
            }
        }
        // What is stored beyond is where pairs may come to soon.
        if additions.len() > first {
            near.extend(tangent.matrix.row(row).map(|(column, _)| places[column]).filter(is_free));
        }
    }
    near.sort_unstable();
    near.dedup();
    let watched = tangent.reads.iter().map(|unknown| places[*unknown]).filter(is_free).collect();
    Ok(Some(Changes { additions, watched, near }))
}

/// The tangent at u less the linear part, in either form in which a problem may tell it.
fn changes(
    problem: &mut dyn NonlinearProblem,
    elimination: &mut Elimination,
    linear_part: &CsrMatrix,
    u: &[f64],
) -> Result<Changes, NewtonFailure> {
    if let Some(changes) = nonlinear_changes(problem, elimination, u)? {
        return Ok(changes);
    }
    let entries = changed_entries(problem, elimination, u)?;
    // Marks are quicker than a sorted list: each unknown is met in many entries.
    let mut is_watched = vec![false; linear_part.rows()];
    for unknown in entries.iter().flat_map(|entry| [entry.row, entry.column]) {
        is_watched[unknown as usize] = true;
    }
    let watched = (0..).zip(is_watched).filter_map(|(unknown, is_watched)| is_watched.then_some(unknown));
    let watched = watched.collect();
    let additions = additions(linear_part, &entries)?;
    Ok(Changes { additions, watched, near: vec![] })
}

/// Tells a condensing solver the part that all tangents share, reduced; none where there is no such solver or part.
pub(super) fn share_linear_part(
    problem: &mut dyn NonlinearProblem,
    elimination: &mut Elimination,
    solver: &mut dyn LinearSolver,
) -> Result<Option<Arc<CsrMatrix>>, NewtonFailure> {
    let Some(solver) = solver.as_condensing() else { return Ok(None) };
    // With related unknowns the reduced matrix is no submatrix, and is made again for each tangent.
    if !elimination.only_prescribes() {
        return Ok(None);
    }
    let is_symmetric = problem.has_symmetric_linear_part();
    let Some(matrix) = problem.linear_part()? else { return Ok(None) };
    let reduced = Arc::new(elimination.reduce_matrix(matrix)?);
    // Its rows and columns are the same ones of the whole, which is compared block by block.
    match is_symmetric || matrix.equals_transposed() {
        true => solver.set_symmetric_linear_part(&reduced),
        false => solver.set_linear_part(&reduced),
    }?;
    Ok(Some(reduced))
}

impl Iteration<'_> {
    /// Lets a condensing solver iterate on the unknowns that the nonlinearity touches, as far as that goes. The residuals are
    /// those of the last iterate.
    pub(super) fn condense(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &mut Elimination,
        linear_part: &Arc<CsrMatrix>,
        guess: Option<Vec<f64>>,
        residuals: Residuals,
        solver: &mut dyn LinearSolver,
    ) -> Result<Residuals, NewtonFailure> {
        let Some(solver) = solver.as_condensing() else { return Ok(residuals) };
        // Where positions follow the iterate, a guess tells nothing of them.
        let follows = problem.nonlinear_tangent(&self.u)?.is_some();
        if let Some(guess) = guess.filter(|_| !follows) {
            let entries = changed_entries(problem, elimination, &guess)?;
            solver.expect_changed(linear_part, &entries)?;
        }
        if self.options.line_search != LineSearch::Off
            || !solver.condenses()
            || !self.iterate_condensed(problem, elimination, linear_part, &residuals.full, solver)?
        {
            return Ok(residuals);
        }
        let residuals = Residuals::at(problem, elimination, &self.u)?;
        self.replace_last_residual(elimination, &residuals.reduced);
        Ok(residuals)
    }

    /// Iterates from the first iterate, whose residual is given, as long as it converges and the solver condenses.
    /// Afterwards u is the last iterate of the history on all unknowns. False: nothing was done.
    fn iterate_condensed(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        elimination: &mut Elimination,
        linear_part: &Arc<CsrMatrix>,
        residual: &[f64],
        solver: &mut dyn CondensingSolver,
    ) -> Result<bool, NewtonFailure> {
        let Some(nonlinear) = problem.nonlinear_residual(&self.u)? else {
            return Ok(false);
        };
        let mut nonlinear = elimination.reduce(&nonlinear)?;
        // R(u₀ + x) = K x + N(u₀ + x) − b.
        let mut b = elimination.reduce(residual)?;
        b.iter_mut().zip(&nonlinear).for_each(|(b, n)| *b = n - *b);
        let Changes { additions: mut added, watched, mut near } =
            changes(problem, elimination, linear_part, &self.u)?;
        let start: Vec<f64> = elimination.free().iter().map(|unknown| self.u[*unknown]).collect();
        // The increment since u₀, up to date in the watched unknowns.
        let mut x = vec![0.0; b.len()];
        let mut known: Option<(CondensedSystem, Vec<f64>)> = None;
        loop {
            let touched: Vec<u32> = (0..x.len() as u32).filter(|i| nonlinear[*i as usize] != 0.0).collect();
            let holds = known.as_ref().is_some_and(|(system, _)| solver.covers(system, &added, &touched));
            if !holds {
                // The iterate is completed with the factor that it belongs to.
                if let Some((system, x_c)) = known.take() {
                    self.complete(elimination, &start, &solver.complete(system, &x_c)?)?;
                    let full = elimination.free().iter().map(|unknown| self.u[*unknown]);
                    x = full.zip(&start).map(|(u, start)| u - start).collect();
                }
                near.extend_from_slice(&touched);
                // What may be touched soon is too much where the dense system would cost more than it saves.
                let covered = solver.cover(&added, &near)?
                    || (near.len() > touched.len() && solver.cover(&added, &touched)?);
                if !covered {
                    return Ok(self.history.len() > 1);
                }
                let system = solver.condensed_system(&b, &watched)?;
                let x_c = system.condensed(&x);
                known = Some((system, x_c));
            }
            let Some((system, x_c)) = &mut known else { return Ok(false) };
            let reduced_residual = system.residual(x_c, &nonlinear);
            let step = solver.condensed_step(linear_part, added, &reduced_residual)?;
            add_scaled(x_c, 1.0, &step);
            system.update(x_c, &mut x)?;
            let moved = |i: usize| start[i] + x[i] - self.u[elimination.free()[i]];
            let lengths = self.fields.norms_over(&watched, moved);
            for &i in &watched {
                self.u[elimination.free()[i as usize]] = start[i as usize] + x[i as usize];
            }
            let found = problem.nonlinear_residual(&self.u)?;
            nonlinear = elimination.reduce(&found.unwrap_or_default())?;
            // Rows outside of c hold; N may have got beyond c.
            let mut residual = nonlinear.clone();
            let reduced_residual = system.residual(x_c, &nonlinear);
            let condensed = system.unknowns().iter().zip(&reduced_residual);
            condensed.for_each(|(place, value)| residual[*place as usize] = *value);
            let norms = Norms {
                residual: self.fields.norms(&residual),
                u: self.fields.norms_over(&watched, |i| start[i] + x[i]),
                step: Some(lengths),
                mark: mark(&watched.iter().map(|i| start[*i as usize] + x[*i as usize]).collect::<Vec<_>>()),
            };
            let active = problem.active_points(&self.u)?;
            let condensed_unknowns = Some(x_c.len());
            let step = Step {
                length: norms.step.as_deref().map(norm),
                damping: Some(1.0),
                linear_iterations: Some(0),
                condensed_unknowns,
            };
            self.record(norm(&residual), norms, active, step);
            // What ends the iteration is said of the whole residual.
            let last = !norm(&residual).is_finite()
                || self.has_dropped_to(self.options.relative_tolerance)
                || self.check_progress().is_err();
            if last {
                break;
            }
            Changes { additions: added, near, .. } = changes(problem, elimination, linear_part, &self.u)?;
        }
        if let Some((system, x_c)) = known {
            self.complete(elimination, &start, &solver.complete(system, &x_c)?)?;
        }
        Ok(true)
    }

    /// u = u₀ + x on the free unknowns.
    fn complete(&mut self, elimination: &Elimination, start: &[f64], x: &[f64]) -> Result<(), NewtonFailure> {
        if let Some(unknown) = x.iter().position(|value| !value.is_finite()) {
            let singular = crate::linear_algebra::LinearAlgebraError::Singular { unknown, ratio: 0.0 };
            return Err(NewtonFailure::LinearSolver(SolverError::LinearAlgebra(singular)));
        }
        for ((unknown, start), x) in elimination.free().iter().zip(start).zip(x) {
            self.u[*unknown] = start + x;
        }
        Ok(())
    }
}
