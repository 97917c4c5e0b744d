//! The loop over steps in time.

use std::sync::Arc;
use std::time::Instant;

use super::central_differences::supports_stand;
use super::checkpoint::Checkpoint;
use super::error::{StepError, StepFailure};
use super::linear_step::{Check, LinearStep, Means, StepMatrix, solve};
use super::mass::Mass;
use super::scheme::{Formulas, Scheme, SolvedFor};
use super::step::{State, Step, Taken, known};
use super::step_cost::StepCost;
use crate::assemble::{Assembler, BlockPattern, Outline, Parts};
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::Form;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::solve::{
    Elimination, LentSolver, LinearSolver, NewtonOptions, NewtonStep, OwnedForm, StepMemory, solve_owned,
};

/// A form of motion that is followed step by step, from a state, by a scheme.
///
/// All steps share one matrix pattern and its analysis. Where the form is affine, and in explicit steps, the matrix is assembled and
/// factored again only when the step size changes.
pub struct TimeLoop<'a, const D: usize> {
    form: FormOfStep<'a, D>,
    scheme: Box<dyn Scheme + 'a>,
    assembler: Assembler<D>,
    constraints: ConstraintsAt<'a, D>,
    solver: LentSolver<'a>,
    options: NewtonOptions,
    mass: Mass,
    constant_coefficients: bool,
    /// Newest first.
    states: Vec<State<D>>,
    number: usize,
    /// Whether the newest state has the second rate that belongs to it.
    has_second_rate: bool,
    pattern: Option<Arc<BlockPattern<D>>>,
    memory: StepMemory,
    kept: Option<StepMatrix>,
}

type FormOfStep<'a, const D: usize> = Box<dyn Fn(&Step<D>) -> Form<D> + 'a>;
type ConstraintsAt<'a, const D: usize> = Box<dyn Fn(f64) -> Result<Constraints<D>, ConstraintsError> + 'a>;

/// With coefficients that are promised to be constant, every n steps the equations are assembled at the solution.
const CHECKED_STEPS: usize = 32;

/// Step sizes that differ by less than this part are equal.
const SAME_SIZE: f64 = 1e-9;

impl<'a, const D: usize> TimeLoop<'a, D> {
    /// The form that `form` gives for each step, from a state on. Loads and other data that change are to be those of
    /// [`Step::time`].
    pub fn new<F: Into<Form<D>>>(
        form: impl Fn(&Step<D>) -> F + 'a,
        scheme: impl Scheme + 'a,
        start: State<D>,
    ) -> Self {
        Self::of(Box::new(move |step| form(step).into()), Box::new(scheme), start)
    }

    #[inline(never)]
    fn of(form: FormOfStep<'a, D>, scheme: Box<dyn Scheme + 'a>, start: State<D>) -> Self {
        let space = Arc::clone(start.value.space());
        TimeLoop {
            form,
            scheme,
            assembler: Assembler::new(space.mesh()),
            constraints: Box::new(move |_| Ok(Constraints::new(&space))),
            solver: LentSolver::default(),
            options: NewtonOptions::default(),
            mass: Mass::Consistent,
            constant_coefficients: false,
            states: vec![start],
            number: 0,
            has_second_rate: false,
            pattern: None,
            memory: StepMemory::default(),
            kept: None,
        }
    }

    /// Conditions that do not change.
    pub fn constrained(self, constraints: &Constraints<D>) -> Self {
        let constraints = constraints.clone();
        self.constrained_at(move |_| Ok(constraints.clone()))
    }

    /// Conditions as a function of the time at the end of a step.
    pub fn constrained_at(
        mut self,
        constraints: impl Fn(f64) -> Result<Constraints<D>, ConstraintsError> + 'a,
    ) -> Self {
        self.constraints = Box::new(constraints);
        self
    }

    /// An assembler in place of the default one: for its quadrature, its threads.
    pub fn assembler(mut self, assembler: &Assembler<D>) -> Self {
        self.assembler = assembler.clone();
        self
    }

    /// A linear solver in place of a [`TangentSolver`](crate::solve::TangentSolver).
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = LentSolver::Lent(solver);
        self
    }

    /// Tolerances of Newton's method in each step.
    pub fn options(mut self, options: NewtonOptions) -> Self {
        self.options = options;
        self
    }

    /// The mass matrix of explicit steps, and of the first state's second rate.
    pub fn mass(mut self, mass: Mass) -> Self {
        self.mass = mass;
        self
    }

    /// The promise that an affine form's tangent depends only on the step size. A step is then one residual and one solve.
    /// Without it each step's equations are assembled at their solution too, and the matrix again when they do not hold; with it this
    /// is done at each 32nd step, and is an error.
    pub fn constant_coefficients(mut self) -> Self {
        self.constant_coefficients = true;
        self
    }

    /// States before the first one, newest first, for schemes that read several.
    pub fn with_earlier(mut self, earlier: impl IntoIterator<Item = State<D>>) -> Self {
        self.states.truncate(1);
        self.states.extend(earlier);
        self
    }

    /// The last state.
    pub fn state(&self) -> &State<D> {
        &self.states[0]
    }

    /// The checkpoint with which a run that goes on later begins.
    pub fn checkpoint(&self) -> Checkpoint<D> {
        Checkpoint { states: self.states.clone(), steps: self.number }
    }

    /// The number of steps taken.
    pub fn steps(&self) -> usize {
        self.number
    }

    /// A loop that continues another run of the same form and scheme. Its results are bit-identical to those of an uninterrupted run, as
    /// long as the solver depends on the current matrix alone: one that solves unsymmetric systems with a factor of an earlier
    /// matrix agrees to its tolerance.
    pub fn resumed(mut self, checkpoint: Checkpoint<D>) -> Self {
        if !checkpoint.states.is_empty() {
            (self.states, self.number) = (checkpoint.states, checkpoint.steps);
            self.has_second_rate = self.number > 0;
        }
        self
    }

    /// One step.
    ///
    /// # Errors
    /// [`StepError`]; the last state is then what it was.
    #[inline(never)]
    pub fn take(&mut self, size: f64) -> Result<Taken<D>, StepError> {
        self.take_within(size, self.state().time + size, f64::INFINITY)
    }

    /// Takes one step that ends at a time.
    pub(super) fn take_to(&mut self, end: f64) -> Result<Taken<D>, StepError> {
        self.take_within(end - self.state().time, end, f64::INFINITY)
    }

    /// Is again where it was before.
    pub(super) fn go_back(&mut self, to: Checkpoint<D>) {
        (self.states, self.number) = (to.states, to.steps);
        self.has_second_rate &= self.number > 0;
    }

    /// Takes one step that ends at `end`, the last time and the size up to rounding, if its error is within a tolerance.
    pub(super) fn take_within(&mut self, size: f64, end: f64, tolerance: f64) -> Result<Taken<D>, StepError> {
        let from = self.state().time;
        self.try_step(end, size, tolerance).map_err(|why| StepError { from, to: end, why })
    }

    fn try_step(&mut self, end: f64, size: f64, tolerance: f64) -> Result<Taken<D>, StepFailure> {
        let (begun, from) = (Instant::now(), self.state().time);
        if !(size > 0.0 && end.is_finite() && end > from) {
            return Err(StepFailure::StepSize(size));
        }
        let constraints = (self.constraints)(end)?;
        self.find_second_rate(&constraints)?;
        let mut sizes = vec![size];
        // Equal steps have equal weights, and one matrix, whatever the rounding of times.
        let equal = |earlier: f64| (earlier - size).abs() <= SAME_SIZE * size;
        let earlier = self.states.windows(2).map(|pair| pair[0].time - pair[1].time);
        sizes.extend(earlier.map(|earlier| if equal(earlier) { size } else { earlier }));
        if sizes.iter().any(|size| size.is_nan() || *size <= 0.0) {
            let times = self.states.iter().map(|state| state.time).collect();
            return Err(StepFailure::NotEarlier { times });
        }
        let formulas = self.scheme.formulas(&sizes);
        let read = formulas.states();
        if read > self.states.len() {
            return Err(StepFailure::MissingStates { read, known: self.states.len() });
        }
        let step = Step::new(&self.states, end, &formulas)?;
        let form = (self.form)(&step);
        let (x, residual, history, cost) = match self.scheme.solved_for() {
            SolvedFor::SecondRate => {
                supports_stand(&step.known[0], &constraints)?;
                let (x, residual, cost) =
                    self.solve_affine(&form, step.weights, &constraints.homogeneous())?;
                (x, residual, vec![], Some(cost))
            }
            SolvedFor::Value if form.is_affine() => {
                let (x, residual, cost) = self.solve_affine(&form, step.weights, &constraints)?;
                (x, residual, vec![], Some(cost))
            }
            SolvedFor::Value => {
                let (x, residual, history) = self.solve_nonlinear(form, size, &constraints)?;
                (x, residual, history, None)
            }
        };
        let at_end = |which: usize| self.at_end(&formulas, which, &step, &x);
        let state = State { time: end, value: at_end(0)?, rate: at_end(1)?, second_rate: at_end(2)? };
        let error = self.scheme.error_factor().map(|factor| {
            let ends = [&state, self.state()].map(|state| state.second_rate.values());
            let changes = ends[0].iter().zip(ends[1]).map(|(after, before)| (after - before).abs());
            factor * size * size * changes.fold(0.0, f64::max)
        });
        if let Some(error) = error
            && error > tolerance
        {
            return Err(StepFailure::TooInexact { error, tolerance });
        }
        let space = Arc::clone(x.space());
        self.states.insert(0, state);
        self.states.truncate(self.scheme.states().max(1));
        self.number += 1;
        let cost = cost.map(|cost| StepCost { seconds: begun.elapsed().as_secs_f64(), ..cost });
        Ok(Taken { number: self.number - 1, from, to: end, history, residual, cost, error, space })
    }

    /// Value, rate or second rate at the end of a step, with the step's unknown x.
    fn at_end(
        &self,
        formulas: &Formulas,
        which: usize,
        step: &Step<D>,
        x: &Field<D>,
    ) -> Result<Field<D>, StepFailure> {
        let combination = &formulas.end[which];
        let reads_states = combination.states.iter().flatten().any(|weight| *weight != 0.0);
        if combination.unknown == 1.0 && !reads_states {
            return Ok(x.clone());
        }
        // Where a form is evaluated at the end of the step, its known part is that.
        let known = match *combination == formulas.evaluated[which] {
            true => step.known[which].clone(),
            false => known(combination, &self.states)?,
        };
        Ok(match combination.unknown {
            0.0 => known,
            weight => Field::combination(&[(weight, x), (1.0, &known)])?,
        })
    }

    /// The second rate of the first state, in agreement with the form there.
    fn find_second_rate(&mut self, constraints: &Constraints<D>) -> Result<(), StepFailure> {
        if self.has_second_rate || !self.scheme.reads_second_rates() {
            return Ok(());
        }
        let state = self.state().clone();
        let zero = Field::zero(state.value.space());
        let step = Step {
            end: state.time,
            time: state.time,
            weights: [0.0, 0.0, 1.0],
            known: [state.value.clone(), state.rate.clone(), zero],
            before: state,
        };
        let form = (self.form)(&step);
        let mut conditions = constraints.homogeneous();
        let (second_rate, ..) = match self.solve_affine(&form, step.weights, &conditions) {
            // What has no inertia follows the others, and has no acceleration of its own.
            Err(StepFailure::Massless { unknowns })
                if self.scheme.solved_for() == SolvedFor::Value
                    && self.scheme.formulas(&[1.0]).second_rates_are_for_inertia() =>
            {
                let components = step.known[0].space().components();
                for unknown in unknowns {
                    conditions.fix_node(unknown / components, unknown % components, 0.0)?;
                }
                self.solve_affine(&form, step.weights, &conditions)?
            }
            found => found?,
        };
        self.states[0].second_rate = second_rate;
        self.has_second_rate = true;
        Ok(())
    }

    fn pattern(&mut self, form: &Form<D>) -> Result<Arc<BlockPattern<D>>, StepFailure> {
        if let Some(known) = &self.pattern {
            return Ok(Arc::clone(known));
        }
        let space = self.states[0].value.space();
        let outline = Outline::of(form, Parts::ALL);
        let pattern = Arc::new(BlockPattern::for_cells_of(&outline, &[space], &[space], &self.assembler)?);
        Ok(Arc::clone(self.pattern.insert(pattern)))
    }

    fn solve_affine(
        &mut self,
        form: &Form<D>,
        weights: [f64; 3],
        constraints: &Constraints<D>,
    ) -> Result<(Field<D>, Vec<f64>, StepCost), StepFailure> {
        let pattern = self.pattern(form)?;
        let state = &self.states[0];
        let mut elimination = Elimination::of(&[constraints])?;
        // From zero where masses are lumped: the form's residual knows the consistent ones.
        let of_second_rate = weights[0] == 0.0;
        let mut guess = match of_second_rate {
            true => vec![0.0; state.value.values().len()],
            false => state.value.values().to_vec(),
        };
        elimination.impose(&mut guess)?;
        let guess = Field::from_values(state.value.space(), guess)?;
        let check = match (self.constant_coefficients, self.number % CHECKED_STEPS) {
            (false, _) => Check::Equations,
            (true, 0) => Check::Promise,
            (true, _) => Check::Nothing,
        };
        let mut means = Means {
            assembler: &self.assembler,
            pattern: &pattern,
            solver: self.solver.get(),
            mass: if of_second_rate { self.mass } else { Mass::Consistent },
        };
        let LinearStep { unknown, residual, cost } =
            solve((form, weights), &guess, &mut elimination, &mut self.kept, &mut means, check)?;
        Ok((Field::from_values(guess.space(), unknown)?, residual, cost))
    }

    fn solve_nonlinear(
        &mut self,
        form: Form<D>,
        size: f64,
        constraints: &Constraints<D>,
    ) -> Result<(Field<D>, Vec<f64>, Vec<NewtonStep>), StepFailure> {
        let pattern = self.pattern(&form)?;
        self.kept = None;
        let state = &self.states[0];
        let start = Field::combination(&[(1.0, &state.value), (size, &state.rate)])?;
        let owned = OwnedForm {
            form,
            assembler: &self.assembler,
            pattern: &pattern,
            constraints,
            start: &start,
            options: self.options.clone(),
        };
        let solved = solve_owned(owned, self.solver.get(), &mut self.memory)?;
        let [value] = solved.fields;
        Ok((value, solved.residual, solved.history))
    }
}

instantiate!(time_loop: TimeLoop::<D>::of, TimeLoop::<D>::take);
