//! The systems of a mass matrix: conjugate gradients, and a factor where they fail.
//!
//! The condition of a mass matrix scaled by its diagonal does not depend on the mesh, only on the element (Wathen 1987: 6.25
//! for biquadratic quadrilaterals): some forty iterations reach rounding, where a factor would have many times the
//! entries of the matrix.

use std::sync::Arc;

use super::loads::Systems;
use super::mass::MassByCells;
use super::pieces::Pieces;
use super::together::{TOLERANCE, hold, together};
use crate::linear_algebra::{
    Analysis, CsrMatrix, Jacobi, KrylovError, KrylovOptions, LinearAlgebraError, LinearOperator, OnThreads,
    Ordering, SymmetricFactor, cg,
};
use crate::threads::Threads;

/// Iterations beyond which a factor is the better way.
const ITERATIONS: usize = 300;

/// The solutions of the systems, without a matrix: all at the same time, and then each by itself as far as an equation does not hold.
pub(super) fn by_cells(
    mass: &MassByCells,
    systems: &mut Systems,
    threads: Threads,
) -> Result<Vec<Vec<f64>>, KrylovError> {
    if let Some(found) = together(mass, systems, threads) {
        if hold(mass, systems, &found, threads) {
            return Ok(found);
        }
        systems.iter_mut().zip(found).for_each(|(system, found)| system.1 = found);
    }
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
    factor.solve_each_in_place(&mut found)?;
    Ok(found)
}

/// Cells that each thread treats in an iteration of all of some systems, for each of them.
pub(in crate::assemble) fn cells_of_parts(pieces: &Pieces, systems: usize, threads: usize) -> Vec<f64> {
    pieces.cells_of_parts(Threads::new(threads)).into_iter().map(|cells| cells * systems as f64).collect()
}

/// Conjugate gradients from the starts.
fn iterated<O: LinearOperator>(
    mass: impl Fn(Threads) -> O + Sync + Send,
    inverse: &Jacobi,
    systems: &Systems,
    threads: Threads,
) -> Result<Vec<Vec<f64>>, KrylovError> {
    // As many right-hand sides at once as there are threads, and the threads that are left for each of them.
    let at_once = threads.count().min(systems.len()).max(1);
    let own = Threads::new(threads.count() / at_once);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::Assembler;
    use crate::element::CellShape;
    use crate::lanes::InstructionSet;
    use crate::linear_algebra::vector::norm;
    use crate::mesh::annulus;
    use crate::norms::mass_matrix;
    use crate::space::Space;

    #[test]
    fn solutions_are_those_by_the_matrix_with_the_same_bits_on_any_number_of_threads() {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            let mesh = annulus(20.0, 30.0, 16, 256, shape, 2).unwrap();
            for space in [Space::scalar(&mesh, 2).unwrap(), Space::discontinuous_scalar(&mesh, 1).unwrap()] {
                let (degree, nodes) = (2 * space.degree() + 3, space.node_count());
                let matrix = mass_matrix(&Assembler::new(&mesh), &space, degree).unwrap();
                // Rough functions, smooth ones, and nothing: more than half as many as there are lanes.
                let functions = [
                    (0..nodes).map(|node| (node as f64 * 0.7).sin()).collect(),
                    space.positions.iter().map(|x| 1e3 * (0.1 * x[0]).exp()).collect(),
                    vec![0.0; nodes],
                    space.positions.iter().map(|x| x[0] * x[1]).collect(),
                    (0..nodes).map(|node| (node % 7) as f64 - 2.5).collect(),
                ];
                let systems: Systems = functions
                    .iter()
                    .map(|f: &Vec<f64>| (matrix.multiply(f).unwrap(), vec![0.0; nodes]))
                    .collect();
                let expected = by_factor(&matrix, systems.clone()).unwrap();
                let pieces = Pieces::new(&space);
                let mass = MassByCells::new(&space, &pieces, degree, InstructionSet::best()).unwrap();
                let found = |threads| {
                    let found = together(&mass, &systems, Threads::new(threads)).unwrap();
                    assert!(hold(&mass, &systems, &found, Threads::ONE));
                    by_cells(&mass, &mut systems.clone(), Threads::new(threads)).unwrap()
                };
                let one = found(1);
                for ((found, expected), exact) in one.iter().zip(&expected).zip(&functions) {
                    let off = |other: &[f64]| -> f64 {
                        norm(&found.iter().zip(other).map(|(a, b)| a - b).collect::<Vec<_>>())
                    };
                    assert!(off(expected) <= 1e-13 * norm(exact), "{shape:?}: {:e}", off(expected));
                    assert!(off(exact) <= 1e-13 * norm(exact), "{shape:?}: {:e}", off(exact));
                }
                let bits =
                    |values: &[Vec<f64>]| values.concat().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                for threads in [2, 3, 7, 16] {
                    assert!(bits(&found(threads)) == bits(&one), "{threads} threads");
                }
            }
        }
    }
}
