//! From a file's elements of dimension D − 1 to regions of facets.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::cells::Cells;
use super::contents::{Contents, Element};
use super::problem::{Flaw, ImportProblem, Note, Result};
use crate::mesh::{Facet, Mesh};

/// The sides of the facets that are asked for by their sorted vertices; of those that do not exist there are none.
fn find_sides<const D: usize>(mesh: &Mesh<D>, sides: &mut HashMap<[u32; 4], Vec<Facet>>) {
    let exterior = mesh.boundary_facets().iter().map(std::slice::from_ref);
    let interior = mesh.interior_facets().iter().map(<[Facet; 2]>::as_slice);
    for found in exterior.chain(interior) {
        if let Some(wanted) = sides.get_mut(&key(mesh.facet_vertices(found[0]))) {
            wanted.extend(found);
        }
    }
}

fn key(vertices: impl Iterator<Item = u32>) -> [u32; 4] {
    let mut key = [u32::MAX; 4];
    for (entry, vertex) in key.iter_mut().zip(vertices) {
        *entry = vertex;
    }
    key.sort_unstable();
    key
}

// Whether one list runs around the facet as the other does.
fn runs_alike(a: &[u32], b: &[u32]) -> bool {
    let start = b.iter().position(|vertex| *vertex == a[0]).unwrap_or(0);
    if a.len() == 2 { start == 0 } else { a[1] == b[(start + 1) % b.len()] }
}

/// The facets of a group.
#[derive(Default)]
struct Group {
    exterior: Vec<Facet>,
    interior: Vec<Facet>,
}

/// Groups of facets become regions.
pub(super) fn name_facets<const D: usize>(
    cells: &mut Cells<D>,
    contents: &Contents,
    notes: &mut Vec<Note>,
) -> Result<()> {
    let members = contents.elements.iter().filter(|element| element.kind.dimension + 1 == D);
    let members = members.filter(|element| !contents.membership(element).groups.is_empty());
    // Each with its vertices, if cells use all of these.
    let members: Vec<(&Element, Option<Vec<u32>>)> = members
        .map(|element| {
            let corners = &contents.nodes_of(element)[..element.kind.vertices];
            (element, corners.iter().map(|&tag| cells.number(tag)).collect())
        })
        .collect();
    if members.is_empty() {
        return Ok(());
    }
    let wanted = members.iter().flat_map(|(_, numbers)| numbers);
    let mut sides = wanted.map(|numbers| (key(numbers.iter().copied()), vec![])).collect();
    find_sides(&cells.mesh, &mut sides);
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    for (element, numbers) in &members {
        let found = numbers.as_ref().map(|numbers| (&sides[&key(numbers.iter().copied())], numbers));
        let found = found.filter(|(sides, _)| !sides.is_empty());
        for &group in &contents.membership(element).groups {
            let name = contents.group_name(D - 1, group);
            let Some((sides, numbers)) = found else {
                let problem =
                    ImportProblem::StrayFacet { element: contents.element(element.tag), group: name };
                return Err(Flaw::at(element.at, problem));
            };
            let group = groups.entry(name).or_default();
            match sides.as_slice() {
                [facet] => group.exterior.push(*facet),
                sides => {
                    let from_inside = |facet: &&Facet| {
                        let own: Vec<u32> = cells.mesh.facet_vertices(**facet).collect();
                        runs_alike(numbers, &own)
                    };
                    group.interior.extend(sides.iter().find(from_inside).or(sides.first()));
                }
            }
        }
    }
    for (name, group) in groups {
        name_group(&mut cells.mesh, name, group, notes)?;
    }
    Ok(())
}

fn name_group<const D: usize>(
    mesh: &mut Mesh<D>,
    name: String,
    mut group: Group,
    notes: &mut Vec<Note>,
) -> Result<()> {
    if mesh.cell_region(&name).is_ok() {
        return Err(ImportProblem::NameTwice { name, cells: D }.into());
    }
    group.exterior.sort_unstable();
    group.exterior.dedup();
    let mut interior_name = name.clone();
    if !group.exterior.is_empty() && !group.interior.is_empty() {
        interior_name.push_str(" (interior)");
        notes.push(Note::InteriorPart { name: name.clone(), interior: interior_name.clone() });
    }
    // "boundary" may be named again.
    if !group.exterior.is_empty() && mesh.facet_region(&name) != Ok(&group.exterior) {
        mesh.name_listed_facets(&name, &group.exterior)?;
    }
    if !group.interior.is_empty() {
        mesh.name_listed_interior_facets(&interior_name, &group.interior)?;
    }
    Ok(())
}

/// Notes of groups that are no regions.
pub(super) fn note_groups<const D: usize>(mesh: &Mesh<D>, contents: &Contents, notes: &mut Vec<Note>) {
    let mut low = BTreeSet::new();
    for element in contents.elements.iter().filter(|element| element.kind.dimension + 1 < D) {
        for &group in &contents.membership(element).groups {
            low.insert((element.kind.dimension, contents.group_name(element.kind.dimension, group)));
        }
    }
    for (&(group, _), name) in &contents.names {
        let exists = match group {
            _ if group == D => mesh.cell_region(name).is_ok(),
            _ if group + 1 == D => mesh.sides_of(name).is_ok(),
            _ => low.contains(&(group, name.clone())),
        };
        if !exists {
            notes.push(Note::EmptyGroup { name: name.clone(), dimension: group });
        }
    }
    notes.extend(low.into_iter().map(|(dimension, name)| Note::GroupLeftOut { name, dimension }));
}
