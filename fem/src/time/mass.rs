//! Mass matrices: those of explicit steps, and what a matrix of inertia has to have.

use super::error::StepFailure;
use crate::linear_algebra::vector::largest;
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

/// The row sums of a mass matrix, on several processes of a part of it.
pub(crate) fn row_sums(matrix: &BlockMatrix) -> Result<Vec<f64>, StepFailure> {
    Ok(matrix.multiply(&vec![1.0; matrix.columns()])?)
}

/// Lumped masses: row sums of the whole matrix, which are positive.
pub(crate) fn lumped(masses: Vec<f64>) -> Result<Vec<f64>, StepFailure> {
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

/// The largest entry of each row of a matrix, by its size.
pub(super) fn largest_of_rows(matrix: &CsrMatrix) -> Vec<f64> {
    matrix.row_pointers().windows(2).map(|ends| largest(&matrix.values()[ends[0]..ends[1]])).collect()
}

/// The free unknowns without inertia: their rows of the reduced mass matrix have only zeros.
pub(super) fn without_inertia(largest: &[f64], elimination: &Elimination) -> Vec<usize> {
    let empty = largest.iter().zip(elimination.free()).filter(|(largest, _)| **largest == 0.0);
    empty.map(|(_, unknown)| *unknown).collect()
}
