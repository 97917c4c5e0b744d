//! Conditions on the unknowns of a problem as functions of a time or of the number of a step.

use std::sync::Arc;

use crate::constraints::{Constraints, ConstraintsError};
use crate::space::Space;

/// Conditions, each on one unknown: the first one on their space that has none yet.
pub(crate) struct Conditions<'a, T, const D: usize> {
    given: Vec<ConstraintsAt<'a, T, D>>,
}

type ConstraintsAt<'a, T, const D: usize> = Box<dyn Fn(T) -> Result<Constraints<D>, ConstraintsError> + 'a>;

impl<'a, T: Copy, const D: usize> Conditions<'a, T, D> {
    /// No conditions.
    pub fn none() -> Self {
        Conditions { given: vec![] }
    }

    /// More conditions, on one unknown.
    pub fn push(&mut self, constraints: impl Fn(T) -> Result<Constraints<D>, ConstraintsError> + 'a) {
        self.given.push(Box::new(constraints));
    }

    /// Conditions on each space at a time; none if some are on a space on which no unknown is left without.
    ///
    /// # Errors
    /// Those of the functions.
    pub fn at(
        &self,
        time: T,
        spaces: &[&Arc<Space<D>>],
    ) -> Result<Option<Vec<Constraints<D>>>, ConstraintsError> {
        let mut all: Vec<Option<Constraints<D>>> = vec![None; spaces.len()];
        for constraints in &self.given {
            let constraints = constraints(time)?;
            let fits =
                |number: &usize| all[*number].is_none() && spaces[*number].numbers_as(constraints.space());
            match (0..all.len()).find(fits) {
                Some(number) => all[number] = Some(constraints),
                None => return Ok(None),
            }
        }
        let or_none =
            |(given, space): (Option<_>, &&Arc<Space<D>>)| given.unwrap_or_else(|| Constraints::new(space));
        Ok(Some(all.into_iter().zip(spaces).map(or_none).collect()))
    }
}

/// Prescribes zero for unknowns, by their numbers on the conditions' space.
pub(crate) fn hold<const D: usize>(
    conditions: &mut Constraints<D>,
    unknowns: impl IntoIterator<Item = usize>,
) -> Result<(), ConstraintsError> {
    let components = conditions.space().components();
    unknowns.into_iter().try_for_each(|unknown| {
        conditions.fix_node(unknown / components, unknown % components, 0.0).map(|_| ())
    })
}
