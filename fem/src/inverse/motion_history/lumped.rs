//! Lumped masses of a motion: equations R(0) + M x = 0 of a second rate x, with the diagonal matrix M of the row sums at the start.
//!
//! M is part of the rows of the sweep. Backwards each step adds x p to the slope by it, with its adjoint state p, and the derivatives of
//! the sum Q over all steps, M·Q = R(1; Q) − R(0; Q), are taken once, at the start.

use super::{MotionHistory, coefficients};
use crate::assemble::Parts;
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::field::{Field, fields_on};
use crate::inverse::error::HistoryFailure;
use crate::inverse::step_equations::{reads_no_history, views};
use crate::inverse::step_map::StepMap;
use crate::time::mass::{lumped, row_sums};
use crate::time::{Mass, SolvedFor, StepFailure};

impl StepMap {
    /// Adds the slope of M x·p by the masses to that by the row before.
    pub(super) fn add_by_masses<const D: usize>(&self, [x, p]: [&[Field<D>]; 2], by_before: &mut [f64]) {
        let by_masses = by_before[3 * self.states * self.count()..].iter_mut();
        let [x, p] = [x, p].map(coefficients);
        by_masses.zip(x).zip(p).for_each(|((sum, x), p)| *sum += x * p);
    }
}

impl<const D: usize> MotionHistory<'_, D> {
    /// Whether rows have masses.
    pub(super) fn lumps(&self) -> bool {
        let second_rates = self.reads_second_rates() || self.schemes[0].solved_for() == SolvedFor::SecondRate;
        self.mass == Mass::Lumped && second_rates
    }

    /// The masses at a start.
    pub(super) fn masses_at(&mut self, start: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let interval = self.interval_at_start();
        let steps = interval.steps_from(&self.unknowns_on(), start)?;
        let form = self.form(&interval, &steps)?;
        reads_no_history(&form)?;
        let matrix = self.equations.tangent(&form, &self.zero())?;
        Ok(lumped(self.equations.summed(&form, row_sums(&matrix)?)?)?)
    }

    /// The second rates by the form's residual at zero.
    pub(super) fn by_masses(
        &self,
        form: &Form<D>,
        masses: &[f64],
        conditions: &[Constraints<D>],
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let (zero, spaces) = (self.zero(), self.unknowns_on());
        let load = self.equations.assembler.residual_of(form, &views(&zero), &spaces, Parts::ALL)?;
        self.divided(&load, masses, conditions)
    }

    /// x with M x = −load, zero where it is prescribed.
    pub(super) fn divided(
        &self,
        load: &[f64],
        masses: &[f64],
        conditions: &[Constraints<D>],
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let mut found: Vec<f64> = load.iter().zip(masses).map(|(load, mass)| -load / mass).collect();
        let mut from = 0;
        for conditions in conditions {
            if !conditions.relations().is_empty() {
                return Err(StepFailure::LumpedRelations.into());
            }
            conditions.prescribed().keys().for_each(|unknown| found[from + unknown] = 0.0);
            from += conditions.space().unknowns();
        }
        Ok(fields_on(&self.unknowns_on(), &found)?)
    }

    /// Adds the derivatives of the masses at the start, whose slopes are in the slope by the first row.
    pub(super) fn reverse_masses(
        &mut self,
        start: &[f64],
        slope: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        let interval = self.interval_at_start();
        let steps = interval.steps_from(&self.unknowns_on(), start)?;
        let by_masses = &slope[3 * interval.states * interval.count()..];
        for [u, p] in self.masses_tested_with(by_masses)? {
            self.add_derivatives((&interval, &steps), [&u, &p], gradient, slope)?;
        }
        Ok(())
    }

    /// The pairs u, p whose residuals R(u; p) add up to M·q: ones with q, zero with −q.
    pub(super) fn masses_tested_with(&self, q: &[f64]) -> Result<[[Vec<Field<D>>; 2]; 2], HistoryFailure> {
        let fields = |values: &[f64]| fields_on(&self.unknowns_on(), values);
        let less: Vec<f64> = q.iter().map(|q| -q).collect();
        Ok([[fields(&vec![1.0; q.len()])?, fields(q)?], [self.zero(), fields(&less)?]])
    }
}
