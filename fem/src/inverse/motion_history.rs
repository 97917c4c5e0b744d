//! Motions: steps in time of one form by a scheme, with a criterion and its discrete adjoint.

mod lumped;
mod reverse;
mod second_order;

use std::cell::Cell;
use std::sync::Arc;

pub use self::second_order::SecondOrderMotion;
use self::second_order::{ADJOINT, SecondSensitivitiesOf};
use super::checkpoint_store::Storage;
use super::choices::choices_of;
use super::controls::{ControlError, ControlValues, Controls, Start};
use super::criterion::Criterion;
use super::differentiable_map::Part;
use super::error::{HistoryError, HistoryFailure};
use super::evolution::{ControlledEvolution, Evolution};
use super::observations::Observations;
use super::reduced_problem::ReducedProblem;
use super::second_order::{Hessian, SecondOrder, TwiceDifferentiable};
use super::sensitivities::{BEFORE, OPERATORS};
use super::step_context::StepContext;
use super::step_equations::{Solution, StepEquations};
use super::step_map::{StepMap, of_start};
use super::step_sizes::StepSizes;
use super::sweep::{Gradient, gradient_stored, value_of};
use super::tangent_state::{Changing, CurvedCriterion};
use crate::assemble::Assembler;
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::{Energy, Form};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::solve::{LinearSolver, NewtonOptions, SolverReport};
use crate::space::Space;
use crate::time::central_differences::supports_stand;
use crate::time::conditions::Conditions;
use crate::time::{Mass, Scheme, SolvedFor, Step, StepFailure};
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
/// A scheme that reads k states begins with one, and with the formulas that it has for fewer; each stored state is then k states.
/// Controls of the start of explicit steps have to be what the conditions prescribe; the gradient by what is prescribed is zero.
pub struct MotionHistory<'a, const D: usize> {
    space: Arc<Space<D>>,
    sizes: StepSizes,
    scheme: Box<dyn Scheme + 'a>,
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
    /// Itself, in addition to them.
    Itself,
}

type FormAt<'a, const D: usize> = Box<dyn Fn(&StepContext<D>) -> Result<Form<D>, ControlError> + 'a>;
type SensitivitiesAt<'a, const D: usize> =
    Box<dyn Fn(&StepContext<D>, &Field<D>, &Field<D>) -> Result<Form<D>, ControlError> + 'a>;

impl<'a, const D: usize> MotionHistory<'a, D> {
    /// Steps from time zero, `(200, 0.01)` equal ones or the size of each, at rest unless the start is a control.
    pub fn new(
        space: &Arc<Space<D>>,
        sizes: impl Into<StepSizes>,
        scheme: impl Scheme + 'a,
        controls: Controls<D>,
    ) -> Self {
        Self::of(space, sizes.into(), Box::new(scheme), controls)
    }

    #[inline(never)]
    fn of(
        space: &Arc<Space<D>>,
        sizes: StepSizes,
        scheme: Box<dyn Scheme + 'a>,
        controls: Controls<D>,
    ) -> Self {
        MotionHistory {
            space: Arc::clone(space),
            sizes,
            scheme,
            mass: Mass::Consistent,
            controls,
            motion: None,
            sensitivities: None,
            second_sensitivities: None,
            criterion: Criterion::none(),
            constraints: Conditions::none(),
            equations: StepEquations::new(&[space]),
            storage: Storage::ALL,
            reading: Reading::Unseen,
            before_is_read: Cell::new(false),
        }
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
        self.controls.check(&[&self.space], self.sizes.count())?;
        self.controls.are_not(&[&OPERATORS[..], &[BEFORE]].concat())?;
        self.criterion.check(&[&self.space], self.sizes.count())?;
        self.equations.forget();
        self.reading = Reading::Unseen;
        self.before_is_read.set(false);
        Ok(self.controls.set_values(m)?)
    }

    fn unknowns_on(&self) -> Vec<&Arc<Space<D>>> {
        vec![&self.space]
    }

    /// The states in a row.
    fn states(&self) -> usize {
        self.scheme.states().max(1)
    }

    fn interval(&self, step: usize) -> Result<StepMap, HistoryFailure> {
        let known = self.states().min(step + 1);
        let formulas = self.scheme.formulas(&self.sizes.newest_first(step, known));
        let read = formulas.states();
        if read > known {
            return Err(StepFailure::MissingStates { read, known }.into());
        }
        Ok(StepMap {
            solution: Solution::Step(step),
            formulas,
            solved_for: self.scheme.solved_for(),
            times: self.sizes.times(step),
            unknowns: self.space.unknowns(),
            states: self.states(),
        })
    }

    /// The start at time zero, where a second rate is found from the form.
    fn interval_at_start(&self) -> StepMap {
        StepMap {
            solution: Solution::Start,
            formulas: of_start(),
            solved_for: SolvedFor::SecondRate,
            times: [0.0; 2],
            unknowns: self.space.unknowns(),
            states: self.states(),
        }
    }

    /// The value in a row.
    fn value_in(&self, row: &[f64]) -> Result<Field<D>, HistoryFailure> {
        Ok(Field::from_values(&self.space, row[..self.space.unknowns()].to_vec())?)
    }

    fn form(&self, interval: &StepMap, step: &Step<D>) -> Result<Form<D>, HistoryFailure> {
        Ok(self.motion.as_ref().ok_or(HistoryFailure::Missing("motion"))?(&self.during(interval, step))?)
    }

    fn during<'s>(&'s self, interval: &StepMap, step: &'s Step<D>) -> StepContext<'s, D> {
        let at = ControlValues::new(&self.controls, interval.step(), None);
        StepContext { step, at, before_is_read: &self.before_is_read }
    }

    /// The conditions at a time.
    fn conditions_at(&self, time: f64) -> Result<Constraints<D>, HistoryFailure> {
        let found = self.constraints.at(time, &[&self.space])?;
        Ok(found.ok_or(HistoryFailure::Unconstrained)?.swap_remove(0))
    }

    /// The conditions on the unknown of a step, which is a value or a second rate.
    fn conditions(&self, interval: &StepMap) -> Result<Constraints<D>, HistoryFailure> {
        let constraints = self.conditions_at(interval.times[1])?;
        Ok(match interval.solved_for {
            SolvedFor::Value => constraints,
            SolvedFor::SecondRate => constraints.homogeneous(),
        })
    }

    #[inline(never)]
    fn advance_by(&mut self, interval: &StepMap, before: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let step = interval.step_from(&self.space, before)?;
        let form = self.form(interval, &step)?;
        if form.is_on_displaced_surfaces() {
            return Err(HistoryFailure::Sliding { form: form.name() });
        }
        if interval.is_explicit_step() {
            supports_stand(&step.known[0], &self.conditions_at(step.end)?)?;
        }
        let conditions = self.conditions(interval)?;
        let unknown = match (interval.masses(before), interval.solved_for) {
            (Some(masses), _) => self.by_masses(&form, masses, &conditions)?,
            (None, SolvedFor::Value) => {
                let start = std::slice::from_ref(&step.before.value);
                self.equations.solve(interval.solution, form, &[conditions], start)?.swap_remove(0)
            }
            (None, SolvedFor::SecondRate) => {
                let start = std::slice::from_ref(&step.before.second_rate);
                self.equations.solve(interval.solution, form, &[conditions], start)?.swap_remove(0)
            }
        };
        Ok(interval.end_of(before, unknown.values()))
    }

    /// The row of the first state, without its second rate.
    fn start_of(&self, controls: &Controls<D>) -> Vec<f64> {
        let count = self.space.unknowns();
        let mut start = controls.start_values(Start::Value, &[&self.space]);
        start.extend(controls.start_values(Start::Rate, &[&self.space]));
        start.resize(3 * self.states() * count, 0.0);
        start
    }

    /// The slope by a first state, without what the conditions prescribe in explicit steps.
    fn slope_by_start(&self, mut slope: Vec<f64>) -> Result<Vec<f64>, HistoryFailure> {
        if self.scheme.solved_for() == SolvedFor::SecondRate {
            let count = self.space.unknowns();
            for unknown in self.conditions_at(0.0)?.prescribed().keys() {
                (slope[*unknown], slope[count + unknown]) = (0.0, 0.0);
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
            match self.scheme.reads_second_rates() {
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
            let after = self.value_in(after)?;
            let at = ControlValues::new(&self.controls, step, None);
            self.criterion.value(&at, &self.equations.assembler, std::slice::from_ref(&after))
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
            let value = self.value_in(after)?;
            let at = ControlValues::new(&self.controls, step, None);
            let own = &mut slope[..value.values().len()];
            self.criterion.add_slope(&at, &self.equations.assembler, std::slice::from_ref(&value), own)?;
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
            if self.scheme.reads_second_rates() {
                slope = self.reverse_by(&self.interval_at_start(), [start, start], &slope, gradient)?;
            }
            if self.lumps() {
                self.reverse_masses(start, &mut slope, gradient)?;
            }
            self.slope_by_start(slope)
        };
        let slope = reverse().map_err(|why: HistoryFailure| why.at(0))?;
        let (count, spaces) = (self.space.unknowns(), [&self.space]);
        self.controls.add_start(Start::Value, &spaces, &slope[..count], gradient);
        self.controls.add_start(Start::Rate, &spaces, &slope[count..2 * count], gradient);
        Ok(())
    }
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
