//! Load histories: quasi-static steps of one form, each from the state before, with a criterion and its discrete adjoint.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::controls::{At, ControlError, Controls};
use super::criterion::Criterion;
use super::error::{HistoryError, HistoryFailure};
use super::evolution::Evolution;
use super::observations::Observations;
use super::rates::add_rates;
use super::reduced_problem::ReducedProblem;
use super::sweep::{Gradient, gradient_of, value_of};
use crate::assemble::{Assembler, BlockPattern, Parts};
use crate::compiled_here::compiled_here;
use crate::constraints::{Constraints, ConstraintsError};
use crate::contract::{Form, Functional};
use crate::field::Field;
use crate::linear_algebra::BlockMatrix;
use crate::linear_algebra::vector::add_scaled;
use crate::solve::any_form::AnyForm;
use crate::solve::{
    Elimination, LinearSolver, NewtonOptions, OwnedForm, TangentSolver, Transpose, solve_linear_transposed,
    solve_owned,
};
use crate::space::Space;
use crate::verification::Sample;

/// Steps Rⁿ(uⁿ, uⁿ⁻¹, m; v) = 0 with a criterion J(m) = Σ Jⁿ(uⁿ), of which it gives value and gradient by the controls m. A problem
/// without a past is a history of one step.
///
/// The rates are a form without unknowns, a function of state, adjoint state and state before: the derivative of R(u, before, m; p), and
/// of what the criterion reads beside u, by the state before, tested with `by_before`, and by each control `name`, tested with
/// `by_name`. The gradient is exact for the equations as they are discretised, to the accuracy to which they are solved. Where a
/// switch of the form changes (contact opens, friction begins to slip) J has a kink, and this is its slope on one side.
pub struct LoadHistory<'a, const D: usize> {
    space: Arc<Space<D>>,
    steps: usize,
    controls: Controls<D>,
    step: Option<FormAt<'a, D>>,
    rates: Option<RatesAt<'a, D>>,
    criterion: Criterion<'a, D>,
    constraints: ConstraintsAt<'a, D>,
    assembler: Assembler<D>,
    solver: Solver<'a>,
    options: NewtonOptions,
    stored: usize,
    pattern: Option<Arc<BlockPattern<D>>>,
    /// Constants, to test rates by numbers with.
    constants: Option<Arc<Space<D>>>,
    /// The step whose tangent the solver has factored at its solution.
    factored: Option<usize>,
}

type FormAt<'a, const D: usize> = Box<dyn Fn(&At<D>) -> Result<Box<dyn AnyForm<D> + 'a>, ControlError> + 'a>;
type RatesAt<'a, const D: usize> =
    Box<dyn Fn(&At<D>, &Field<D>, &Field<D>) -> Result<Box<dyn AnyForm<D> + 'a>, ControlError> + 'a>;
type ConstraintsAt<'a, const D: usize> = Box<dyn Fn(usize) -> Result<Constraints<D>, ConstraintsError> + 'a>;

/// The history's own linear solver, or one that is lent to it.
enum Solver<'a> {
    Own(Box<TangentSolver>),
    Lent(&'a mut dyn LinearSolver),
}

impl Solver<'_> {
    fn get(&mut self) -> &mut dyn LinearSolver {
        match self {
            Solver::Own(solver) => &mut **solver,
            Solver::Lent(solver) => &mut **solver,
        }
    }
}

impl<'a, const D: usize> LoadHistory<'a, D> {
    /// A number of steps on a space, from zero unless the start is a control.
    #[inline(never)]
    pub fn new(space: &Arc<Space<D>>, steps: usize, controls: Controls<D>) -> Self {
        let unconstrained = Constraints::new(space);
        LoadHistory {
            space: Arc::clone(space),
            steps,
            controls,
            step: None,
            rates: None,
            criterion: Criterion { energy: None, observations: BTreeMap::new(), of_controls: None },
            constraints: Box::new(move |_| Ok(unconstrained.clone())),
            assembler: Assembler::new(space.mesh()),
            solver: Solver::Own(Box::default()),
            options: NewtonOptions::default(),
            stored: usize::MAX,
            pattern: None,
            constants: None,
            factored: None,
        }
    }

    /// The form of a step.
    pub fn step<F: Form<D> + 'a>(mut self, form: impl Fn(&At<D>) -> Result<F, ControlError> + 'a) -> Self {
        self.step = Some(Box::new(move |at| Ok(Box::new(form(at)?))));
        self
    }

    /// The rates of a step at its state u and adjoint state p.
    pub fn rates<F: Form<D> + 'a>(
        mut self,
        form: impl Fn(&At<D>, &Field<D>, &Field<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.rates = Some(Box::new(move |at, u, p| Ok(Box::new(form(at, u, p)?))));
        self
    }

    /// Jⁿ, an energy of the state after the step, whose slope is the adjoint's load. A criterion of the last step alone has a factor
    /// that is zero in the others.
    pub fn criterion<F: Form<D> + Functional<D> + 'a>(
        mut self,
        energy: impl Fn(&At<D>) -> Result<F, ControlError> + 'a,
    ) -> Self {
        self.criterion.energy = Some(Box::new(move |at| Ok(Box::new(energy(at)?))));
        self
    }

    /// What is measured at the end of a step, numbered from 0, adds to the criterion.
    pub fn observed(mut self, step: usize, observations: Observations<D>) -> Self {
        self.criterion.observations.entry(step).or_default().push(observations);
        self
    }

    /// A function of the controls alone that adds to the criterion, with its gradient, as a regularisation.
    pub fn with_cost_of_controls(mut self, cost: impl Fn(&[f64]) -> (f64, Vec<f64>) + 'a) -> Self {
        self.criterion.of_controls = Some(Box::new(cost));
        self
    }

    /// Conditions that do not change.
    pub fn constrained(self, constraints: &Constraints<D>) -> Self {
        let constraints = constraints.clone();
        self.constrained_at(move |_| Ok(constraints.clone()))
    }

    /// Conditions as a function of the number of the step.
    pub fn constrained_at(
        mut self,
        constraints: impl Fn(usize) -> Result<Constraints<D>, ConstraintsError> + 'a,
    ) -> Self {
        self.constraints = Box::new(constraints);
        self
    }

    /// Another assembler than the default one: for its quadrature, its threads.
    pub fn assembler(mut self, assembler: &Assembler<D>) -> Self {
        self.assembler = assembler.clone();
        self
    }

    /// Another linear solver than a [`TangentSolver`], for the steps and their adjoints.
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = Solver::Lent(solver);
        self
    }

    /// Tolerances of Newton's method in each step.
    pub fn options(mut self, options: NewtonOptions) -> Self {
        self.options = options;
        self
    }

    /// At most so many states are stored, and the others computed again on the way back; all are, unless this is said.
    pub fn stored_states(mut self, most: usize) -> Self {
        self.stored = most;
        self
    }

    /// The controls with their last values.
    pub fn controls(&self) -> &Controls<D> {
        &self.controls
    }

    /// J with its gradient, and what it took.
    ///
    /// # Errors
    /// [`HistoryError`], which names the step.
    #[inline(never)]
    pub fn gradient(&mut self, m: &[f64]) -> Result<Gradient, HistoryError> {
        self.begin(m).map_err(|why| why.at(0))?;
        let stored = self.stored;
        let mut found = gradient_of(self, stored)?;
        if let Some((value, slope)) = self.criterion.of_controls(m).map_err(|why| why.at(0))? {
            found.value += value;
            add_scaled(&mut found.gradient, 1.0, &slope);
        }
        Ok(found)
    }

    /// The state after each step.
    ///
    /// # Errors
    /// [`HistoryError`], which names the step.
    #[inline(never)]
    pub fn states(&mut self, m: &[f64]) -> Result<Vec<Field<D>>, HistoryError> {
        self.begin(m).map_err(|why| why.at(0))?;
        let mut states: Vec<Field<D>> = vec![];
        let mut before = self.start()?;
        for step in 0..self.steps {
            before = self.advance(step, &before)?;
            let state = Field::from_values(&self.space, before.clone());
            states.push(state.map_err(|why| HistoryFailure::from(why).at(step))?);
        }
        Ok(states)
    }

    fn begin(&mut self, m: &[f64]) -> Result<(), HistoryFailure> {
        self.controls.check(&self.space, self.steps)?;
        self.criterion.check(&Field::zero(&self.space), self.steps)?;
        self.factored = None;
        Ok(self.controls.set_values(m)?)
    }

    /// The form of a step from a state.
    fn form(&self, at: &At<D>) -> Result<Box<dyn AnyForm<D> + 'a>, HistoryFailure> {
        Ok(self.step.as_ref().ok_or(HistoryFailure::Missing("step"))?(at)?)
    }

    fn field(&self, values: &[f64]) -> Result<Field<D>, HistoryFailure> {
        Ok(Field::from_values(&self.space, values.to_vec())?)
    }

    fn pattern(&mut self, form: &dyn AnyForm<D>) -> Result<Arc<BlockPattern<D>>, HistoryFailure> {
        if let Some(known) = &self.pattern {
            return Ok(Arc::clone(known));
        }
        let outline = form.outline(Parts::ALL);
        let pattern = BlockPattern::for_cells_of(&outline, &[&self.space], &[&self.space], &self.assembler)?;
        Ok(Arc::clone(self.pattern.insert(Arc::new(pattern))))
    }

    #[inline(never)]
    fn try_advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let before = self.field(before)?;
        let form = self.form(&At::new(&self.controls, step, &before))?;
        if form.slides() {
            return Err(HistoryFailure::Sliding { form: form.name() });
        }
        let (affine, pattern, constraints) =
            (form.is_affine(), self.pattern(&*form)?, (self.constraints)(step)?);
        let owned = OwnedForm {
            form,
            assembler: &self.assembler,
            pattern: &pattern,
            constraints: &constraints,
            start: &before,
            options: self.options.clone(),
        };
        self.factored = None;
        let [state] = solve_owned(owned, self.solver.get())?.fields;
        // Of an affine form it is the tangent wherever; Newton's method has that of an iterate.
        self.factored = affine.then_some(step);
        Ok(state.values().to_vec())
    }

    /// p with R_uᵀ p = −slope.
    fn adjoint(
        &mut self,
        step: usize,
        form: &dyn AnyForm<D>,
        state: &Field<D>,
        slope: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let load: Vec<f64> = slope.iter().map(|slope| -slope).collect();
        let mut elimination = Elimination::of(&[&(self.constraints)(step)?.homogeneous()])?;
        if self.factored == Some(step) && self.solver.get().judges_equations() {
            let reduced = elimination.reduce(&load)?;
            let found = self.solver.get().solve_with(&reduced, 0.0, Transpose::Yes)?;
            return Ok(elimination.extend_by_zero(&found.solution)?);
        }
        let pattern = self.pattern(form)?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        let arguments = (&[state.view()][..], &[&self.space][..]);
        form.assemble_tangent(&self.assembler, arguments, Parts::ALL, &pattern, &mut matrix)?;
        let found = solve_linear_transposed(&matrix, &load, &mut elimination, self.solver.get())?;
        self.factored = Some(step);
        Ok(found.solution)
    }

    #[inline(never)]
    fn try_reverse(
        &mut self,
        step: usize,
        [before, after]: [&[f64]; 2],
        mut slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let (before, after) = (self.field(before)?, self.field(after)?);
        let at = At::new(&self.controls, step, &before);
        let form = self.form(&at)?;
        self.criterion.add_slope(&at, &self.assembler, &after, &mut slope)?;
        let adjoint = self.adjoint(step, &*form, &after, &slope)?;
        let adjoint = self.field(&adjoint)?;
        let constants = match &self.constants {
            Some(known) => Arc::clone(known),
            None => Arc::clone(self.constants.insert(Space::discontinuous_scalar(self.space.mesh(), 0)?)),
        };
        let at = At::new(&self.controls, step, &before);
        let rates = self.rates.as_ref().ok_or(HistoryFailure::Missing("rates"))?(&at, &after, &adjoint)?;
        let remembers = self.steps > 1 || self.controls.has_start();
        let spaces = [&self.space, &constants];
        add_rates(&*rates, step, (&self.controls, remembers), spaces, &self.assembler, gradient)
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
        Ok(self.controls.start_values(&self.space))
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        self.try_advance(step, before).map_err(|why| why.at(step))
    }

    fn cost(&mut self, step: usize, before: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        let value = || -> Result<f64, HistoryFailure> {
            let (before, after) = (self.field(before)?, self.field(after)?);
            self.criterion.value(&At::new(&self.controls, step, &before), &self.assembler, &after)
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

    fn reverse_start(&mut self, slope: &[f64], gradient: &mut [f64]) -> Result<(), HistoryError> {
        self.controls.add_start(slope, gradient);
        Ok(())
    }

    fn switches(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
    ) -> Result<Option<Vec<u32>>, HistoryError> {
        let found = || -> Result<Option<Vec<u32>>, HistoryFailure> {
            let (before, after) = (self.field(before)?, self.field(after)?);
            let form = self.form(&At::new(&self.controls, step, &before))?;
            Ok(form.active_set(&self.assembler, &[after.view()])?)
        };
        found().map_err(|why| why.at(step))
    }
}

impl<const D: usize> ReducedProblem for LoadHistory<'_, D> {
    type Error = HistoryError;

    fn start(&self) -> Vec<f64> {
        self.controls.values().to_vec()
    }

    fn sample(&mut self, m: &[f64]) -> Result<Sample, HistoryError> {
        self.begin(m).map_err(|why| why.at(0))?;
        let mut found = value_of(self)?;
        if let Some((value, _)) = self.criterion.of_controls(m).map_err(|why| why.at(0))? {
            found.value[0] += value;
        }
        Ok(found)
    }

    fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), HistoryError> {
        let found = self.gradient(m)?;
        Ok((found.value, found.gradient))
    }
}

compiled_here!(
    LoadHistory::<D>::new,
    LoadHistory::<D>::gradient,
    LoadHistory::<D>::states,
    LoadHistory::<D>::try_advance,
    LoadHistory::<D>::try_reverse,
);
