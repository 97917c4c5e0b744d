//! Histories that kernels read at the points of contact pairs.

use forms_core::contract::{Pairing, Requirements};

use super::{Binding, Values};
use crate::assemble::AssemblyError;
use crate::instantiate::instantiate;

impl<const D: usize> Binding<'_, D> {
    /// Whether the histories that a kernel reads on contact pairs belong to these, and how many there are.
    ///
    /// # Errors
    /// [`AssemblyError::History`]: a history of other pairs.
    #[inline(never)]
    pub fn histories_on_pairs(
        &self,
        requirements: &Requirements,
        pairing: &Pairing,
    ) -> Result<usize, AssemblyError> {
        let mut count = 0;
        for (number, values) in self.values.iter().enumerate() {
            let Values::History(history) = values else { continue };
            let (form, field) = (self.name, self.fields[number].name);
            let checked = history.check_on_pairs(requirements, number, pairing);
            checked.map_err(|source| AssemblyError::History { form, field, source })?;
            count += usize::from(requirements.fields.iter().any(|slot| slot.field == number));
        }
        Ok(count)
    }
}

instantiate!(pair_histories: Binding::<D>::histories_on_pairs);
