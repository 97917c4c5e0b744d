//! Pencil with a part on each process: products are added up, and solutions come from the solver of all processes.

use std::cell::{Cell, RefCell};

use super::EigenproblemError;
use crate::assemble::AssemblyError;
use crate::linear_algebra::eigenpairs::{Pencil, amounts_of, check_symmetric, on_one_pattern};
use crate::linear_algebra::spectrum::irregular_from;
use crate::linear_algebra::vector::dot;
use crate::linear_algebra::{CsrMatrix, Positive};
use crate::solve::communicator::{Communicator, agreed_or};
use crate::solve::{LinearSolver, Processes};

/// The seeds of the processes differ by multiples of this.
const OF_A_PROCESS: u64 = 0x9e37_79b9_7f4a_7c15;

/// A x = λ B x on the free unknowns of some processes.
pub(super) struct PencilOfAll<'a> {
    all: &'a dyn Communicator,
    processes: &'a Processes<'a>,
    form: &'static str,
    /// This process's parts of A and B.
    matrices: [CsrMatrix; 2],
    positive: Positive,
    /// The free unknowns among `count`, and whether each is this process's own.
    free: &'a [usize],
    count: usize,
    is_own: Vec<bool>,
    solver: RefCell<&'a mut dyn LinearSolver>,
    /// The shift of the matrix that the solver has.
    shift: Cell<Option<f64>>,
}

/// A − σ B, which the solver takes again when another came in between.
pub(super) struct AtShift {
    shift: f64,
    negative: Option<usize>,
}

impl<'a> PencilOfAll<'a> {
    /// The pencil of all processes' parts.
    ///
    /// # Errors
    /// A matrix that is not symmetric or not finite; a failed exchange.
    pub fn new(
        (all, processes, form): (&'a dyn Communicator, &'a Processes<'a>, &'static str),
        (matrices, positive): ([CsrMatrix; 2], Positive),
        (free, count): (&'a [usize], usize),
        solver: &'a mut dyn LinearSolver,
    ) -> Result<Self, EigenproblemError> {
        let [first, second] = &matrices;
        let fit = check_symmetric("first", first).and_then(|()| check_symmetric("second", second));
        let fit = fit.and_then(|()| Ok(on_one_pattern(first, second)?));
        let failed = |source| EigenproblemError::from(AssemblyError::Communication { form, source });
        let matrices = <[_; 2]>::from(agreed_or(all, fit.map_err(EigenproblemError::Eigen), failed)?);
        let owns = |unknown: &usize| processes.divided().is_none_or(|divided| divided.owns(*unknown));
        let is_own = free.iter().map(owns).collect();
        let (solver, shift) = (RefCell::new(solver), Cell::new(None));
        Ok(PencilOfAll { all, processes, form, matrices, positive, free, count, is_own, solver, shift })
    }

    fn added_up(&self, own: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        Ok(self.processes.added_up_at(self.form, self.free, own, self.count)?)
    }

    fn product(&self, matrix: &CsrMatrix, x: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        self.added_up(&matrix.multiply(x)?)
    }

    /// The sums over all processes of what each has of its own unknowns.
    fn totals(&self, own: Vec<f64>) -> Result<Vec<f64>, EigenproblemError> {
        Ok(self.processes.totals(self.form, Ok(own))?)
    }

    /// A vector without the unknowns of others.
    fn own(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.is_own).map(|(x, is_own)| if *is_own { *x } else { 0.0 }).collect()
    }

    /// Hands the solver A − σ B, unless it has that.
    fn set_shift(&self, shift: f64) -> Result<(), EigenproblemError> {
        if self.shift.get() == Some(shift) {
            return Ok(());
        }
        let mut matrix = self.matrices[0].clone();
        let own = matrix.add_scaled(-shift, &self.matrices[1]).map(|()| matrix);
        let failed =
            |source| EigenproblemError::from(AssemblyError::Communication { form: self.form, source });
        let matrix = agreed_or(self.all, own.map_err(EigenproblemError::LinearAlgebra), failed)?;
        let mut solver = self.solver.borrow_mut();
        let set = solver.set_processes(self.all.size()).and_then(|()| solver.set_matrix(matrix));
        // The next matrix is a whole one, unless its owner says otherwise; a solver that takes none then says so.
        let _ = solver.set_processes(1);
        set.map_err(|why| EigenproblemError::Solver { shift, why })?;
        self.shift.set(Some(shift));
        Ok(())
    }
}

impl Pencil for PencilOfAll<'_> {
    type Factor = AtShift;
    type Error = EigenproblemError;

    fn positive(&self) -> Positive {
        self.positive
    }

    fn size(&self) -> usize {
        self.free.len()
    }

    fn first(&self, x: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        self.product(&self.matrices[0], x)
    }

    fn second(&self, x: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        self.product(&self.matrices[1], x)
    }

    fn amounts(&self, value: f64, x: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        self.added_up(&amounts_of(self.matrices.each_ref(), value, x))
    }

    fn dots(&self, vectors: &[Vec<f64>], y: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        let own = self.own(y);
        self.totals(vectors.iter().map(|vector| dot(vector, &own)).collect())
    }

    fn norms(&self, vectors: [&[f64]; 2]) -> Result<[f64; 2], EigenproblemError> {
        let squares = vectors.map(|vector| dot(vector, &self.own(vector)));
        let sums = self.totals(squares.to_vec())?;
        Ok([sums[0].sqrt(), sums[1].sqrt()])
    }

    fn irregular(&self, seed: u64) -> Result<Vec<f64>, EigenproblemError> {
        let Some(divided) = self.processes.divided() else {
            return Ok(irregular_from(seed, self.free.len()).collect());
        };
        let seed = seed.wrapping_add(OF_A_PROCESS.wrapping_mul(2 * self.all.rank() as u64));
        let mut values = vec![0.0; self.count];
        self.free.iter().zip(irregular_from(seed, self.free.len())).for_each(|(k, value)| values[*k] = value);
        let spread = divided.spread(&mut values);
        spread.map_err(|source| AssemblyError::Communication { form: self.form, source })?;
        Ok(self.free.iter().map(|unknown| values[*unknown]).collect())
    }

    fn factor(&self, shift: f64) -> Result<AtShift, EigenproblemError> {
        self.set_shift(shift)?;
        let negative = self.solver.borrow_mut().negative_eigenvalues();
        Ok(AtShift { shift, negative: negative.map_err(|why| EigenproblemError::Solver { shift, why })? })
    }

    fn solve(&self, factor: &AtShift, b: &[f64]) -> Result<Vec<f64>, EigenproblemError> {
        self.set_shift(factor.shift)?;
        let found = self.solver.borrow_mut().solve(b, 0.0);
        let shift = factor.shift;
        Ok(found.map_err(|why| EigenproblemError::Solver { shift, why })?.solution)
    }

    fn negative(&self, factor: &AtShift) -> Result<usize, EigenproblemError> {
        factor.negative.ok_or(EigenproblemError::NoCount)
    }
}
