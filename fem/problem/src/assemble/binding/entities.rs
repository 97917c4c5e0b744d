//! The cells or facets of a form's region.

use std::borrow::Cow;

use forms_core::contract::{Entity, Region};

use super::pair_error;
use crate::assemble::AssemblyError;
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Mesh, MeshError};
use crate::pairs::PairError;

/// The cells or facets of a region.
pub(in crate::assemble) enum Entities<'a> {
    Cells(Cow<'a, [u32]>),
    Facets(Cow<'a, [Facet]>),
    InteriorFacets(Cow<'a, [[Facet; 2]]>),
}

impl<'a> Entities<'a> {
    /// The entities of a form's region.
    ///
    /// # Errors
    /// [`AssemblyError::Region`], and pairs that are not bound to a pairing.
    #[inline(never)]
    pub fn of<const D: usize>(
        mesh: &'a Mesh<D>,
        form: &'static str,
        region: &Region,
    ) -> Result<Self, AssemblyError> {
        let name = &region.name;
        let found = match region.entity {
            Entity::Cells if mesh.rigid_surface(name).is_some() => {
                Err(MeshError::NoBody { name: name.clone() })
            }
            Entity::Cells => mesh.cell_region(name).map(|cells| Entities::Cells(cells.into())),
            Entity::Facets => mesh.facet_region(name).map(|facets| Entities::Facets(facets.into())),
            // Their facets follow from a search, not from a name: `Binding::pairs`.
            Entity::Pairs => return Err(pair_error(form, region, PairError::NoPairing)),
            Entity::InteriorFacets => {
                mesh.interior_facet_region(name).map(|facets| Entities::InteriorFacets(facets.into()))
            }
        };
        found.map_err(|source| AssemblyError::Region { form, symbol: region.symbol, source })
    }

    /// Number of cells or facets.
    pub fn count(&self) -> usize {
        match self {
            Entities::Cells(cells) => cells.len(),
            Entities::Facets(facets) => facets.len(),
            Entities::InteriorFacets(facets) => facets.len(),
        }
    }

    /// The sides of a facet: one or two. Cells have none.
    pub fn sides(&self, index: usize) -> &[Facet] {
        match self {
            Entities::Cells(_) => &[],
            Entities::Facets(facets) => &facets[index..index + 1],
            Entities::InteriorFacets(facets) => &facets[index],
        }
    }
}

instantiate!(entities: Entities::of::<D>);
