//! The criterion of a history: an energy of each step's state, observations of some, and what depends on the controls alone.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::controls::{ControlError, ControlValues};
use super::error::HistoryFailure;
use super::observations::Observations;
use super::second_order::Hessian;
use super::step_equations::StepEquations;
use super::sweep::{Gradient, Work};
use crate::contract::{Energy, Role};
use crate::field::Field;
use crate::linear_algebra::vector::add_scaled;
use crate::space::Space;

/// Terms of a history's criterion.
pub(super) struct Criterion<'a, const D: usize> {
    pub energy: Option<EnergyAt<'a, D>>,
    /// By the number of the step.
    pub observations: BTreeMap<usize, Vec<Observations<D>>>,
    pub of_controls: Option<OfControls<'a>>,
    /// The second derivative of that along a direction.
    pub curvature_of_controls: Option<CurvatureOfControls<'a>>,
}

pub(super) type EnergyAt<'a, const D: usize> =
    Box<dyn Fn(&ControlValues<D>) -> Result<Energy<D>, ControlError> + 'a>;
pub(super) type OfControls<'a> = Box<dyn Fn(&[f64]) -> (f64, Vec<f64>) + 'a>;
pub(super) type CurvatureOfControls<'a> = Box<dyn Fn(&[f64], &[f64]) -> Vec<f64> + 'a>;

/// The states that an energy reads: of the first unknowns, as many as it has.
fn read_by<'f, const D: usize>(energy: &Energy<D>, states: &'f [Field<D>]) -> Vec<&'f Field<D>> {
    let count = energy.fields().iter().filter(|field| matches!(field.role, Role::Unknown(_))).count();
    states.iter().take(count).collect()
}

/// The first unknown on the space of observations.
fn unknown_of<const D: usize>(observations: &Observations<D>, states: &[Field<D>]) -> usize {
    states.iter().position(|state| observations.fit(state.space())).unwrap_or(0)
}

/// The number of coefficients of the unknowns before one.
fn values_before<const D: usize>(unknown: usize, states: &[Field<D>]) -> usize {
    states[..unknown].iter().map(|field| field.values().len()).sum()
}

impl<'a, const D: usize> Criterion<'a, D> {
    /// No criterion yet.
    pub fn none() -> Criterion<'a, D> {
        Criterion {
            energy: None,
            observations: BTreeMap::new(),
            of_controls: None,
            curvature_of_controls: None,
        }
    }

    /// Check that the criterion reads states of the history.
    ///
    /// # Errors
    /// [`HistoryFailure::Missing`].
    pub fn exists(&self) -> Result<(), HistoryFailure> {
        if self.energy.is_none() && self.observations.is_empty() {
            return Err(HistoryFailure::Missing("criterion"));
        }
        Ok(())
    }

    /// Whether it is one of states on the spaces of a history with the given number of steps.
    ///
    /// # Errors
    /// [`HistoryFailure::ObservedLater`], [`HistoryFailure::ObservedElsewhere`].
    pub fn check(&self, spaces: &[&Arc<Space<D>>], steps: usize) -> Result<(), HistoryFailure> {
        if let Some(step) = self.observations.keys().find(|step| **step >= steps) {
            return Err(HistoryFailure::ObservedLater { step: *step, steps });
        }
        let mut all = self.observations.iter().flat_map(|(step, all)| all.iter().map(move |one| (step, one)));
        match all.find(|(_, one)| !spaces.iter().any(|space| one.fit(space))) {
            Some((step, _)) => Err(HistoryFailure::ObservedElsewhere { step: *step }),
            None => Ok(()),
        }
    }

    /// Contribution of a step.
    ///
    /// # Errors
    /// Those of the energy.
    pub fn value(
        &self,
        at: &ControlValues<D>,
        equations: &StepEquations<'_, D>,
        after: &[Field<D>],
    ) -> Result<f64, HistoryFailure> {
        let energy = match &self.energy {
            Some(energy) => {
                let energy = energy(at)?;
                equations.check_given(&energy)?;
                let own = equations.assembler.energy(&energy, &read_by(&energy, after))?;
                equations.totals(vec![own])?[0]
            }
            None => 0.0,
        };
        let Some(observed) = self.observations.get(&at.step()) else { return Ok(energy) };
        let value = |one: &Observations<D>| one.value(after[unknown_of(one, after)].values());
        let values = equations.totals(observed.iter().map(value).collect())?;
        Ok(values.into_iter().fold(energy, |sum, value| sum + value))
    }

    /// Learns which process counts an observation, where they have parts of a mesh.
    ///
    /// # Errors
    /// A point that is on no process; a failed exchange.
    pub fn divide(&mut self, equations: &StepEquations<'_, D>) -> Result<(), HistoryFailure> {
        for one in self.observations.values_mut().flatten() {
            let processes = equations.processes_of(|space| one.fit(space));
            one.divide(processes)?;
        }
        Ok(())
    }

    /// Adds what observations of a step give of a vector over the unknowns.
    fn add_observed(
        &self,
        step: usize,
        equations: &StepEquations<'_, D>,
        states: &[Field<D>],
        sum: &mut [f64],
        add: impl Fn(&Observations<D>, &[f64], &mut [f64]),
    ) -> Result<(), HistoryFailure> {
        let Some(observed) = self.observations.get(&step) else { return Ok(()) };
        let mut own = equations.processes().divided().map(|_| vec![0.0; sum.len()]);
        for one in observed {
            let unknown = unknown_of(one, states);
            let from = values_before(unknown, states);
            add(one, states[unknown].values(), &mut own.as_deref_mut().unwrap_or(&mut *sum)[from..]);
        }
        if let Some(own) = own {
            add_scaled(sum, 1.0, &equations.completed(None, own)?);
        }
        Ok(())
    }

    /// The derivative of [`Self::value`] with respect to the state after the step, added to `slope`.
    ///
    /// # Errors
    /// Those of the energy.
    pub fn add_slope(
        &self,
        at: &ControlValues<D>,
        equations: &StepEquations<'_, D>,
        after: &[Field<D>],
        slope: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        if let Some(energy) = &self.energy {
            let energy = energy(at)?;
            let read = read_by(&energy, after);
            let spaces: Vec<&Arc<Space<D>>> = read.iter().map(|field| field.space()).collect();
            let mut found = equations.assembler.residual(&energy, &read, &spaces)?;
            found.resize(slope.len(), 0.0);
            add_scaled(slope, 1.0, &equations.completed(None, found)?);
        }
        self.add_observed(at.step(), equations, after, slope, Observations::add_slope)
    }

    /// The second derivative of [`Self::value`] with respect to the state along a change of it, added.
    ///
    /// # Errors
    /// Those of the energy.
    pub fn add_curvature(
        &self,
        at: &ControlValues<D>,
        equations: &StepEquations<'_, D>,
        [after, change]: [&[Field<D>]; 2],
        curvature: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        if let Some(energy) = &self.energy {
            let energy = energy(at)?;
            let (read, changed) = (read_by(&energy, after), read_by(&energy, change));
            let spaces: Vec<&Arc<Space<D>>> = read.iter().map(|field| field.space()).collect();
            let mut product = equations.assembler.action(&energy, &read, &changed, &spaces)?;
            product.resize(curvature.len(), 0.0);
            add_scaled(curvature, 1.0, &equations.completed(None, product)?);
        }
        self.add_observed(at.step(), equations, change, curvature, Observations::add_curvature)
    }

    /// J, gradient and Hessian along a direction, from the sweep of second order over the steps, whose gradient contains them one after
    /// the other.
    ///
    /// # Errors
    /// [`HistoryFailure::Missing`] if the cost of the controls has no curvature; those of [`Self::add_cost_of_controls`].
    pub fn hessian(
        &self,
        mut found: Gradient,
        m: &[f64],
        direction: &[f64],
    ) -> Result<Hessian, HistoryFailure> {
        let mut along = found.gradient.split_off(m.len());
        self.add_cost_of_controls(m, &mut found)?;
        self.add_curvature_of_controls(m, direction, &mut along)?;
        let Gradient { value, gradient, work } = found;
        Ok(Hessian { value, gradient, along, work })
    }

    /// Adds the second derivative of the cost of the controls along a direction.
    fn add_curvature_of_controls(
        &self,
        m: &[f64],
        direction: &[f64],
        action: &mut [f64],
    ) -> Result<(), HistoryFailure> {
        let curvature = match (&self.of_controls, &self.curvature_of_controls) {
            (None, None) => return Ok(()),
            (_, Some(curvature)) => curvature(m, direction),
            (Some(_), None) => return Err(HistoryFailure::Missing("with_curvature_of_controls")),
        };
        if curvature.len() != m.len() {
            let (expected, found) = (m.len(), curvature.len());
            return Err(ControlError::Length { expected, found }.into());
        }
        add_scaled(action, 1.0, &curvature);
        Ok(())
    }

    /// Contribution of only the controls.
    ///
    /// # Errors
    /// Those of [`Self::add_cost_of_controls`].
    pub fn cost_of_controls(&self, m: &[f64]) -> Result<f64, HistoryFailure> {
        let mut alone = Gradient { value: 0.0, gradient: vec![0.0; m.len()], work: Work::default() };
        self.add_cost_of_controls(m, &mut alone)?;
        Ok(alone.value)
    }

    /// The cost of the controls, added to a value with its gradient.
    ///
    /// # Errors
    /// A gradient of another length than that of the controls.
    pub fn add_cost_of_controls(&self, m: &[f64], found: &mut Gradient) -> Result<(), HistoryFailure> {
        let Some(of_controls) = &self.of_controls else { return Ok(()) };
        let (value, gradient) = of_controls(m);
        if gradient.len() != m.len() {
            let (expected, found) = (m.len(), gradient.len());
            return Err(ControlError::Length { expected, found }.into());
        }
        found.value += value;
        add_scaled(&mut found.gradient, 1.0, &gradient);
        Ok(())
    }
}
