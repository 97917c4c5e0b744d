//! Functions of position that kernels read on contact pairs: whether they are those of the body behind the surface.

use forms_core::contract::{FieldSlot, Requirements};

use super::{Binding, Values, pair_error};
use crate::assemble::AssemblyError;
use crate::compiled_here::compiled_here;
use crate::pairs::ReadFunction;
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
        let region = &self.regions[region];
        let (Some((known, _)), Some(pairing)) = (self.searches, &region.pairing) else { return Ok(()) };
        for FieldSlot { field, side, components, .. } in requirements.fields {
            let Values::Function { function, .. } = self.values[*field] else { continue };
            let name = self.fields[*field].name;
            let read = ReadFunction { name, side: *side, components: *components, function };
            let checked = known.check_function(self.mesh, pairing, quadrature, degree, &read);
            checked.map_err(|source| pair_error(self.name, region, source))?;
        }
        Ok(())
    }
}

compiled_here!(functions_on_pairs: Binding::<D>::check_functions_on_pairs);
