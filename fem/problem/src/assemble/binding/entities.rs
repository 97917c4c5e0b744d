//! The cells or facets of a form's region.

use std::borrow::Cow;

use forms_core::contract::{Entity, Region};

use super::pair_error;
use crate::assemble::AssemblyError;
use crate::cut::{CUT, Cut, CutSide, GHOST, INSIDE};
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
            Entity::Cells | Entity::Interface if mesh.rigid_surface(name).is_some() => {
                Err(MeshError::NoBody { name: name.clone() })
            }
            // All cells through which an interface may pass.
            Entity::Cells | Entity::Interface => {
                mesh.cell_region(name).map(|cells| Entities::Cells(cells.into()))
            }
            Entity::Facets => mesh.facet_region(name).map(|facets| Entities::Facets(facets.into())),
            // Their facets follow from a search, not from a name: `Binding::pairs`.
            Entity::Pairs => return Err(pair_error(form, region, PairError::NoPairing)),
            Entity::InteriorFacets => {
                mesh.interior_facet_region(name).map(|facets| Entities::InteriorFacets(facets.into()))
            }
        };
        found.map_err(|source| AssemblyError::Region { form, symbol: region.symbol, source })
    }

    /// The entities of a form's region in a cut body: active cells, those with a part of an interface, and facets that are not outside. The
    /// names that a cut gives are known.
    ///
    /// # Errors
    /// As [`Entities::of`].
    #[inline(never)]
    pub fn inside<const D: usize>(
        cut: Option<&Cut<D>>,
        mesh: &'a Mesh<D>,
        form: &'static str,
        region: &Region,
    ) -> Result<Self, AssemblyError> {
        let Some(cut) = cut else { return Self::of(mesh, form, region) };
        let known = match (region.entity, &region.name[..]) {
            (Entity::Cells, CUT) => Some(Entities::Cells(cut.cut_cells().to_vec().into())),
            (Entity::Cells, INSIDE) => Some(Entities::Cells(cut.inside_cells().to_vec().into())),
            (Entity::InteriorFacets, GHOST) => {
                Some(Entities::InteriorFacets(cut.ghost_facets().to_vec().into()))
            }
            _ => None,
        };
        if let Some(known) = known {
            return Ok(known);
        }
        Ok(match Self::of(mesh, form, region)? {
            Entities::Cells(cells) => {
                let interface = region.entity == Entity::Interface;
                let is_wanted = |cell: &u32| match cut.side_of_cell(*cell) {
                    CutSide::Cut => true,
                    CutSide::Inside => !interface,
                    CutSide::Outside => false,
                };
                Entities::Cells(cells.iter().copied().filter(is_wanted).collect())
            }
            Entities::Facets(facets) => {
                let is_wanted = |facet: &Facet| cut.side_of_facet(*facet) != CutSide::Outside;
                Entities::Facets(facets.iter().copied().filter(is_wanted).collect())
            }
            Entities::InteriorFacets(facets) => {
                let is_wanted = |sides: &&[Facet; 2]| cut.side_of_facet(sides[0]) != CutSide::Outside;
                Entities::InteriorFacets(facets.iter().filter(is_wanted).copied().collect())
            }
        })
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

instantiate!(entities: Entities::of::<D>, Entities::inside::<D>);
