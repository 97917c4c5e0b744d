//! Hessians of load histories along a direction: a tangent linear sweep forward, a second-order adjoint sweep backward.
//!
//! With the Lagrangian L = Σ Jⁿ(uⁿ) + Rⁿ(uⁿ, uⁿ⁻¹, m; pⁿ) the changes along d are R_u δuⁿ = −R_w δuⁿ⁻¹ − R_m d, and backwards
//! R_uᵀ δpⁿ = −δ(J_u) − (δR_u)ᵀ pⁿ − δ((∂Rⁿ⁺¹/∂uⁿ)ᵀ pⁿ⁺¹); the Hessian's action is the sum of δ((∂Rⁿ/∂m)ᵀ pⁿ).

use super::LoadHistory;
use crate::contract::Form;
use crate::field::Field;
use crate::inverse::controls::{ControlError, ControlValues, Controls, Start};
use crate::inverse::error::HistoryFailure;
use crate::inverse::evolution::Evolution;
use crate::inverse::sensitivities::{BEFORE, OF_BEFORE, Own, Wanted, add_sensitivities, rows};
use crate::inverse::step_equations::Solution;
use crate::inverse::tangent_state::{Linearised, halves};
use crate::linear_algebra::vector::add_scaled;
use crate::solve::Transpose;

/// The states that a form of second sensitivities reads.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderState<'f, const D: usize> {
    /// The state u after the step.
    pub u: &'f Field<D>,
    /// The adjoint state p.
    pub p: &'f Field<D>,
    /// The change of u along the direction.
    pub du: &'f Field<D>,
    /// The change of the state before the step.
    pub dbefore: &'f Field<D>,
    /// The change of p.
    pub dp: &'f Field<D>,
    /// The direction: numbers and fields by the names of their controls.
    pub along: ControlValues<'f, D>,
}

pub(super) type SecondSensitivitiesAt<'a, const D: usize> =
    Box<dyn Fn(&ControlValues<D>, &SecondOrderState<D>) -> Result<Form<D>, ControlError> + 'a>;

pub(super) const STATE: &str = "state";
pub(super) const ADJOINT: &str = "adjoint";

impl<'a, const D: usize> LoadHistory<'a, D> {
    /// The change of a step's sensitivities: with the work R(u, before, m; p) of the step, the derivative of
    ///
    /// ```text
    /// derivative(work, u, by_state) + derivative(work, before, by_before) + derivative(work, p, by_adjoint)
    ///     + derivative(work, name, by_name) + …                        // a term for each control
    /// ```
    ///
    /// by u along `du`, by the state before along `dbefore`, by p along `dp`, and by each control along its direction, each by
    /// `derivative`. The criterion's own second variation by the state is taken from its energy; where that energy reads controls, its
    /// derivatives by state and control, and by control twice, have to be in the second sensitivities.
    pub fn second_sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&ControlValues<D>, &SecondOrderState<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.second_sensitivities = Some(Box::new(move |at, states| Ok(form(at, states)?.into())));
        self
    }
}

impl<const D: usize> LoadHistory<'_, D> {
    /// The rows of the second sensitivities by state, state before and adjoint state; those by the controls are added to `action`.
    fn second_rows(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &Field<D>,
        [u, p, du, dbefore, dp]: [&Field<D>; 5],
        action: &mut [f64],
    ) -> Result<[Vec<f64>; 3], HistoryFailure> {
        let along = ControlValues::new(along, step, None);
        let at = ControlValues::new(&self.controls, step, Some(std::slice::from_ref(before)));
        let form =
            self.second_sensitivities.as_ref().ok_or(HistoryFailure::Missing("second_sensitivities"))?;
        let form = form(&at, &SecondOrderState { u, p, du, dbefore, dp, along })?;
        let (constants, space) = (self.equations.constants()?, &self.spaces[0]);
        let before = Wanted::when(self.remembers());
        let own = [
            Own { name: STATE, meaning: "the derivative by the state changes", wanted: Wanted::Yes, space },
            Own { name: BEFORE, meaning: OF_BEFORE, wanted: before, space },
            Own { name: ADJOINT, meaning: "the equations of the step change", wanted: Wanted::Yes, space },
        ];
        rows(&form, &own, step, &self.controls, &constants, &self.equations.assembler, action)
    }

    /// The values of the only unknown as a field.
    fn only(&self, values: &[f64]) -> Result<Field<D>, HistoryFailure> {
        Ok(Field::from_values(&self.spaces[0], values.to_vec())?)
    }

    /// x with R_u x = −load or R_uᵀ x = −load.
    fn linearised(
        &mut self,
        step: usize,
        [before, u]: [&Field<D>; 2],
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Field<D>, HistoryFailure> {
        let form =
            self.form(&ControlValues::new(&self.controls, step, Some(std::slice::from_ref(before))))?;
        let (constraints, at) = (self.conditions(step)?, std::slice::from_ref(u));
        let found = self.equations.linearised(Solution::Step(step), &form, &constraints, at, load, transpose);
        Ok(found?.swap_remove(0))
    }
}

impl<const D: usize> Linearised<D> for LoadHistory<'_, D> {
    fn start_along(&mut self, along: &Controls<D>) -> Result<Vec<f64>, HistoryFailure> {
        let spaces = self.unknowns_on();
        if spaces.len() > 1 {
            return Err(HistoryFailure::SecondOrderOfSeveral { count: spaces.len() });
        }
        Ok([&self.controls, along].map(|controls| controls.start_values(Start::Value, &spaces)).concat())
    }

    fn advance_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let [before, change] = halves(before);
        let mut after = self.try_advance(step, before)?;
        let zero = Field::zero(&self.spaces[0]);
        let (before, dbefore) = (self.only(before)?, self.only(change)?);
        let u = self.only(&after)?;
        let mut unused = vec![0.0; self.control_count()];
        let states = [&u, &zero, &zero, &dbefore, &zero];
        let [_, _, load] = self.second_rows(along, step, &before, states, &mut unused)?;
        after.extend(self.linearised(step, [&before, &u], &load, Transpose::No)?.values());
        Ok(after)
    }

    fn reverse_along(
        &mut self,
        along: &Controls<D>,
        step: usize,
        [before, after]: [&[f64]; 2],
        [slope, change]: [&[f64]; 2],
        [gradient, action]: [&mut [f64]; 2],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let ([before, dbefore], [u, du]) = (halves(before), halves(after));
        let [before, dbefore, u, du] = [before, dbefore, u, du].map(|values| self.only(values));
        let (before, dbefore, u, du) = (before?, dbefore?, u?, du?);
        let p = self.linearised(step, [&before, &u], slope, Transpose::Yes)?;
        let constants = self.equations.constants()?;
        let at = ControlValues::new(&self.controls, step, Some(std::slice::from_ref(&before)));
        let rates = self.sensitivities.as_ref().ok_or(HistoryFailure::Missing("sensitivities"))?;
        let rates = rates(&at, std::slice::from_ref(&u), std::slice::from_ref(&p))?;
        let tests = [(BEFORE.to_owned(), &self.spaces[0])];
        let (controls, assembler) = ((&self.controls, self.remembers()), &self.equations.assembler);
        let mut by_before =
            add_sensitivities(&rates, step, controls, (&tests, &constants), assembler, gradient)?;
        let zero = Field::zero(&self.spaces[0]);
        let mut unused = vec![0.0; action.len()];
        // Without a change of p first, which is found from it.
        let states = [&u, &p, &du, &dbefore, &zero];
        let [by_state, _, _] = self.second_rows(along, step, &before, states, &mut unused)?;
        let mut change = change.to_vec();
        add_scaled(&mut change, 1.0, &by_state);
        let dp = self.linearised(step, [&before, &u], &change, Transpose::Yes)?;
        let states = [&u, &p, &du, &dbefore, &dp];
        let [_, change_before, _] = self.second_rows(along, step, &before, states, action)?;
        by_before.extend(change_before);
        Ok(by_before)
    }
}
