//! Hessians of motions along a direction, as those of load histories, with value, rate and second rate as the state.
//!
//! A form of motion is a function of what the operators of [`time`](crate::time) evaluate, e = w x + k with the step's unknown x, and its
//! derivative by a known part k is that by e. With the work F(e, m; p) of a step the changes along d are F_x δx = −F_e δk − F_m d, and
//! backwards F_xᵀ δp = −δ(load) − Σ w δ(F_eᵀ p).

use super::{MotionHistory, Reading};
use crate::assemble::Parts;
use crate::compiled_here::compiled_here;
use crate::contract::Form;
use crate::field::Field;
use crate::inverse::changing::{Changing, Linearised, halves};
use crate::inverse::controls::{At, ControlError, Controls, Start};
use crate::inverse::during::{During, Interval, add_slope, of_start};
use crate::inverse::error::{HistoryError, HistoryFailure};
use crate::inverse::evolution::Evolution;
use crate::inverse::rates::{BY, Own, rows};
use crate::inverse::second_order::{Hessian, SecondOrder, TwiceDifferentiable};
use crate::inverse::steps_unknown::evaluated;
use crate::inverse::sweep::gradient_stored;
use crate::linear_algebra::vector::{add_scaled, largest};
use crate::solve::Transpose;
use crate::solve::any_form::AnyForm;
use crate::time::Step;

/// The fields that a form of second rates of a motion reads.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderMotion<'f, const D: usize> {
    /// The step's unknown u.
    pub u: &'f Field<D>,
    /// The adjoint state p.
    pub p: &'f Field<D>,
    /// The changes of value, rate and second rate that the operators evaluate, along the direction.
    pub changes: [&'f Field<D>; 3],
    /// The change of p.
    pub dp: &'f Field<D>,
    /// The direction: numbers and fields by the names of their controls.
    pub along: At<'f, D>,
}

pub(super) type SecondRatesOf<'a, const D: usize> =
    Box<dyn Fn(&During<D>, &SecondOrderMotion<D>) -> Result<Box<dyn AnyForm<D> + 'a>, ControlError> + 'a>;

/// Arguments of operators, as test functions of the derivatives by it are named.
const OPERATORS: [&str; 3] = ["value", "rate", "second_rate"];
const ADJOINT: &str = "adjoint";

impl<'a, const D: usize> MotionHistory<'a, D> {
    /// The change of a step's rates: with the work R(u, m; p) of the step, the derivative of
    ///
    /// ```text
    /// derivative(work, known_value, by_value) + derivative(work, known_rate, by_rate)
    ///     + derivative(work, known_second_rate, by_second_rate) + derivative(work, p, by_adjoint)
    ///     + derivative(work, name, by_name) + …                        // a term for each control
    /// ```
    ///
    /// by `known_value`, `known_rate` and `known_second_rate` along the three `changes`, by p along `dp`, and by each control along its
    /// direction, each by `derivative`; known parts that the form does not read are left out. The form reads its unknown, and the state
    /// before, by the operators of [`time`](crate::time) alone.
    pub fn second_rates<F: Form<D> + 'a>(
        mut self,
        form: impl Fn(&During<D>, &SecondOrderMotion<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.second_rates = Some(Box::new(move |during, states| Ok(Box::new(form(during, states)?))));
        self
    }

    /// J with its gradient and its Hessian applied to a direction, exact for the discrete equations where no switch of the form changes.
    /// States and their changes count as one for `stored_states`.
    ///
    /// # Errors
    /// [`HistoryError`], which names the step.
    #[inline(never)]
    pub fn hessian(&mut self, m: &[f64], direction: &[f64]) -> Result<Hessian, HistoryError> {
        let along = self.begin_along(m, direction).map_err(|why| why.at(0))?;
        let storage = self.storage.clone();
        let found = gradient_stored(&mut Changing { history: &mut *self, along }, &storage)?;
        self.criterion.hessian(found, m, direction).map_err(|why| why.at(0))
    }

    /// The direction as values of the controls.
    fn begin_along(&mut self, m: &[f64], direction: &[f64]) -> Result<Controls<D>, HistoryFailure> {
        self.begin(m).and_then(|()| self.criterion.exists())?;
        self.controls
            .directed(direction, &[&OPERATORS[..], &[ADJOINT]].concat())
            .map_err(HistoryFailure::from)
    }

    /// The rows of the second rates by what is evaluated and by the adjoint state; those by the controls are added to `action`.
    fn second_rows(
        &mut self,
        along: &Controls<D>,
        (interval, step): (&Interval, &Step<D>),
        [u, p, dp]: [&Field<D>; 3],
        changes: &[Field<D>; 3],
        action: &mut [f64],
    ) -> Result<[Vec<f64>; 4], HistoryFailure> {
        let form = self.form(interval, step)?;
        if self.before_is_read.get() || self.reading == Reading::Itself {
            return Err(HistoryFailure::BesideOperators { form: form.name() });
        }
        let along = At::new(along, interval.step(), None);
        let states = SecondOrderMotion { u, p, changes: changes.each_ref(), dp, along };
        let second = self.second_rates.as_ref().ok_or(HistoryFailure::Missing("second_rates"))?;
        let second = second(&self.during(interval, step), &states)?;
        let mut own = OPERATORS.map(|name| Own {
            name,
            meaning: "the derivative by what is evaluated changes",
            wanted: false,
        });
        for (place, own) in own.iter_mut().enumerate() {
            let is_tested = second.fields().iter().any(|field| field.name.strip_prefix(BY) == Some(own.name));
            own.wanted = !is_tested && self.reads(interval, step, u, place)?;
        }
        let adjoint = Own { name: ADJOINT, meaning: "the equations of the step change", wanted: true };
        let [value, rate, second_rate] = own;
        let spaces = [&self.space, &self.equations.constants()?];
        let own = [value, rate, second_rate, adjoint];
        rows(&*second, &own, interval.step(), &self.controls, spaces, &self.equations.assembler, action)
    }

    /// Whether the form depends on value, rate or second rate: whether another known part gives another residual.
    fn reads(
        &self,
        interval: &Interval,
        step: &Step<D>,
        unknown: &Field<D>,
        place: usize,
    ) -> Result<bool, HistoryFailure> {
        let mut other = step.clone();
        let scale = 1.0 + largest(step.known[place].values());
        let known = step.known[place].values().iter().enumerate();
        let moved = known.map(|(k, value)| value + scale * (1.0 + 1.7 * k as f64).sin()).collect();
        other.known[place] = Field::from_values(&self.space, moved)?;
        let residual = |step: &Step<D>| -> Result<Vec<f64>, HistoryFailure> {
            let form = self.form(interval, step)?;
            Ok(form.residual(&self.equations.assembler, &[unknown.view()], &[&self.space], Parts::ALL)?)
        };
        Ok(residual(step)? != residual(&other)?)
    }

    /// x with F_x x = −load or F_xᵀ x = −load.
    fn linearised(
        &mut self,
        (interval, step): (&Interval, &Step<D>),
        unknown: &Field<D>,
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Field<D>, HistoryFailure> {
        let (form, conditions) = (self.form(interval, step)?, self.conditions(interval)?);
        self.equations.linearised(interval.solution, &*form, &conditions, unknown, load, transpose)
    }

    #[inline(never)]
    fn advance_along_by(
        &mut self,
        along: &Controls<D>,
        interval: &Interval,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let (before, change) = halves(before);
        let mut after = self.advance_by(interval, before)?;
        let [step, changing] = [before, change].map(|row| interval.step_from(&self.space, row));
        let (step, changing) = (step?, changing?);
        let (unknown, zero) = (interval.unknown_of(&step.before, &after)?, Field::zero(&self.space));
        let mut unused = vec![0.0; self.control_count()];
        let states = [&unknown, &zero, &zero];
        let [.., load] = self.second_rows(along, (interval, &step), states, &changing.known, &mut unused)?;
        let change = self.linearised((interval, &step), &unknown, &load, Transpose::No)?;
        after.extend(interval.end_of(&changing.before, &change)?);
        Ok(after)
    }

    #[inline(never)]
    fn reverse_along_by(
        &mut self,
        along: &Controls<D>,
        interval: &Interval,
        [before, after]: [&[f64]; 2],
        [slope, change]: [&[f64]; 2],
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let (gradient, action) = gradient.split_at_mut(gradient.len() / 2);
        let ((before, dbefore), (after, dafter)) = (halves(before), halves(after));
        let mut by_before = self.reverse_by(interval, [before, after], slope, gradient)?;
        let [step, changing] = [before, dbefore].map(|row| interval.step_from(&self.space, row));
        let (step, changing) = (step?, changing?);
        let unknown = interval.unknown_of(&step.before, after)?;
        let changes = evaluated(&changing, &interval.unknown_of(&changing.before, dafter)?)?;
        let load = interval.slope_by_unknown(slope);
        let p = self.linearised((interval, &step), &unknown, &load, Transpose::Yes)?;
        // Without a change of p first, which is found from it.
        let zero = Field::zero(&self.space);
        let mut unused = vec![0.0; action.len()];
        let states = [&unknown, &p, &zero];
        let by_evaluated = self.second_rows(along, (interval, &step), states, &changes, &mut unused)?;
        let mut load = interval.slope_by_unknown(change);
        for (weight, row) in step.weights.iter().zip(&by_evaluated) {
            add_scaled(&mut load, *weight, row);
        }
        let dp = self.linearised((interval, &step), &unknown, &load, Transpose::Yes)?;
        let states = [&unknown, &p, &dp];
        let by_evaluated = self.second_rows(along, (interval, &step), states, &changes, action)?;
        let count = self.space.unknowns();
        let mut change_before = vec![0.0; 3 * count];
        let of_end = interval.formulas.end.iter().zip(change.chunks(count));
        of_end.for_each(|(combination, slope)| add_slope(combination, slope, &mut change_before));
        let of_evaluated = interval.formulas.evaluated.iter().zip(&by_evaluated);
        of_evaluated.for_each(|(combination, slope)| add_slope(combination, slope, &mut change_before));
        by_before.extend(change_before);
        Ok(by_before)
    }
}

impl<const D: usize> Linearised<D> for MotionHistory<'_, D> {
    fn start_along(&mut self, along: &Controls<D>) -> Result<Vec<f64>, HistoryError> {
        let count = self.space.unknowns();
        let mut start = vec![];
        for controls in [&self.controls, along] {
            start.extend(controls.start_values(Start::Value, count));
            start.extend(controls.start_values(Start::Rate, count));
            start.extend(vec![0.0; count]);
        }
        if !self.scheme.reads_second_rates() {
            return Ok(start);
        }
        let formulas = of_start();
        self.advance_along_by(along, &Interval::at_start(&formulas), &start).map_err(|why| why.at(0))
    }

    fn advance_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryError> {
        let formulas = self.scheme.formulas(&[self.size]);
        let interval = self.interval(step, &formulas);
        self.advance_along_by(along, &interval, before).map_err(|why| why.at(step))
    }

    fn reverse_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        [before, after]: [&[f64]; 2],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        let mut reverse = || {
            let (mut slope, mut change) = (halves(slope).0.to_vec(), halves(slope).1.to_vec());
            let [value, dvalue] = [halves(after).0, halves(after).1].map(|row| self.value_in(row));
            let (value, dvalue) = (value?, dvalue?);
            let (at, assembler) = (At::new(&self.controls, step, None), &self.equations.assembler);
            let count = value.values().len();
            self.criterion.add_slope(&at, assembler, &value, &mut slope[..count])?;
            self.criterion.add_curvature(&at, assembler, [&value, &dvalue], &mut change[..count])?;
            let formulas = self.scheme.formulas(&[self.size]);
            let interval = self.interval(step, &formulas);
            self.reverse_along_by(along, &interval, [before, after], [&slope, &change], gradient)
        };
        reverse().map_err(|why: HistoryFailure| why.at(step))
    }

    fn reverse_start_along(
        &mut self,
        along: &Controls<D>,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        let mut slope = slope.to_vec();
        if self.scheme.reads_second_rates() {
            let formulas = of_start();
            let (interval, slopes) = (Interval::at_start(&formulas), halves(&slope));
            let found =
                self.reverse_along_by(along, &interval, [start, start], [slopes.0, slopes.1], gradient);
            slope = found.map_err(|why| why.at(0))?;
        }
        let (gradient, action) = gradient.split_at_mut(gradient.len() / 2);
        for (slope, gradient) in [(halves(&slope).0, gradient), (halves(&slope).1, action)] {
            let count = slope.len() / 3;
            self.controls.add_start(Start::Value, &slope[..count], gradient);
            self.controls.add_start(Start::Rate, &slope[count..2 * count], gradient);
        }
        Ok(())
    }
}

impl<const D: usize> TwiceDifferentiable for MotionHistory<'_, D> {
    fn second_order(&mut self, m: &[f64], direction: &[f64]) -> Result<SecondOrder, HistoryError> {
        Ok(self.hessian(m, direction)?.into())
    }
}

compiled_here!(
    MotionHistory::<D>::hessian,
    MotionHistory::<D>::advance_along_by,
    MotionHistory::<D>::reverse_along_by,
);
