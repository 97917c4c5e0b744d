//! Functions of position that kernels read on contact pairs: whether they are those of the body behind the surface.

use forms_core::contract::{FieldSlot, Region, Requirements};

use super::{Binding, Values, pair_error};
use crate::assemble::AssemblyError;
use crate::instantiate::instantiate;
use crate::pairs::{KnownPairs, ReadFunction};
use crate::quadrature::Quadrature;

impl<const D: usize> Binding<'_, D> {
    /// Refuses functions of position that a kernel reads on the pairs of a region where they are another body's.
    #[inline(never)]
    pub(in crate::assemble) fn check_functions_on_pairs(
        &self,
        region: usize,
        quadrature: &Quadrature<D>,
        degree: usize,
        requirements: &Requirements,
    ) -> Result<(), AssemblyError> {
        let Some((known, _)) = self.searches else { return Ok(()) };
        self.check_functions(known, &self.regions[region], quadrature, degree, requirements.fields)
    }

    /// The same for fields that are read on pairs that are none of a form's.
    #[inline(never)]
    pub(in crate::assemble) fn check_functions(
        &self,
        known: &KnownPairs<D>,
        region: &Region,
        quadrature: &Quadrature<D>,
        degree: usize,
        fields: &[FieldSlot],
    ) -> Result<(), AssemblyError> {
        let Some(pairing) = &region.pairing else { return Ok(()) };
        for FieldSlot { field, side, components, .. } in fields {
            let Values::Function { function, .. } = self.values[*field] else { continue };
            let name = self.fields[*field].name;
            let read = ReadFunction { name, side: *side, components: *components, function };
            let checked = known.check_function(self.mesh, pairing, quadrature, degree, &read);
            checked.map_err(|source| pair_error(self.name, region, source))?;
        }
        Ok(())
    }
}

instantiate!(
    functions_on_pairs: Binding::<D>::check_functions_on_pairs,
    Binding::<D>::check_functions,
);
