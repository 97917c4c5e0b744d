//! The surfaces of a pairing by name, parametrised once for all that read them, and the values that displace them.

use std::ops::Range;

use forms_core::contract::Pairing;

use super::displacement::Displacement;
use super::rest::SurfacesAtRest;
use super::surface::SurfaceFacet;
use super::{PairError, rigid};
use crate::mesh::{Facet, Mesh};
use crate::space::Space;
use crate::threads::Threads;

/// Facets that a thread parametrises at a time.
const CHUNK: usize = 256;

/// The facets of each name.
pub(super) struct Surfaces<'m, const D: usize> {
    named: Vec<(String, Vec<SurfaceFacet<'m, D>>)>,
    pub displaced: bool,
}

/// The facets of a surface of a body, at least one.
fn facets<'m, const D: usize>(mesh: &'m Mesh<D>, name: &str) -> Result<&'m [Facet], PairError> {
    let facets = mesh.facets_of_surface(name).map_err(|source| PairError::Surface { source })?;
    match facets.is_empty() {
        true => Err(PairError::Empty { surface: name.to_owned() }),
        false => Ok(facets),
    }
}

/// The names of a pairing's surfaces, each once.
pub(super) fn names(pairing: &Pairing) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for name in pairing.surfaces.iter().flat_map(|facing| [&facing.own, &facing.opposite]) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

impl<'m, const D: usize> Surfaces<'m, D> {
    /// The displaced surfaces of a pairing, from the data that are known at rest.
    ///
    /// # Errors
    /// A surface that does not exist, or displacements that fold it.
    pub fn new(
        mesh: &'m Mesh<D>,
        pairing: &Pairing,
        at_rest: &SurfacesAtRest<D>,
        displacement: Option<&Displacement<D>>,
        threads: Threads,
    ) -> Result<Self, PairError> {
        let mut surfaces = Vec::new();
        for name in names(pairing) {
            if let Some(carried) = mesh.rigid_surface(name) {
                surfaces.push((name.to_owned(), rigid::facets(mesh, carried, displacement, threads)?));
                continue;
            }
            let surface = at_rest.of(mesh, name, facets(mesh, name)?, displacement);
            let count = surface.facets.len();
            let parts = threads.count().min(count.div_ceil(CHUNK)).max(1);
            let cut = |part: usize| part * count / parts;
            let parts = (0..parts).map(|part| cut(part)..cut(part + 1)).collect();
            let parametrised = threads
                .run(parts, |facets: Range<usize>| SurfaceFacet::all(mesh, &surface, facets, displacement));
            // The first part's memory serves for all: on one thread nothing is copied.
            let joined = parametrised.into_iter().reduce(|mut all, mut part| {
                all.append(&mut part);
                all
            });
            surfaces.push((name.to_owned(), joined.unwrap_or_default()));
        }
        Ok(Surfaces { named: surfaces, displaced: displacement.is_some() })
    }

    pub fn of(&self, name: &str) -> &[SurfaceFacet<'m, D>] {
        self.named.iter().find(|(known, _)| known == name).map_or(&[], |(_, facets)| facets)
    }
}

/// The nodes of a space on the surfaces of a pairing, ascending: those whose values displace the surfaces.
pub(super) fn nodes_on_surfaces<const D: usize>(
    mesh: &Mesh<D>,
    pairing: &Pairing,
    space: &Space<D>,
) -> Result<Vec<u32>, PairError> {
    let mut on_surfaces: Vec<u32> = Vec::new();
    for name in names(pairing) {
        if let Some(carried) = mesh.rigid_surface(name) {
            on_surfaces.extend(space.nodes_at(carried.cell, None));
            continue;
        }
        for facet in facets(mesh, name)? {
            let element = space.traces_of(mesh.cell_shape(facet.cell as usize));
            let nodes = space.nodes_at(facet.cell, Some(facet.local));
            match element.degree {
                // The one node of degree zero lies on no facet, and is read at all.
                0 => on_surfaces.push(nodes[0]),
                _ => {
                    let of_facet = element.facet_nodes(usize::from(facet.local));
                    on_surfaces.extend(of_facet.into_iter().map(|node| nodes[node]));
                }
            }
        }
    }
    on_surfaces.sort_unstable();
    on_surfaces.dedup();
    Ok(on_surfaces)
}
