//! Names of regions on a new mesh.

use std::collections::BTreeMap;

use super::RemeshingError;
use super::outline::{Arc, Outline, ends_and_middle};
use crate::disjoint_sets::DisjointSets;
use crate::facet::Facet;
use crate::mesh::{EVERYWHERE, INTERIOR, Mesh};

/// Carries the regions of a mesh to a new one with the same outline.
pub(super) fn carry(
    old: &Mesh<2>,
    outline: &Outline,
    new: &mut Mesh<2>,
    cells_of_facets: &[(&str, &str)],
) -> Result<(), RemeshingError> {
    if let Some(name) = old.interior_facet_region_names().find(|name| *name != INTERIOR) {
        let why = "facets between cells have no place in an outline";
        return Err(RemeshingError::Region { name: name.to_owned(), why });
    }
    let mut facets: BTreeMap<&str, Vec<Facet>> = BTreeMap::new();
    let components = components(new);
    let old_components = self::components(old);
    // The old component that each new one is.
    let mut origin: BTreeMap<u32, u32> = BTreeMap::new();
    for &facet in new.boundary_facets() {
        let [start, middle, end] = ends_and_middle(new, facet);
        let Some(arc) = outline.nearest(&middle) else { continue };
        let new_arc = Arc { nodes: [start, middle, end], facet: None, regions: arc.regions };
        for near_an_end in [0.1, 0.9].map(|t| new_arc.point(t)) {
            if let Some(other) = outline.nearest(&near_an_end)
                && other.regions != arc.regions
            {
                let names = [arc.regions, other.regions].map(|set| outline.sets.get(set).cloned());
                let [own, others] = names.map(Option::unwrap_or_default);
                let differs = |name: &&String| own.contains(name) != others.contains(name);
                let name = own.iter().chain(&others).find(differs).cloned().unwrap_or_default();
                let why = "it ends inside a facet of the new outline, which is cut where a sector ends";
                return Err(RemeshingError::Region { name, why });
            }
        }
        for name in outline.sets.get(arc.regions).into_iter().flatten() {
            facets.entry(name).or_default().push(facet);
        }
        if let Some(own) = arc.facet {
            origin.insert(components[facet.cell as usize], old_components[own.cell as usize]);
        }
    }
    for (name, facets) in facets {
        new.name_listed_facets(name, &facets)?;
    }
    for name in old.facet_region_names() {
        // One that is so short that no new facet belongs to it.
        new.facet_region(name)?;
    }
    for name in old.cell_region_names().filter(|name| *name != EVERYWHERE) {
        if let Some((_, facets)) = cells_of_facets.iter().find(|(cells, _)| *cells == name) {
            new.name_cells_of_facets(name, facets)?;
            continue;
        }
        let cells = old.cell_region(name)?;
        let own: Vec<u32> = cells.iter().map(|cell| old_components[*cell as usize]).collect();
        let whole = old_components.iter().filter(|component| own.contains(component)).count();
        if whole != cells.len() {
            let why = "its cells are a part of a body that hangs together";
            return Err(RemeshingError::Region { name: name.to_owned(), why });
        }
        let is_in = |cell: &u32| origin.get(&components[*cell as usize]).is_some_and(|old| own.contains(old));
        let cells: Vec<u32> = (0..new.cell_count() as u32).filter(is_in).collect();
        new.name_listed_cells(name, &cells)?;
    }
    Ok(())
}

/// The component of each cell, by the least cell of it.
fn components(mesh: &Mesh<2>) -> Vec<u32> {
    let mut components = DisjointSets::new(mesh.cell_count());
    for [one, other] in mesh.interior_facets() {
        components.join(one.cell, other.cell);
    }
    (0..mesh.cell_count() as u32).map(|cell| components.root(cell)).collect()
}

/// The mesh with the nodes of a region of facets on a curve.
pub(super) fn put_onto(
    mesh: &Mesh<2>,
    region: &str,
    surface: &dyn Fn(&[f64; 2]) -> [f64; 2],
) -> Result<Mesh<2>, RemeshingError> {
    let mut nodes = mesh.nodes().to_vec();
    for facet in mesh.facet_region(region)? {
        let cell = facet.cell as usize;
        for local in mesh.cell_element(cell).facet_nodes(facet.local.into()) {
            let node = mesh.cell(cell)[local] as usize;
            nodes[node] = surface(&mesh.nodes()[node]);
        }
    }
    Ok(mesh.with_nodes(nodes)?)
}
