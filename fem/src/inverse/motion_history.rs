//! Motions: steps in time of one form by a scheme, with a criterion and its discrete adjoint.

mod second_order;

use std::cell::Cell;
use std::sync::Arc;

pub use self::second_order::SecondOrderMotion;
use self::second_order::SecondRatesOf;
use super::choices::choices_of;
use super::controls::{At, ControlError, Controls, Start};
use super::criterion::Criterion;
use super::differentiable_map::Part;
use super::during::{During, Interval, add_slope, of_start};
use super::error::{HistoryError, HistoryFailure};
use super::evolution::{ControlledEvolution, Evolution};
use super::observations::Observations;
use super::rates::add_rates;
use super::reduced_problem::ReducedProblem;
use super::shelf::Storage;
use super::step_equations::{Solution, StepEquations};
use super::steps_unknown::{evaluated, reads_unknown_itself, refused};
use super::sweep::{Gradient, gradient_stored, value_of};
use crate::assemble::Assembler;
use crate::compiled_here::compiled_here;
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::{Form, Functional};
use crate::field::Field;
use crate::linear_algebra::vector::add_scaled;
use crate::solve::any_form::AnyForm;
use crate::solve::{LinearSolver, NewtonOptions, SolverReport};
use crate::space::Space;
use crate::time::{Formulas, Scheme, SolvedFor, Step};
use crate::verification::Sample;

/// A motion in equal steps by a scheme of one step, with a criterion J(m) = Σ Jⁿ(uⁿ) of which it gives value and gradient by m.
///
/// The form is written with the operators of [`time`](crate::time): derivatives by the state before are tangents with other weights. Where
/// it reads the value before beside them ([`During::before`]), the form of rates has a test `by_before`. A form may read the unknown
/// itself, which is the value at the end of the step, with schemes that read no second rates; with others it is refused by name. The
/// form of rates, of the step's unknown and adjoint state, has a test `by_name` per control.
pub struct MotionHistory<'a, const D: usize> {
    space: Arc<Space<D>>,
    steps: usize,
    size: f64,
    scheme: Box<dyn Scheme + 'a>,
    controls: Controls<D>,
    motion: Option<FormAt<'a, D>>,
    rates: Option<RatesAt<'a, D>>,
    second_rates: Option<SecondRatesOf<'a, D>>,
    criterion: Criterion<'a, D>,
    constraints: ConstraintsAt<'a, D>,
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
    /// By operators alone: an affine form, of which one step tells all.
    ByOperators,
    /// Itself, beside them.
    Itself,
}

type FormAt<'a, const D: usize> =
    Box<dyn Fn(&During<D>) -> Result<Box<dyn AnyForm<D> + 'a>, ControlError> + 'a>;
type RatesAt<'a, const D: usize> =
    Box<dyn Fn(&During<D>, &Field<D>, &Field<D>) -> Result<Box<dyn AnyForm<D> + 'a>, ControlError> + 'a>;
type ConstraintsAt<'a, const D: usize> = Box<dyn Fn(f64) -> Result<Constraints<D>, ConstraintsError> + 'a>;

impl<'a, const D: usize> MotionHistory<'a, D> {
    /// Equal steps of a size from time zero, at rest unless the start is a control.
    pub fn new(
        space: &Arc<Space<D>>,
        (steps, size): (usize, f64),
        scheme: impl Scheme + 'a,
        controls: Controls<D>,
    ) -> Self {
        Self::of(space, (steps, size), Box::new(scheme), controls)
    }

    #[inline(never)]
    fn of(
        space: &Arc<Space<D>>,
        (steps, size): (usize, f64),
        scheme: Box<dyn Scheme + 'a>,
        controls: Controls<D>,
    ) -> Self {
        let unconstrained = Constraints::new(space);
        MotionHistory {
            space: Arc::clone(space),
            steps,
            size,
            scheme,
            controls,
            motion: None,
            rates: None,
            second_rates: None,
            criterion: Criterion::none(),
            constraints: Box::new(move |_| Ok(unconstrained.clone())),
            equations: StepEquations::new(space),
            storage: Storage::ALL,
            reading: Reading::Unseen,
            before_is_read: Cell::new(false),
        }
    }

    /// The form of motion.
    pub fn motion<F: Form<D> + 'a>(
        mut self,
        form: impl Fn(&During<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.motion = Some(Box::new(move |during| Ok(Box::new(form(during)?))));
        self
    }

    /// The rates of a step at its unknown u and adjoint state p.
    pub fn rates<F: Form<D> + 'a>(
        mut self,
        form: impl Fn(&During<D>, &Field<D>, &Field<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.rates = Some(Box::new(move |during, u, p| Ok(Box::new(form(during, u, p)?))));
        self
    }

    /// Jⁿ, an energy of the value after the step, which depends on no control.
    pub fn criterion<F: Form<D> + Functional<D> + 'a>(
        mut self,
        energy: impl Fn(&At<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.criterion.energy = Some(Box::new(move |at| Ok(Box::new(energy(at)?))));
        self
    }

    fn begin(&mut self, m: &[f64]) -> Result<(), HistoryFailure> {
        if self.scheme.states() != 1 || self.scheme.solved_for() != SolvedFor::Value {
            return Err(HistoryFailure::Scheme { scheme: format!("{:?}", self.scheme) });
        }
        if !(self.size > 0.0 && self.size.is_finite()) {
            return Err(HistoryFailure::StepSize(self.size));
        }
        self.controls.check(&self.space, self.steps)?;
        self.criterion.check(&self.space, self.steps)?;
        self.equations.forget();
        self.reading = Reading::Unseen;
        self.before_is_read.set(false);
        Ok(self.controls.set_values(m)?)
    }

    fn interval<'f>(&self, step: usize, formulas: &'f Formulas) -> Interval<'f> {
        let at = |step: usize| self.size * step as f64;
        Interval { solution: Solution::Step(step), formulas, from: at(step), to: at(step + 1) }
    }

    /// The value in a row of value, rate and second rate.
    fn value_in(&self, row: &[f64]) -> Result<Field<D>, HistoryFailure> {
        Ok(Field::from_values(&self.space, row[..self.space.unknowns()].to_vec())?)
    }

    fn form(&self, interval: &Interval, step: &Step<D>) -> Result<Box<dyn AnyForm<D> + 'a>, HistoryFailure> {
        Ok(self.motion.as_ref().ok_or(HistoryFailure::Missing("motion"))?(&self.during(interval, step))?)
    }

    fn during<'s>(&'s self, interval: &Interval, step: &'s Step<D>) -> During<'s, D> {
        let at = At::new(&self.controls, interval.step(), None);
        During { step, at, before_is_read: &self.before_is_read }
    }

    /// The conditions on the unknown of a step; that of the start is a second rate.
    fn conditions(&self, interval: &Interval) -> Result<Constraints<D>, HistoryFailure> {
        let constraints = (self.constraints)(interval.to)?;
        Ok(if interval.to > interval.from { constraints } else { constraints.homogeneous() })
    }

    #[inline(never)]
    fn advance_by(&mut self, interval: &Interval, before: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let step = interval.step_from(&self.space, before)?;
        let form = self.form(interval, &step)?;
        if form.is_on_displaced_surfaces() {
            return Err(HistoryFailure::Sliding { form: form.name() });
        }
        let guess = if interval.to > interval.from { &step.before.value } else { &step.before.second_rate };
        let conditions = self.conditions(interval)?;
        let unknown = self.equations.solve(interval.solution, form, &conditions, guess)?;
        interval.end_of(&step.before, &unknown)
    }

    #[inline(never)]
    fn reverse_by(
        &mut self,
        interval: &Interval,
        [before, after]: [&[f64]; 2],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let count = self.space.unknowns();
        let formulas = interval.formulas;
        let step = interval.step_from(&self.space, before)?;
        let unknown = interval.unknown_of(&step.before, after)?;
        let load = interval.slope_by_unknown(slope);
        let form = self.form(interval, &step)?;
        let conditions = self.conditions(interval)?;
        let adjoint = self.equations.adjoint(interval.solution, &*form, &conditions, &unknown, &load)?;
        let during = self.during(interval, &step);
        let reads_before = self.before_is_read.get();
        let rates =
            self.rates.as_ref().ok_or(HistoryFailure::Missing("rates"))?(&during, &unknown, &adjoint)?;
        let spaces = [&self.space, &self.equations.constants()?];
        let controls = (&self.controls, reads_before);
        let mut by_before =
            add_rates(&*rates, interval.step(), controls, spaces, &self.equations.assembler, gradient)?;
        by_before.resize(3 * count, 0.0);

        for (combination, slope) in formulas.end.iter().zip(slope.chunks(count)) {
            add_slope(combination, slope, &mut by_before);
        }
        // What the form evaluates: its tangent by one of the three is that with the weight one there and what is known of it zero.
        let evaluated = evaluated(&step, &unknown)?;
        let directly = self.read_directly(interval, &step, (&unknown, &evaluated), &adjoint)?;
        for (place, combination) in formulas.evaluated.iter().enumerate() {
            if combination.states.iter().flatten().all(|weight| *weight == 0.0) {
                continue;
            }
            let mut alone = Step { weights: [0.0; 3], known: evaluated.clone(), ..step.clone() };
            alone.weights[place] = 1.0;
            let slope = match &directly {
                None => {
                    alone.known[place] = Field::zero(&self.space);
                    let form = self.form(interval, &alone)?;
                    self.equations.transposed(&*form, &evaluated[place], &adjoint)?
                }
                Some(directly) => {
                    alone.known[place] = evaluated[place].minus(&unknown)?;
                    let form = self.form(interval, &alone)?;
                    let mut slope = self.equations.transposed(&*form, &unknown, &adjoint)?;
                    add_scaled(&mut slope, -1.0, directly);
                    slope
                }
            };
            add_slope(combination, &slope, &mut by_before);
        }
        Ok(by_before)
    }

    /// T₀ᵀ p of a form that reads its unknown itself, with its tangent T₀ for weights zero; none of one that does not.
    fn read_directly(
        &mut self,
        interval: &Interval,
        step: &Step<D>,
        (unknown, evaluated): (&Field<D>, &[Field<D>; 3]),
        adjoint: &Field<D>,
    ) -> Result<Option<Vec<f64>>, HistoryFailure> {
        if self.reading == Reading::ByOperators {
            return Ok(None);
        }
        let fixed = Step { weights: [0.0; 3], known: evaluated.clone(), ..step.clone() };
        let form = self.form(interval, &fixed)?;
        if self.reading == Reading::Unseen
            && !reads_unknown_itself(&*form, unknown, evaluated, &self.equations.assembler)?
        {
            self.reading = if form.is_affine() { Reading::ByOperators } else { Reading::Unseen };
            return Ok(None);
        }
        self.reading = Reading::Itself;
        if self.scheme.reads_second_rates() {
            return Err(refused(&*form));
        }
        Ok(Some(self.equations.transposed(&*form, unknown, adjoint)?))
    }
}

impl<const D: usize> Evolution for MotionHistory<'_, D> {
    type Error = HistoryError;

    fn steps(&self) -> usize {
        self.steps
    }

    fn control_count(&self) -> usize {
        self.controls.values().len()
    }

    fn start(&mut self) -> Result<Vec<f64>, HistoryError> {
        let count = self.space.unknowns();
        let mut start = self.controls.start_values(Start::Value, count);
        start.extend(self.controls.start_values(Start::Rate, count));
        start.extend(vec![0.0; count]);
        if !self.scheme.reads_second_rates() {
            return Ok(start);
        }
        let start_formulas = of_start();
        let interval = Interval::at_start(&start_formulas);
        self.advance_by(&interval, &start).map_err(|why| why.at(0))
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        let formulas = self.scheme.formulas(&[self.size]);
        self.advance_by(&self.interval(step, &formulas), before).map_err(|why| why.at(step))
    }

    fn cost(&mut self, step: usize, _: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        let value = || {
            let after = self.value_in(after)?;
            let at = At::new(&self.controls, step, None);
            self.criterion.value(&at, &self.equations.assembler, &after)
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
            let at = At::new(&self.controls, step, None);
            let own = &mut slope[..value.values().len()];
            self.criterion.add_slope(&at, &self.equations.assembler, &value, own)?;
            let formulas = self.scheme.formulas(&[self.size]);
            self.reverse_by(&self.interval(step, &formulas), [before, after], &slope, gradient)
        };
        reverse().map_err(|why| why.at(step))
    }

    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        let count = self.space.unknowns();
        let mut slope = slope.to_vec();
        if self.scheme.reads_second_rates() {
            let start_formulas = of_start();
            let interval = Interval::at_start(&start_formulas);
            slope = self.reverse_by(&interval, [start, start], &slope, gradient).map_err(|why| why.at(0))?;
        }
        self.controls.add_start(Start::Value, &slope[..count], gradient);
        self.controls.add_start(Start::Rate, &slope[count..2 * count], gradient);
        Ok(())
    }
}

choices_of!(MotionHistory, constrained_at f64, "the time at the end of a step");

compiled_here!(
    MotionHistory::<D>::of,
    MotionHistory::<D>::gradient,
    MotionHistory::<D>::advance_by,
    MotionHistory::<D>::reverse_by,
);
