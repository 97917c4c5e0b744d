//! The loop over steps in time.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use super::central_differences::supports_stand;
use super::checkpoint::Checkpoint;
use super::conditions::{Conditions, hold};
use super::error::{StepError, StepFailure};
use super::linear_step::{Check, LinearStep, Means, StepMatrix, solve};
use super::mass::Mass;
use super::scheme::{Formulas, Scheme, SolvedFor, agreed_unknown};
use super::step::{State, Step, Taken, known};
use super::step_cost::StepCost;
use crate::assemble::{Assembler, BlockPattern, Outline, Parts};
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::Form;
use crate::field::{Field, fields_on};
use crate::instantiate::instantiate;
use crate::solve::communicator::Fingerprint;
use crate::solve::{
    Communicator, Elimination, GivenEquations, LentSolver, LinearSolver, NewtonOptions, OwnedForm, Processes,
    SolvedForm, StepMemory, agreed, solve_owned,
};

/// A form of motion that is followed step by step, from a state, by a scheme. Forms of up to four unknowns are
/// [coupled](TimeLoop::coupled).
///
/// All steps share one matrix pattern and its analysis. Where the form is affine, and in explicit steps, the matrix is assembled and
/// factored again only when the step size changes.
pub struct TimeLoop<'a, const D: usize> {
    form: FormOfStep<'a, D>,
    /// Of each unknown.
    schemes: Vec<Rc<dyn Scheme + 'a>>,
    assembler: Assembler<D>,
    /// An unknown that was given a scheme and does not exist.
    no_unknown: Option<usize>,
    constraints: Conditions<'a, f64, D>,
    solver: LentSolver<'a>,
    /// The processes that take each step together, if there are several.
    communicator: Option<&'a dyn Communicator>,
    /// The same with the division of vectors, once it is known.
    processes: Option<Processes<'a>>,
    options: NewtonOptions,
    mass: Mass,
    constant_coefficients: bool,
    /// Newest first, each with the states of all unknowns.
    states: Vec<Vec<State<D>>>,
    number: usize,
    /// Whether the newest states have the second rates that belong to them.
    has_second_rate: bool,
    pattern: Option<Arc<BlockPattern<D>>>,
    memory: StepMemory,
    kept: Option<StepMatrix>,
}

/// The unknowns of affine equations, their residual, and the cost.
type AffineStep<const D: usize> = (Vec<Field<D>>, Vec<f64>, StepCost);

type FormOfStep<'a, const D: usize> = Box<dyn Fn(&[Step<D>]) -> Form<D> + 'a>;

/// With coefficients that are promised to be constant, every n steps the equations are assembled at the solution.
const CHECKED_STEPS: usize = 32;

/// Name of a motion in errors of exchanges before its form is known.
const MOTION: &str = "a motion";

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
        Self::coupled(move |[step]| form(step), scheme, [start])
    }

    /// A form of N unknowns, each from a state of its own, by one scheme. The form gets a step for each unknown, in the order of its
    /// arguments; all steps have the same times. [`vector_and_scalar`](super::operators::vector_and_scalar) are the operators of a vector
    /// and a scalar unknown.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # use forms_fem::time::{OneStepTheta, State, Step, TimeLoop};
    /// // Squeezing water out of a porous body (Biot): displacement u and pressure p of the water.
    /// #[forms(dimension = 2)]
    /// mod porous {
    ///     use forms_fem::time::operators::vector::{displacement, velocity};
    ///     use forms_fem::time::operators::vector_and_scalar::value;
    ///
    ///     #[includes(forms_fem::time::operators::vector_and_scalar::Data)]
    ///     pub struct Data {
    ///         pub mu: Param,
    ///         pub permeability: Param,
    ///     }
    ///     #[cells]
    ///     pub struct Omega;
    ///     #[facets]
    ///     pub struct Top;
    ///
    ///     pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
    ///         integral(Omega, 2 * mu * inner(eps(displacement(u)), eps(v)) - value(p) * div(v))
    ///             + integral(Omega, div(velocity(u)) * q + permeability * dot(grad(value(p)), grad(q)))
    ///             + integral(Top, dot(n, v))
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let mesh = rectangle([0.0; 2], [0.1, 1.0], [1, 10], CellShape::Quadrilateral, 2)?;
    /// let (displacements, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
    /// let mut held = Constraints::new(&displacements);
    /// held.fix("bottom", |_| [0.0; 2])?;
    /// held.fix_component("left", 0, |_| 0.0)?;
    /// held.fix_component("right", 0, |_| 0.0)?;
    /// let mut drained = Constraints::new(&pressures);
    /// drained.fix("top", |_| 0.0)?;
    ///
    /// let form = |steps: &[Step<2>; 2]| porous::Model::new(porous::data_from(steps).mu(1.0).permeability(1.0)).balance();
    /// let start = [&displacements, &pressures].map(|space| State::at_rest(0.0, Field::zero(space)));
    /// let mut squeezed =
    ///     TimeLoop::coupled(form, OneStepTheta::implicit_euler(), start).constrained(&held).constrained(&drained);
    /// for _ in 0..10 {
    ///     squeezed.take(0.01)?;
    /// }
    /// let [u, p] = squeezed.states() else { unreachable!("two unknowns") };
    /// println!("{:?} {:?}", u.value.evaluate(&[0.05, 1.0])?, p.value.evaluate(&[0.05, 0.0])?);
    /// # Ok(())
    /// # }
    /// ```
    pub fn coupled<F: Into<Form<D>>, const N: usize>(
        form: impl Fn(&[Step<D>; N]) -> F + 'a,
        scheme: impl Scheme + 'a,
        start: [State<D>; N],
    ) -> Self {
        const { assert!(N > 0, "a motion has an unknown") };
        let form: FormOfStep<'a, D> = Box::new(move |steps| match steps.first_chunk() {
            Some(steps) => form(steps).into(),
            None => unreachable!("there are as many steps as states"),
        });
        Self::of(form, Rc::new(scheme), start.into())
    }

    #[inline(never)]
    fn of(form: FormOfStep<'a, D>, scheme: Rc<dyn Scheme + 'a>, start: Vec<State<D>>) -> Self {
        TimeLoop {
            form,
            schemes: vec![scheme; start.len()],
            no_unknown: None,
            assembler: Assembler::new(start[0].value.space().mesh()),
            constraints: Conditions::none(),
            solver: LentSolver::default(),
            communicator: None,
            processes: None,
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

    /// The scheme of one unknown, by its number, in place of the common one. All schemes have to give loads at the same time of a step and to solve for the same:
    /// a step that does not agree is an error.
    pub fn scheme_of(mut self, unknown: usize, scheme: impl Scheme + 'a) -> Self {
        match self.schemes.get_mut(unknown) {
            Some(own) => *own = Rc::new(scheme),
            None => self.no_unknown = Some(unknown),
        }
        self
    }

    /// Conditions that do not change, on one unknown: the first one on the constraints' space that has none yet.
    pub fn constrained(self, constraints: &Constraints<D>) -> Self {
        let constraints = constraints.clone();
        self.constrained_at(move |_| Ok(constraints.clone()))
    }

    /// Conditions on one unknown as a function of the time at the end of a step.
    pub fn constrained_at(
        mut self,
        constraints: impl Fn(f64) -> Result<Constraints<D>, ConstraintsError> + 'a,
    ) -> Self {
        self.constraints.push(constraints);
        self
    }

    /// An assembler in place of the default one: for its quadrature, and its threads, which a linear solver of the loop's own has then, too.
    pub fn assembler(mut self, assembler: &Assembler<D>) -> Self {
        self.solver.set_threads(assembler.threads());
        self.assembler = assembler.clone();
        self
    }

    /// A linear solver in place of a [`TangentSolver`](crate::solve::TangentSolver).
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = LentSolver::Lent(solver);
        self
    }

    /// Steps on several processes: each assembles the integrals over its part of the cells. The linear solver has to take
    /// matrices that are sums over the processes. All processes have the same states, on pieces of a mesh those of the piece, and take the same
    /// steps.
    pub fn on(mut self, communicator: &'a dyn Communicator) -> Self {
        let is_piece = self.assembler.mesh().is_piece();
        self.communicator = Some(communicator).filter(|communicator| is_piece || communicator.size() > 1);
        self.processes = None;
        // Each process has the positions of its own entries only.
        (self.pattern, self.kept) = (None, None);
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

    /// States before the first one, newest first, for schemes that read several; of a coupled form all unknowns of a time, one after the
    /// other.
    pub fn with_earlier(mut self, earlier: impl IntoIterator<Item = State<D>>) -> Self {
        self.states.truncate(1);
        let (count, earlier) = (self.schemes.len(), earlier.into_iter().collect::<Vec<_>>());
        self.states.extend(earlier.chunks_exact(count).map(<[_]>::to_vec));
        self
    }

    /// The last state, of the first unknown.
    pub fn state(&self) -> &State<D> {
        &self.states[0][0]
    }

    /// The last states of all unknowns.
    pub fn states(&self) -> &[State<D>] {
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
        if let Some(unknown) = self.no_unknown {
            return Err(StepFailure::NoUnknown { unknown, count: self.schemes.len() });
        }
        let processes = self.processes()?;
        let constraints = processes.all_succeed(MOTION, self.constraints_at(end))?;
        self.find_second_rates(&constraints)?;
        let sizes = self.sizes(size)?;
        let formulas: Vec<Formulas> = self.schemes.iter().map(|scheme| scheme.formulas(&sizes)).collect();
        let solved_for = agreed_unknown(&self.schemes, &formulas)?;
        let read = formulas.iter().map(Formulas::states).max().unwrap_or(0);
        if read > self.states.len() {
            return Err(StepFailure::MissingStates { read, known: self.states.len() });
        }
        let number = |(unknown, formulas)| Step::new(&self.states_of(unknown), end, formulas);
        let steps: Vec<Step<D>> = formulas.iter().enumerate().map(number).collect::<Result<_, _>>()?;
        let weights: Vec<[f64; 3]> = steps.iter().map(|step| step.weights).collect();
        let form = (self.form)(&steps);
        let (x, residual, history, cost) = match solved_for {
            SolvedFor::SecondRate => {
                let mut stand = steps.iter().zip(&constraints);
                let stand =
                    stand.try_for_each(|(step, constraints)| supports_stand(&step.known[0], constraints));
                processes.all_succeed(MOTION, stand)?;
                let homogeneous: Vec<_> = constraints.iter().map(Constraints::homogeneous).collect();
                let (x, residual, cost) = self.solve_affine(&form, &weights, &homogeneous)?;
                (x, residual, vec![], Some(cost))
            }
            SolvedFor::Value if form.is_affine() => {
                let (x, residual, cost) = self.solve_affine(&form, &weights, &constraints)?;
                (x, residual, vec![], Some(cost))
            }
            SolvedFor::Value => {
                let SolvedForm { fields, residual, history, .. } =
                    self.solve_nonlinear(form, size, &constraints)?;
                (fields, residual, history, None)
            }
        };
        let mut states = vec![];
        for (unknown, ((step, formulas), x)) in steps.iter().zip(&formulas).zip(&x).enumerate() {
            let at_end = |which: usize| self.at_end(unknown, formulas, which, step, x);
            let [value, rate, second_rate] = [at_end(0)?, at_end(1)?, at_end(2)?];
            states.push(State { time: end, value, rate, second_rate });
        }
        let error = self.schemes[0].error_factor().map(|factor| {
            let ends = [&states[0], self.state()].map(|state| state.second_rate.values());
            let changes = ends[0].iter().zip(ends[1]).map(|(after, before)| (after - before).abs());
            processes.largest(MOTION, factor * size * size * changes.fold(0.0, f64::max))
        });
        let error = error.transpose()?;
        if let Some(error) = error
            && error > tolerance
        {
            return Err(StepFailure::TooInexact { error, tolerance });
        }
        let spaces = x.iter().map(|x| Arc::clone(x.space())).collect();
        self.states.insert(0, states);
        let kept = self.schemes.iter().map(|scheme| scheme.states()).max();
        self.states.truncate(kept.unwrap_or(1).max(1));
        self.number += 1;
        let cost = cost.map(|cost| StepCost { seconds: begun.elapsed().as_secs_f64(), ..cost });
        Ok(Taken { number: self.number - 1, from, to: end, history, residual, cost, error, spaces })
    }

    /// The states of an unknown, newest first.
    fn states_of(&self, unknown: usize) -> Vec<&State<D>> {
        self.states.iter().map(|states| &states[unknown]).collect()
    }

    /// The sizes of the step to be taken and of those that led to the states, newest first.
    fn sizes(&self, size: f64) -> Result<Vec<f64>, StepFailure> {
        let mut sizes = vec![size];
        // Equal steps have equal weights, and one matrix, whatever the rounding of times.
        let equal = |earlier: f64| (earlier - size).abs() <= SAME_SIZE * size;
        let earlier = self.states.windows(2).map(|pair| pair[0][0].time - pair[1][0].time);
        sizes.extend(earlier.map(|earlier| if equal(earlier) { size } else { earlier }));
        let differ = |states: &Vec<State<D>>| states.iter().any(|state| state.time != states[0].time);
        if sizes.iter().any(|size| size.is_nan() || *size <= 0.0) || self.states.iter().any(differ) {
            let times = self.states.iter().flatten().map(|state| state.time).collect();
            return Err(StepFailure::NotEarlier { times });
        }
        Ok(sizes)
    }

    /// The conditions of each unknown at a time.
    fn constraints_at(&self, end: f64) -> Result<Vec<Constraints<D>>, StepFailure> {
        let spaces: Vec<_> = self.states().iter().map(|state| state.value.space()).collect();
        self.constraints.at(end, &spaces)?.ok_or(StepFailure::Unconstrained)
    }

    /// Value, rate or second rate at the end of a step, with the step's unknown x.
    fn at_end(
        &self,
        unknown: usize,
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
            false => known(combination, &self.states_of(unknown))?,
        };
        Ok(match combination.unknown {
            0.0 => known,
            weight => Field::combination(&[(weight, x), (1.0, &known)])?,
        })
    }

    /// The second rates of the first states, in agreement with the form there.
    fn find_second_rates(&mut self, constraints: &[Constraints<D>]) -> Result<(), StepFailure> {
        if self.has_second_rate || !self.schemes.iter().any(|scheme| scheme.reads_second_rates()) {
            return Ok(());
        }
        let mut conditions: Vec<_> = constraints.iter().map(Constraints::homogeneous).collect();
        let mut steps = vec![];
        for ((state, scheme), conditions) in self.states[0].iter().zip(&self.schemes).zip(&mut conditions) {
            let second_rate = f64::from(u8::from(scheme.reads_second_rates()));
            if second_rate == 0.0 {
                // Without a second rate.
                *conditions = Constraints::new(state.value.space());
                hold(conditions, 0..state.value.values().len())?;
            }
            let zero = Field::zero(state.value.space());
            steps.push(Step {
                end: state.time,
                time: state.time,
                weights: [0.0, 0.0, second_rate],
                known: [state.value.clone(), state.rate.clone(), zero],
                before: state.clone(),
            });
        }
        let weights: Vec<[f64; 3]> = steps.iter().map(|step| step.weights).collect();
        let form = (self.form)(&steps);
        let (second_rates, ..) = match self.solve_affine(&form, &weights, &conditions) {
            // What has no inertia follows the others, and has no acceleration of its own.
            Err(StepFailure::Massless { unknowns })
                if self.schemes.iter().all(|scheme| {
                    scheme.solved_for() == SolvedFor::Value
                        && scheme.formulas(&[1.0]).second_rates_are_for_inertia()
                }) =>
            {
                let mut from = 0;
                for (conditions, step) in conditions.iter_mut().zip(&steps) {
                    let to = from + step.known[0].values().len();
                    let own = unknowns.iter().filter(|unknown| (from..to).contains(*unknown));
                    hold(conditions, own.map(|unknown| unknown - from))?;
                    from = to;
                }
                self.solve_affine(&form, &weights, &conditions)?
            }
            found => found?,
        };
        for (state, second_rate) in self.states[0].iter_mut().zip(second_rates) {
            state.second_rate = second_rate;
        }
        self.has_second_rate = true;
        Ok(())
    }

    /// The processes with the division of vectors between them.
    fn processes(&mut self) -> Result<Processes<'a>, StepFailure> {
        if let Some(known) = &self.processes {
            return Ok(known.clone());
        }
        let spaces: Vec<_> = self.states[0].iter().map(|state| state.value.space()).collect();
        let found = Processes::on(self.communicator, &spaces, MOTION)?;
        Ok(self.processes.insert(found).clone())
    }

    /// Takes this process's part of the cells, and compares what the processes were given.
    fn agree_on_step(&mut self, form: &Form<D>, constraints: &[&Constraints<D>]) -> Result<(), StepFailure> {
        let Some(communicator) = self.communicator else { return Ok(()) };
        let processes = self.processes()?;
        let spaces: Vec<_> = self.states[0].iter().map(|state| state.value.space()).collect();
        processes.check_form(form, spaces[0].mesh())?;
        let own = processes.assembler(&self.assembler, spaces[0].mesh(), form.name());
        self.assembler = agreed(Some(communicator), form.name(), own)?;
        let promises = [self.mass == Mass::Lumped, self.constant_coefficients].map(u64::from);
        let given = GivenEquations {
            form,
            spaces: &spaces,
            assembler: &self.assembler,
            constraints,
            others: vec![("the options of a motion", Fingerprint::default().numbers(promises).finish())],
        };
        Ok(given.agree(communicator)?)
    }

    fn pattern(&mut self, form: &Form<D>) -> Result<Arc<BlockPattern<D>>, StepFailure> {
        if let Some(known) = &self.pattern {
            return Ok(Arc::clone(known));
        }
        let spaces: Vec<_> = self.states[0].iter().map(|state| state.value.space()).collect();
        let outline = Outline::of(form, Parts::ALL);
        let pattern = Arc::new(BlockPattern::for_cells_of(&outline, &spaces, &spaces, &self.assembler)?);
        Ok(Arc::clone(self.pattern.insert(pattern)))
    }

    fn solve_affine(
        &mut self,
        form: &Form<D>,
        weights: &[[f64; 3]],
        constraints: &[Constraints<D>],
    ) -> Result<AffineStep<D>, StepFailure> {
        let of_second_rate = weights.iter().all(|weights| weights[0] == 0.0);
        let constraints: Vec<_> = constraints.iter().collect();
        self.agree_on_step(form, &constraints)?;
        let pattern = self.pattern(form)?;
        let processes = self.processes()?;
        let mut elimination = processes.elimination(form.name(), Elimination::of(&constraints)?)?;
        // From zero where masses are lumped: the form's residual knows the consistent ones.
        let values = self.states[0].iter().flat_map(|state| state.value.values());
        let mut guess: Vec<f64> = values.map(|value| if of_second_rate { 0.0 } else { *value }).collect();
        elimination.impose(&mut guess)?;
        let spaces: Vec<_> = self.states[0].iter().map(|state| state.value.space()).collect();
        let check = match (self.constant_coefficients, self.number % CHECKED_STEPS) {
            (false, _) => Check::Equations,
            (true, 0) => Check::Promise,
            (true, _) => Check::Nothing,
        };
        let mut means = Means {
            assembler: &self.assembler,
            processes: &processes,
            pattern: &pattern,
            solver: self.solver.get(),
            mass: if of_second_rate { self.mass } else { Mass::Consistent },
        };
        let LinearStep { unknown, residual, cost } =
            solve((form, weights), (&spaces, &guess), &mut elimination, &mut self.kept, &mut means, check)?;
        Ok((fields_on(&spaces, &unknown)?, residual, cost))
    }

    fn solve_nonlinear(
        &mut self,
        form: Form<D>,
        size: f64,
        constraints: &[Constraints<D>],
    ) -> Result<SolvedForm<D>, StepFailure> {
        self.kept = None;
        let predicted = |state: &State<D>| Field::combination(&[(1.0, &state.value), (size, &state.rate)]);
        let start: Vec<Field<D>> = self.states[0].iter().map(predicted).collect::<Result<_, _>>()?;
        self.solve_by_newton(form, &start, constraints)
    }

    fn solve_by_newton(
        &mut self,
        form: Form<D>,
        start: &[Field<D>],
        constraints: &[Constraints<D>],
    ) -> Result<SolvedForm<D>, StepFailure> {
        let pattern = match self.communicator {
            None => Some(self.pattern(&form)?),
            Some(_) => self.pattern.take(),
        };
        let owned = OwnedForm {
            form,
            assembler: &self.assembler,
            pattern: pattern.as_ref(),
            communicator: self.communicator,
            constraints: &constraints.iter().collect::<Vec<_>>(),
            start: &start.iter().collect::<Vec<_>>(),
            positive: vec![],
            options: self.options.clone(),
        };
        let solved = solve_owned(owned, self.solver.get(), &mut self.memory)?;
        if self.communicator.is_some() {
            self.pattern.clone_from(&solved.pattern);
        }
        Ok(solved)
    }
}

instantiate!(time_loop: TimeLoop::<D>::of, TimeLoop::<D>::take);
