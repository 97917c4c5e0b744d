//! Motions: steps in time of one form by a scheme, with a criterion and its discrete adjoint.

mod lumped;
mod reverse;
mod second_order;

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

use self::second_order::{ADJOINT, SecondSensitivitiesOf};
pub use self::second_order::{SecondOrderMotion, SecondOrderMotions};
use super::checkpoint_store::Storage;
use super::choices::choices_of;
use super::control_vectors::ControlVectors;
use super::controls::{ControlError, ControlValues, Controls, Start};
use super::criterion::Criterion;
use super::differentiable_map::Part;
use super::error::{HistoryError, HistoryFailure};
use super::evolution::{ControlledEvolution, Evolution};
use super::observations::Observations;
use super::reduced_problem::ReducedProblem;
use super::second_order::{Hessian, SecondOrder, TwiceDifferentiable};
use super::sensitivities::{BEFORE, OPERATORS, has_unknowns};
use super::step_context::StepContext;
use super::step_equations::{Solution, StepEquations};
use super::step_map::{StepMap, of_start};
use super::step_sizes::StepSizes;
use super::sweep::{Gradient, gradient_stored, value_of};
use super::tangent_state::{Changing, CurvedCriterion};
use crate::assemble::Assembler;
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::{Energy, Form};
use crate::field::{Field, fields_on};
use crate::instantiate::instantiate;
use crate::solve::{Communicator, LinearSolver, NewtonOptions, PerUnknown, SolverReport};
use crate::space::Space;
use crate::time::central_differences::supports_stand;
use crate::time::conditions::{Conditions, hold};
use crate::time::scheme::agreed_unknown;
use crate::time::{Formulas, Mass, Scheme, SolvedFor, Step, StepFailure};
use crate::verification::Sample;

/// A motion in steps by a scheme, with a criterion J(m) = Σ Jⁿ(uⁿ), with value and gradient by m.
///
/// The form is written with the operators of [`time`](crate::time), and the form of rates, of the step's unknown and adjoint state, has a
/// test `by_name` per control. Derivatives by the states before are tangents with other weights; where the rates have tests
/// `by_value`, `by_rate` and `by_second_rate`, of the derivatives by `known_value`, `known_rate` and `known_second_rate`, they are
/// taken from these, which takes a fraction of the time. Where the form reads the value before next to the operators
/// ([`StepContext::before`]), the rates have a test `by_before`. It may read the unknown itself, which is the value at the end of the step, with
/// schemes that read no second rates; with others it is refused by name.
///
/// Forms of up to four unknowns are motions on the list of their spaces, as `[&displacements, &pressures]`. They read
/// [`StepContext::steps`], the sensitivities are [`MotionHistory::coupled_sensitivities`], and tests of derivatives by what is known of the
/// unknown `u` are `by_value_u`, `by_rate_u`, `by_second_rate_u` and `by_before_u`. An unknown may have a scheme of its own
/// ([`MotionHistory::scheme_of`]); one without inertia has a scheme that reads no second rates. The criterion may read the first unknown
/// or more of them.
///
/// A scheme that reads k states begins with one, and with the formulas that it has for fewer; each stored state is then k states.
/// Controls of the start of explicit steps have to be what the conditions prescribe; the gradient by what is prescribed is zero.
pub struct MotionHistory<'a, const D: usize> {
    /// Of each unknown.
    spaces: Vec<Arc<Space<D>>>,
    sizes: StepSizes,
    /// Of each unknown.
    schemes: Vec<Rc<dyn Scheme + 'a>>,
    /// An unknown that was given a scheme and does not exist.
    no_unknown: Option<usize>,
    mass: Mass,
    controls: Controls<D>,
    motion: Option<FormAt<'a, D>>,
    sensitivities: Option<SensitivitiesAt<'a, D>>,
    second_sensitivities: Option<SecondSensitivitiesOf<'a, D>>,
    criterion: Criterion<'a, D>,
    constraints: Conditions<'a, f64, D>,
    equations: StepEquations<'a, D>,
    storage: Storage,
    reading: Reading,
    /// Whether the form of motion has asked for the value before the step.
    before_is_read: Cell<bool>,
}

/// The ways in which a form reads its unknown, as far as was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reading {
    /// Nothing is known but of the steps that were looked at.
    Unseen,
    /// By operators alone: an affine form, where one step is enough.
    ByOperators,
    /// Itself, in addition to them: the number of the first unknown that is read so.
    Itself(usize),
}

type FormAt<'a, const D: usize> = Box<dyn Fn(&StepContext<D>) -> Result<Form<D>, ControlError> + 'a>;
type SensitivitiesAt<'a, const D: usize> =
    Box<dyn Fn(&StepContext<D>, &[Field<D>], &[Field<D>]) -> Result<Form<D>, ControlError> + 'a>;

impl<'a, const D: usize> MotionHistory<'a, D> {
    /// Steps from time zero on a space, or on `[&first, &second]`: `(200, 0.01)` equal ones or the size of each, at rest unless the start is a
    /// control.
    pub fn new<'s, const N: usize>(
        spaces: impl PerUnknown<'s, Arc<Space<D>>, N>,
        sizes: impl Into<StepSizes>,
        scheme: impl Scheme + 'a,
        controls: Controls<D>,
    ) -> Self {
        const { assert!(N > 0, "a motion has an unknown") };
        Self::of(&spaces.per_unknown(), sizes.into(), Rc::new(scheme), controls)
    }

    #[inline(never)]
    fn of(
        spaces: &[&Arc<Space<D>>],
        sizes: StepSizes,
        scheme: Rc<dyn Scheme + 'a>,
        controls: Controls<D>,
    ) -> Self {
        MotionHistory {
            spaces: spaces.iter().map(|space| Arc::clone(space)).collect(),
            sizes,
            schemes: vec![scheme; spaces.len()],
            no_unknown: None,
            mass: Mass::Consistent,
            controls,
            motion: None,
            sensitivities: None,
            second_sensitivities: None,
            criterion: Criterion::none(),
            constraints: Conditions::none(),
            equations: StepEquations::new(spaces),
            storage: Storage::ALL,
            reading: Reading::Unseen,
            before_is_read: Cell::new(false),
        }
    }

    /// The scheme of one unknown, by its number, in place of the common one. All schemes have to give loads at the same time of a step and
    /// to solve for the same: a motion that does not agree is an error.
    pub fn scheme_of(mut self, unknown: usize, scheme: impl Scheme + 'a) -> Self {
        match self.schemes.get_mut(unknown) {
            Some(own) => *own = Rc::new(scheme),
            None => self.no_unknown = Some(unknown),
        }
        self
    }

    /// The form of motion.
    pub fn motion<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&StepContext<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.motion = Some(Box::new(move |during| Ok(form(during)?.into())));
        self
    }

    /// The rates of a step at its unknown u and adjoint state p.
    pub fn sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&StepContext<D>, &Field<D>, &Field<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.sensitivities = Some(Box::new(move |during, u, p| Ok(form(during, &u[0], &p[0])?.into())));
        self
    }

    /// The rates of a step of several unknowns at them and their adjoint states, a field for each unknown.
    pub fn coupled_sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&StepContext<D>, &[Field<D>], &[Field<D>]) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.sensitivities = Some(Box::new(move |during, u, p| Ok(form(during, u, p)?.into())));
        self
    }

    /// The mass matrix of explicit steps, and of the first state's second rate. Lumped masses are those of the start.
    pub fn mass(mut self, mass: Mass) -> Self {
        self.mass = mass;
        self
    }

    fn begin(&mut self, m: &[f64]) -> Result<(), HistoryFailure> {
        if let Some(size) = self.sizes.unfit() {
            return Err(HistoryFailure::StepSize(size));
        }
        if let Some(unknown) = self.no_unknown {
            return Err(StepFailure::NoUnknown { unknown, count: self.schemes.len() }.into());
        }
        self.controls.check(&self.unknowns_on(), self.sizes.count())?;
        self.controls.are_not(&[&OPERATORS[..], &[BEFORE]].concat())?;
        self.criterion.check(&self.unknowns_on(), self.sizes.count())?;
        let lumps = (self.mass == Mass::Lumped, "adjoint states of motions with lumped masses");
        self.equations.begin(&self.controls, [lumps])?;
        self.criterion.divide(&self.equations)?;
        self.reading = Reading::Unseen;
        self.before_is_read.set(false);
        Ok(self.controls.set_values(m)?)
    }

    fn unknowns_on(&self) -> Vec<&Arc<Space<D>>> {
        self.spaces.iter().collect()
    }

    /// The number of coefficients of all unknowns.
    fn count(&self) -> usize {
        self.spaces.iter().map(|space| space.unknowns()).sum()
    }

    /// The states in a row.
    fn states(&self) -> usize {
        self.schemes.iter().map(|scheme| scheme.states()).max().unwrap_or(0).max(1)
    }

    /// Whether the scheme of an unknown reads second rates.
    fn reads_second_rates(&self) -> bool {
        self.schemes.iter().any(|scheme| scheme.reads_second_rates())
    }

    fn interval(&self, step: usize) -> Result<StepMap, HistoryFailure> {
        let known = self.states().min(step + 1);
        let sizes = self.sizes.newest_first(step, known);
        let formulas: Vec<Formulas> = self.schemes.iter().map(|scheme| scheme.formulas(&sizes)).collect();
        let solved_for = agreed_unknown(&self.schemes, &formulas)?;
        let read = formulas.iter().map(Formulas::states).max().unwrap_or(0);
        if read > known {
            return Err(StepFailure::MissingStates { read, known }.into());
        }
        Ok(self.step_map(Solution::Step(step), formulas, solved_for, self.sizes.times(step)))
    }

    /// The start at time zero, where a second rate is found from the form.
    fn interval_at_start(&self) -> StepMap {
        let formulas = self.schemes.iter().map(|scheme| of_start(scheme.reads_second_rates())).collect();
        self.step_map(Solution::Start, formulas, SolvedFor::SecondRate, [0.0; 2])
    }

    fn step_map(
        &self,
        solution: Solution,
        formulas: Vec<Formulas>,
        solved_for: SolvedFor,
        times: [f64; 2],
    ) -> StepMap {
        let counts = self.spaces.iter().map(|space| space.unknowns()).collect();
        StepMap { solution, formulas, solved_for, times, counts, states: self.states() }
    }

    /// The values in a row, of each unknown.
    fn values_in(&self, row: &[f64]) -> Result<Vec<Field<D>>, HistoryFailure> {
        Ok(fields_on(&self.unknowns_on(), &row[..self.count()])?)
    }

    fn zero(&self) -> Vec<Field<D>> {
        self.spaces.iter().map(Field::zero).collect()
    }

    fn form(&self, interval: &StepMap, steps: &[Step<D>]) -> Result<Form<D>, HistoryFailure> {
        let form =
            self.motion.as_ref().ok_or(HistoryFailure::Missing("motion"))?(&self.during(interval, steps))?;
        has_unknowns(form, self.spaces.len())
    }

    fn during<'s>(&'s self, interval: &StepMap, steps: &'s [Step<D>]) -> StepContext<'s, D> {
        let at = ControlValues::new(&self.controls, interval.step(), None);
        StepContext { steps, at, before_is_read: &self.before_is_read }
    }

    /// The conditions on each unknown at a time.
    fn conditions_at(&self, time: f64) -> Result<Vec<Constraints<D>>, HistoryFailure> {
        self.constraints.at(time, &self.unknowns_on())?.ok_or(HistoryFailure::Unconstrained)
    }

    /// The conditions on the unknowns of a step, which are values or second rates.
    fn conditions(&self, interval: &StepMap) -> Result<Vec<Constraints<D>>, HistoryFailure> {
        let mut conditions = self.conditions_at(interval.times[1])?;
        if interval.solved_for == SolvedFor::Value {
            return Ok(conditions);
        }
        for (conditions, formulas) in conditions.iter_mut().zip(&interval.formulas) {
            *conditions = conditions.homogeneous();
            if formulas.evaluated[2].unknown == 0.0 {
                // Without a second rate.
                *conditions = Constraints::new(conditions.space());
                let all = 0..conditions.space().unknowns();
                hold(conditions, all)?;
            }
        }
        Ok(conditions)
    }

    #[inline(never)]
    fn advance_by(&mut self, interval: &StepMap, before: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let steps = interval.steps_from(&self.unknowns_on(), before)?;
        let form = self.form(interval, &steps)?;
        if form.is_on_displaced_surfaces() {
            return Err(HistoryFailure::Sliding { form: form.name() });
        }
        if interval.is_explicit_step() {
            for (step, conditions) in steps.iter().zip(self.conditions_at(interval.times[1])?) {
                supports_stand(&step.known[0], &conditions)?;
            }
        }
        let conditions = self.conditions(interval)?;
        let unknowns = match interval.masses(before) {
            Some(masses) => self.by_masses(&form, masses, &conditions)?,
            None => {
                let start: Vec<Field<D>> = match interval.solved_for {
                    SolvedFor::Value => steps.into_iter().map(|step| step.before.value).collect(),
                    SolvedFor::SecondRate => steps.into_iter().map(|step| step.before.second_rate).collect(),
                };
                self.equations.solve(interval.solution, form, &conditions, &start)?
            }
        };
        Ok(interval.end_of(before, &coefficients(&unknowns)))
    }

    /// The row of the first state, without its second rate.
    fn start_of(&self, controls: &Controls<D>) -> Vec<f64> {
        let mut start = controls.start_values(Start::Value, &self.unknowns_on());
        start.extend(controls.start_values(Start::Rate, &self.unknowns_on()));
        start.resize(3 * self.states() * self.count(), 0.0);
        start
    }

    /// The slope by a first state, without what the conditions prescribe in explicit steps.
    fn slope_by_start(&self, mut slope: Vec<f64>) -> Result<Vec<f64>, HistoryFailure> {
        if self.schemes[0].solved_for() == SolvedFor::SecondRate {
            let (count, mut from) = (self.count(), 0);
            for (conditions, space) in self.conditions_at(0.0)?.iter().zip(&self.spaces) {
                for unknown in conditions.prescribed().keys() {
                    (slope[from + unknown], slope[count + from + unknown]) = (0.0, 0.0);
                }
                from += space.unknowns();
            }
        }
        Ok(slope)
    }
}

impl<const D: usize> Evolution for MotionHistory<'_, D> {
    type Error = HistoryError;

    fn steps(&self) -> usize {
        self.sizes.count()
    }

    fn control_count(&self) -> usize {
        self.controls.values().len()
    }

    fn start(&mut self) -> Result<Vec<f64>, HistoryError> {
        let mut start = || {
            let mut start = self.start_of(&self.controls);
            if self.lumps() {
                let masses = self.masses_at(&start)?;
                start.extend(masses);
            }
            match self.reads_second_rates() {
                true => self.advance_by(&self.interval_at_start(), &start),
                false => Ok(start),
            }
        };
        start().map_err(|why: HistoryFailure| why.at(0))
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        let mut advance = || self.advance_by(&self.interval(step)?, before);
        advance().map_err(|why| why.at(step))
    }

    fn cost(&mut self, step: usize, _: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        let value = || {
            let after = self.values_in(after)?;
            let at = ControlValues::new(&self.controls, step, None);
            self.criterion.value(&at, &self.equations, &after)
        };
        value().map_err(|why| why.at(step))
    }

    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        mut slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        let mut reverse = || {
            let values = self.values_in(after)?;
            let at = ControlValues::new(&self.controls, step, None);
            let own = &mut slope[..self.count()];
            self.criterion.add_slope(&at, &self.equations, &values, own)?;
            self.reverse_by(&self.interval(step)?, [before, after], &slope, gradient)
        };
        reverse().map_err(|why| why.at(step))
    }

    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        let mut reverse = || {
            let mut slope = slope.to_vec();
            if self.reads_second_rates() {
                slope = self.reverse_by(&self.interval_at_start(), [start, start], &slope, gradient)?;
            }
            if self.lumps() {
                self.reverse_masses(start, &mut slope, gradient)?;
            }
            self.slope_by_start(slope)
        };
        let slope = reverse().map_err(|why: HistoryFailure| why.at(0))?;
        let (count, spaces) = (self.count(), self.unknowns_on());
        self.controls.add_start(Start::Value, &spaces, &slope[..count], gradient);
        self.controls.add_start(Start::Rate, &spaces, &slope[count..2 * count], gradient);
        Ok(())
    }
}

/// The coefficients of all unknowns, one after the other.
fn coefficients<const D: usize>(fields: &[Field<D>]) -> Vec<f64> {
    fields.iter().flat_map(Field::values).copied().collect()
}

choices_of!(
    MotionHistory,
    constrained_at f64,
    "the time at the end of a step",
    second_rates by &[ADJOINT]
);

instantiate!(
    motion_history:
    MotionHistory::<D>::of,
    MotionHistory::<D>::gradient,
    MotionHistory::<D>::hessian,
    MotionHistory::<D>::advance_by,
    MotionHistory::<D>::reverse_by,
);
