//! States between steps, and what a form reads in a step.

use std::sync::Arc;

use super::operators::{scalar, vector, vector_and_scalar};
use super::scheme::{Combination, Formulas};
use super::step_cost::StepCost;
use crate::contract::Given;
use crate::field::{Field, FieldError};
use crate::instantiate::instantiate;
use crate::solve::solved::resultant;
use crate::solve::{NewtonStep, ReactionError};
use crate::space::Space;

/// A value with its rates at a time: displacement, velocity and acceleration of a moving body.
#[derive(Clone, Debug)]
pub struct State<const D: usize> {
    /// Time.
    pub time: f64,
    /// The value.
    pub value: Field<D>,
    /// Its rate \[value/time\].
    pub rate: Field<D>,
    /// The rate of that \[value/time²\], as the scheme knows it. Schemes that read second rates give the first state one that agrees
    /// with the form when the first step is taken. With other schemes it stays zero, or what it was, until the end of the first step.
    ///
    /// At the end of a step it is of second order for the trapezoidal rule, central differences and backward differences of order 2,
    /// and of first order for schemes of the generalised-α family that balance forces before the end of a step. The mid-point rule
    /// gives that of the middle of the step, of second order there; schemes for first order give zero.
    pub second_rate: Field<D>,
}

impl<const D: usize> State<D> {
    /// A first state; the loop finds its second rate from the form, where the scheme reads one.
    ///
    /// # Errors
    /// [`FieldError::OtherSpace`] where value and rate are not on one space.
    pub fn new(time: f64, value: Field<D>, rate: Field<D>) -> Result<Self, FieldError> {
        let second_rate = value.minus(&rate)?.times(0.0)?;
        Ok(State { time, value, rate, second_rate })
    }

    /// The field that has the value, with the rate zero: a start at rest.
    pub fn at_rest(time: f64, value: Field<D>) -> Self {
        let zero = Field::zero(value.space());
        State { time, value, rate: zero.clone(), second_rate: zero }
    }
}

/// A step about to be taken, as a form reads it: `step.into()` is the `Data` of [`operators`](super::operators).
#[derive(Clone, Debug)]
pub struct Step<const D: usize> {
    /// The state before.
    pub before: State<D>,
    /// Time at the end of the step.
    pub end: f64,
    /// The time for which loads are to be given: between the ends of the step as the scheme says.
    pub time: f64,
    /// Weights of the unknown in value, rate and second rate.
    pub weights: [f64; 3],
    /// Known parts of value, rate and second rate.
    pub known: [Field<D>; 3],
}

impl<const D: usize> Step<D> {
    /// Δt.
    pub fn size(&self) -> f64 {
        self.end - self.before.time
    }

    /// The step to `end` by these formulas, with the states before it, newest first.
    #[inline(never)]
    pub(super) fn new(states: &[&State<D>], end: f64, formulas: &Formulas) -> Result<Self, FieldError> {
        let before = states[0].clone();
        let [value, rate, second_rate] = &formulas.evaluated;
        Ok(Step {
            end,
            time: before.time + formulas.load_at * (end - before.time),
            weights: [value.unknown, rate.unknown, second_rate.unknown],
            known: [known(value, states)?, known(rate, states)?, known(second_rate, states)?],
            before,
        })
    }
}

/// The part of a combination that the states give.
#[inline(never)]
pub(super) fn known<const D: usize>(
    combination: &Combination,
    states: &[&State<D>],
) -> Result<Field<D>, FieldError> {
    let mut terms = vec![];
    for (weights, state) in combination.states.iter().zip(states) {
        let fields = [&state.value, &state.rate, &state.second_rate];
        terms.extend(weights.iter().copied().zip(fields).filter(|(weight, _)| *weight != 0.0));
    }
    match terms.is_empty() {
        true => Ok(Field::zero(states[0].value.space())),
        false => Field::combination(&terms),
    }
}

impl<const D: usize> From<&Step<D>> for vector::Data<D> {
    fn from(step: &Step<D>) -> Self {
        let [value_weight, rate_weight, second_rate_weight] = step.weights;
        let [known_value, known_rate, known_second_rate] = step.known.each_ref().map(Given::field);
        vector::data()
            .value_weight(value_weight)
            .rate_weight(rate_weight)
            .second_rate_weight(second_rate_weight)
            .known_value(known_value)
            .known_rate(known_rate)
            .known_second_rate(known_second_rate)
    }
}

impl<const D: usize> From<&[Step<D>; 2]> for vector_and_scalar::Data<D> {
    fn from([first, second]: &[Step<D>; 2]) -> Self {
        let [scalar_value_weight, scalar_rate_weight, _] = second.weights;
        let [known_scalar_value, known_scalar_rate, _] = second.known.each_ref().map(Given::field);
        vector_and_scalar::data_from(first)
            .scalar_value_weight(scalar_value_weight)
            .scalar_rate_weight(scalar_rate_weight)
            .known_scalar_value(known_scalar_value)
            .known_scalar_rate(known_scalar_rate)
    }
}

impl<const D: usize> From<&Step<D>> for scalar::Data<D> {
    fn from(step: &Step<D>) -> Self {
        let [value_weight, rate_weight, second_rate_weight] = step.weights;
        let [known_value, known_rate, known_second_rate] = step.known.each_ref().map(Given::field);
        scalar::data()
            .value_weight(value_weight)
            .rate_weight(rate_weight)
            .second_rate_weight(second_rate_weight)
            .known_value(known_value)
            .known_rate(known_rate)
            .known_second_rate(known_second_rate)
    }
}

/// Account of a step that was taken.
#[derive(Clone, Debug)]
pub struct Taken<const D: usize> {
    /// Steps before this one.
    pub number: usize,
    /// Time before the step.
    pub from: f64,
    /// Time at its end.
    pub to: f64,
    /// Newton's iterates; none where the form is affine, or the step explicit.
    pub history: Vec<NewtonStep>,
    /// R(u) on all unknowns: reactions where values are prescribed, about zero elsewhere; of a step that is one residual and one solve
    /// computed where constraints act, and zero elsewhere.
    pub residual: Vec<f64>,
    /// Work of the step, part by part; none where Newton's method has solved it.
    pub cost: Option<StepCost>,
    /// Estimate of the error that this step has added to the value of the first unknown, at the node where it is largest; none where
    /// the scheme has no rule for it.
    pub error: Option<f64>,
    /// The space of each unknown.
    pub(super) spaces: Vec<Arc<Space<D>>>,
}

impl<const D: usize> Taken<D> {
    /// Number of points on the active side of their kinks at the end of the step, as points in contact; none of affine forms.
    pub fn active_points(&self) -> Option<usize> {
        self.history.last().and_then(|step| step.active_points)
    }

    /// [`Taken::reaction_of`] the first unknown.
    ///
    /// # Errors
    /// [`ReactionError::Region`].
    pub fn reaction(&self, region: &str) -> Result<Vec<f64>, ReactionError> {
        self.reaction_of(0, region)
    }

    /// The resultant of the forces by which the constraints of an unknown hold the nodes of a region at the time at which the scheme
    /// evaluates the form, one number per component, as [`Solved::reaction_of`](crate::solve::Solved::reaction_of) says.
    ///
    /// # Errors
    /// [`ReactionError::Region`], [`ReactionError::Unknown`].
    pub fn reaction_of(&self, unknown: usize, region: &str) -> Result<Vec<f64>, ReactionError> {
        let count = self.spaces.len();
        let space = self.spaces.get(unknown).ok_or(ReactionError::Unknown { number: unknown, count })?;
        let offset = self.spaces[..unknown].iter().map(|space| space.unknowns()).sum::<usize>();
        resultant(space, &self.residual[offset..], region)
    }
}

instantiate!(step: Step::<D>::new, known::<D>);
