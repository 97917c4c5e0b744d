//! Masks of held unknowns: their rows and columns leave the tangent, whose pattern stays.

use super::ActiveSet;
use crate::linear_algebra::CsrMatrix;
use crate::solve::newton::{FreeEquations, NewtonFailure};

/// Part of a step that leads held unknowns to their bounds.
pub(in crate::solve::newton) struct Lead {
    /// On the free unknowns.
    pub reduced: Vec<f64>,
    /// The forces of it, K d, on the rows that are not held.
    pub forces: Vec<f64>,
}

impl ActiveSet {
    // The held rows leave a residual of the free unknowns.
    pub fn mask(&self, reduced: &mut [f64]) {
        for one in self.unknowns.iter().filter(|one| one.held.is_some()) {
            reduced[one.place] = 0.0;
        }
    }

    // The held rows and columns leave a matrix of the free unknowns. The diagonal keeps its scale, so that solvers see rows of like
    // size.
    pub fn mask_matrix(&self, matrix: &mut CsrMatrix) {
        let mut is_held = vec![false; matrix.rows()];
        for one in self.unknowns.iter().filter(|one| one.held.is_some()) {
            is_held[one.place] = true;
        }
        let pattern = matrix.pattern().clone();
        let (rows, columns) = (pattern.row_pointers(), pattern.column_indices());
        let values = matrix.values_mut();
        for row in 0..is_held.len() {
            for place in rows[row]..rows[row + 1] {
                let column = columns[place] as usize;
                if is_held[row] && row == column {
                    let scale = values[place];
                    values[place] = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
                } else if is_held[row] || is_held[column] {
                    values[place] = 0.0;
                }
            }
        }
    }
}

impl FreeEquations<'_> {
    /// The part of the next step that leads held unknowns to their bounds; none where all are there.
    pub(in crate::solve::newton) fn lead_to_bounds(&mut self) -> Result<Option<Lead>, NewtonFailure> {
        let Some(set) = &self.bounds else { return Ok(None) };
        let mut reduced = vec![0.0; self.elimination.free().len()];
        for one in &set.unknowns {
            if let Some(side) = one.held {
                reduced[one.place] = one.bound(side) - self.iterates.u[one.unknown];
            }
        }
        if reduced.iter().all(|value| *value == 0.0) {
            return Ok(None);
        }
        let full = self.elimination.extend_by_zero(&reduced)?;
        let forces = self.problem.products(&self.iterates.u, &full)?.sums;
        let mut forces = self.elimination.reduce(&forces)?;
        set.mask(&mut forces);
        Ok(Some(Lead { reduced, forces }))
    }
}
