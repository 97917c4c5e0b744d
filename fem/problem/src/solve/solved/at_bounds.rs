//! Unknowns of a solution at their bounds, and constraints for its adjoint states.

use super::Solved;
use crate::constraints::{Constraints, ConstraintsError};
use crate::solve::newton::HeldUnknown;

/// The constraints of a solution's problem, and its unknowns at bounds, field by field.
#[derive(Clone, Debug)]
pub(in crate::solve) struct AtBounds<const D: usize, const N: usize> {
    pub constraints: [Constraints<D>; N],
    pub held: [Vec<HeldUnknown>; N],
    pub remark: Option<String>,
}

impl<const D: usize, const N: usize> Solved<D, N> {
    /// Unknowns of a field at their bounds, ascending, numbered in the field's own values; none for a field that does not exist.
    pub fn held_of(&self, unknown: usize) -> &[HeldUnknown] {
        self.at_bounds.held.get(unknown).map_or(&[], |held| held)
    }

    /// The constraints of a field's problem, and with them each unknown that a bound holds, prescribed as its value. An adjoint state
    /// obeys them as homogeneous ones ([`Problem::homogeneous`](crate::solve::Problem::homogeneous)). The adjoint problem's residual at a held
    /// unknown ([`Solved::residual`]) is then the derivative of the criterion with respect to its bound.
    ///
    /// Derivatives are exact if no unknown is held weakly ([`HeldUnknown::is_weak`]); [`Solved::notes`] says so where one is. A weakly held unknown is free in
    /// these constraints.
    ///
    /// # Errors
    /// [`ConstraintsError`] if the constraints do not take the values, as two unknowns of one relation. Another number than that of a field is
    /// [`ConstraintsError::Component`].
    pub fn held_at_bounds_of(&self, unknown: usize) -> Result<Constraints<D>, ConstraintsError> {
        let (Some(constraints), Some(field)) =
            (self.at_bounds.constraints.get(unknown), self.fields.get(unknown))
        else {
            let place = "the unknowns of the problem".to_owned();
            return Err(ConstraintsError::Component { place, component: unknown, components: N });
        };
        let mut constraints = constraints.clone();
        let components = field.space().components();
        for one in self.held_of(unknown).iter().filter(|one| !one.is_weak) {
            let value = field.values()[one.unknown];
            constraints.fix_node(one.unknown / components, one.unknown % components, value)?;
        }
        Ok(constraints)
    }
}

impl<const D: usize> Solved<D, 1> {
    /// [`Solved::held_of`] the only field.
    pub fn held(&self) -> &[HeldUnknown] {
        self.held_of(0)
    }

    /// [`Solved::held_at_bounds_of`] the only field.
    ///
    /// # Errors
    /// As there.
    pub fn held_at_bounds(&self) -> Result<Constraints<D>, ConstraintsError> {
        self.held_at_bounds_of(0)
    }
}
