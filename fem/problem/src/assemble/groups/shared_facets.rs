//! Groups of interior facets that the integrals of a form share: a tangent has an integral for each pair of sides, a residual one for each
//! side, and all of them have the same facets and points.

use std::rc::Rc;

use forms_core::contract::{Degree, Entity, Integral, Requirements, Role};

use super::means::FurtherTables;
use super::{Group, groups};
use crate::assemble::AssemblyError;
use crate::assemble::binding::Binding;
use crate::quadrature::Quadrature;
use crate::space::Space;

/// The groups of the last integral over interior facets, if there was one.
pub(in crate::assemble) struct SharedFacetGroups<const D: usize>(Option<Known<D>>);

/// Groups with the properties of an integral that they follow from.
struct Known<const D: usize> {
    region: usize,
    degree: Degree,
    further: FurtherTables,
    groups: Rc<Vec<Group<D>>>,
}

impl<const D: usize> Default for SharedFacetGroups<D> {
    fn default() -> Self {
        SharedFacetGroups(None)
    }
}

impl<const D: usize> SharedFacetGroups<D> {
    /// The groups of an integral, which are those of the last one where both have the same interior facets and points.
    ///
    /// # Errors
    /// As [`groups`].
    pub fn groups(
        &mut self,
        binding: &Binding<D>,
        integral: &Integral,
        quadrature: &Quadrature<D>,
        degrees: &[usize],
        requirements: &Requirements,
        arguments: &[(Role, &Space<D>)],
    ) -> Result<Rc<Vec<Group<D>>>, AssemblyError> {
        let (region, degree, further) = (integral.region, integral.degree, FurtherTables::of(requirements));
        // A history brings its own points, and straight facets a notice to a kernel that reads the curvature.
        let shared = binding.regions[region].entity == Entity::InteriorFacets
            && !requirements.curvature
            && binding.history_degree(requirements, quadrature)?.is_none();
        if let Some(known) = self.0.as_ref().filter(|_| shared)
            && (known.region, known.degree, known.further) == (region, degree, further)
        {
            return Ok(Rc::clone(&known.groups));
        }
        let groups = Rc::new(groups(binding, integral, quadrature, degrees, requirements, arguments)?);
        if shared {
            self.0 = Some(Known { region, degree, further, groups: Rc::clone(&groups) });
        }
        Ok(groups)
    }
}
