//! Histories that kernels read at the points of contact pairs.

use forms_core::contract::{Pairing, Requirements};

use super::{Binding, Values};
use crate::assemble::AssemblyError;
use crate::history::PointsOfPairs;
use crate::instantiate::instantiate;

impl<const D: usize> Binding<'_, D> {
    /// Whether the histories that a kernel reads on contact pairs belong to these.
    ///
    /// # Errors
    /// [`AssemblyError::History`]: a history of other pairs.
    #[inline(never)]
    pub fn histories_on_pairs(
        &self,
        requirements: &Requirements,
        pairing: &Pairing,
        points: PointsOfPairs,
    ) -> Result<(), AssemblyError> {
        for (number, values) in self.values.iter().enumerate() {
            let Values::History(history) = values else { continue };
            let (form, field) = (self.name, self.fields[number].name);
            let checked = history.check_on_pairs(requirements, number, pairing, points);
            checked.map_err(|source| AssemblyError::History { form, field, source })?;
        }
        Ok(())
    }
}

instantiate!(pair_histories: Binding::<D>::histories_on_pairs);
