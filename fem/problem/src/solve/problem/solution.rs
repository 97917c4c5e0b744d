//! Solution of a problem: of one linear system, or by Newton's method.

use std::borrow::Cow;
use std::time::Instant;

use super::{Problem, SolveError};
use crate::assemble::AssemblyError;
use crate::constraints::Constraints;
use crate::field::Field;
use crate::history::commits;
use crate::instantiate::instantiate;
use crate::solve::communicator::agreed;
use crate::solve::linear_part::{Assembled, System};
use crate::solve::local_unknowns::groups_of;
use crate::solve::{
    Elimination, LinearSolver, LocalUnknowns, NewtonFailure, NewtonStep, Oscillation, Solved, Start,
    StepMemory, newton_bounded,
};

/// The problem's own linear solver, or one that is lent to it.
pub(in crate::solve) enum Solver<'a> {
    Own(Box<LocalUnknowns>),
    Lent(&'a mut dyn LinearSolver),
}

impl Solver<'_> {
    pub(super) fn get(&mut self) -> &mut dyn LinearSolver {
        match self {
            Solver::Own(solver) => &mut **solver,
            Solver::Lent(solver) => &mut **solver,
        }
    }
}

/// Is called with the start and each iterate.
pub(in crate::solve) type EachStep<'a> = Box<dyn FnMut(&NewtonStep) + 'a>;

impl<'a, const D: usize, const N: usize> Problem<'a, D, N> {
    /// Solution of the problem.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let solved = Problem::new(&form, &space).constrained(&held).solve()?;
    /// assert!(solved.field().evaluate(&[1.0, 0.5])?[0] > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SolveError`] with the reason, and of Newton's method the history and the last iterate.
    #[inline(never)]
    pub fn solve(&mut self) -> Result<Solved<D, N>, SolveError> {
        let mut solver = std::mem::replace(&mut self.solver, Solver::Own(Box::default()));
        let solved = self.solve_by(solver.get());
        self.solver = solver;
        solved
    }

    /// The solution by another linear solver than the problem's own.
    pub(super) fn solve_by(&mut self, solver: &mut dyn LinearSolver) -> Result<Solved<D, N>, SolveError> {
        let begun = Instant::now();
        let processes = self.communicator.map_or(1, |communicator| communicator.size());
        let found = match solver.set_processes(processes) {
            Ok(()) => self.find(solver),
            Err(error) => Err(error.into()),
        };
        if processes > 1 {
            // The next matrix is a whole one, unless its problem says otherwise; a solver that takes none then says so.
            let _ = solver.set_processes(1);
        }
        let report = solver.report();
        let (u, residual, history) = found.map_err(|mut error| {
            error.notes.extend(self.notes.iter().cloned());
            error
        })?;
        let seconds = begun.elapsed().as_secs_f64();
        Ok(Solved { history, report, seconds, ..self.solved_at(&u, residual)? })
    }

    /// A solution that was found, without its history.
    ///
    /// # Errors
    /// [`AssemblyError`]: pairs that cannot be found.
    pub(in crate::solve) fn solved_at(
        &self,
        u: &[f64],
        residual: Vec<f64>,
    ) -> Result<Solved<D, N>, AssemblyError> {
        let constraints = self.all_constraints()?.map(Cow::into_owned);
        Ok(Solved {
            at_bounds: self.at_bounds(&self.held, constraints),
            fields: self.system.fields(u),
            history: vec![],
            residual,
            report: None,
            assembly_seconds: self.seconds,
            seconds: 0.0,
            pairs: self.system.pairs(u)?,
            assembler: match self.communicator {
                // Each process has the whole solution.
                Some(_) => self.system.assembler.on_all_cells(),
                None => self.system.assembler.clone().into_owned(),
            },
            remarks: self.notes.clone(),
        })
    }

    /// The solution by a linear solver that takes what the problem assembles.
    fn find(&mut self, solver: &mut dyn LinearSolver) -> Result<Found, SolveError> {
        let shared = self.share_cells().and_then(|()| self.all_constraints());
        let constraints = agreed(self.communicator, self.system.form.name(), shared)?;
        let constraints = constraints.each_ref().map(|one| &**one);
        self.agree_on_problem(&constraints)?;
        let own = Elimination::of(&constraints).map_err(NewtonFailure::Mismatch)?;
        let own = own.on(self.system.assembler.threads());
        let mut elimination = self.divide(own)?;
        solver.set_local_unknowns(groups_of(&self.system.spaces.each_ref(), &elimination));
        if self.system.form.is_affine() && self.bounds.is_empty() && self.positive.is_empty() {
            self.take_memory_of(solver);
            elimination = elimination.with_restriction(self.memory.restriction.take());
            self.repel(&elimination, &vec![0.0; self.system.unknowns()])?;
            let found = self.solve_affine(&mut elimination, solver);
            let found = found.and_then(|found| self.refuse_known(&found.0).map(|()| found));
            self.memory.restriction = elimination.into_restriction();
            self.leave_memory_to(solver);
            return found;
        }
        self.take_memory_of(solver);
        elimination = elimination.with_restriction(self.memory.restriction.take());
        let before = self.state_before_prediction();
        let again = before.map(|_| elimination.again());
        let found = self.iterate(elimination, constraints, self.start, solver);
        match (found, again) {
            // Nothing of the failure is kept but the solver's memory.
            (Err(_), Some(again)) => self.iterate(again, constraints, before, solver),
            (found, _) => found,
        }
    }

    /// Takes what an earlier problem has left to the solver, where this one has no memory of its own.
    pub(super) fn take_memory_of(&mut self, solver: &mut dyn LinearSolver) {
        let Some(left) = solver.memory().map(std::mem::take) else { return };
        self.memory.restriction = self.memory.restriction.take().or(left.restriction);
        if self.assembled.is_none() {
            self.memory.matrix = self.memory.matrix.take().or(left.matrix);
        }
    }

    /// Leaves the matrix and the map to the reduced one to the next problem with this solver.
    pub(super) fn leave_memory_to(&mut self, solver: &mut dyn LinearSolver) {
        if let Some(memory) = solver.memory() {
            let matrix = self.assembled.take().map(|assembled| assembled.matrix);
            *memory = StepMemory { matrix, restriction: self.memory.restriction.take() };
        }
    }

    /// Semismooth Newton from a start, and in a load step the motion followed to what it finds.
    fn iterate(
        &mut self,
        elimination: Elimination,
        constraints: [&Constraints<D>; N],
        start: Option<[&Field<D>; N]>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Found, SolveError> {
        let mut u: Vec<f64> = match start {
            Some(start) => {
                self.check_spaces("start", start.map(|field| field.space()))?;
                start.iter().flat_map(|field| field.values()).copied().collect()
            }
            None => vec![0.0; self.system.unknowns()],
        };
        self.overlap_touching(&elimination, &mut u)?;
        self.repel(&elimination, &u)?;
        let guess = self.extrapolate_prescribed(&u, constraints);
        if let Some(divided) = &self.divided {
            divided.spread(&mut u).map_err(NewtonFailure::Exchange)?;
        }
        let of_names = self.divided.is_some().then(|| elimination.again());
        self.split = None;
        self.switches.begin();
        let bounds = self.all_bounds()?;
        let options = self.options.clone();
        let mut progress = self.progress.take();
        let mut ignored = |_: &NewtonStep| ();
        let told: &mut dyn FnMut(&NewtonStep) = match &mut progress {
            Some(progress) => &mut **progress,
            None => &mut ignored,
        };
        let start = Start { u, guess, expected: self.expected_unknowns()? };
        let found = newton_bounded(self, elimination, bounds.as_ref(), start, solver, &options, told);
        self.progress = progress;
        let found = found.map_err(|mut error| {
            if let NewtonFailure::LinearSolver(source) = error.why {
                let named = match of_names.map_or_else(|| Elimination::of(&constraints), Ok) {
                    Ok(elimination) => self.named(source, &elimination),
                    Err(_) => source,
                };
                error.why = NewtonFailure::LinearSolver(named);
            }
            error.notes = self.lost_pairs(&error.u);
            error.notes.extend(self.bounds_in_words(&error));
            error.oscillation = self.oscillation(&error).map(Box::new);
            error.notes.extend(error.oscillation.as_deref().map(Oscillation::summary));
            error.notes.extend(error.worst.as_deref().and_then(|worst| self.equation_that_is_off(*worst)));
            if matches!(error.why, NewtonFailure::NotFinite) {
                error.notes.extend(self.place_without_a_number(&error.u));
            }
            error
        })?;
        self.held = found.held;
        self.refuse_known(&found.u)?;
        self.follow_from_last_state(&found.u)?;
        Ok((found.u, found.residual, found.history))
    }

    /// The system, with what no iterate changes assembled.
    #[inline(never)]
    pub(in crate::solve) fn ready(&mut self) -> Result<(&System<'a, D, N>, &mut Assembled), AssemblyError> {
        let commits = commits(self.system.form.inputs());
        let assembled = match self.assembled.take() {
            Some(assembled) if assembled.commits == commits => assembled,
            earlier => {
                let start = Instant::now();
                let assembled = self.system.assemble(commits, earlier, self.memory.matrix.take())?;
                self.seconds += start.elapsed().as_secs_f64();
                assembled
            }
        };
        Ok((&self.system, self.assembled.insert(assembled)))
    }
}

/// A nonlinear problem may be solved for further loads with what it has assembled. Its solver gets the memory at the end.
impl<const D: usize, const N: usize> Drop for Problem<'_, D, N> {
    fn drop(&mut self) {
        if let (Solver::Lent(solver), Some(assembled)) = (&mut self.solver, self.assembled.take())
            && let Some(memory) = solver.memory()
            && memory.matrix.is_none()
        {
            memory.matrix = Some(assembled.matrix);
        }
    }
}

/// u, R(u) and the history.
pub(super) type Found = (Vec<f64>, Vec<f64>, Vec<NewtonStep>);

instantiate!(
    solution:
    Problem::<D, 1>::on_spaces,
    Problem::<D, 1>::solve,
    Problem::<D, 1>::ready,
    Problem::<D, 2>::on_spaces,
    Problem::<D, 2>::solve,
    Problem::<D, 2>::ready,
    Problem::<D, 3>::on_spaces,
    Problem::<D, 3>::solve,
    Problem::<D, 3>::ready,
);
