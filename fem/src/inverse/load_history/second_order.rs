//! Hessians of load histories along a direction: a tangent linear sweep forward, a second-order adjoint sweep backward.
//!
//! With the Lagrangian L = Σ Jⁿ(uⁿ) + Rⁿ(uⁿ, uⁿ⁻¹, m; pⁿ) the changes along d are R_u δuⁿ = −R_w δuⁿ⁻¹ − R_m d, and backwards
//! R_uᵀ δpⁿ = −δ(J_u) − (δR_u)ᵀ pⁿ − δ((∂Rⁿ⁺¹/∂uⁿ)ᵀ pⁿ⁺¹); the Hessian's action is the sum of δ((∂Rⁿ/∂m)ᵀ pⁿ).

use super::LoadHistory;
use crate::compiled_here::compiled_here;
use crate::contract::Form;
use crate::field::Field;
use crate::inverse::controls::{At, ControlError, Controls, Start};
use crate::inverse::error::{HistoryError, HistoryFailure};
use crate::inverse::evolution::Evolution;
use crate::inverse::rates::{BEFORE, OF_BEFORE, Own, add_rates, rows};
use crate::inverse::second_order::{SecondOrder, TwiceDifferentiable};
use crate::inverse::step_equations::Solution;
use crate::inverse::sweep::{Gradient, Work, gradient_stored};
use crate::linear_algebra::vector::add_scaled;
use crate::solve::Transpose;
use crate::solve::any_form::AnyForm;

/// The states that a form of second rates reads.
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
    pub along: At<'f, D>,
}

/// J, its gradient, and the Hessian along a direction, with what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Hessian {
    /// J(m).
    pub value: f64,
    /// dJ/dm.
    pub gradient: Vec<f64>,
    /// (d²J/dm²) d.
    pub along: Vec<f64>,
    /// Steps solved and stored.
    pub work: Work,
}

pub(super) type SecondRatesAt<'a, const D: usize> =
    Box<dyn Fn(&At<D>, &SecondOrderState<D>) -> Result<Box<dyn AnyForm<D> + 'a>, ControlError> + 'a>;

const STATE: &str = "state";
const ADJOINT: &str = "adjoint";

impl<'a, const D: usize> LoadHistory<'a, D> {
    /// The change of a step's rates: with the work R(u, before, m; p) of the step, the derivative of
    ///
    /// ```text
    /// derivative(work, u, by_state) + derivative(work, before, by_before) + derivative(work, p, by_adjoint)
    ///     + derivative(work, name, by_name) + …                        // a term for each control
    /// ```
    ///
    /// by u along `du`, by the state before along `dbefore`, by p along `dp`, and by each control along its direction, each by
    /// `derivative`. The criterion's own second variation by the state is taken from its energy; where that energy reads controls, its
    /// derivatives by state and control, and by control twice, have to stand in the second rates.
    pub fn second_rates<F: Form<D> + 'a>(
        mut self,
        form: impl Fn(&At<D>, &SecondOrderState<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.second_rates = Some(Box::new(move |at, states| Ok(Box::new(form(at, states)?))));
        self
    }

    /// The second derivative of [`LoadHistory::with_cost_of_controls`] at m along a direction.
    pub fn with_curvature_of_controls(mut self, curvature: impl Fn(&[f64], &[f64]) -> Vec<f64> + 'a) -> Self {
        self.criterion.curvature_of_controls = Some(Box::new(curvature));
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
        let (storage, count) = (self.storage.clone(), m.len());
        let mut found = gradient_stored(&mut Changing { history: &mut *self, along }, &storage)?;
        let mut along = found.gradient.split_off(count);
        let criterion = &self.criterion;
        criterion.add_cost_of_controls(m, &mut found).map_err(|why| why.at(0))?;
        criterion.add_curvature_of_controls(m, direction, &mut along).map_err(|why| why.at(0))?;
        let Gradient { value, gradient, work } = found;
        Ok(Hessian { value, gradient, along, work })
    }

    /// The direction as values of the controls.
    fn begin_along(&mut self, m: &[f64], direction: &[f64]) -> Result<Controls<D>, HistoryFailure> {
        self.begin(m).and_then(|()| self.criterion.exists())?;
        if let Some(name) = self.controls.tested().find(|name| [STATE, ADJOINT].contains(name)) {
            return Err(ControlError::Twice { name: name.to_owned() }.into());
        }
        let mut along = self.controls.clone();
        along.set_values(direction)?;
        Ok(along)
    }
}

impl<const D: usize> TwiceDifferentiable for LoadHistory<'_, D> {
    fn second_order(&mut self, m: &[f64], direction: &[f64]) -> Result<SecondOrder, HistoryError> {
        let Hessian { value, gradient, along, .. } = self.hessian(m, direction)?;
        Ok(SecondOrder { value, gradient, along })
    }
}

/// A history whose states are pairs of a state and its change, and whose gradient is one with its change.
struct Changing<'h, 'a, const D: usize> {
    history: &'h mut LoadHistory<'a, D>,
    along: Controls<D>,
}

/// The first and the second half of a pair.
fn halves(pair: &[f64]) -> (&[f64], &[f64]) {
    pair.split_at(pair.len() / 2)
}

impl<const D: usize> Changing<'_, '_, D> {
    /// The rows of the second rates by state, state before and adjoint state; those by the controls are added to `action`.
    fn rows(
        &mut self,
        step: usize,
        before: &Field<D>,
        [u, p, du, dbefore, dp]: [&Field<D>; 5],
        action: &mut [f64],
    ) -> Result<[Vec<f64>; 3], HistoryFailure> {
        let history = &mut *self.history;
        let along = At::new(&self.along, step, None);
        let at = At::new(&history.controls, step, Some(before));
        let form = history.second_rates.as_ref().ok_or(HistoryFailure::Missing("second_rates"))?;
        let form = form(&at, &SecondOrderState { u, p, du, dbefore, dp, along })?;
        let own = [
            Own { name: STATE, meaning: "the derivative by the state changes", wanted: true },
            Own { name: BEFORE, meaning: OF_BEFORE, wanted: history.remembers() },
            Own { name: ADJOINT, meaning: "the equations of the step change", wanted: true },
        ];
        let spaces = [&history.space, &history.equations.constants()?];
        rows(&*form, &own, step, &history.controls, spaces, &history.equations.assembler, action)
    }

    fn try_advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let (before, change) = halves(before);
        let mut after = self.history.try_advance(step, before)?;
        let zero = Field::zero(&self.history.space);
        let (before, dbefore) = (self.history.field(before)?, self.history.field(change)?);
        let u = self.history.field(&after)?;
        let mut unused = vec![0.0; self.history.control_count()];
        let [_, _, load] = self.rows(step, &before, [&u, &zero, &zero, &dbefore, &zero], &mut unused)?;
        after.extend(self.linearised(step, [&before, &u], &load, Transpose::No)?.values());
        Ok(after)
    }

    /// x with R_u x = −load or R_uᵀ x = −load.
    fn linearised(
        &mut self,
        step: usize,
        [before, u]: [&Field<D>; 2],
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Field<D>, HistoryFailure> {
        let history = &mut *self.history;
        let form = history.form(&At::new(&history.controls, step, Some(before)))?;
        let constraints = (history.constraints)(step)?;
        history.equations.linearised(Solution::Step(step), &*form, &constraints, u, load, transpose)
    }

    #[inline(never)]
    fn try_reverse(
        &mut self,
        step: usize,
        [before, after]: [&[f64]; 2],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let (gradient, action) = gradient.split_at_mut(gradient.len() / 2);
        let history = &*self.history;
        let ((before, dbefore), (u, du)) = (halves(before), halves(after));
        let [before, dbefore, u, du] = [before, dbefore, u, du].map(|values| history.field(values));
        let (before, dbefore, u, du) = (before?, dbefore?, u?, du?);
        let (mut slope, mut change) = (halves(slope).0.to_vec(), halves(slope).1.to_vec());
        let (at, assembler) = (At::new(&history.controls, step, None), &history.equations.assembler);
        history.criterion.add_slope(&at, assembler, &u, &mut slope)?;
        history.criterion.add_curvature(&at, assembler, [&u, &du], &mut change)?;
        let p = self.linearised(step, [&before, &u], &slope, Transpose::Yes)?;
        let history = &mut *self.history;
        let at = At::new(&history.controls, step, Some(&before));
        let rates = history.rates.as_ref().ok_or(HistoryFailure::Missing("rates"))?(&at, &u, &p)?;
        let spaces = [&history.space, &history.equations.constants()?];
        let controls = (&history.controls, history.remembers());
        let mut by_before =
            add_rates(&*rates, step, controls, spaces, &history.equations.assembler, gradient)?;
        let zero = Field::zero(&history.space);
        let mut unused = vec![0.0; action.len()];
        // Without a change of p first, which is found from it.
        let [by_state, _, _] = self.rows(step, &before, [&u, &p, &du, &dbefore, &zero], &mut unused)?;
        add_scaled(&mut change, 1.0, &by_state);
        let dp = self.linearised(step, [&before, &u], &change, Transpose::Yes)?;
        let [_, change_before, _] = self.rows(step, &before, [&u, &p, &du, &dbefore, &dp], action)?;
        by_before.extend(change_before);
        Ok(by_before)
    }
}

impl<const D: usize> Evolution for Changing<'_, '_, D> {
    type Error = HistoryError;

    fn steps(&self) -> usize {
        self.history.steps
    }

    fn control_count(&self) -> usize {
        2 * self.history.control_count()
    }

    fn start(&mut self) -> Result<Vec<f64>, HistoryError> {
        let mut start = self.history.start()?;
        start.extend(self.along.start_values(Start::Value, self.history.space.unknowns()));
        Ok(start)
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        self.try_advance(step, before).map_err(|why| why.at(step))
    }

    fn cost(&mut self, step: usize, before: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        self.history.cost(step, halves(before).0, halves(after).0)
    }

    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        self.try_reverse(step, [before, after], &slope, gradient).map_err(|why| why.at(step))
    }

    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        let (gradient, action) = gradient.split_at_mut(gradient.len() / 2);
        self.history.reverse_start(halves(start).0, halves(slope).0, gradient)?;
        self.history.reverse_start(halves(start).1, halves(slope).1, action)
    }
}

compiled_here!(LoadHistory::<D>::hessian, Changing::<D>::try_advance, Changing::<D>::try_reverse,);
