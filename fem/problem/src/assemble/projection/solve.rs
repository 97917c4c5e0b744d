//! The systems of a mass matrix: conjugate gradients, and a factor where they fail.
//!
//! The condition of a mass matrix scaled by its diagonal does not depend on the mesh, only on the element (Wathen 1987: 6.25
//! for biquadratic quadrilaterals): some forty iterations reach rounding, where a factor would have many times the
//! entries of the matrix.

use std::sync::Arc;

use super::loads::Systems;
use super::mass::MassByCells;
use super::pieces::Pieces;
use crate::linear_algebra::{
    Analysis, CsrMatrix, Jacobi, KrylovError, KrylovOptions, LinearAlgebraError, LinearOperator, OnThreads,
    Ordering, SymmetricFactor, cg,
};
use crate::threads::Threads;

/// Relative residual at which the coefficients of a projection are as good as rounding lets them be.
const TOLERANCE: f64 = 1e-14;
/// Iterations beyond which a factor is the better way.
const ITERATIONS: usize = 300;

/// The solutions of the systems, without a matrix.
pub(super) fn by_cells(
    mass: &MassByCells,
    systems: &Systems,
    threads: Threads,
) -> Result<Vec<Vec<f64>>, KrylovError> {
    iterated(|threads| mass.on(threads), &Jacobi::of_diagonal(mass.diagonal())?, systems, threads)
}

/// The solutions of the systems of a matrix.
pub(super) fn by_matrix(
    mass: &CsrMatrix,
    systems: Systems,
    threads: Threads,
) -> Result<Vec<Vec<f64>>, LinearAlgebraError> {
    match iterated(|threads| OnThreads(mass, threads), &Jacobi::of(mass)?, &systems, threads) {
        Ok(found) => Ok(found),
        // Cells that are all but flat: the factor says what is wrong, or solves the systems.
        Err(_) => by_factor(mass, systems),
    }
}

/// The solutions of the systems of a matrix, by its factor.
pub(super) fn by_factor(mass: &CsrMatrix, systems: Systems) -> Result<Vec<Vec<f64>>, LinearAlgebraError> {
    let analysis = Arc::new(Analysis::new(mass.pattern(), &Ordering::default())?);
    let factor = SymmetricFactor::cholesky(&analysis, mass, Vec::new())?;
    let mut found: Vec<Vec<f64>> = systems.into_iter().map(|(load, _)| load).collect();
    found.iter_mut().try_for_each(|load| factor.solve_in_place(load))?;
    Ok(found)
}

/// Right-hand sides that are solved at once, as many as there are threads, and the threads that are left for each of them.
fn at_once(systems: usize, threads: Threads) -> (usize, Threads) {
    let at_once = threads.count().min(systems).max(1);
    (at_once, Threads::new(threads.count() / at_once))
}

/// Cells that each thread treats in an iteration of all of some systems.
pub(in crate::assemble) fn cells_of_parts(pieces: &Pieces, systems: usize, threads: usize) -> Vec<f64> {
    let (at_once, own) = at_once(systems, Threads::new(threads));
    let one = pieces.cells_of_parts(own);
    let rounds = systems.div_ceil(at_once);
    // In the last round some threads may have nothing to do.
    let of_place =
        |place: usize| (0..rounds).filter(|round| round * at_once + place < systems).count() as f64;
    (0..at_once).flat_map(|place| one.iter().map(move |cells| cells * of_place(place))).collect()
}

/// Conjugate gradients from the starts.
fn iterated<O: LinearOperator>(
    mass: impl Fn(Threads) -> O + Sync + Send,
    inverse: &Jacobi,
    systems: &Systems,
    threads: Threads,
) -> Result<Vec<Vec<f64>>, KrylovError> {
    let (at_once, own) = at_once(systems.len(), threads);
    let options = KrylovOptions {
        tolerance: TOLERANCE,
        max_iterations: ITERATIONS,
        threads: own,
        ..Default::default()
    };
    let one = |(load, start): &(Vec<f64>, Vec<f64>)| -> Result<Vec<f64>, KrylovError> {
        let mut values = start.clone();
        cg(&mass(own), &mut { inverse }, load, &mut values, &options)?;
        Ok(values)
    };
    let mut found = Vec::with_capacity(systems.len());
    for some in systems.chunks(at_once) {
        found.extend(threads.run(some.iter().collect(), one));
    }
    found.into_iter().collect()
}
