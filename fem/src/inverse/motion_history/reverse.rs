//! A step of a motion backwards: its adjoint state, and derivatives by the row before it and by the controls.

use super::{MotionHistory, Reading};
use crate::field::Field;
use crate::inverse::error::HistoryFailure;
use crate::inverse::sensitivities::{BEFORE, OF_BEFORE, OPERATORS, Own, Wanted, is_tested, rows};
use crate::inverse::step_equations::Solution;
use crate::inverse::step_map::{StepMap, reads_states};
use crate::inverse::steps_unknown::{evaluated, reads_unknown_itself, refused};
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
        let step = interval.step_from(&self.space, before)?;
        let unknown = interval.unknown_of(&self.space, before, after)?;
        let load = interval.slope_by_unknown(slope);
        let mut by_before = interval.slope_before(slope);
        let conditions = self.conditions(interval)?;
        if interval.solution == Solution::Start {
            self.see_reading(interval, &step, &unknown)?;
        }
        let Some(masses) = interval.masses(before) else {
            let form = self.form(interval, &step)?;
            let mut adjoint = self.equations.adjoint(
                interval.solution,
                &form,
                &[conditions],
                std::slice::from_ref(&unknown),
                &load,
            )?;
            let adjoint = adjoint.swap_remove(0);
            self.add_derivatives((interval, &step), [&unknown, &adjoint], gradient, &mut by_before)?;
            return Ok(by_before);
        };
        let adjoint = self.divided(&load, masses, &conditions)?;
        let zero = Field::zero(&self.space);
        self.add_derivatives((interval, &step), [&zero, &adjoint], gradient, &mut by_before)?;
        interval.add_by_masses([&unknown, &adjoint], &mut by_before);
        Ok(by_before)
    }

    /// Adds the derivatives of a step's residual R(u; p) by the controls to the gradient, and those by the row of states before the step to the slope
    /// by that row.
    pub(super) fn add_derivatives(
        &mut self,
        (interval, step): (&StepMap, &Step<D>),
        [u, p]: [&Field<D>; 2],
        gradient: &mut [f64],
        by_before: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        let wanted = Wanted::when(self.before_is_read.get());
        let rates = self.sensitivities.as_ref().ok_or(HistoryFailure::Missing("sensitivities"))?;
        let rates = rates(&self.during(interval, step), u, p)?;
        // What an operator evaluates of no known state, as the acceleration of explicit steps, has no derivative by one.
        let read = interval.formulas.evaluated.each_ref().map(reads_states);
        let of_operator = |place: usize| {
            let wanted = if read[place] { Wanted::IfTested } else { Wanted::No };
            Own { name: OPERATORS[place], meaning: "", wanted, space: &self.space }
        };
        let [value, rate, second_rate] = [0, 1, 2].map(of_operator);
        let own =
            [value, rate, second_rate, Own { name: BEFORE, meaning: OF_BEFORE, wanted, space: &self.space }];
        let (constants, assembler) = (self.equations.constants()?, &self.equations.assembler);
        let [given @ .., before] =
            rows(&rates, &own, interval.step(), &self.controls, &constants, assembler, gradient)?;
        add_scaled(&mut by_before[..interval.unknowns], 1.0, &before);
        let tested = OPERATORS.map(|name| is_tested(&rates, name));
        let (by_rows, by_tangents): (Vec<usize>, Vec<usize>) =
            (0..3).filter(|place| read[*place]).partition(|place| tested[*place]);
        for place in by_rows {
            interval.add_slope(&interval.formulas.evaluated[place], &given[place], by_before);
        }
        if by_tangents.is_empty() {
            return Ok(());
        }
        let evaluated = evaluated(step, u)?;
        let directly = self.read_directly(interval, step, (u, &evaluated), p)?;
        for place in by_tangents {
            let slope = self.by_tangent(interval, step, (u, &evaluated), p, place, directly.as_deref())?;
            interval.add_slope(&interval.formulas.evaluated[place], &slope, by_before);
        }
        Ok(())
    }

    /// The derivative by the known part of an operator: the tangent with the weight one there and zero of what is known of it, or of a form
    /// that reads its unknown itself, less what that gives.
    fn by_tangent(
        &mut self,
        interval: &StepMap,
        step: &Step<D>,
        (unknown, evaluated): (&Field<D>, &[Field<D>; 3]),
        adjoint: &Field<D>,
        place: usize,
        directly: Option<&[f64]>,
    ) -> Result<Vec<f64>, HistoryFailure> {
        let mut alone = Step { weights: [0.0; 3], known: evaluated.clone(), ..step.clone() };
        alone.weights[place] = 1.0;
        let Some(directly) = directly else {
            alone.known[place] = Field::zero(&self.space);
            let form = self.form(interval, &alone)?;
            return self.equations.transposed(&form, &evaluated[place], adjoint);
        };
        alone.known[place] = evaluated[place].minus(unknown)?;
        let form = self.form(interval, &alone)?;
        let mut slope = self.equations.transposed(&form, unknown, adjoint)?;
        add_scaled(&mut slope, -1.0, directly);
        Ok(slope)
    }

    /// T₀ᵀ p of a form that reads its unknown itself, with its tangent T₀ for weights zero; none of one that does not.
    fn read_directly(
        &mut self,
        interval: &StepMap,
        step: &Step<D>,
        (unknown, evaluated): (&Field<D>, &[Field<D>; 3]),
        adjoint: &Field<D>,
    ) -> Result<Option<Vec<f64>>, HistoryFailure> {
        self.see_reading(interval, step, unknown)?;
        if self.reading != Reading::Itself {
            return Ok(None);
        }
        let fixed = Step { weights: [0.0; 3], known: evaluated.clone(), ..step.clone() };
        let form = self.form(interval, &fixed)?;
        Ok(Some(self.equations.transposed(&form, unknown, adjoint)?))
    }

    /// Looks whether the form reads its unknown itself, and refuses that with schemes that read second rates.
    pub(super) fn see_reading(
        &mut self,
        interval: &StepMap,
        step: &Step<D>,
        unknown: &Field<D>,
    ) -> Result<(), HistoryFailure> {
        if self.reading == Reading::Unseen {
            let evaluated = evaluated(step, unknown)?;
            let fixed = Step { weights: [0.0; 3], known: evaluated.clone(), ..step.clone() };
            let form = self.form(interval, &fixed)?;
            if reads_unknown_itself(&form, unknown, &evaluated, &self.equations.assembler)? {
                self.reading = Reading::Itself;
            } else if form.is_affine() {
                self.reading = Reading::ByOperators;
            }
        }
        if self.reading == Reading::Itself && self.scheme.reads_second_rates() {
            return Err(refused(&self.form(interval, step)?));
        }
        Ok(())
    }
}
