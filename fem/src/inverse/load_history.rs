//! Load histories: quasi-static steps of one form, each from the state before, with a criterion and its discrete adjoint.

mod second_order;

use std::cell::Cell;
use std::sync::Arc;

use self::second_order::{ADJOINT, STATE, SecondSensitivitiesAt};
pub use self::second_order::{SecondOrderState, SecondOrderStates};
use super::checkpoint_store::Storage;
use super::choices::choices_of;
use super::control_vectors::ControlVectors;
use super::controls::{ControlError, ControlValues, Controls, Start};
use super::criterion::Criterion;
use super::differentiable_map::Part;
use super::error::{HistoryError, HistoryFailure};
use super::evolution::{ControlledEvolution, Evolution};
use super::observations::Observations;
use super::reduced_problem::ReducedProblem;
use super::second_order::{Hessian, SecondOrder, TwiceDifferentiable};
use super::sensitivities::{BEFORE, Wanted, add_sensitivities, has_unknowns, names_of, names_of_unknowns};
use super::step_equations::{Solution, StepEquations};
use super::sweep::{Gradient, gradient_stored, value_of};
use super::tangent_state::{Changing, CurvedCriterion};
use crate::assemble::Assembler;
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::{Energy, Form, Functional};
use crate::field::{Field, FieldView, fields_on};
use crate::instantiate::instantiate;
use crate::solve::communicator::Fingerprint;
use crate::solve::{Communicator, LinearSolver, NewtonOptions, PerUnknown, SolverReport};
use crate::space::Space;
use crate::time::conditions::Conditions;
use crate::verification::Sample;

/// Steps Rⁿ(uⁿ, uⁿ⁻¹, m; v) = 0 with a criterion J(m) = Σ Jⁿ(uⁿ), with value and gradient by the controls m. A problem
/// without a past is a history of one step.
///
/// The rates are a form without unknowns, a function of state, adjoint state and state before: the derivative of R(u, before, m; p), and
/// of what the criterion reads of the controls, by the state before, tested with `by_before`, and by each control `name`, tested with
/// `by_name`. Where no step asks for [`ControlValues::before`], nothing is tested with `by_before`: then steps only lead Newton's method to
/// the last one. The gradient is exact for the equations as they are discretised, to the accuracy to which they are solved. Where a
/// switch of the form changes (contact opens, friction begins to slip) J has a kink, and this is its slope on one side. So it is where
/// a point of a sliding pair comes to another facet, finds an opposite surface or loses it.
///
/// Forms of up to four unknowns are histories on the list of their spaces, as `[&displacements, &pressures]`. States are then read by
/// [`ControlValues::before_of_all`], the sensitivities are [`LoadHistory::coupled_sensitivities`], and each state before has a test function,
/// `by_before_u` for that of the unknown `u`. Where steps ask for [`ControlValues::before`] only, that of the first unknown is enough. The criterion may read the first unknown or more of them. A start that is a control is that
/// of the first unknown on its space.
///
/// Pairs of displaced surfaces may depend on the state of the step, on the state before, or on both: their motion is in the tangent
/// and in the rates that `derivative` makes.
pub struct LoadHistory<'a, const D: usize> {
    /// Of each unknown.
    spaces: Vec<Arc<Space<D>>>,
    steps: usize,
    controls: Controls<D>,
    step: Option<FormAt<'a, D>>,
    sensitivities: Option<SensitivitiesAt<'a, D>>,
    second_sensitivities: Option<SecondSensitivitiesAt<'a, D>>,
    positive: Vec<PositiveAt<'a, D>>,
    criterion: Criterion<'a, D>,
    constraints: Conditions<'a, usize, D>,
    equations: StepEquations<'a, D>,
    storage: Storage,
    /// The number of unknowns, from the first on, whose state before a step asked for.
    before_read: Cell<usize>,
}

type FormAt<'a, const D: usize> = Box<dyn Fn(&ControlValues<D>) -> Result<Form<D>, ControlError> + 'a>;
type PositiveAt<'a, const D: usize> =
    Box<dyn Fn(&ControlValues<D>) -> Result<Functional<D>, ControlError> + 'a>;
type SensitivitiesAt<'a, const D: usize> =
    Box<dyn Fn(&ControlValues<D>, &[Field<D>], &[Field<D>]) -> Result<Form<D>, ControlError> + 'a>;

impl<'a, const D: usize> LoadHistory<'a, D> {
    /// A number of steps on a space, or on `[&first, &second]`, from zero unless the start is a control.
    pub fn new<'s, const N: usize>(
        spaces: impl PerUnknown<'s, Arc<Space<D>>, N>,
        steps: usize,
        controls: Controls<D>,
    ) -> Self {
        const { assert!(N > 0, "a history has an unknown") };
        Self::of_spaces(&spaces.per_unknown(), steps, controls)
    }

    #[inline(never)]
    fn of_spaces(spaces: &[&Arc<Space<D>>], steps: usize, controls: Controls<D>) -> Self {
        LoadHistory {
            spaces: spaces.iter().map(|space| Arc::clone(space)).collect(),
            steps,
            controls,
            step: None,
            sensitivities: None,
            second_sensitivities: None,
            positive: vec![],
            criterion: Criterion::none(),
            constraints: Conditions::none(),
            equations: StepEquations::new(spaces),
            storage: Storage::ALL,
            before_read: Cell::new(0),
        }
    }

    /// The form of a step.
    pub fn step<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&ControlValues<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.step = Some(Box::new(move |at| Ok(form(at)?.into())));
        self
    }

    /// A functional whose integrand each step of Newton's method keeps positive, as
    /// [`Problem::keep_positive`](crate::solve::Problem::keep_positive) does: J = det F of a soft medium, a gap under a barrier.
    pub fn keep_positive(
        mut self,
        functional: impl Fn(&ControlValues<D>) -> Result<Functional<D>, ControlError> + 'a,
    ) -> Self {
        self.positive.push(Box::new(functional));
        self
    }

    /// The rates of a step at its state u and adjoint state p.
    pub fn sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&ControlValues<D>, &Field<D>, &Field<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.sensitivities = Some(Box::new(move |at, u, p| Ok(form(at, &u[0], &p[0])?.into())));
        self
    }

    /// The rates of a step of several unknowns at its states and adjoint states, a field for each unknown.
    pub fn coupled_sensitivities<F: Into<Form<D>>>(
        mut self,
        form: impl Fn(&ControlValues<D>, &[Field<D>], &[Field<D>]) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.sensitivities = Some(Box::new(move |at, u, p| Ok(form(at, u, p)?.into())));
        self
    }

    /// The controls with their last values.
    pub fn controls(&self) -> &Controls<D> {
        &self.controls
    }

    /// The state of the first unknown after each step.
    ///
    /// # Errors
    /// [`HistoryError`], which names the step.
    pub fn states(&mut self, m: &[f64]) -> Result<Vec<Field<D>>, HistoryError> {
        Ok(self.states_of_all(m)?.into_iter().map(|mut states| states.swap_remove(0)).collect())
    }

    /// The states of all unknowns after each step.
    ///
    /// # Errors
    /// [`HistoryError`], which names the step.
    #[inline(never)]
    pub fn states_of_all(&mut self, m: &[f64]) -> Result<Vec<Vec<Field<D>>>, HistoryError> {
        self.begin(m).map_err(|why| why.at(0))?;
        let mut states = vec![];
        let mut before = self.start()?;
        for step in 0..self.steps {
            before = self.advance(step, &before)?;
            states.push(self.fields(&before).map_err(|why| why.at(step))?);
        }
        Ok(states)
    }

    fn begin(&mut self, m: &[f64]) -> Result<(), HistoryFailure> {
        self.controls.check(&self.unknowns_on(), self.steps)?;
        self.controls.are_not(&[BEFORE])?;
        if let Some(name) = self.controls.start_name(Start::Rate) {
            return Err(ControlError::NoRate { name: name.to_owned() }.into());
        }
        self.criterion.check(&self.unknowns_on(), self.steps)?;
        self.before_read.set(0);
        self.equations.begin(&self.controls, [])?;
        self.criterion.divide(&self.equations)?;
        Ok(self.controls.set_values(m)?)
    }

    /// The use of the derivative by an unknown's state before: whether a step depends on it, and it is no constant.
    fn wanted(&self, unknown: usize) -> Wanted {
        let varies = self.steps > 1 || self.controls.start_name(Start::Value).is_some();
        Wanted::when(varies && unknown < self.before_read.get())
    }

    /// The form of a step from a state.
    fn form(&self, at: &ControlValues<D>) -> Result<Form<D>, HistoryFailure> {
        has_unknowns(self.step.as_ref().ok_or(HistoryFailure::Missing("step"))?(at)?, self.spaces.len())
    }

    fn fields(&self, values: &[f64]) -> Result<Vec<Field<D>>, HistoryFailure> {
        Ok(fields_on(&self.unknowns_on(), values)?)
    }

    fn unknowns_on(&self) -> Vec<&Arc<Space<D>>> {
        self.spaces.iter().collect()
    }

    /// The conditions of a step.
    fn conditions(&self, step: usize) -> Result<Vec<Constraints<D>>, HistoryFailure> {
        self.constraints.at(step, &self.unknowns_on())?.ok_or(HistoryFailure::Unconstrained)
    }

    /// The test functions of the derivatives by the states before, of a step's form.
    fn tests_before(&self, form: &Form<D>) -> Vec<(String, &Arc<Space<D>>, Wanted)> {
        let names = names_of(BEFORE, &names_of_unknowns(form)).into_iter().zip(&self.spaces).enumerate();
        names.map(|(unknown, (name, space))| (name, space, self.wanted(unknown))).collect()
    }

    #[inline(never)]
    fn try_advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let before = self.fields(before)?;
        let at = ControlValues::new(&self.controls, step, Some((&before, &self.before_read)));
        let (form, constraints) = (self.form(&at)?, self.conditions(step)?);
        self.equations.positive =
            self.positive.iter().map(|functional| functional(&at)).collect::<Result<_, _>>()?;
        let states = self.equations.solve(Solution::Step(step), form, &constraints, &before)?;
        Ok(states.iter().flat_map(Field::values).copied().collect())
    }

    #[inline(never)]
    fn try_reverse(
        &mut self,
        step: usize,
        [before, after]: [&[f64]; 2],
        mut slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let (before, after) = (self.fields(before)?, self.fields(after)?);
        let at = ControlValues::new(&self.controls, step, None);
        self.criterion.add_slope(&at, &self.equations, &after, &mut slope)?;
        let at = ControlValues::new(&self.controls, step, Some((&before, &self.before_read)));
        let (form, constraints) = (self.form(&at)?, self.conditions(step)?);
        let adjoint = self.equations.adjoint(Solution::Step(step), &form, &constraints, &after, &slope)?;
        let rates = self.sensitivities.as_ref().ok_or(HistoryFailure::Missing("sensitivities"))?(
            &at, &after, &adjoint,
        )?;
        let constants = self.equations.constants()?;
        let tests = self.tests_before(&form);
        add_sensitivities(&rates, step, &self.controls, &tests, &constants, &self.equations, gradient)
    }
}

impl<const D: usize> Evolution for LoadHistory<'_, D> {
    type Error = HistoryError;

    fn steps(&self) -> usize {
        self.steps
    }

    fn control_count(&self) -> usize {
        self.controls.values().len()
    }

    fn start(&mut self) -> Result<Vec<f64>, HistoryError> {
        Ok(self.controls.start_values(Start::Value, &self.unknowns_on()))
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        self.try_advance(step, before).map_err(|why| why.at(step))
    }

    fn cost(&mut self, step: usize, _: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        let value = || {
            let (after, at) = (self.fields(after)?, ControlValues::new(&self.controls, step, None));
            self.criterion.value(&at, &self.equations, &after)
        };
        value().map_err(|why| why.at(step))
    }

    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        self.try_reverse(step, [before, after], slope, gradient).map_err(|why| why.at(step))
    }

    fn reverse_start(&mut self, _: &[f64], slope: &[f64], gradient: &mut [f64]) -> Result<(), HistoryError> {
        self.controls.add_start(Start::Value, &self.unknowns_on(), slope, gradient);
        Ok(())
    }

    fn switches(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
    ) -> Result<Option<Vec<u32>>, HistoryError> {
        let found = || -> Result<Option<Vec<u32>>, HistoryFailure> {
            let (before, after) = (self.fields(before)?, self.fields(after)?);
            let form =
                self.form(&ControlValues::new(&self.controls, step, Some((&before, &self.before_read))))?;
            let at: Vec<FieldView<D>> = after.iter().map(Field::view).collect();
            let assembler = &self.equations.assembler;
            let mut switches = assembler.active_set_of(&form, &at)?;
            if form.is_on_displaced_surfaces() {
                // Where a point crosses an edge of the opposite surface the normal there jumps.
                let pairs = assembler.pairs_of_form(&form, &at, &self.unknowns_on())?;
                let met = pairs
                    .iter()
                    .filter(|pairs| pairs.report.displaced)
                    .flat_map(|all| all.pairs.contact_topology());
                switches.get_or_insert_default().extend(met);
            }
            // On pieces of a mesh a number that tells apart the switches of all.
            let own = Fingerprint::default().numbers(switches.iter().flatten().map(|on| u64::from(*on)));
            match self.equations.processes().fingerprint(form.name(), &own)? {
                Some(all) if switches.is_some() => Ok(Some(vec![all as u32, (all >> 32) as u32])),
                _ => Ok(switches),
            }
        };
        found().map_err(|why| why.at(step))
    }
}

choices_of!(LoadHistory, constrained_at usize, "the number of the step", second_rates by &[STATE, ADJOINT]);

instantiate!(
    load_history:
    LoadHistory::<D>::on,
    LoadHistory::<D>::gradient,
    LoadHistory::<D>::hessian,
    LoadHistory::<D>::states_of_all,
    LoadHistory::<D>::try_advance,
    LoadHistory::<D>::try_reverse,
);
