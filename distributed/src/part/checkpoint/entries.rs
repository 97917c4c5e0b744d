//! The nodes, cells and facets of the whole mesh that have values, as all processes know them, and a number of the mesh itself.

use forms_fem::contract::FieldValue;
use forms_fem::output::checksum;
use forms_fem::prelude::*;
use forms_fem::space::Scope;

use super::unfit;
use crate::error::PetscError;
use crate::part::MeshPart;
use crate::part::shared_nodes::{Key, Supports, Vertices};

/// A node, a cell or a facet with its values: the place of the first of them here, and their number.
pub(in crate::part) type Entry = (Key, usize, usize);

/// The nodes of a space on a mesh whose nodes have numbers in the whole.
pub(in crate::part) fn entries_of<const D: usize>(
    vertices: &Vertices,
    space: &Space<D>,
) -> Result<Vec<Entry>, PetscError> {
    let (mesh, components) = (space.mesh(), space.components());
    let (mut supports, mut entries) = (Supports::default(), vec![]);
    let mut is_known = vec![false; space.node_count()];
    for cell in 0..mesh.cell_count() {
        let nodes = space.cell_nodes(cell);
        match space.scope() {
            Scope::Nodes => {
                for (node, support) in nodes.iter().zip(supports.of(space, cell)) {
                    if !std::mem::replace(&mut is_known[*node as usize], true) {
                        let key = vertices.key(mesh.cell_vertices(cell), support);
                        entries.push((key, *node as usize * components, components));
                    }
                }
            }
            Scope::Cell | Scope::Point => {
                for (place, node) in nodes.iter().enumerate() {
                    let key = numbers_of(vertices, mesh, cell).chain([place as u64]).collect();
                    entries.push((key, *node as usize * components, components));
                }
            }
            scope => return Err(PetscError::Divided { what: format!("spaces {scope}") }),
        }
    }
    Ok(entries)
}

/// The cells or facets of a history, in the order of its values.
pub(super) fn entries_of_history<const D: usize, V: FieldValue>(
    part: &MeshPart<'_, D>,
    assembler: &Assembler<D>,
    history: &History<V, D>,
) -> Result<Vec<Entry>, PetscError> {
    if !assembler.mesh().is_same(part) {
        return Err(unfit("an assembler is not on this part of a mesh".to_owned()));
    }
    let mut first = 0;
    let entry = |(cell, facet, points): (u32, Option<u8>, usize)| {
        let facet = facet.map_or(0, |local| u64::from(local) + 1);
        let count = points * V::COMPONENTS;
        first += count;
        (numbers_of(&part.vertices, part, cell as usize).chain([facet]).collect(), first - count, count)
    };
    let entities = assembler.history_entities(history).map_err(unfit)?;
    if entities.is_empty() && !assembler.history_values(history).map_err(unfit)?.is_empty() {
        let what = "histories of pairs in checkpoints".to_owned();
        return Err(PetscError::Divided { what });
    }
    Ok(entities.into_iter().map(entry).collect())
}

/// A number of the whole mesh: of the numbers and positions of each cell's nodes, whatever the order of the cells and their division.
pub(in crate::part) fn mesh_of<const D: usize>(part: &MeshPart<'_, D>) -> Result<u64, PetscError> {
    let own = number_of(part, &part.vertices.numbers);
    Ok(part.world().gather(own)?.into_iter().fold(0, u64::wrapping_add))
}

/// The same of a mesh whose nodes have these numbers.
pub(in crate::part) fn number_of<const D: usize>(mesh: &Mesh<D>, numbers: &[u64]) -> u64 {
    let of_cell = |cell: usize| {
        let nodes = mesh.cell(cell).iter().map(|node| *node as usize);
        checksum(nodes.flat_map(|node| {
            let position = mesh.nodes()[node].into_iter().map(f64::to_bits);
            std::iter::once(numbers[node]).chain(position).flat_map(u64::to_le_bytes)
        }))
    };
    let cells = mesh.body_cells();
    cells.clone().fold(cells.len() as u64, |sum, cell| sum.wrapping_add(of_cell(cell)))
}

/// The numbers of a cell's vertices in the whole mesh.
fn numbers_of<const D: usize>(vertices: &Vertices, mesh: &Mesh<D>, cell: usize) -> impl Iterator<Item = u64> {
    mesh.cell_vertices(cell).iter().map(|vertex| vertices.numbers[*vertex as usize])
}
