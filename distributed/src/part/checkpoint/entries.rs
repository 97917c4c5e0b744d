//! The nodes, cells and facets that have values in a checkpoint, as all processes know them.

use forms_fem::contract::FieldValue;
use forms_fem::prelude::*;
use forms_fem::space::Scope;

use super::unfit;
use crate::error::PetscError;
use crate::part::MeshPart;
use crate::part::shared_nodes::{Key, Supports};

/// A node, a cell or a facet with its values: the place of the first of them here, and their number.
pub(super) type Entry = (Key, usize, usize);

/// The nodes of a space.
pub(super) fn entries_of<const D: usize>(
    part: &MeshPart<'_, D>,
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
                        let key = part.vertices.key(mesh.cell_vertices(cell), support);
                        entries.push((key, *node as usize * components, components));
                    }
                }
            }
            Scope::Cell | Scope::Point => {
                for (place, node) in nodes.iter().enumerate() {
                    let key = numbers_of(part, cell).chain([place as u64]).collect();
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
        (numbers_of(part, cell as usize).chain([facet]).collect(), first - count, count)
    };
    let entities = assembler.history_entities(history).map_err(unfit)?;
    if entities.is_empty() && !assembler.history_values(history).map_err(unfit)?.is_empty() {
        let what = "histories of pairs in checkpoints".to_owned();
        return Err(PetscError::Divided { what });
    }
    Ok(entities.into_iter().map(entry).collect())
}

/// The numbers of a cell's vertices in the whole mesh.
fn numbers_of<const D: usize>(part: &MeshPart<'_, D>, cell: usize) -> impl Iterator<Item = u64> {
    part.mesh.cell_vertices(cell).iter().map(|vertex| part.vertices.numbers[*vertex as usize])
}
