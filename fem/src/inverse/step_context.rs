//! A step of a motion as its form reads it.

use std::cell::Cell;

use super::controls::{ControlError, ControlValues};
use crate::field::Field;
use crate::time::Step;
use crate::time::operators::{scalar, vector};

/// Data of a form of motion in a step: `during.into()` is the `Data` of the operators of [`time`](crate::time).
#[derive(Clone, Copy, Debug)]
pub struct StepContext<'a, const D: usize> {
    /// Of each unknown.
    pub(super) steps: &'a [Step<D>],
    pub(super) at: ControlValues<'a, D>,
    /// Whether the state before was asked for.
    pub(super) before_is_read: &'a Cell<bool>,
}

impl<const D: usize> StepContext<'_, D> {
    /// The time for which loads are to be given.
    pub fn time(&self) -> f64 {
        self.steps[0].time
    }

    /// The steps of N unknowns, in their order: `during.steps::<2>()?.into()` is the `Data` of
    /// [`vector_and_scalar`](crate::time::operators::vector_and_scalar).
    ///
    /// # Errors
    /// [`ControlError::StepsOfUnknowns`] where the motion has another number of unknowns.
    pub fn steps<const N: usize>(&self) -> Result<&[Step<D>; N], ControlError> {
        let count = self.steps.len();
        <&[Step<D>; N]>::try_from(self.steps).map_err(|_| ControlError::StepsOfUnknowns { asked: N, count })
    }

    /// The value before the step, of the first unknown, which a form takes as a `State` next to what the operators of [`time`](crate::time) give, as the
    /// schemes of impact do. Its rates then have a test function `by_before`, of the derivative by it.
    pub fn before(&self) -> &Field<D> {
        self.before_is_read.set(true);
        &self.steps[0].before.value
    }

    /// The values of all unknowns before the step; their rates then have a test function `by_before_u` for that of the unknown `u`, and so on.
    pub fn before_of_all(&self) -> Vec<&Field<D>> {
        self.before_is_read.set(true);
        self.steps.iter().map(|step| &step.before.value).collect()
    }

    /// The value of a number in this step.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn number(&self, name: &str) -> Result<f64, ControlError> {
        self.at.number(name)
    }

    /// The field of a control.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn field(&self, name: &str) -> Result<Field<D>, ControlError> {
        self.at.field(name)
    }
}

impl<const D: usize> From<&StepContext<'_, D>> for vector::Data<D> {
    fn from(during: &StepContext<'_, D>) -> Self {
        (&during.steps[0]).into()
    }
}

impl<const D: usize> From<&StepContext<'_, D>> for scalar::Data<D> {
    fn from(during: &StepContext<'_, D>) -> Self {
        (&during.steps[0]).into()
    }
}
