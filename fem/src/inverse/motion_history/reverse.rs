//! A step of a motion backwards: its adjoint state, and derivatives by the row before it and by the controls.

use super::{MotionHistory, Reading, coefficients};
use crate::field::Field;
use crate::inverse::error::HistoryFailure;
use crate::inverse::sensitivities::{
    BEFORE, OF_BEFORE, OPERATORS, Own, Wanted, is_tested, names_of, names_of_unknowns, rows_of,
};
use crate::inverse::step_equations::Solution;
use crate::inverse::step_map::{StepMap, reads_states};
use crate::inverse::steps_unknown::{Evaluated, evaluated, fixed, refused, unknown_read_itself};
use crate::linear_algebra::vector::add_scaled;
use crate::time::Step;

impl<const D: usize> MotionHistory<'_, D> {
    /// The slope by the row before a step from that by the row after it.
    #[inline(never)]
    pub(super) fn reverse_by(
        &mut self,
        interval: &StepMap,
        [before, after]: [&[f64]; 2],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let steps = interval.steps_from(&self.unknowns_on(), before)?;
        let unknowns = interval.unknowns_of(&self.unknowns_on(), before, after)?;
        let load = interval.slope_by_unknowns(slope);
        let mut by_before = interval.slope_before(slope);
        let conditions = self.conditions(interval)?;
        if interval.solution == Solution::Start {
            self.see_reading(interval, &steps, &unknowns)?;
        }
        let Some(masses) = interval.masses(before) else {
            let form = self.form(interval, &steps)?;
            let adjoint = self.equations.adjoint(interval.solution, &form, &conditions, &unknowns, &load)?;
            self.add_derivatives((interval, &steps), [&unknowns, &adjoint], gradient, &mut by_before)?;
            return Ok(by_before);
        };
        let adjoint = self.divided(&load, masses, &conditions)?;
        self.add_derivatives((interval, &steps), [&self.zero(), &adjoint], gradient, &mut by_before)?;
        interval.add_by_masses([&unknowns, &adjoint], &mut by_before);
        Ok(by_before)
    }

    /// The names of the unknowns of a step's form.
    pub(super) fn names(
        &self,
        interval: &StepMap,
        steps: &[Step<D>],
    ) -> Result<Vec<&'static str>, HistoryFailure> {
        Ok(names_of_unknowns(&self.form(interval, steps)?))
    }

    /// Adds the derivatives of a step's residual R(u; p) by the controls to the gradient, and those by the row of states before the step to the slope
    /// by that row.
    pub(super) fn add_derivatives(
        &mut self,
        (interval, steps): (&StepMap, &[Step<D>]),
        [u, p]: [&[Field<D>]; 2],
        gradient: &mut [f64],
        by_before: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        let names = self.names(interval, steps)?;
        let wanted = Wanted::when(self.before_is_read.get());
        let rates = self.sensitivities.as_ref().ok_or(HistoryFailure::Missing("sensitivities"))?;
        let rates = rates(&self.during(interval, steps), u, p)?;
        // What an operator evaluates of no known state, as the acceleration of explicit steps, has no derivative by one.
        let read = |unknown: usize, place: usize| reads_states(&interval.formulas[unknown].evaluated[place]);
        let of_operators = OPERATORS.map(|name| names_of(name, &names));
        let of_before = names_of(BEFORE, &names);
        let mut own = vec![];
        for (place, of_operator) in of_operators.iter().enumerate() {
            for (unknown, (name, space)) in of_operator.iter().zip(&self.spaces).enumerate() {
                let wanted = if read(unknown, place) { Wanted::IfTested } else { Wanted::No };
                own.push(Own { name, meaning: "", wanted, space });
            }
        }
        let before = of_before.iter().zip(&self.spaces);
        own.extend(before.map(|(name, space)| Own { name, meaning: OF_BEFORE, wanted, space }));
        let (constants, equations) = (self.equations.constants()?, &self.equations);
        let found = rows_of(&rates, &own, interval.step(), &self.controls, &constants, equations, gradient)?;
        let (given, before) = found.split_at(3 * names.len());
        add_scaled(&mut by_before[..interval.count()], 1.0, &before.concat());
        let mut by_tangents = vec![];
        for (place, of_operator) in of_operators.iter().enumerate() {
            for (unknown, name) in of_operator.iter().enumerate().filter(|(unknown, _)| read(*unknown, place))
            {
                if !is_tested(&rates, name) {
                    by_tangents.push((unknown, place));
                    continue;
                }
                let combination = &interval.formulas[unknown].evaluated[place];
                interval.add_slope(unknown, combination, &given[place * names.len() + unknown], by_before);
            }
        }
        if by_tangents.is_empty() {
            return Ok(());
        }
        let (evaluated, p) = (evaluated(steps, u)?, coefficients(p));
        let directly = self.read_directly(interval, steps, (u, &evaluated), &p)?;
        for place in 0..3 {
            let of_place = by_tangents.iter().filter(|(_, tested)| *tested == place);
            let unknowns: Vec<usize> = of_place.map(|(unknown, _)| *unknown).collect();
            if unknowns.is_empty() {
                continue;
            }
            let slope = self.by_tangent(interval, steps, (u, &evaluated), &p, place, directly.as_deref())?;
            for unknown in unknowns {
                let combination = &interval.formulas[unknown].evaluated[place];
                interval.add_slope(unknown, combination, &slope[interval.block(unknown)], by_before);
            }
        }
        Ok(())
    }

    /// The derivatives by the known parts of an operator of all unknowns: the tangent with the weights one there and zero of what is known, or
    /// of a form that reads an unknown itself, less what that gives. Unknowns may share weights.
    fn by_tangent(
        &mut self,
        interval: &StepMap,
        steps: &[Step<D>],
        (unknowns, evaluated): (&[Field<D>], &[Evaluated<D>]),
        adjoint: &[f64],
        place: usize,
        directly: Option<&[f64]>,
    ) -> Result<Vec<f64>, HistoryFailure> {
        let (mut only, mut at) = (fixed(steps, evaluated), unknowns.to_vec());
        for (unknown, (step, evaluated)) in only.iter_mut().zip(evaluated).enumerate() {
            step.weights[place] = 1.0;
            step.known[place] = match directly {
                None => {
                    at[unknown] = evaluated[place].clone();
                    Field::zero(&self.spaces[unknown])
                }
                Some(_) => evaluated[place].minus(&unknowns[unknown])?,
            };
        }
        let form = self.form(interval, &only)?;
        let mut slope = self.equations.transposed(&form, &at, adjoint)?;
        if let Some(directly) = directly {
            add_scaled(&mut slope, -1.0, directly);
        }
        Ok(slope)
    }

    /// T₀ᵀ p of a form that reads an unknown itself, with its tangent T₀ for weights zero; none of one that does not.
    fn read_directly(
        &mut self,
        interval: &StepMap,
        steps: &[Step<D>],
        (unknowns, evaluated): (&[Field<D>], &[Evaluated<D>]),
        adjoint: &[f64],
    ) -> Result<Option<Vec<f64>>, HistoryFailure> {
        self.see_reading(interval, steps, unknowns)?;
        let Reading::Itself(_) = self.reading else { return Ok(None) };
        let form = self.form(interval, &fixed(steps, evaluated))?;
        Ok(Some(self.equations.transposed(&form, unknowns, adjoint)?))
    }

    /// Looks whether the form reads an unknown itself, and refuses that with schemes that read second rates.
    pub(super) fn see_reading(
        &mut self,
        interval: &StepMap,
        steps: &[Step<D>],
        unknowns: &[Field<D>],
    ) -> Result<(), HistoryFailure> {
        if self.reading == Reading::Unseen {
            let evaluated = evaluated(steps, unknowns)?;
            let form = self.form(interval, &fixed(steps, &evaluated))?;
            let read = unknown_read_itself(&form, unknowns, &evaluated, &self.equations.assembler)?;
            // A process may have none of the integrals that read an unknown.
            let first = read.map_or(-(self.spaces.len() as f64), |unknown| -(unknown as f64));
            let first = -self.equations.processes().largest(form.name(), first)? as usize;
            if let Some(unknown) = Some(first).filter(|first| *first < self.spaces.len()) {
                self.reading = Reading::Itself(unknown);
            } else if form.is_affine() {
                self.reading = Reading::ByOperators;
            }
        }
        match self.reading {
            Reading::Itself(unknown) if self.reads_second_rates() => {
                Err(refused(&self.form(interval, steps)?, unknown))
            }
            _ => Ok(()),
        }
    }
}
