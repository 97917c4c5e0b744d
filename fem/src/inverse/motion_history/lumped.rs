//! Lumped masses of a motion: equations R(0) + M x = 0 of a second rate x, with the diagonal matrix M of the row sums at the start.
//!
//! M is part of the rows of the sweep. Backwards each step adds x p to the slope by it, with its adjoint state p, and the derivatives of
//! the sum Q over all steps, M·Q = R(1; Q) − R(0; Q), are taken once, at the start.

use super::MotionHistory;
use crate::assemble::Parts;
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::field::Field;
use crate::inverse::error::HistoryFailure;
use crate::inverse::step_equations::reads_no_history;
use crate::inverse::step_map::StepMap;
use crate::time::mass::row_sums;
use crate::time::{Mass, SolvedFor, StepFailure};

impl StepMap {
    /// Adds the slope of M x·p by the masses to that by the row before.
    pub(super) fn add_by_masses<const D: usize>(&self, [x, p]: [&Field<D>; 2], by_before: &mut [f64]) {
        let by_masses = by_before[3 * self.states * self.unknowns..].iter_mut();
        by_masses.zip(x.values()).zip(p.values()).for_each(|((sum, x), p)| *sum += x * p);
    }
}

impl<const D: usize> MotionHistory<'_, D> {
    /// Whether rows have masses.
    pub(super) fn lumps(&self) -> bool {
        let second_rates =
            self.scheme.reads_second_rates() || self.scheme.solved_for() == SolvedFor::SecondRate;
        self.mass == Mass::Lumped && second_rates
    }

    /// The masses at a start.
    pub(super) fn masses_at(&mut self, start: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let interval = self.interval_at_start();
        let step = interval.step_from(&self.space, start)?;
        let form = self.form(&interval, &step)?;
        reads_no_history(&form)?;
        let matrix = self.equations.tangent(&form, &[Field::zero(&self.space)])?;
        Ok(row_sums(&matrix)?)
    }

    /// The second rate by the form's residual at zero.
    pub(super) fn by_masses(
        &self,
        form: &Form<D>,
        masses: &[f64],
        conditions: &Constraints<D>,
    ) -> Result<Field<D>, HistoryFailure> {
        let zero = Field::zero(&self.space);
        let load = self.equations.assembler.residual_of(form, &[zero.view()], &[&self.space], Parts::ALL)?;
        self.divided(&load, masses, conditions)
    }

    /// x with M x = −load, zero where it is prescribed.
    pub(super) fn divided(
        &self,
        load: &[f64],
        masses: &[f64],
        conditions: &Constraints<D>,
    ) -> Result<Field<D>, HistoryFailure> {
        if !conditions.relations().is_empty() {
            return Err(StepFailure::LumpedRelations.into());
        }
        let mut found: Vec<f64> = load.iter().zip(masses).map(|(load, mass)| -load / mass).collect();
        conditions.prescribed().keys().for_each(|unknown| found[*unknown] = 0.0);
        Ok(Field::from_values(&self.space, found)?)
    }

    /// Adds the derivatives of the masses at the start, whose slopes are in the slope by the first row.
    pub(super) fn reverse_masses(
        &mut self,
        start: &[f64],
        slope: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        let interval = self.interval_at_start();
        let step = interval.step_from(&self.space, start)?;
        let by_masses = &slope[3 * interval.states * interval.unknowns..];
        for (u, p) in self.masses_tested_with(by_masses)? {
            self.add_derivatives((&interval, &step), [&u, &p], gradient, slope)?;
        }
        Ok(())
    }

    /// The pairs u, p whose residuals R(u; p) add up to M·q: ones with q, zero with −q.
    pub(super) fn masses_tested_with(&self, q: &[f64]) -> Result<[(Field<D>, Field<D>); 2], HistoryFailure> {
        let q = Field::from_values(&self.space, q.to_vec())?;
        let ones = Field::from_values(&self.space, vec![1.0; q.values().len()])?;
        let (zero, less) = (Field::zero(&self.space), q.times(-1.0)?);
        Ok([(ones, q), (zero, less)])
    }
}
