//! Steps whose equations are affine in the unknown: one matrix and one factor for as long as its weights stay.

use std::sync::Arc;
use std::time::Instant;

use super::error::StepFailure;
use super::mass::{Mass, diagonal, largest_of_rows, lumped, row_sums, without_inertia};
use super::step_cost::StepCost;
use crate::assemble::{Assembler, AssemblyError, BlockPattern, Parts, ValuesBefore};
use crate::contract::Form;
use crate::field::views_on;
use crate::instantiate::instantiate;
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::vector::{add_scaled, largest};
use crate::linear_algebra::{BlockMatrix, CsrMatrix};
use crate::solve::{Elimination, LinearSolver, Processes, SolverError, agreed, groups_of};
use crate::space::Space;

/// The matrix of steps with the same weights, on several processes this one's part; the solver has its reduced form and the factor.
#[derive(Debug)]
pub(super) struct StepMatrix {
    /// Of each unknown.
    weights: Vec<[f64; 3]>,
    free: Vec<usize>,
    matrix: BlockMatrix,
    /// Its lumped masses, where these are solved with.
    lumped: Option<Vec<f64>>,
    /// The rows in which constraints act.
    held: Vec<usize>,
}

/// The solution of a step's equations.
pub(super) struct LinearStep {
    /// The step's unknown.
    pub unknown: Vec<f64>,
    /// The residual there: computed in the rows in which constraints act, and where the equations were looked at, in all of them.
    pub residual: Vec<f64>,
    pub cost: StepCost,
}

/// Who assembles and solves a step.
pub(super) struct Means<'a, const D: usize> {
    /// On several processes of this one's part of the cells.
    pub assembler: &'a Assembler<D>,
    /// The processes that add up what they assemble.
    pub processes: &'a Processes<'a>,
    pub pattern: &'a Arc<BlockPattern<D>>,
    pub solver: &'a mut dyn LinearSolver,
    pub mass: Mass,
}

impl<const D: usize> Means<'_, D> {
    /// Hands the solver a matrix, on several processes this one's part of it.
    fn set_matrix(&mut self, own: CsrMatrix) -> Result<(), SolverError> {
        let Some(communicator) = self.processes.communicator() else { return self.solver.set_matrix(own) };
        self.solver.set_processes(communicator.size())?;
        let set = self.solver.set_matrix(own);
        // The next matrix is a whole one, unless its owner says otherwise; a solver that takes none then says so.
        let _ = self.solver.set_processes(1);
        set
    }
}

/// An equation may be off by these parts of its residual before the solution, and of its terms: far more than rounding leaves, and
/// less than coefficients that change.
const HOLDS: [f64; 2] = [1e-9, 1e-11];

/// Whether a solution is looked at with a residual of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Check {
    /// The equations are assembled at the solution, and the matrix again if they do not hold.
    Equations,
    /// The same, but the matrix has to be the right one.
    Promise,
    /// The matrix is known to be the form's.
    Nothing,
}

/// The unknown that solves an affine form, from a guess that fulfils the constraints.
#[inline(never)]
pub(super) fn solve<const D: usize>(
    (form, weights): (&Form<D>, &[[f64; 3]]),
    (spaces, guess): (&[&Arc<Space<D>>], &[f64]),
    elimination: &mut Elimination,
    kept: &mut Option<StepMatrix>,
    means: &mut Means<'_, D>,
    check: Check,
) -> Result<LinearStep, StepFailure> {
    let mut cost = StepCost::default();
    let (assembler, processes) = (means.assembler, means.processes);
    let residual_at = |values: &[f64], cost: &mut StepCost| {
        let begun = Instant::now();
        let views = views_on(spaces, values);
        let own = assembler.residual_of(form, &views, spaces, Parts::ALL);
        let residual = processes.added_up(form.name(), own);
        cost.residuals += 1;
        cost.residual_seconds += begun.elapsed().as_secs_f64();
        residual
    };
    let before = residual_at(guess, &mut cost)?;
    let load: Vec<f64> = elimination.reduce(&before)?.iter().map(|value| -value).collect();
    let known = kept.take().filter(|kept| kept.weights == weights && kept.free == elimination.free());
    // A relation may have other factors than before without another free unknown.
    let fresh = known.is_none() || !elimination.only_prescribes();
    let mut fresh = processes.any(form.name(), fresh)?;
    let mut matrix = match known {
        Some(known) if !fresh => known,
        _ => StepMatrix::assemble((form, weights), (spaces, guess), elimination, means, &mut cost)?,
    };
    loop {
        let begun = Instant::now();
        let step = elimination.extend_by_zero(&means.solver.solve(&load, 0.0)?.solution)?;
        cost.solves += 1;
        cost.solve_seconds += begun.elapsed().as_secs_f64();
        let mut unknown = guess.to_vec();
        add_scaled(&mut unknown, 1.0, &step);
        if check == Check::Nothing || matrix.lumped.is_some() {
            let residual = matrix.residual_after(&before, &step, form.name(), processes)?;
            *kept = Some(matrix);
            return Ok(LinearStep { unknown, residual, cost });
        }
        let residual = residual_at(&unknown, &mut cost)?;
        let Some(residual_of_row) =
            matrix.wrong_row(&residual, (form, &load), (spaces, &unknown), elimination, processes)?
        else {
            *kept = Some(matrix);
            return Ok(LinearStep { unknown, residual, cost });
        };
        if check == Check::Promise {
            return Err(StepFailure::CoefficientsChanged { residual: residual_of_row });
        }
        if fresh {
            return Err(StepFailure::Inaccurate { residual: residual_of_row });
        }
        matrix = StepMatrix::assemble((form, weights), (spaces, guess), elimination, means, &mut cost)?;
        fresh = true;
    }
}

impl StepMatrix {
    /// Assembles the matrix and hands it to the solver.
    #[inline(never)]
    fn assemble<const D: usize>(
        (form, weights): (&Form<D>, &[[f64; 3]]),
        (spaces, at): (&[&Arc<Space<D>>], &[f64]),
        elimination: &mut Elimination,
        means: &mut Means<'_, D>,
        cost: &mut StepCost,
    ) -> Result<Self, StepFailure> {
        let begun = Instant::now();
        let mut matrix = BlockMatrix::zero(means.pattern.sparsity());
        let views = views_on(spaces, at);
        let arguments = (&views[..], spaces);
        let (assembler, processes, vanish) = (means.assembler, means.processes, ValuesBefore::Vanish);
        let own = assembler.write_tangent(form, arguments, Parts::ALL, means.pattern, &mut matrix, vanish);
        agreed(processes.communicator(), form.name(), own)?;
        let (own, lumped) = match means.mass {
            Mass::Consistent => {
                let own = elimination.reduce_matrix(&matrix)?;
                if weights.iter().all(|weights| weights[..2] == [0.0; 2]) {
                    let largest = largest_of_rows(&own);
                    let (free, size) = (elimination.free(), elimination.size());
                    let largest = processes.added_up_at(form.name(), free, &largest, size)?;
                    let unknowns = without_inertia(&largest, elimination);
                    if processes.any(form.name(), !unknowns.is_empty())? {
                        return Err(StepFailure::Massless { unknowns });
                    }
                }
                (own, None)
            }
            Mass::Lumped => {
                let own = row_sums(&matrix)?;
                let masses = lumped(processes.added_up(form.name(), Ok(own.clone()))?);
                let masses = processes.all_succeed(form.name(), masses)?;
                (diagonal(&own, elimination)?, Some(masses))
            }
        };
        means.solver.set_local_unknowns(groups_of(spaces, elimination));
        means.set_matrix(own)?;
        cost.matrices += 1;
        cost.matrix_seconds += begun.elapsed().as_secs_f64();
        let (free, held) = (elimination.free().to_vec(), elimination.held());
        Ok(StepMatrix { weights: weights.to_vec(), free, matrix, lumped, held })
    }

    /// The residual of the first equation that does not hold, each relative to its own terms with the largest values of the unknowns: a
    /// stiff part hides no soft one.
    fn wrong_row<const D: usize>(
        &self,
        residual: &[f64],
        (form, load): (&Form<D>, &[f64]),
        (spaces, found): (&[&Arc<Space<D>>], &[f64]),
        elimination: &Elimination,
        processes: &Processes<'_>,
    ) -> Result<Option<f64>, StepFailure> {
        let mut amplitudes = vec![];
        for view in views_on(spaces, found) {
            let amplitude = processes.largest(form.name(), largest(view.values))?;
            amplitudes.resize(amplitudes.len() + view.values.len(), amplitude);
        }
        let own = self.matrix.products(&amplitudes)?.1;
        let sizes = elimination.reduce_amounts(&processes.added_up(form.name(), Ok(own))?)?;
        let rows = elimination.reduce(residual)?.into_iter().zip(load).zip(sizes);
        // A residual that is no number does not hold.
        let holds = |residual: f64, load: f64, size: f64| residual <= HOLDS[0] * load + HOLDS[1] * size;
        let mut wrong = rows.filter(|((row, load), size)| !holds(row.abs(), load.abs(), *size));
        let own = wrong.next().map(|((row, _), _)| row);
        if processes.divided().is_none() {
            return Ok(own);
        }
        // A row that is off is not zero.
        let of_all = processes.largest(form.name(), own.map_or(0.0, f64::abs))?;
        Ok(if of_all == 0.0 { None } else { Some(of_all) })
    }

    /// The residual after a step in the rows in which constraints act, by the matrix; the others are solved for.
    fn residual_after(
        &self,
        before: &[f64],
        step: &[f64],
        form: &'static str,
        processes: &Processes<'_>,
    ) -> Result<Vec<f64>, AssemblyError> {
        let held = self.held.iter();
        let forces = match &self.lumped {
            Some(masses) => held.map(|&row| masses[row] * step[row]).collect(),
            None => {
                let product = |row: &usize| {
                    self.matrix.row(*row).map(|(column, value)| value * step[column]).sum::<f64>()
                };
                let own: Vec<f64> = held.map(product).collect();
                processes.added_up_at(form, &self.held, &own, step.len())?
            }
        };
        let mut after = vec![0.0; before.len()];
        for (&row, force) in self.held.iter().zip(forces) {
            after[row] = before[row] + force;
        }
        Ok(after)
    }
}

instantiate!(linear_step: solve::<D>, StepMatrix::assemble::<D>);
