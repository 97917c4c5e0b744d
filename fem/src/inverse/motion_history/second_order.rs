//! Hessians of motions along a direction, as those of load histories, with value, rate and second rate as the state.
//!
//! A form of motion is a function of what the operators of [`time`](crate::time) evaluate, e = w x + k with the step's unknown x, and its
//! derivative by a known part k is that by e. With the work F(e, m; p) of a step the changes along d are F_x δx = −F_e δk − F_m d, and
//! backwards F_xᵀ δp = −δ(load) − Σ w δ(F_eᵀ p).

use super::{MotionHistory, Reading};
use crate::assemble::Parts;
use crate::contract::Form;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::inverse::controls::{ControlError, ControlValues, Controls};
use crate::inverse::error::HistoryFailure;
use crate::inverse::evolution::Evolution;
use crate::inverse::sensitivities::{OPERATORS, Own, Wanted, is_tested, rows};
use crate::inverse::step_context::StepContext;
use crate::inverse::step_map::StepMap;
use crate::inverse::steps_unknown::evaluated;
use crate::inverse::tangent_state::{Linearised, halves};
use crate::linear_algebra::vector::{add_scaled, largest};
use crate::solve::Transpose;
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
    pub along: ControlValues<'f, D>,
}

pub(super) type SecondSensitivitiesOf<'a, const D: usize> =
    Box<dyn Fn(&StepContext<D>, &SecondOrderMotion<D>) -> Result<Form<D>, ControlError> + 'a>;

pub(super) const ADJOINT: &str = "adjoint";

impl<'a, const D: usize> MotionHistory<'a, D> {
    /// The change of a step's sensitivities: with the work R(u, m; p) of the step, the derivative of
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
    pub fn second_sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&StepContext<D>, &SecondOrderMotion<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.second_sensitivities = Some(Box::new(move |during, states| Ok(form(during, states)?.into())));
        self
    }

    /// The rows of the second sensitivities by the evaluated known parts and by the adjoint state; those by the controls are added to `action`.
    fn second_rows(
        &mut self,
        along: &Controls<D>,
        (interval, step): (&StepMap, &Step<D>),
        [u, p, dp]: [&Field<D>; 3],
        changes: &[Field<D>; 3],
        action: &mut [f64],
    ) -> Result<[Vec<f64>; 4], HistoryFailure> {
        let form = self.form(interval, step)?;
        if self.before_is_read.get() || self.reading == Reading::Itself {
            return Err(HistoryFailure::BesideOperators { form: form.name() });
        }
        let along = ControlValues::new(along, interval.step(), None);
        let states = SecondOrderMotion { u, p, changes: changes.each_ref(), dp, along };
        let second =
            self.second_sensitivities.as_ref().ok_or(HistoryFailure::Missing("second_sensitivities"))?;
        let second = second(&self.during(interval, step), &states)?;
        let mut own = OPERATORS.map(|name| Own {
            name,
            meaning: "the derivative by what is evaluated changes",
            wanted: Wanted::IfTested,
            space: &self.space,
        });
        for (place, own) in own.iter_mut().enumerate() {
            let untested = !is_tested(&second, own.name);
            own.wanted = Wanted::when(untested && self.reads(interval, step, u, place)?);
        }
        let meaning = "the equations of the step change";
        let adjoint = Own { name: ADJOINT, meaning, wanted: Wanted::Yes, space: &self.space };
        let [value, rate, second_rate] = own;
        let constants = self.equations.constants()?;
        let own = [value, rate, second_rate, adjoint];
        rows(&second, &own, interval.step(), &self.controls, &constants, &self.equations.assembler, action)
    }

    /// Whether the form depends on value, rate or second rate: whether another known part gives another residual.
    fn reads(
        &self,
        interval: &StepMap,
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
            let assembler = &self.equations.assembler;
            Ok(assembler.residual_of(&form, &[unknown.view()], &[&self.space], Parts::ALL)?)
        };
        Ok(residual(step)? != residual(&other)?)
    }

    /// x with F_x x = −load or F_xᵀ x = −load.
    fn linearised(
        &mut self,
        (interval, step): (&StepMap, &Step<D>),
        unknown: &Field<D>,
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Field<D>, HistoryFailure> {
        let (form, conditions) = (self.form(interval, step)?, self.conditions(interval)?);
        let at = std::slice::from_ref(unknown);
        let found = self.equations.linearised(interval.solution, &form, &[conditions], at, load, transpose);
        Ok(found?.swap_remove(0))
    }

    #[inline(never)]
    fn advance_along_by(
        &mut self,
        along: &Controls<D>,
        interval: &StepMap,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let [before, change] = halves(before);
        let mut after = self.advance_by(interval, before)?;
        let [step, changing] = [before, change].map(|row| interval.step_from(&self.space, row));
        let (step, changing) = (step?, changing?);
        let (unknown, zero) = (interval.unknown_of(&self.space, before, &after)?, Field::zero(&self.space));
        let mut unused = vec![0.0; self.control_count()];
        let Some(masses) = interval.masses(before) else {
            let states = [&unknown, &zero, &zero];
            let [.., load] =
                self.second_rows(along, (interval, &step), states, &changing.known, &mut unused)?;
            let dunknown = self.linearised((interval, &step), &unknown, &load, Transpose::No)?;
            after.extend(interval.end_of(change, dunknown.values()));
            return Ok(after);
        };
        let [.., mut load] =
            self.second_rows(along, (interval, &step), [&zero; 3], &changing.known, &mut unused)?;
        add_products(&mut load, interval.masses(change).unwrap_or_default(), unknown.values());
        let dunknown = self.divided(&load, masses, &self.conditions(interval)?)?;
        after.extend(interval.end_of(change, dunknown.values()));
        Ok(after)
    }

    #[inline(never)]
    fn reverse_along_by(
        &mut self,
        along: &Controls<D>,
        interval: &StepMap,
        [before, after]: [&[f64]; 2],
        [slope, change]: [&[f64]; 2],
        [gradient, action]: [&mut [f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let ([before, dbefore], [after, dafter]) = (halves(before), halves(after));
        let mut by_before = self.reverse_by(interval, [before, after], slope, gradient)?;
        let [step, changing] = [before, dbefore].map(|row| interval.step_from(&self.space, row));
        let (step, changing) = (step?, changing?);
        let unknown = interval.unknown_of(&self.space, before, after)?;
        let dunknown = interval.unknown_of(&self.space, dbefore, dafter)?;
        self.see_reading(interval, &step, &unknown)?;
        let lumped = match (interval.masses(before), interval.masses(dbefore)) {
            (Some(masses), Some(dmasses)) => Some((masses, dmasses, self.conditions(interval)?)),
            _ => None,
        };
        let zero = Field::zero(&self.space);
        // With lumped masses the form is evaluated at the second rate zero.
        let (at, weights, changes) = match &lumped {
            None => (&unknown, step.weights, evaluated(&changing, &dunknown)?),
            Some(_) => (&zero, [0.0; 3], changing.known),
        };
        let adjoint = |history: &mut Self, load: &[f64]| match &lumped {
            None => history.linearised((interval, &step), &unknown, load, Transpose::Yes),
            Some((masses, _, conditions)) => history.divided(load, masses, conditions),
        };
        let p = adjoint(self, &interval.slope_by_unknown(slope))?;
        // Without a change of p first, which is found from it.
        let mut unused = vec![0.0; action.len()];
        let by_evaluated =
            self.second_rows(along, (interval, &step), [at, &p, &zero], &changes, &mut unused)?;
        let mut load = interval.slope_by_unknown(change);
        for (weight, row) in weights.iter().zip(&by_evaluated) {
            add_scaled(&mut load, *weight, row);
        }
        if let Some((_, dmasses, _)) = &lumped {
            add_products(&mut load, dmasses, p.values());
        }
        let dp = adjoint(self, &load)?;
        let by_evaluated = self.second_rows(along, (interval, &step), [at, &p, &dp], &changes, action)?;
        let mut change_before = interval.slope_before(change);
        for (combination, slope) in interval.formulas.evaluated.iter().zip(&by_evaluated) {
            interval.add_slope(combination, slope, &mut change_before);
        }
        if lumped.is_some() {
            interval.add_by_masses([&unknown, &dp], &mut change_before);
            interval.add_by_masses([&dunknown, &p], &mut change_before);
        }
        by_before.extend(change_before);
        Ok(by_before)
    }

    /// The change of the masses at a start.
    fn masses_along(
        &mut self,
        along: &Controls<D>,
        [start, change]: [&[f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let interval = self.interval_at_start();
        let [step, changing] = [start, change].map(|row| interval.step_from(&self.space, row));
        let (step, changing, zero) = (step?, changing?, Field::zero(&self.space));
        let mut unused = vec![0.0; self.control_count()];
        let mut at = |u: &Field<D>| {
            self.second_rows(along, (&interval, &step), [u, &zero, &zero], &changing.known, &mut unused)
        };
        let ones = Field::from_values(zero.space(), vec![1.0; zero.values().len()])?;
        let ([.., mut masses], [.., without]) = (at(&ones)?, at(&zero)?);
        add_scaled(&mut masses, -1.0, &without);
        Ok(masses)
    }

    /// Adds the changes of the derivatives of the masses at a start.
    fn reverse_masses_along(
        &mut self,
        along: &Controls<D>,
        start: [&[f64]; 2],
        [slope, change]: [&mut [f64]; 2],
        action: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        let interval = self.interval_at_start();
        let [step, changing] = start.map(|row| interval.step_from(&self.space, row));
        let (step, changing) = (step?, changing?);
        let own = 3 * interval.states * interval.unknowns;
        let tests = self.masses_tested_with(&slope[own..])?.into_iter();
        for ((u, p), (_, dp)) in tests.zip(self.masses_tested_with(&change[own..])?) {
            let rows = self.second_rows(along, (&interval, &step), [&u, &p, &dp], &changing.known, action)?;
            for (combination, slope) in interval.formulas.evaluated.iter().zip(&rows) {
                interval.add_slope(combination, slope, change);
            }
        }
        Ok(())
    }
}

/// Adds the products of two vectors' entries.
fn add_products(sum: &mut [f64], one: &[f64], other: &[f64]) {
    sum.iter_mut().zip(one).zip(other).for_each(|((sum, one), other)| *sum += one * other);
}

impl<const D: usize> Linearised<D> for MotionHistory<'_, D> {
    fn start_along(&mut self, along: &Controls<D>) -> Result<Vec<f64>, HistoryFailure> {
        let [mut start, mut change] = [&self.controls, along].map(|controls| self.start_of(controls));
        if self.lumps() {
            let masses = self.masses_at(&start)?;
            let dmasses = self.masses_along(along, [&start, &change])?;
            start.extend(masses);
            change.extend(dmasses);
        }
        start.extend(change);
        match self.scheme.reads_second_rates() {
            true => self.advance_along_by(along, &self.interval_at_start(), &start),
            false => Ok(start),
        }
    }

    fn advance_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        self.advance_along_by(along, &self.interval(step)?, before)
    }

    fn reverse_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        pairs: [&[f64]; 2],
        slopes: [&[f64]; 2],
        gradients: [&mut [f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure> {
        self.reverse_along_by(along, &self.interval(step)?, pairs, slopes, gradients)
    }

    fn reverse_start_along(
        &mut self,
        along: &Controls<D>,
        start: &[f64],
        slope: &[f64],
        [gradient, action]: [&mut [f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let mut slope = slope.to_vec();
        if self.scheme.reads_second_rates() {
            let gradients = [&mut *gradient, &mut *action];
            let interval = self.interval_at_start();
            slope = self.reverse_along_by(along, &interval, [start; 2], halves(&slope), gradients)?;
        }
        let (slope, change) = slope.split_at_mut(start.len() / 2);
        if self.lumps() {
            self.reverse_masses_along(along, halves(start), [slope, change], action)?;
            self.reverse_masses(halves(start)[0], slope, gradient)?;
        }
        Ok([self.slope_by_start(slope.to_vec())?, self.slope_by_start(change.to_vec())?].concat())
    }
}

instantiate!(second_order: MotionHistory::<D>::advance_along_by, MotionHistory::<D>::reverse_along_by);
