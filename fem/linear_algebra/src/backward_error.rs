//! Residuals judged equation by equation, each relative to the sizes of its own terms (Oettli and Prager 1964; Arioli,
//! Demmel and Duff 1989): a stiff part of a system then does not hide a soft one, nor one field another.

mod together;

use super::equations::{Equations, WorstRow};
use super::error::LinearAlgebraError;
use super::vector::norm;
use crate::threads::Threads;
pub use together::{Rule, refine_each};

/// Refinement goes on as long as an equation is off by more than this part of its terms.
const AIM: f64 = 1e-12;
/// The most by which an equation may be off in a solution that is handed out.
pub const ACCEPTED: f64 = 1e-10;
/// Most rounds in which unknowns of equations that do not hold are made zero.
const ZEROINGS: usize = 4;
/// Most further steps of refinement.
const STEPS: usize = 8;
/// Most sweeps over single equations that do not hold. Each takes what decays one unknown further; 500 unknowns take it to underflow.
const SWEEPS: usize = 4096;
/// Sweeps after which the terms of equations that do not hold have to be smaller by ten.
const PATIENCE: usize = 64;
/// The part of a correction by a single equation: mass matrices of degree two on triangles need one below 0.97.
const DAMPING: f64 = 0.8;

/// Bound on equations off by a part of their own terms, where a residual of the given part of the right-hand side is enough: ten times that
/// part, within limits.
#[doc(hidden)]
pub fn rough(target: f64) -> f64 {
    (10.0 * target).clamp(1e-3, 1e-1)
}

/// b − A x, and the equation that holds worst in it.
#[derive(Clone, Debug, Default)]
pub struct Residual {
    /// b − A x.
    pub rest: Vec<f64>,
    worst: WorstRow,
    room: Vec<f64>,
}

impl Residual {
    /// The residual of x.
    ///
    /// # Errors
    /// Those of [`Equations::residual`].
    pub fn of(
        equations: &impl Equations,
        threads: Threads,
        x: &[f64],
        b: &[f64],
    ) -> Result<Self, LinearAlgebraError> {
        let mut residual = Residual::default();
        residual.compute(equations, threads, x, b)?;
        Ok(residual)
    }

    /// The residual of another x, in the same memory.
    fn compute(
        &mut self,
        equations: &impl Equations,
        threads: Threads,
        x: &[f64],
        b: &[f64],
    ) -> Result<(), LinearAlgebraError> {
        self.worst = equations.residual(threads, x, b, &mut self.rest, &mut self.room)?;
        Ok(())
    }

    /// The equation that holds worst.
    pub fn worst(&self) -> WorstRow {
        self.worst
    }

    /// Check that each equation holds up to a part of its terms. A row whose terms are pure round-off, such as
    /// that of a fluid at rest under a pressure, is scaled by the terms of neighbouring rows.
    ///
    /// # Errors
    /// [`LinearAlgebraError::Inaccurate`] with the equation that is off by more.
    pub fn check(
        &self,
        equations: &impl Equations,
        (x, b): (&[f64], &[f64]),
        level: f64,
    ) -> Result<(), LinearAlgebraError> {
        if self.worst.error <= level {
            return Ok(());
        }
        let sizes = |x: &[f64]| equations.products(x).map(|(_, sizes)| sizes);
        check_residual(&self.rest, (x, b), &equations.diagonal(), sizes, level)
    }
}

/// Check that each equation of A x = b holds up to a part `level` of its terms, where `rest` is b − A x and `sizes` gives
/// Σ_j |a_ij y_j| of each row for a y. For solvers that keep their matrix elsewhere: a norm over all rows says nothing of
/// those with small terms.
///
/// # Errors
/// [`LinearAlgebraError::Inaccurate`] with the row, or an error of `sizes`.
pub fn check_residual<E: From<LinearAlgebraError>>(
    rest: &[f64],
    (x, b): (&[f64], &[f64]),
    diagonal: &[f64],
    sizes: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
    level: f64,
) -> Result<(), E> {
    check_rows(rest, (x, b), || Ok(diagonal.to_vec()), sizes, Ok, level)
}

/// [`check_residual`] of the rows that one of several processes has: `of_all` tells whether what holds on this process holds on all, and all make the same
/// calls.
///
/// # Errors
/// As [`check_residual`], or an error of `of_all`.
#[doc(hidden)]
pub fn check_rows<E: From<LinearAlgebraError>>(
    rest: &[f64],
    (x, b): (&[f64], &[f64]),
    diagonal: impl FnOnce() -> Result<Vec<f64>, E>,
    mut sizes: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
    of_all: impl FnOnce(bool) -> Result<bool, E>,
    level: f64,
) -> Result<(), E> {
    let mut own = sizes(x)?;
    own.iter_mut().zip(b).for_each(|(size, b)| *size += b.abs());
    if of_all(WorstRow::of(rest, &own).error <= level)? {
        return Ok(());
    }
    let amounts: Vec<f64> = diagonal()?
        .iter()
        .zip(own.iter().zip(x))
        .map(|(diagonal, (size, x))| if *diagonal == 0.0 { x.abs() } else { size / diagonal.abs() })
        .collect();
    let mut sizes = sizes(&amounts)?;
    sizes.iter_mut().zip(&own).for_each(|(size, own)| *size += own);
    let WorstRow { row, error } = WorstRow::of(rest, &sizes);
    if error <= level {
        return Ok(());
    }
    Err(LinearAlgebraError::Inaccurate { row, backward_error: error }.into())
}

/// A solution of A x = b that is improved step by step, in memory that all steps share.
pub struct Refinement<'a, E> {
    equations: &'a E,
    threads: Threads,
    b: &'a [f64],
    pub x: Vec<f64>,
    pub residual: Residual,
    /// Solution after the last step.
    candidate: Vec<f64>,
    pub next: Residual,
}

impl<'a, E: Equations> Refinement<'a, E> {
    /// A first solution with its residual.
    ///
    /// # Errors
    /// Those of [`Residual::of`].
    pub fn new(
        equations: &'a E,
        threads: Threads,
        b: &'a [f64],
        x: Vec<f64>,
    ) -> Result<Self, LinearAlgebraError> {
        let residual = Residual::of(equations, threads, &x, b)?;
        Ok(Refinement { equations, threads, b, x, residual, candidate: vec![], next: Residual::default() })
    }

    /// One step of refinement from the residual: `solve` replaces it by A⁻¹ times it. [`Refinement::next`] is the residual that is left.
    ///
    /// # Errors
    /// Those of `solve` and of the residual.
    pub fn step<F: From<LinearAlgebraError>>(
        &mut self,
        solve: impl FnOnce(&mut Vec<f64>) -> Result<(), F>,
    ) -> Result<(), F> {
        self.candidate.clone_from(&self.residual.rest);
        solve(&mut self.candidate)?;
        Ok(self.add_candidate()?)
    }

    /// A step of refinement with a method that solves from zero, and reports.
    ///
    /// # Errors
    /// Those of `further` and of the residual.
    pub fn go_on<R, F: From<LinearAlgebraError>>(
        &mut self,
        further: impl FnOnce(&[f64], &mut [f64]) -> Result<R, F>,
    ) -> Result<R, F> {
        self.candidate.clear();
        self.candidate.resize(self.x.len(), 0.0);
        let report = further(&self.residual.rest, &mut self.candidate)?;
        self.add_candidate()?;
        Ok(report)
    }

    fn add_candidate(&mut self) -> Result<(), LinearAlgebraError> {
        self.candidate.iter_mut().zip(&self.x).for_each(|(change, x)| *change += x);
        self.next.compute(self.equations, self.threads, &self.candidate, self.b)
    }

    /// The solution that the last step leads to.
    pub fn candidate(&self) -> &[f64] {
        &self.candidate
    }

    /// The step, accepted.
    pub fn accept(&mut self) {
        std::mem::swap(&mut self.x, &mut self.candidate);
        std::mem::swap(&mut self.residual, &mut self.next);
    }

    /// Check that each equation holds up to a part of its terms, as [`Residual::check`].
    ///
    /// # Errors
    /// Those of [`Residual::check`].
    pub fn check(&self, level: f64) -> Result<(), LinearAlgebraError> {
        self.residual.check(self.equations, (&self.x, self.b), level)
    }

    /// Whether the solution is good enough for a caller who gains nothing from a residual below `absolute_tolerance`: the residual is, and
    /// no equation is left aside for it ([`rough`]).
    pub fn is_enough(&self, absolute_tolerance: f64) -> bool {
        norm(&self.residual.rest) <= absolute_tolerance
            && self.residual.worst.error <= rough(absolute_tolerance / norm(self.b))
    }

    /// Steps until each equation holds up to 1e-12 of its terms, or no step helps.
    ///
    /// # Errors
    /// [`LinearAlgebraError::Inaccurate`] with the equation that still is off by more than 1e-10, or as the solve.
    pub fn finish<F: From<LinearAlgebraError>>(
        &mut self,
        mut solve: impl FnMut(&mut Vec<f64>) -> Result<(), F>,
    ) -> Result<(), F> {
        for _ in 0..STEPS {
            let error = self.residual.worst.error;
            if error <= AIM {
                return Ok(());
            }
            self.step(&mut solve)?;
            let next_error = self.next.worst.error;
            if next_error >= error {
                break;
            }
            self.accept();
            if next_error > 0.5 * error {
                break;
            }
        }
        match self.check(ACCEPTED) {
            Err(error) if !self.vanishes_where_wrong()? && !self.decays_where_wrong()? => Err(error.into()),
            _ => Ok(()),
        }
    }

    /// Makes those unknowns zero whose equations do not hold, if all equations hold then. Where the solution of some unknowns is
    /// zero, as a multiplier of contact that is open, a solve leaves rounding of the others, which is no solution of
    /// equations that these do not enter. False: the solution is left as it was.
    fn vanishes_where_wrong(&mut self) -> Result<bool, LinearAlgebraError> {
        Ok(self.vanishes(Vanishing::WhereWrong)? || self.vanishes(Vanishing::WhereAsSmall)?)
    }

    /// Solves equations that do not hold by themselves, each for its own unknown, if all equations hold then. A multiplier falls from facet to facet
    /// next to the end of contact, by the inverse of a mass matrix, below the rounding of the whole system, which is then no solution of
    /// the small equations. False: the solution is left as it was.
    fn decays_where_wrong(&mut self) -> Result<bool, LinearAlgebraError> {
        let diagonal = self.equations.diagonal();
        let (mut x, mut rest, mut largest) = (self.x.clone(), vec![], f64::INFINITY);
        for sweep in 0..SWEEPS {
            let (sums, mut sizes) = self.equations.products(&x)?;
            sizes.iter_mut().zip(self.b).for_each(|(size, b)| *size += b.abs());
            rest.clear();
            rest.extend(self.b.iter().zip(&sums).map(|(b, sum)| b - sum));
            if WorstRow::of(&rest, &sizes).error <= ACCEPTED {
                let residual = Residual::of(self.equations, self.threads, &x, self.b)?;
                (self.x, self.residual) = (x, residual);
                return Ok(true);
            }
            let is_wrong = |row: &usize| rest[*row].abs() > ACCEPTED * sizes[*row];
            let wrong: Vec<usize> = (0..x.len()).filter(is_wrong).collect();
            if sweep.is_multiple_of(PATIENCE) {
                let next = wrong.iter().map(|row| sizes[*row]).fold(0.0, f64::max);
                // Without a row of its own that is off, a number is not finite.
                if wrong.is_empty() || !next.is_finite() || next > 0.1 * largest {
                    return Ok(false);
                }
                largest = next;
            }
            for row in wrong {
                if diagonal[row] == 0.0 {
                    return Ok(false);
                }
                // Rounding is far above what decays: a sweep from zero is faster.
                x[row] = if sweep < ZEROINGS { 0.0 } else { x[row] + DAMPING * rest[row] / diagonal[row] };
            }
        }
        Ok(false)
    }

    /// Zeros by one choice of unknowns.
    fn vanishes(&mut self, choice: Vanishing) -> Result<bool, LinearAlgebraError> {
        let mut x = self.x.clone();
        let mut residual = Residual::of(self.equations, self.threads, &x, self.b)?;
        for _ in 0..ZEROINGS {
            let mut sizes = self.equations.products(&x)?.1;
            sizes.iter_mut().zip(self.b).for_each(|(size, b)| *size += b.abs());
            let is_wrong = |row: usize| residual.rest[row].abs() > ACCEPTED * sizes[row];
            let largest = (0..x.len()).filter(|row| is_wrong(*row)).map(|row| sizes[row]).fold(0.0, f64::max);
            let is_chosen = |row: usize| match choice {
                Vanishing::WhereWrong => is_wrong(row),
                Vanishing::WhereAsSmall => sizes[row] <= largest,
            };
            let chosen: Vec<usize> = (0..x.len()).filter(|row| is_chosen(*row) && x[*row] != 0.0).collect();
            if chosen.is_empty() {
                return Ok(false);
            }
            chosen.into_iter().for_each(|unknown| x[unknown] = 0.0);
            residual = Residual::of(self.equations, self.threads, &x, self.b)?;
            if residual.check(self.equations, (&x, self.b), ACCEPTED).is_ok() {
                (self.x, self.residual) = (x, residual);
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// The unknowns that may be zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Vanishing {
    /// Those whose equations do not hold.
    WhereWrong,
    /// Those whose equations have terms no larger than the ones that do not hold: noise that satisfies the equations around it is noise, too.
    WhereAsSmall,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CsrMatrix;
    use crate::Transpose;
    use crate::equations::Side;

    fn matrix() -> CsrMatrix {
        CsrMatrix::from_triplets(2, 2, &[(0, 0, 1e12), (0, 1, -2.0), (1, 0, 3.0), (1, 1, 4.0)]).unwrap()
    }

    #[test]
    fn the_row_that_is_off_is_named_whatever_its_scale() {
        let matrix = matrix();
        let (x, b) = ([1.0, 1.0], [1e12 - 2.0, 8.0]);
        let residual = Residual::of(&Side::plain(&matrix), Threads::ONE, &x, &b).unwrap();
        assert_eq!(residual.rest, [0.0, 1.0]);
        assert_eq!(residual.worst(), WorstRow { row: 1, error: 1.0 / 15.0 });
        let found = residual.check(&Side::plain(&matrix), (&x, &b), 1e-6);
        assert!(matches!(found, Err(LinearAlgebraError::Inaccurate { row: 1, .. })), "{found:?}");
        let side = Side::of(&matrix, Transpose::Yes);
        let transposed = Residual::of(&side, Threads::ONE, &x, &[1e12 + 3.0, 4.0]).unwrap();
        assert_eq!(transposed.rest, [0.0, 2.0]);
        assert_eq!(transposed.worst(), WorstRow { row: 1, error: 0.2 });
        assert_eq!(side.products(&x).unwrap().1, [1e12 + 3.0, 6.0]);
    }

    #[test]
    fn what_is_not_finite_is_the_worst() {
        let found = Residual::of(&Side::plain(&matrix()), Threads::ONE, &[f64::NAN, 0.0], &[0.0; 2]).unwrap();
        assert_eq!(found.worst().error, f64::INFINITY);
    }

    /// [K Bᵀ; B 0] with a load that the multiplier alone carries: u is rounding, and so is every term of B u = 0.
    #[test]
    fn an_equation_of_rounding_is_judged_beside_its_neighbours() {
        let entries = [(0, 0, 2.0), (1, 1, 2.0), (0, 2, 1.0), (2, 0, 1.0), (1, 2, 1.0), (2, 1, 1.0)];
        let matrix = CsrMatrix::from_triplets(3, 3, &entries).unwrap();
        let (x, b) = ([1e-17, 1e-17, 1.0], [1.0, 1.0, 0.0]);
        let residual = Residual::of(&Side::plain(&matrix), Threads::ONE, &x, &b).unwrap();
        assert_eq!(residual.worst(), WorstRow { row: 2, error: 1.0 });
        residual.check(&Side::plain(&matrix), (&x, &b), 1e-15).unwrap();
        // Off by much more than rounding.
        let x = [1e-6, 1e-6, 1.0];
        let residual = Residual::of(&Side::plain(&matrix), Threads::ONE, &x, &b).unwrap();
        assert!(residual.check(&Side::plain(&matrix), (&x, &b), 1e-10).is_err());
    }

    /// [K B; 0 M] whose second unknowns are zero. Refinement has left noise in one of them, and what it makes of the others decays from there
    /// as M's inverse does: their equations hold.
    #[test]
    fn noise_that_satisfies_the_equations_around_it_vanishes() {
        const COUNT: usize = 40;
        let mut entries = vec![(0, 0, 2.0), (0, 1, 1.0)];
        for k in 1..=COUNT {
            entries.push((k, k, 4.0));
            if k > 1 {
                entries.extend([(k, k - 1, 1.0), (k - 1, k, 1.0)]);
            }
        }
        let matrix = CsrMatrix::from_triplets(COUNT + 1, COUNT + 1, &entries).unwrap();
        let side = Side::plain(&matrix);
        let mut b = vec![0.0; COUNT + 1];
        b[0] = 1.0;
        let ratio = 3.0_f64.sqrt() - 2.0;
        let mut x = vec![0.5];
        x.extend((0..COUNT).map(|k| 1e-30 * ratio.powi(k as i32)));
        // A solver without any improvement.
        let nothing = |change: &mut Vec<f64>| -> Result<(), LinearAlgebraError> {
            change.fill(0.0);
            Ok(())
        };
        let mut found = Refinement::new(&side, Threads::ONE, &b, x.clone()).unwrap();
        found.finish(nothing).unwrap();
        assert!(found.x[0] == 0.5 && found.x[1..].iter().all(|x| *x == 0.0), "{:?}", found.x);
        // Where the equation asks for something, however small, that is found in place of noise.
        b[1] = 1e-31;
        let mut found = Refinement::new(&side, Threads::ONE, &b, x).unwrap();
        found.finish(nothing).unwrap();
        for k in 1..COUNT / 2 {
            let exact = 1e-31 / (4.0 + ratio) * ratio.powi(k as i32 - 1);
            assert!((found.x[k] / exact - 1.0).abs() < 1e-8, "{k}: {} {exact}", found.x[k]);
        }
    }

    /// [1 0; c M] whose first unknown is 1: the others fall as M's inverse does, far below the rounding that a solver leaves in all of them.
    #[test]
    fn unknowns_that_decay_below_rounding_are_found() {
        for count in [30, 100, 700] {
            let mut entries = vec![(0, 0, 1.0)];
            for k in 1..=count {
                entries.extend([(k, k, 4.0), (k, k - 1, 1.0)]);
                if k < count {
                    entries.push((k, k + 1, 1.0));
                }
            }
            let matrix = CsrMatrix::from_triplets(count + 1, count + 1, &entries).unwrap();
            let side = Side::plain(&matrix);
            let mut b = vec![0.0; count + 1];
            b[0] = 1.0;
            let ratio = 3.0_f64.sqrt() - 2.0;
            let x = (0..=count).map(|k| ratio.powi(k as i32) + if k > 0 { 1e-18 } else { 0.0 });
            let mut found = Refinement::new(&side, Threads::ONE, &b, x.collect()).unwrap();
            // A solver that leaves the same rounding again.
            let nothing = |change: &mut Vec<f64>| -> Result<(), LinearAlgebraError> {
                change.fill(0.0);
                Ok(())
            };
            found.finish(nothing).unwrap();
            // Without the end, whose reflection is as small as the square of what arrives there.
            for k in (1..count / 2).filter(|k| ratio.abs().powi(*k as i32) > 1e-280) {
                let exact = ratio.powi(k as i32);
                // Each equation holds to 1e-10 of its terms, which are up to 2.2 times the largest one.
                let most = 3e-10 * k as f64;
                assert!((found.x[k] / exact - 1.0).abs() < most, "{count}: {k}: {} {exact}", found.x[k]);
            }
        }
    }
}
