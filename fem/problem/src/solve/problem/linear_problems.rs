//! Linear problems that are solved together: one call of the solver for all right-hand sides.

use std::time::Instant;

use super::affine::{AffineLoad, complete};
use super::solution::Solver;
use super::{Problem, SolveError};
use crate::instantiate::instantiate;
use crate::linear_algebra::vector::add_scaled;
use crate::linear_algebra::{BlockMatrix, Entry, LinearAlgebraError, Transpose};
use crate::solve::linear_system::check_equations;
use crate::solve::local_unknowns::groups_of;
use crate::solve::{
    CondensedSolver, Elimination, LinearSolution, LinearSolver, NewtonFailure, NonlinearProblem, Solved,
    SolverError, StepMemory,
};
use crate::threads::Threads;

/// Linear problems that are solved together, as the adjoint states of several criteria or a structure under several loads. Each is stated as
/// if it were alone.
///
/// Problems that follow each other with equal matrices share one factor, and the solver gets all their right-hand sides in one call
/// ([`LinearSolver::solve_each`]). With a [`CondensedSolver`] that has solved the direct problem, their matrices may differ from each other where
/// contact changes them: all read the factor of the linear part once. A solution has the bits that [`Problem::solve`] finds, whatever
/// the others are. What cannot be shared (nonlinear forms, several processes) is solved by itself, in its place.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [2.0, 1.0], [8, 4], CellShape::Quadrilateral, 2)?;
/// let space = Space::scalar(&mesh, 2)?;
/// let mut held = Constraints::new(&space);
/// held.fix("left", |_| 0.0)?;
/// // Two adjoint states: of the mean of u, and of its mean on the right side.
/// let mean = form!(|p: Unknown<Scalar>, q: Test<Scalar>| integral(cells("all"), dot(grad(p), grad(q)) + q / 2));
/// let end = form!(|p: Unknown<Scalar>, q: Test<Scalar>| {
///     integral(cells("all"), dot(grad(p), grad(q))) + integral(facets("right"), q)
/// });
/// let mut solver = TangentSolver::default();
/// let problems = [&mean, &end].map(|form| Problem::new(form, &space).constrained(&held));
/// let states = LinearProblems::of(problems).solver(&mut solver).solve()?;
/// assert!((states[1].field().evaluate(&[1.5, 0.5])?[0] + 1.5).abs() < 1e-12);
/// assert_eq!((states.len(), solver.report().factorisations), (2, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LinearProblems<'a, 's, const D: usize, const N: usize = 1> {
    problems: Vec<Problem<'a, D, N>>,
    solver: Option<&'s mut dyn LinearSolver>,
}

impl<'a, 's, const D: usize, const N: usize> LinearProblems<'a, 's, D, N> {
    /// Problems in the order in which they are solved. The solver is that of the first one, unless another is given.
    pub fn of(problems: impl IntoIterator<Item = Problem<'a, D, N>>) -> Self {
        LinearProblems { problems: problems.into_iter().collect(), solver: None }
    }

    /// The linear solver, in place of that of the first problem.
    pub fn solver(mut self, solver: &'s mut dyn LinearSolver) -> Self {
        self.solver = Some(solver);
        self
    }

    /// Solutions of the problems, in their order. The seconds of what is done for several are divided among them.
    ///
    /// # Errors
    /// [`SolveError`] of the first problem that is found not to be solved, with a remark that names it.
    pub fn solve(self) -> Result<Vec<Solved<D, N>>, SolveError> {
        let LinearProblems { mut problems, solver } = self;
        match (solver, problems.first_mut()) {
            (Some(solver), _) => solve_by(solver, &mut problems),
            (None, None) => Ok(vec![]),
            (None, Some(first)) => {
                let mut own = std::mem::replace(&mut first.solver, Solver::Own(Box::default()));
                solve_by(own.get(), &mut problems)
            }
        }
    }
}

fn solve_by<const D: usize, const N: usize>(
    solver: &mut dyn LinearSolver,
    problems: &mut [Problem<'_, D, N>],
) -> Result<Vec<Solved<D, N>>, SolveError> {
    let count = problems.len();
    let mut session = Session {
        solver,
        columns: vec![],
        matrix: None,
        spare: StepMemory::default(),
        solved: problems.iter().map(|_| None).collect(),
    };
    let Err(Failed { number, mut error }) = session.run(problems) else {
        return Ok(session.solved.into_iter().flatten().collect());
    };
    if let Some(condensed) = session.solver.as_condensed() {
        condensed.forget_kept();
    }
    if count > 1 {
        let form = problems[number].system.form.name();
        error.notes.push(format!("this is number {} of {count} problems, `{form}`", number + 1));
    }
    Err(*error)
}

/// A failure of the problem with a number.
struct Failed {
    number: usize,
    error: Box<SolveError>,
}

impl Failed {
    fn of(number: usize, error: SolveError) -> Self {
        Failed { number, error: Box::new(error) }
    }
}

/// A problem whose right-hand side waits for others.
struct Column {
    number: usize,
    elimination: Elimination,
    system: AffineLoad,
    /// The rows of prescribed unknowns in the columns of free ones, where the solver keeps the matrix.
    rows: Vec<Entry>,
    /// The residuals of these rows without them.
    held: Vec<(usize, f64)>,
    seconds: f64,
}

/// The state between one problem and the next.
struct Session<'s, const D: usize, const N: usize> {
    solver: &'s mut dyn LinearSolver,
    /// Either with one matrix, or each with its own, which the solver keeps.
    columns: Vec<Column>,
    matrix: Option<BlockMatrix>,
    /// Memory of earlier problems.
    spare: StepMemory,
    solved: Vec<Option<Solved<D, N>>>,
}

impl<const D: usize, const N: usize> Session<'_, D, N> {
    fn run(&mut self, problems: &mut [Problem<'_, D, N>]) -> Result<(), Failed> {
        for number in 0..problems.len() {
            if problems[number].is_one_system() {
                self.add(number, problems)?;
            } else {
                self.flush(problems)?;
                let solved = problems[number].solve_by(self.solver);
                self.solved[number] = Some(solved.map_err(|error| Failed::of(number, error))?);
            }
        }
        self.flush(problems)
    }

    /// Assembles a problem, and leaves its right-hand side with those that wait.
    fn add(&mut self, number: usize, problems: &mut [Problem<'_, D, N>]) -> Result<(), Failed> {
        let begun = Instant::now();
        let failed = |error: SolveError| Failed::of(number, error);
        let elimination = problems[number].own_elimination().map_err(failed)?;
        let keeps = elimination.only_prescribes()
            && self.solver.as_condensed().is_some_and(|condensed| condensed.condenses());
        if keeps == self.matrix.is_some() {
            self.flush(problems)?;
        }
        let problem = &mut problems[number];
        let column = match keeps {
            true => self.keep(problem, number, elimination).map_err(failed)?,
            false => {
                let (column, matrix) = self.assemble(problem, number, elimination).map_err(failed)?;
                let is_same = |first: &Column| {
                    first.elimination.conditions().1 == column.elimination.conditions().1
                        && first.elimination.free() == column.elimination.free()
                };
                if self.matrix.as_ref() == Some(&matrix) && self.columns.first().is_some_and(is_same) {
                    self.spare.matrix = Some(matrix);
                } else {
                    self.flush(problems)?;
                    self.matrix = Some(matrix);
                }
                Some(column)
            }
        };
        if let Some(mut column) = column {
            column.seconds = begun.elapsed().as_secs_f64();
            self.columns.push(column);
        }
        Ok(())
    }

    /// Assembles a problem whose matrix is stored here.
    fn assemble(
        &mut self,
        problem: &mut Problem<'_, D, N>,
        number: usize,
        elimination: Elimination,
    ) -> Result<(Column, BlockMatrix), SolveError> {
        if problem.assembled.is_none() {
            problem.memory.matrix = problem.memory.matrix.take().or_else(|| self.spare.matrix.take());
        }
        let column = problem.column(number, elimination)?;
        problem.tangent(&column.system.lifted)?;
        let assembled = problem.assembled.take().map(|assembled| assembled.matrix);
        let matrix = assembled.ok_or(NewtonFailure::LinearSolver(SolverError::NoMatrix))?;
        Ok((column, matrix))
    }

    /// Assembles a problem whose matrix the solver keeps by its difference from the linear part. None: it is solved already, because it is no
    /// such matrix.
    fn keep(
        &mut self,
        problem: &mut Problem<'_, D, N>,
        number: usize,
        elimination: Elimination,
    ) -> Result<Option<Column>, SolveError> {
        let start = Instant::now();
        self.solver.set_processes(1)?;
        self.solver.set_local_unknowns(groups_of(&problem.system.spaces.each_ref(), &elimination));
        problem.take_memory_of(self.solver);
        let mut column = problem.column(number, elimination)?;
        let mut elimination = column.elimination.again().with_restriction(problem.memory.restriction.take());
        let threads = problem.system.assembler.threads();
        let tangent = problem.tangent(&column.system.lifted)?.matrix;
        let found = self.keep_or_solve(&tangent, &mut column, &mut elimination, threads);
        drop(tangent);
        let found = found.map_err(|error| NewtonFailure::LinearSolver(problem.named(error, &elimination)))?;
        problem.memory.restriction = elimination.into_restriction();
        problem.leave_memory_to(self.solver);
        let Some((found, residual)) = found else { return Ok(Some(column)) };
        let own = start.elapsed().as_secs_f64();
        let solved = problem.solved_column(&column, &found, residual, &*self.solver, own)?;
        self.solved[number] = Some(solved);
        Ok(None)
    }

    /// Gives a matrix to the solver, to be kept with a right-hand side; or the solution with its residual.
    fn keep_or_solve(
        &mut self,
        matrix: &BlockMatrix,
        column: &mut Column,
        elimination: &mut Elimination,
        threads: Threads,
    ) -> Result<Option<(LinearSolution, Vec<f64>)>, SolverError> {
        self.solver.set_reduced(matrix, elimination)?;
        if let Some(condensed) = self.solver.as_condensed()
            && condensed.keep(&column.system.load)?
        {
            column.rows = prescribed_rows(matrix, elimination);
            // The solver tells the others.
            let residual = std::mem::take(&mut column.system.residual);
            column.held = elimination.prescribed().keys().map(|row| (*row, residual[*row])).collect();
            return Ok(None);
        }
        let found = self.solver.solve_with(&column.system.load, 0.0, Transpose::No)?;
        check_equations(matrix, &column.system.load, elimination, self.solver, &found, Transpose::No)?;
        let residual = column.residual_with(matrix, &found, threads)?;
        Ok(Some((found, residual)))
    }

    /// Solves what waits.
    fn flush(&mut self, problems: &mut [Problem<'_, D, N>]) -> Result<(), Failed> {
        let columns = std::mem::take(&mut self.columns);
        let Some(first) = columns.first().map(|first| first.number) else { return Ok(()) };
        let (start, count) = (Instant::now(), columns.len() as f64);
        if let Some(matrix) = self.matrix.take() {
            let found = self.solve_columns(&matrix, &columns, &problems[first]);
            let found = found
                .map_err(|(place, error)| problems[columns[place].number].unsolved(&columns[place], error))?;
            let shared = start.elapsed().as_secs_f64() / count;
            for (column, found) in columns.into_iter().zip(found) {
                let problem = &mut problems[column.number];
                let threads = problem.system.assembler.threads();
                let residual = column.residual_with(&matrix, &found, threads);
                let residual = residual.map_err(|why| problem.unsolved(&column, why.into()))?;
                self.finish(problem, &column, (&found, residual), shared)?;
            }
            self.spare.matrix = Some(matrix);
            return Ok(());
        }
        let kept = self.solver.as_condensed().map(CondensedSolver::take_kept).unwrap_or_default();
        let shared = start.elapsed().as_secs_f64() / count;
        // Solutions and right-hand sides are dropped one by one.
        for (column, kept) in columns.into_iter().zip(kept) {
            let problem = &mut problems[column.number];
            let kept = kept.map_err(|error| problem.unsolved(&column, error))?;
            let residual = column.residual_by_rows(&kept.found, &kept.rest);
            self.finish(problem, &column, (&kept.found, residual), shared)?;
        }
        Ok(())
    }

    /// Notes the solution of a column.
    fn finish(
        &mut self,
        problem: &mut Problem<'_, D, N>,
        column: &Column,
        (found, residual): (&LinearSolution, Vec<f64>),
        shared: f64,
    ) -> Result<(), Failed> {
        let seconds = column.seconds + shared;
        let solved = problem.solved_column(column, found, residual, &*self.solver, seconds);
        self.solved[column.number] = Some(solved.map_err(|error| Failed::of(column.number, error))?);
        Ok(())
    }

    /// Solves with one matrix. A failure has the place of its column.
    fn solve_columns(
        &mut self,
        matrix: &BlockMatrix,
        columns: &[Column],
        first: &Problem<'_, D, N>,
    ) -> Result<Vec<LinearSolution>, (usize, SolverError)> {
        let at_first = |error: SolverError| (0, error);
        let solver = &mut *self.solver;
        solver.set_processes(1).map_err(at_first)?;
        let mut elimination = columns[0].elimination.again().with_restriction(self.spare.restriction.take());
        solver.set_local_unknowns(groups_of(&first.system.spaces.each_ref(), &elimination));
        solver.set_reduced(matrix, &mut elimination).map_err(at_first)?;
        let loads: Vec<&[f64]> = columns.iter().map(|column| &column.system.load[..]).collect();
        let found = solver.solve_each(&loads, 0.0, Transpose::No).map_err(|error| match error {
            SolverError::OfSeveral { number, why, .. } => (number, *why),
            error => (0, error),
        })?;
        for (place, (found, load)) in found.iter().zip(&loads).enumerate() {
            check_equations(matrix, load, &elimination, solver, found, Transpose::No)
                .map_err(|error| (place, error))?;
        }
        self.spare.restriction = elimination.into_restriction();
        Ok(found)
    }
}

impl Column {
    /// The residual of a solution, by the matrix.
    fn residual_with(
        &self,
        matrix: &BlockMatrix,
        found: &LinearSolution,
        threads: Threads,
    ) -> Result<Vec<f64>, LinearAlgebraError> {
        let change = self.elimination.extend_by_zero(&found.solution)?;
        let mut residual = self.system.residual.clone();
        let mut forces = vec![0.0; residual.len()];
        matrix.multiply_on(threads, &change, &mut forces)?;
        add_scaled(&mut residual, 1.0, &forces);
        Ok(residual)
    }

    /// The same by b − A x of the reduced system, and the rows of prescribed unknowns.
    fn residual_by_rows(&self, found: &LinearSolution, rest: &[f64]) -> Vec<f64> {
        let mut residual = vec![0.0; self.elimination.size()];
        self.held.iter().for_each(|(row, value)| residual[*row] = *value);
        let free = self.elimination.free();
        for (unknown, rest) in free.iter().zip(rest) {
            residual[*unknown] = -rest;
        }
        for Entry { row, column, value } in &self.rows {
            residual[*row as usize] += value * found.solution[*column as usize];
        }
        residual
    }
}

/// The rows of prescribed unknowns, with the numbers of free ones as columns.
fn prescribed_rows(matrix: &BlockMatrix, elimination: &Elimination) -> Vec<Entry> {
    let free = elimination.free();
    let mut entries = vec![];
    for row in elimination.prescribed().keys() {
        for (column, value) in matrix.row(*row) {
            if let Ok(column) = free.binary_search(&column) {
                entries.push(Entry { row: *row as u32, column: column as u32, value });
            }
        }
    }
    entries
}

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// Whether the problem is one linear system on one process.
    fn is_one_system(&self) -> bool {
        let is_plain = self.bounds.is_empty() && self.positive.is_empty() && self.deflation.is_none();
        self.system.form.is_affine() && self.communicator.is_none() && is_plain
    }

    fn own_elimination(&self) -> Result<Elimination, SolveError> {
        let constraints = self.all_constraints()?;
        let own = Elimination::of(&constraints.each_ref().map(|one| &**one));
        Ok(own.map_err(NewtonFailure::Mismatch)?.on(self.system.assembler.threads()))
    }

    /// The problem's right-hand side.
    fn column(&mut self, number: usize, elimination: Elimination) -> Result<Column, SolveError> {
        let system = self.affine_load(&elimination)?;
        Ok(Column { number, elimination, system, rows: vec![], held: vec![], seconds: 0.0 })
    }

    /// A failure of the linear solver in the problem's own terms.
    fn unsolved(&self, column: &Column, error: SolverError) -> Failed {
        Failed::of(column.number, NewtonFailure::LinearSolver(self.named(error, &column.elimination)).into())
    }

    fn solved_column(
        &mut self,
        column: &Column,
        found: &LinearSolution,
        residual: Vec<f64>,
        solver: &dyn LinearSolver,
        seconds: f64,
    ) -> Result<Solved<D, N>, SolveError> {
        let mut u = column.system.lifted.clone();
        complete(&column.elimination, found, &mut u)?;
        let history = self.affine_history(&column.elimination, &column.system.load, found, &residual)?;
        Ok(Solved { history, report: solver.report(), seconds, ..self.solved_at(&u, residual)? })
    }
}

instantiate!(
    linear_problems:
    LinearProblems::<D, 1>::solve,
    LinearProblems::<D, 2>::solve,
    LinearProblems::<D, 3>::solve,
);
