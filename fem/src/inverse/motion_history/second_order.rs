//! Hessians of motions along a direction, as those of load histories, with value, rate and second rate as the state.
//!
//! A form of motion is a function of what the operators of [`time`](crate::time) evaluate, e = w x + k with the step's unknown x, and its
//! derivative by a known part k is that by e. With the work F(e, m; p) of a step the changes along d are F_x δx = −F_e δk − F_m d, and
//! backwards F_xᵀ δp = −δ(load) − Σ w δ(F_eᵀ p).

use super::{MotionHistory, Reading, coefficients};
use crate::assemble::Parts;
use crate::contract::Form;
use crate::field::{Field, fields_on};
use crate::instantiate::instantiate;
use crate::inverse::controls::{ControlError, ControlValues, Controls};
use crate::inverse::error::HistoryFailure;
use crate::inverse::evolution::Evolution;
use crate::inverse::sensitivities::{OPERATORS, Own, Wanted, is_tested, names_of, rows_of};
use crate::inverse::step_context::StepContext;
use crate::inverse::step_equations::views;
use crate::inverse::step_map::StepMap;
use crate::inverse::steps_unknown::{Evaluated, evaluated};
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

/// The fields of several unknowns that a form of second rates of a motion reads, one for each unknown.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderMotions<'f, const D: usize> {
    /// The step's unknowns u.
    pub u: &'f [Field<D>],
    /// The adjoint states p.
    pub p: &'f [Field<D>],
    /// The changes of value, rate and second rate that the operators evaluate of each unknown, along the direction.
    pub changes: &'f [[Field<D>; 3]],
    /// The changes of p.
    pub dp: &'f [Field<D>],
    /// The direction: numbers and fields by the names of their controls.
    pub along: ControlValues<'f, D>,
}

pub(super) type SecondSensitivitiesOf<'a, const D: usize> =
    Box<dyn Fn(&StepContext<D>, &SecondOrderMotions<D>) -> Result<Form<D>, ControlError> + 'a>;

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
        self.second_sensitivities = Some(Box::new(move |during, all| {
            let SecondOrderMotions { u, p, changes, dp, along } = *all;
            let changes = changes[0].each_ref();
            Ok(form(during, &SecondOrderMotion { u: &u[0], p: &p[0], changes, dp: &dp[0], along })?.into())
        }));
        self
    }

    /// [`Self::second_sensitivities`] of several unknowns: with test functions `by_value_u`, `by_rate_u`, `by_second_rate_u` and
    /// `by_adjoint_u` for the unknown `u`, and so on.
    pub fn coupled_second_sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&StepContext<D>, &SecondOrderMotions<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.second_sensitivities = Some(Box::new(move |during, states| Ok(form(during, states)?.into())));
        self
    }

    /// The rows of the second sensitivities by the evaluated known parts and by the adjoint states; those by the controls are added to `action`.
    fn second_rows(
        &mut self,
        along: &Controls<D>,
        (interval, steps): (&StepMap, &[Step<D>]),
        [u, p, dp]: [&[Field<D>]; 3],
        changes: &[Evaluated<D>],
        action: &mut [f64],
    ) -> Result<SecondRows, HistoryFailure> {
        let form = self.form(interval, steps)?;
        if self.before_is_read.get() || matches!(self.reading, Reading::Itself(_)) {
            return Err(HistoryFailure::BesideOperators { form: form.name() });
        }
        let along = ControlValues::new(along, interval.step(), None);
        let states = SecondOrderMotions { u, p, changes, dp, along };
        let second =
            self.second_sensitivities.as_ref().ok_or(HistoryFailure::Missing("second_sensitivities"))?;
        let second = second(&self.during(interval, steps), &states)?;
        let names = self.names(interval, steps)?;
        let (of_operators, of_adjoints) =
            (OPERATORS.map(|name| names_of(name, &names)), names_of(ADJOINT, &names));
        let mut own = vec![];
        for (unknown, space) in self.spaces.iter().enumerate() {
            for (place, names) in of_operators.iter().enumerate() {
                let (name, meaning) = (&names[unknown], "the derivative by what is evaluated changes");
                let untested = !is_tested(&second, name);
                let wanted = Wanted::when(untested && self.reads(interval, steps, u, [unknown, place])?);
                own.push(Own { name, meaning, wanted, space });
            }
        }
        let (meaning, wanted) = ("the equations of the step change", Wanted::Yes);
        let adjoints = of_adjoints.iter().zip(&self.spaces);
        own.extend(adjoints.map(|(name, space)| Own { name, meaning, wanted, space }));
        let constants = self.equations.constants()?;
        let equations = &self.equations;
        let found = rows_of(&second, &own, interval.step(), &self.controls, &constants, equations, action)?;
        let (by_evaluated, by_adjoint) = found.split_at(3 * self.spaces.len());
        let by_evaluated = by_evaluated.as_chunks().0.to_vec();
        Ok(SecondRows { by_evaluated, by_adjoint: by_adjoint.concat() })
    }

    /// Whether the form depends on value, rate or second rate of an unknown: whether another known part gives another residual.
    fn reads(
        &self,
        interval: &StepMap,
        steps: &[Step<D>],
        unknowns: &[Field<D>],
        [unknown, place]: [usize; 2],
    ) -> Result<bool, HistoryFailure> {
        let mut other = steps.to_vec();
        let known = steps[unknown].known[place].values();
        let scale = 1.0 + largest(known);
        let moved = known.iter().enumerate();
        let moved = moved.map(|(k, value)| value + scale * (1.0 + 1.7 * k as f64).sin()).collect();
        other[unknown].known[place] = Field::from_values(&self.spaces[unknown], moved)?;
        let residual = |steps: &[Step<D>]| -> Result<Vec<f64>, HistoryFailure> {
            let form = self.form(interval, steps)?;
            let (assembler, spaces) = (&self.equations.assembler, self.unknowns_on());
            Ok(assembler.residual_of(&form, &views(unknowns), &spaces, Parts::ALL)?)
        };
        let differ = residual(steps)? != residual(&other)?;
        Ok(self.equations.processes().any("a motion", differ)?)
    }

    /// x with F_x x = −load or F_xᵀ x = −load.
    fn linearised(
        &mut self,
        (interval, steps): (&StepMap, &[Step<D>]),
        unknowns: &[Field<D>],
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let (form, conditions) = (self.form(interval, steps)?, self.conditions(interval)?);
        self.equations.linearised(interval.solution, &form, &conditions, unknowns, load, transpose)
    }

    /// The steps from a row and from the change of it.
    fn changing(&self, interval: &StepMap, rows: [&[f64]; 2]) -> Result<[Vec<Step<D>>; 2], HistoryFailure> {
        let [steps, changing] = rows.map(|row| interval.steps_from(&self.unknowns_on(), row));
        Ok([steps?, changing?])
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
        let [steps, changing] = self.changing(interval, [before, change])?;
        let (unknowns, zero) = (interval.unknowns_of(&self.unknowns_on(), before, &after)?, self.zero());
        let mut unused = vec![0.0; self.control_count()];
        let (at, changes) = (interval.masses(before).map_or(&unknowns, |_| &zero), known(&changing));
        let rows = self.second_rows(along, (interval, &steps), [at, &zero, &zero], &changes, &mut unused)?;
        let mut load = rows.by_adjoint;
        let change_of_unknowns = match interval.masses(before) {
            None => self.linearised((interval, &steps), &unknowns, &load, Transpose::No)?,
            Some(masses) => {
                let dmasses = interval.masses(change).unwrap_or_default();
                add_products(&mut load, dmasses, &coefficients(&unknowns));
                self.divided(&load, masses, &self.conditions(interval)?)?
            }
        };
        after.extend(interval.end_of(change, &coefficients(&change_of_unknowns)));
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
        let [steps, changing] = self.changing(interval, [before, dbefore])?;
        let unknowns = interval.unknowns_of(&self.unknowns_on(), before, after)?;
        let dunknowns = interval.unknowns_of(&self.unknowns_on(), dbefore, dafter)?;
        self.see_reading(interval, &steps, &unknowns)?;
        let lumped = match (interval.masses(before), interval.masses(dbefore)) {
            (Some(masses), Some(dmasses)) => Some((masses, dmasses, self.conditions(interval)?)),
            _ => None,
        };
        let zero = self.zero();
        // With lumped masses the form is evaluated at the second rate zero.
        let (at, changes) = match &lumped {
            None => (&unknowns, evaluated(&changing, &dunknowns)?),
            Some(_) => (&zero, known(&changing)),
        };
        let adjoint = |history: &mut Self, load: &[f64]| match &lumped {
            None => history.linearised((interval, &steps), &unknowns, load, Transpose::Yes),
            Some((masses, _, conditions)) => history.divided(load, masses, conditions),
        };
        let p = adjoint(self, &interval.slope_by_unknowns(slope))?;
        // Without a change of p first, which is found from it.
        let mut unused = vec![0.0; action.len()];
        let rows = self.second_rows(along, (interval, &steps), [at, &p, &zero], &changes, &mut unused)?;
        let mut load = interval.slope_by_unknowns(change);
        match &lumped {
            Some((_, dmasses, _)) => add_products(&mut load, dmasses, &coefficients(&p)),
            None => {
                for (unknown, (step, rows)) in steps.iter().zip(&rows.by_evaluated).enumerate() {
                    for (weight, row) in step.weights.iter().zip(rows) {
                        add_scaled(&mut load[interval.block(unknown)], *weight, row);
                    }
                }
            }
        }
        let dp = adjoint(self, &load)?;
        let rows = self.second_rows(along, (interval, &steps), [at, &p, &dp], &changes, action)?;
        let mut change_before = interval.slope_before(change);
        interval.add_slopes_by_evaluated(&rows.by_evaluated, &mut change_before);
        if lumped.is_some() {
            interval.add_by_masses([&unknowns, &dp], &mut change_before);
            interval.add_by_masses([&dunknowns, &p], &mut change_before);
        }
        by_before.extend(change_before);
        Ok(by_before)
    }

    /// The change of the masses at a start.
    fn masses_along(&mut self, along: &Controls<D>, start: [&[f64]; 2]) -> Result<Vec<f64>, HistoryFailure> {
        let interval = self.interval_at_start();
        let ([steps, changing], zero) = (self.changing(&interval, start)?, self.zero());
        let mut unused = vec![0.0; self.control_count()];
        let changes = known(&changing);
        let mut at = |u: &[Field<D>]| {
            self.second_rows(along, (&interval, &steps), [u, &zero, &zero], &changes, &mut unused)
        };
        let ones = vec![1.0; interval.count()];
        let ones = fields_on(&zero.iter().map(Field::space).collect::<Vec<_>>(), &ones)?;
        let (mut masses, without) = (at(&ones)?.by_adjoint, at(&zero)?.by_adjoint);
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
        let [steps, changing] = self.changing(&interval, start)?;
        let (own, changes) = (3 * interval.states * interval.count(), known(&changing));
        let tests = self.masses_tested_with(&slope[own..])?.into_iter();
        for ([u, p], [_, dp]) in tests.zip(self.masses_tested_with(&change[own..])?) {
            let rows = self.second_rows(along, (&interval, &steps), [&u, &p, &dp], &changes, action)?;
            interval.add_slopes_by_evaluated(&rows.by_evaluated, change);
        }
        Ok(())
    }
}

/// Rows of second sensitivities.
struct SecondRows {
    /// Of each unknown, by value, rate and second rate.
    by_evaluated: Vec<[Vec<f64>; 3]>,
    /// Of all unknowns, one after the other.
    by_adjoint: Vec<f64>,
}

/// The known parts of steps.
fn known<const D: usize>(steps: &[Step<D>]) -> Vec<Evaluated<D>> {
    steps.iter().map(|step| step.known.clone()).collect()
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
        match self.reads_second_rates() {
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
        if self.reads_second_rates() {
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
