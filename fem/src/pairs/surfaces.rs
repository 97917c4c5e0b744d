//! The surfaces of a pairing by name, parametrised once for all that read them, and the values that displace them.

use forms_core::contract::Pairing;

use super::displacement::Displacement;
use super::surface::SurfaceFacet;
use super::traces::Traces;
use super::{PairError, rigid};
use crate::element::Lagrange;
use crate::mesh::{Facet, Mesh};
use crate::threads::Threads;

/// Facets that a thread parametrises at a time.
const CHUNK: usize = 256;

/// The facets of each name.
pub(super) struct Surfaces<'m, const D: usize> {
    named: Vec<(String, Vec<SurfaceFacet<'m, D>>)>,
    pub displaced: bool,
}

/// The facets of a surface of a body, of which there is one at least.
fn facets<'m, const D: usize>(mesh: &'m Mesh<D>, name: &str) -> Result<&'m [Facet], PairError> {
    let facets = mesh.facet_region(name).map_err(|source| PairError::Surface { source })?;
    match facets.is_empty() {
        true => Err(PairError::Empty { surface: name.to_owned() }),
        false => Ok(facets),
    }
}

/// The names of a pairing's surfaces, each once.
fn names(pairing: &Pairing) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for name in pairing.surfaces.iter().flat_map(|facing| [&facing.own, &facing.opposite]) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

impl<'m, const D: usize> Surfaces<'m, D> {
    /// Those of a pairing, displaced.
    pub fn new(
        mesh: &'m Mesh<D>,
        pairing: &Pairing,
        displacement: Option<&Displacement<D>>,
        threads: Threads,
    ) -> Result<Self, PairError> {
        let mut surfaces = Vec::new();
        for name in names(pairing) {
            if let Some(carried) = mesh.rigid_surface(name) {
                surfaces.push((name.to_owned(), rigid::facets(mesh, carried, displacement, threads)?));
                continue;
            }
            let facets = facets(mesh, name)?;
            let parts = threads.count().min(facets.len().div_ceil(CHUNK)).max(1);
            let cut = |part: usize| part * facets.len() / parts;
            let parts = (0..parts).map(|part| &facets[cut(part)..cut(part + 1)]).collect();
            let parametrised = threads.run(parts, |facets: &[Facet]| -> Vec<SurfaceFacet<'m, D>> {
                let mut traces = Traces::default();
                let parametrised = |facet: &Facet| SurfaceFacet::new(mesh, *facet, displacement, &mut traces);
                facets.iter().map(parametrised).collect()
            });
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

/// Degrees and values of the fields that displace a pairing's surfaces, at the nodes of their facets: what pairs depend on.
pub(super) fn displacements<const D: usize>(
    mesh: &Mesh<D>,
    pairing: &Pairing,
    displacement: &Displacement<D>,
) -> Result<Vec<f64>, PairError> {
    let mut values: Vec<f64> = displacement.fields.iter().map(|field| field.space.degree as f64).collect();
    let mut known: Vec<(Lagrange, u8, Vec<usize>)> = Vec::new();
    for name in names(pairing) {
        if let Some(carried) = mesh.rigid_surface(name) {
            for field in &displacement.fields {
                let nodes = field.space.nodes_at(carried.cell, None);
                values.extend(nodes.iter().flat_map(|node| field.value_at(*node)));
            }
            continue;
        }
        for facet in facets(mesh, name)? {
            let shape = mesh.cell_shape(facet.cell as usize);
            for field in &displacement.fields {
                let element = Lagrange { shape, degree: field.space.degree };
                let is_this =
                    |known: &(Lagrange, u8, Vec<usize>)| known.0 == element && known.1 == facet.local;
                let place = known.iter().position(is_this).unwrap_or_else(|| {
                    // The one node of degree zero lies on no facet, and is read at all.
                    let nodes = match element.degree {
                        0 => vec![0],
                        _ => element.facet_nodes(usize::from(facet.local)),
                    };
                    known.push((element, facet.local, nodes));
                    known.len() - 1
                });
                let nodes = field.space.nodes_at(facet.cell, Some(facet.local));
                values.extend(known[place].2.iter().flat_map(|node| field.value_at(nodes[*node])));
            }
        }
    }
    Ok(values)
}
