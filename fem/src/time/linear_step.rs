//! Steps whose equations are affine in the unknown: one matrix and one factor for as long as its weights stay.

use std::sync::Arc;

use super::error::StepFailure;
use super::mass::{Mass, diagonal, row_sums};
use crate::assemble::{Assembler, BlockPattern, Parts};
use crate::compiled_here::compiled_here;
use crate::field::{Field, FieldView};
use crate::linear_algebra::BlockMatrix;
use crate::linear_algebra::equations::Equations;
use crate::linear_algebra::vector::{add_scaled, largest};
use crate::solve::any_form::AnyForm;
use crate::solve::{Elimination, LinearSolver};

/// The matrix of steps with the same weights; the solver has its reduced form and the factor.
#[derive(Debug)]
pub(super) struct StepMatrix {
    weights: [f64; 3],
    free: Vec<usize>,
    matrix: BlockMatrix,
    /// Its lumped masses, where these are solved with.
    lumped: Option<Vec<f64>>,
}

/// Who assembles and solves a step.
pub(super) struct Means<'a, const D: usize> {
    pub assembler: &'a Assembler<D>,
    pub pattern: &'a Arc<BlockPattern<D>>,
    pub solver: &'a mut dyn LinearSolver,
    pub mass: Mass,
}

/// An equation may be off by these parts of its residual before the solution, and of its terms: far more than rounding leaves, and
/// less than coefficients that change.
const HOLDS: [f64; 2] = [1e-9, 1e-11];

/// Whether a solution is looked at with a residual of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Check {
    /// The equations are assembled at the solution, and the matrix anew if they do not hold.
    Equations,
    /// The same, but the matrix has to be the right one.
    Promise,
    /// The matrix is known to be the form's.
    Nothing,
}

/// The unknown that solves an affine form, from a guess that fulfils the constraints, and the residual on all unknowns there.
#[inline(never)]
pub(super) fn solve<const D: usize>(
    (form, weights): (&dyn AnyForm<D>, [f64; 3]),
    guess: &Field<D>,
    elimination: &mut Elimination,
    kept: &mut Option<StepMatrix>,
    means: &mut Means<'_, D>,
    check: Check,
) -> Result<(Vec<f64>, Vec<f64>), StepFailure> {
    let space = guess.space();
    let residual_at = |values: &[f64]| {
        let view = FieldView { space, values, finite: false };
        form.residual(means.assembler, &[view], &[space], Parts::ALL)
    };
    let before = residual_at(guess.values())?;
    let load: Vec<f64> = elimination.reduce(&before)?.iter().map(|value| -value).collect();
    let known = kept.take().filter(|kept| kept.weights == weights && kept.free == elimination.free());
    // A relation may have other factors than before without another free unknown.
    let mut fresh = known.is_none() || !elimination.only_prescribes();
    let mut matrix = match known {
        Some(known) if !fresh => known,
        _ => StepMatrix::assemble((form, weights), guess, elimination, means)?,
    };
    loop {
        let step = elimination.extend_by_zero(&means.solver.solve(&load, 0.0)?.solution)?;
        let mut found = guess.values().to_vec();
        add_scaled(&mut found, 1.0, &step);
        let predicted = matrix.residual_after(&before, &step)?;
        if check == Check::Nothing || matrix.lumped.is_some() {
            *kept = Some(matrix);
            return Ok((found, predicted));
        }
        let residual = residual_at(&found)?;
        let Some(residual_of_row) = matrix.wrong_row(&residual, &load, &found, elimination)? else {
            *kept = Some(matrix);
            return Ok((found, residual));
        };
        if check == Check::Promise {
            return Err(StepFailure::CoefficientsChanged { residual: residual_of_row });
        }
        if fresh {
            return Err(StepFailure::Inaccurate { residual: residual_of_row });
        }
        matrix = StepMatrix::assemble((form, weights), guess, elimination, means)?;
        fresh = true;
    }
}

impl StepMatrix {
    /// Assembles the matrix and hands it to the solver.
    #[inline(never)]
    fn assemble<const D: usize>(
        (form, weights): (&dyn AnyForm<D>, [f64; 3]),
        at: &Field<D>,
        elimination: &mut Elimination,
        means: &mut Means<'_, D>,
    ) -> Result<Self, StepFailure> {
        let mut matrix = BlockMatrix::zero(means.pattern.sparsity());
        let arguments = (&[at.view()][..], &[at.space()][..]);
        form.assemble_tangent(means.assembler, arguments, Parts::ALL, means.pattern, &mut matrix)?;
        let lumped = match means.mass {
            Mass::Consistent => None,
            Mass::Lumped => Some(row_sums(&matrix)?),
        };
        means.solver.set_matrix(match &lumped {
            Some(masses) => diagonal(masses, elimination)?,
            None => elimination.reduce_matrix(&matrix)?,
        })?;
        Ok(StepMatrix { weights, free: elimination.free().to_vec(), matrix, lumped })
    }

    /// The residual of the first equation that does not hold, each beside its own terms with the largest value of the unknown: a
    /// stiff part hides no soft one.
    fn wrong_row(
        &self,
        residual: &[f64],
        load: &[f64],
        found: &[f64],
        elimination: &Elimination,
    ) -> Result<Option<f64>, StepFailure> {
        let amplitudes = vec![largest(found); found.len()];
        let sizes = elimination.reduce_amounts(&self.matrix.products(&amplitudes)?.1)?;
        let rows = elimination.reduce(residual)?.into_iter().zip(load).zip(sizes);
        // A residual that is no number does not hold.
        let holds = |residual: f64, load: f64, size: f64| residual <= HOLDS[0] * load + HOLDS[1] * size;
        let mut wrong = rows.filter(|((row, load), size)| !holds(row.abs(), load.abs(), *size));
        Ok(wrong.next().map(|((row, _), _)| row))
    }

    /// The residual after a step, by the matrix.
    fn residual_after(&self, before: &[f64], step: &[f64]) -> Result<Vec<f64>, StepFailure> {
        let mut after = before.to_vec();
        match &self.lumped {
            Some(masses) => {
                let forces: Vec<f64> = masses.iter().zip(step).map(|(mass, step)| mass * step).collect();
                add_scaled(&mut after, 1.0, &forces);
            }
            None => add_scaled(&mut after, 1.0, &self.matrix.multiply(step)?),
        }
        Ok(after)
    }
}

compiled_here!(solve::<D>, StepMatrix::assemble::<D>);
