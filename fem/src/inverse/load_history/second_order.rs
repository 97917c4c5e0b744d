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
use crate::inverse::sensitivities::{
    BEFORE, OF_BEFORE, Own, Wanted, add_sensitivities, names_of, names_of_unknowns, rows_of,
};
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

/// The states of several unknowns that a form of second sensitivities reads, a field for each unknown.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderStates<'f, const D: usize> {
    /// The states u after the step.
    pub u: &'f [Field<D>],
    /// The adjoint states p.
    pub p: &'f [Field<D>],
    /// The changes of u along the direction.
    pub du: &'f [Field<D>],
    /// The changes of the states before the step.
    pub dbefore: &'f [Field<D>],
    /// The changes of p.
    pub dp: &'f [Field<D>],
    /// The direction: numbers and fields by the names of their controls.
    pub along: ControlValues<'f, D>,
}

pub(super) type SecondSensitivitiesAt<'a, const D: usize> =
    Box<dyn Fn(&ControlValues<D>, &SecondOrderStates<D>) -> Result<Form<D>, ControlError> + 'a>;

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
        self.second_sensitivities = Some(Box::new(move |at, all| {
            let SecondOrderStates { u, p, du, dbefore, dp, along } = *all;
            let [u, p, du, dbefore, dp] = [u, p, du, dbefore, dp].map(|fields| &fields[0]);
            Ok(form(at, &SecondOrderState { u, p, du, dbefore, dp, along })?.into())
        }));
        self
    }

    /// [`Self::second_sensitivities`] of several unknowns: with test functions `by_state_u`, `by_before_u` and `by_adjoint_u` for the unknown
    /// `u`, and so on.
    pub fn coupled_second_sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&ControlValues<D>, &SecondOrderStates<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.second_sensitivities = Some(Box::new(move |at, states| Ok(form(at, states)?.into())));
        self
    }
}

impl<const D: usize> LoadHistory<'_, D> {
    /// The rows of the second sensitivities by states, states before and adjoint states; those by the controls are added to `action`.
    fn second_rows(
        &mut self,
        along: &Controls<D>,
        step: usize,
        before: &[Field<D>],
        [u, p, du, dbefore, dp]: [&[Field<D>]; 5],
        action: &mut [f64],
    ) -> Result<[Vec<f64>; 3], HistoryFailure> {
        let along = ControlValues::new(along, step, None);
        let at = ControlValues::new(&self.controls, step, Some((before, &self.before_read)));
        let second =
            self.second_sensitivities.as_ref().ok_or(HistoryFailure::Missing("second_sensitivities"))?;
        let second = second(&at, &SecondOrderStates { u, p, du, dbefore, dp, along })?;
        let names = names_of_unknowns(&self.form(&at)?);
        let names = [STATE, BEFORE, ADJOINT].map(|quantity| names_of(quantity, &names));
        let meanings = ["the derivative by the state changes", OF_BEFORE, "the equations of the step change"];
        let mut own = vec![];
        for (names, meaning) in names.iter().zip(meanings) {
            for (unknown, (name, space)) in names.iter().zip(&self.spaces).enumerate() {
                let wanted = if meaning == OF_BEFORE { self.wanted(unknown) } else { Wanted::Yes };
                own.push(Own { name, meaning, wanted, space });
            }
        }
        let constants = self.equations.constants()?;
        let equations = &self.equations;
        let found = rows_of(&second, &own, step, &self.controls, &constants, equations, action)?;
        let mut found = found.chunks(self.spaces.len()).map(<[_]>::concat);
        Ok(std::array::from_fn(|_| found.next().unwrap_or_default()))
    }

    /// x with R_u x = −load or R_uᵀ x = −load.
    fn linearised(
        &mut self,
        step: usize,
        [before, u]: [&[Field<D>]; 2],
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let form = self.form(&ControlValues::new(&self.controls, step, Some((before, &self.before_read))))?;
        let constraints = self.conditions(step)?;
        self.equations.linearised(Solution::Step(step), &form, &constraints, u, load, transpose)
    }

    fn zero(&self) -> Vec<Field<D>> {
        self.spaces.iter().map(Field::zero).collect()
    }
}

impl<const D: usize> Linearised<D> for LoadHistory<'_, D> {
    fn start_along(&mut self, along: &Controls<D>) -> Result<Vec<f64>, HistoryFailure> {
        let spaces = self.unknowns_on();
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
        let (zero, before, dbefore) = (self.zero(), self.fields(before)?, self.fields(change)?);
        let u = self.fields(&after)?;
        let mut unused = vec![0.0; self.control_count()];
        let states = [&u[..], &zero, &zero, &dbefore, &zero];
        let [_, _, load] = self.second_rows(along, step, &before, states, &mut unused)?;
        let change = self.linearised(step, [&before, &u], &load, Transpose::No)?;
        after.extend(change.iter().flat_map(Field::values));
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
        let [before, dbefore, u, du] = [before, dbefore, u, du].map(|values| self.fields(values));
        let (before, dbefore, u, du) = (before?, dbefore?, u?, du?);
        let p = self.linearised(step, [&before, &u], slope, Transpose::Yes)?;
        let constants = self.equations.constants()?;
        let at = ControlValues::new(&self.controls, step, Some((&before, &self.before_read)));
        let rates = self.sensitivities.as_ref().ok_or(HistoryFailure::Missing("sensitivities"))?;
        let rates = rates(&at, &u, &p)?;
        let form = self.form(&at)?;
        let tests = self.tests_before(&form);
        let (controls, equations) = (&self.controls, &self.equations);
        let mut by_before =
            add_sensitivities(&rates, step, controls, &tests, &constants, equations, gradient)?;
        let zero = self.zero();
        let mut unused = vec![0.0; action.len()];
        // Without a change of p first, which is found from it.
        let states = [&u[..], &p, &du, &dbefore, &zero];
        let [by_state, _, _] = self.second_rows(along, step, &before, states, &mut unused)?;
        let mut change = change.to_vec();
        add_scaled(&mut change, 1.0, &by_state);
        let dp = self.linearised(step, [&before, &u], &change, Transpose::Yes)?;
        let states = [&u[..], &p, &du, &dbefore, &dp];
        let [_, change_before, _] = self.second_rows(along, step, &before, states, action)?;
        by_before.extend(change_before);
        Ok(by_before)
    }
}
