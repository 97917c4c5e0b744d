//! Mass matrices: those of explicit steps, and what a matrix of inertia has to have.

use super::error::StepFailure;
use crate::linear_algebra::{BlockMatrix, CsrMatrix};
use crate::solve::Elimination;

/// The matrix of inertia in steps that solve for the second rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mass {
    /// As the form says.
    #[default]
    Consistent,
    /// The diagonal matrix of its row sums: what quadrature at the nodes gives on elements of degree one. Inertia
    /// is taken to be linear in the second rate, with the densities of the first step.
    Lumped,
}

/// The row sums of a mass matrix.
pub(crate) fn row_sums(matrix: &BlockMatrix) -> Result<Vec<f64>, StepFailure> {
    let masses = matrix.multiply(&vec![1.0; matrix.columns()])?;
    match masses.iter().position(|mass| !(mass.is_finite() && *mass > 0.0)) {
        Some(unknown) => Err(StepFailure::NoMass { unknown, mass: masses[unknown] }),
        None => Ok(masses),
    }
}

/// The diagonal matrix of the free masses.
pub(super) fn diagonal(masses: &[f64], elimination: &Elimination) -> Result<CsrMatrix, StepFailure> {
    if !elimination.only_prescribes() {
        return Err(StepFailure::LumpedRelations);
    }
    let free = elimination.free();
    let entries: Vec<_> =
        free.iter().enumerate().map(|(row, &unknown)| (row, row, masses[unknown])).collect();
    Ok(CsrMatrix::from_triplets(free.len(), free.len(), &entries)?)
}

/// A reduced mass matrix in which every free unknown has inertia.
pub(super) fn with_inertia(matrix: CsrMatrix, elimination: &Elimination) -> Result<CsrMatrix, StepFailure> {
    let rows = matrix.row_pointers().windows(2).map(|ends| &matrix.values()[ends[0]..ends[1]]);
    let empty = rows.zip(elimination.free()).filter(|(row, _)| row.iter().all(|value| *value == 0.0));
    let unknowns: Vec<usize> = empty.map(|(_, unknown)| *unknown).collect();
    match unknowns.is_empty() {
        true => Ok(matrix),
        false => Err(StepFailure::Massless { unknowns }),
    }
}
