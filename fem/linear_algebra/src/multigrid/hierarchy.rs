//! The levels of multigrid, and its V-cycle.

use std::sync::Arc;
use std::time::Instant;

use super::super::analysis::Analysis;
use super::super::block_matrix::BlockMatrix;
use super::super::block_product::{multiply, transpose};
use super::super::cholesky::SymmetricFactor;
use super::super::error::{LinearAlgebraError, check_size};
use super::super::operator::{OperatorError, Preconditioner};
use super::super::ordering::Ordering;
use super::super::task_graph::SharedWork;
use super::super::vector::add_scaled_on;
use super::aggregation::Aggregates;
use super::chebyshev::{Chebyshev, PRODUCTS};
use super::counted::{divided, product, product_with_vector, transposition};
use super::diagonal::BlockDiagonal;
use super::tentative::{smoothed, tentative};
use crate::threads::Threads;

/// Choices of [`Multigrid`].
#[derive(Clone, Debug, PartialEq)]
pub struct MultigridOptions {
    /// Degree of the Chebyshev smoother on levels with given transfers: this number of products before and after the
    /// correction.
    pub degree: usize,
    /// Degree on the other levels.
    pub aggregated_degree: usize,
    /// The smoother damps eigenvalues of D⁻¹A from λ / `range` to λ, the largest.
    pub range: f64,
    /// Couplings with ‖A_ij‖² ≤ threshold² ‖A_ii‖ ‖A_jj‖ do not join nodes to aggregates.
    pub threshold: f64,
    /// Matrices of at most this number of unknowns are solved directly.
    pub direct_size: usize,
    /// Most levels; the last is solved directly whatever its size.
    pub max_levels: usize,
    /// Threads for all stages but the aggregates; the numbers are the same for each number of them.
    pub threads: Threads,
}

impl Default for MultigridOptions {
    fn default() -> Self {
        MultigridOptions {
            degree: 2,
            aggregated_degree: 2,
            range: 10.0,
            threshold: 0.0,
            direct_size: 4000,
            max_levels: 12,
            threads: Threads::all(),
        }
    }
}

/// Kinds of levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelReport {
    /// Unknowns.
    pub unknowns: usize,
    /// Stored numbers of the matrix.
    pub entries: usize,
    /// Estimated largest eigenvalue of D⁻¹ A; none on the last level, which is solved directly.
    pub largest_eigenvalue: Option<f64>,
}

/// A V-cycle as a preconditioner: symmetric and positive definite where the matrix is.
#[derive(Debug)]
pub struct Multigrid {
    levels: Vec<Level>,
    bottom: SymmetricFactor,
    reports: Vec<LevelReport>,
    setup_work: SharedWork,
    cycle_work: SharedWork,
    seconds: f64,
}

#[derive(Debug)]
struct Level {
    matrix: Arc<BlockMatrix>,
    diagonal: BlockDiagonal,
    smoother: Chebyshev,
    prolongation: BlockMatrix,
    restriction: BlockMatrix,
    threads: Threads,
    /// Room for vectors of this level: residual, direction, image; and of the next: right-hand side, correction.
    r: Vec<f64>,
    d: Vec<f64>,
    image: Vec<f64>,
    coarse_b: Vec<f64>,
    coarse_x: Vec<f64>,
}

impl Multigrid {
    /// Levels of a symmetric positive definite matrix over one set of nodes: one per given transfer (a prolongation
    /// from the next coarser level, finest first), then by smoothed aggregation, for which the near-null space is given
    /// as vectors on the last of the given levels: rigid motions for elasticity, the constant for diffusion.
    ///
    /// # Errors
    /// If sizes disagree, or a level's matrix is singular.
    pub fn new(
        matrix: Arc<BlockMatrix>,
        transfers: Vec<BlockMatrix>,
        near_null_space: Vec<Vec<f64>>,
        options: &MultigridOptions,
    ) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        let threads = options.threads;
        let (mut current, mut vectors) = (matrix, near_null_space);
        let (mut levels, mut reports) = (Vec::new(), Vec::new());
        let mut transfers = transfers.into_iter();
        let mut work = SharedWork::alone(0.0);
        loop {
            let given = transfers.next();
            let small = current.rows() <= options.direct_size || levels.len() + 1 >= options.max_levels;
            if given.is_none() && (small || vectors.is_empty()) {
                break;
            }
            let diagonal = BlockDiagonal::new(&current, threads)?;
            let degree = if given.is_some() { options.degree } else { options.aggregated_degree };
            let smoother = Chebyshev::new(&current, &diagonal, degree, options.range, threads)?;
            let size = current.rows();
            work = work.then(&divided(size * current.sparsity().row_sets()[0].components, size));
            let of_matrix = product_with_vector(&current)?;
            work = (0..PRODUCTS).fold(work, |work, _| work.then(&of_matrix));
            let prolongation = match given {
                Some(given) => given,
                None => {
                    let aggregates = Aggregates::new(&current, options.threshold)?;
                    let components = current.sparsity().row_sets()[0].components;
                    let size = aggregates.count * vectors.len();
                    // Nothing is gained where aggregates hardly join nodes.
                    if aggregates.count == 0 || 10 * size > 9 * current.rows() {
                        break;
                    }
                    let (first, coarse) = tentative(&aggregates, components, &vectors)?;
                    let orthogonalised = current.rows() * vectors.len() * vectors.len();
                    work = work.then(&SharedWork::alone((current.values().len() + orthogonalised) as f64));
                    work = work.then(&product(&current, &first)?);
                    vectors = coarse;
                    let omega = 4.0 / 3.0 / smoother.largest_eigenvalue();
                    smoothed(&current, &diagonal, &first, omega, threads)?
                }
            };
            check_size("the set of rows of a prolongation", current.rows(), prolongation.rows())?;
            let restriction = transpose(&prolongation, threads)?;
            let half = multiply(&current, &prolongation, threads)?;
            let mut next = multiply(&restriction, &half, threads)?;
            for stage in [
                transposition(&prolongation)?,
                product(&current, &prolongation)?,
                product(&restriction, &half)?,
            ] {
                work = work.then(&stage);
            }
            drop(half);
            fill_empty_rows(&mut next);
            reports.push(LevelReport {
                unknowns: current.rows(),
                entries: current.values().len(),
                largest_eigenvalue: Some(smoother.largest_eigenvalue()),
            });
            let (size, coarse_size) = (current.rows(), next.rows());
            levels.push(Level {
                matrix: current,
                diagonal,
                smoother,
                prolongation,
                restriction,
                threads,
                r: vec![0.0; size],
                d: vec![0.0; size],
                image: vec![0.0; size],
                coarse_b: vec![0.0; coarse_size],
                coarse_x: vec![0.0; coarse_size],
            });
            current = Arc::new(next);
        }
        let last = current.to_csr();
        reports.push(LevelReport {
            unknowns: last.rows(),
            entries: last.values().len(),
            largest_eigenvalue: None,
        });
        let analysis = Arc::new(Analysis::new(last.pattern(), &Ordering::default())?);
        let bottom = SymmetricFactor::cholesky_on(threads, &analysis, &last, Vec::new())?;
        let setup_work = work.then(&analysis.factorisation_work());
        let cycle_work = work_of_cycle(&levels, &analysis)?;
        let seconds = start.elapsed().as_secs_f64();
        Ok(Multigrid { levels, bottom, reports, setup_work, cycle_work, seconds })
    }

    /// The levels, finest first.
    pub fn levels(&self) -> &[LevelReport] {
        &self.reports
    }

    /// Seconds that the set-up took.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Counted work of the set-up, without the ordering of the last level.
    pub fn setup_work(&self) -> &SharedWork {
        &self.setup_work
    }

    /// Counted work of one cycle.
    pub fn cycle_work(&self) -> &SharedWork {
        &self.cycle_work
    }

    /// Stored numbers of all levels' matrices divided by those of the finest.
    pub fn operator_complexity(&self) -> f64 {
        let all: usize = self.reports.iter().map(|level| level.entries).sum();
        all as f64 / self.reports[0].entries.max(1) as f64
    }
}

/// Counted work of one cycle.
fn work_of_cycle(levels: &[Level], bottom: &Analysis) -> Result<SharedWork, LinearAlgebraError> {
    let solve = bottom.solve_work();
    let mut work = solve.clone().then(&solve);
    for level in levels {
        let (size, components) = (level.matrix.rows(), level.matrix.sparsity().row_sets()[0].components);
        // Per smoothing step a product, one with the inverse diagonal, and two sums.
        let step = product_with_vector(&level.matrix)?.then(&divided(size * (components + 2), size));
        work = (0..2 * level.smoother.degree()).fold(work, |work, _| work.then(&step));
        work = work.then(&product_with_vector(&level.prolongation)?);
        work = work.then(&product_with_vector(&level.restriction)?).then(&divided(2 * size, size));
    }
    Ok(work)
}

/// Puts 1 on the diagonal of rows that are empty: unknowns of a coarser level that represent nothing.
fn fill_empty_rows(matrix: &mut BlockMatrix) {
    let sparsity = matrix.sparsity().clone();
    let (set, pair, values) = (sparsity.row_sets()[0], sparsity.pair(0, 0), matrix.values_mut());
    let size = set.components * set.components;
    for node in 0..set.nodes {
        if let Some(place) = pair.place(node, node as u32) {
            let diagonal = values[place * size..][..size].iter_mut().step_by(set.components + 1);
            diagonal.filter(|value| **value == 0.0).for_each(|value| *value = 1.0);
        }
    }
}

/// x = (V-cycle) b on the first of some levels.
fn cycle(
    levels: &mut [Level],
    bottom: &SymmetricFactor,
    b: &[f64],
    x: &mut [f64],
) -> Result<(), LinearAlgebraError> {
    let Some((level, coarser)) = levels.split_first_mut() else {
        x.copy_from_slice(b);
        return bottom.solve_in_place(x);
    };
    let Level { matrix, diagonal, smoother, prolongation, restriction, threads, .. } = level;
    let (r, d, image) = (&mut level.r, &mut level.d, &mut level.image);
    x.fill(0.0);
    r.copy_from_slice(b);
    smoother.smooth((matrix, diagonal), x, r, (d, image), true)?;
    restriction.multiply_on(*threads, r, &mut level.coarse_b)?;
    cycle(coarser, bottom, &level.coarse_b, &mut level.coarse_x)?;
    prolongation.multiply_on(*threads, &level.coarse_x, d)?;
    add_scaled_on(*threads, x, 1.0, d);
    matrix.multiply_on(*threads, d, image)?;
    add_scaled_on(*threads, r, -1.0, image);
    smoother.smooth((matrix, diagonal), x, r, (d, image), false)
}

impl Preconditioner for Multigrid {
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
        let size = self.reports[0].unknowns;
        check_size("the vector to precondition", size, r.len())?;
        check_size("the preconditioned vector", size, z.len())?;
        Ok(cycle(&mut self.levels, &self.bottom, r, z)?)
    }
}

#[cfg(test)]
mod tests;
