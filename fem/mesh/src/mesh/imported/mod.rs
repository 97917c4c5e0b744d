//! From what a file says to a mesh with regions: the same for every format.
//!
//! A format's reader fills [`Contents`], with the file's own numbers; the kinds of cells are its own table. What is wrong
//! with them is reported in the file's words and numbers.

mod cells;
mod complete;
mod contents;
mod facets;
mod kinds;
mod plane;
mod problem;
mod tags;

use super::Mesh;

pub(super) use complete::Completed;
pub(super) use contents::{Contents, Element, Membership, Node, Words};
pub(super) use kinds::{Kind, cell, kind};
pub use problem::{FilePosition, ImportProblem, Item, Note};
pub(super) use problem::{Flaw, dimensions, entities, entity, shortened};

/// A mesh, and how its numbers belong to the file's.
pub(super) struct Imported<const D: usize> {
    pub(super) mesh: Mesh<D>,
    pub(super) notes: Vec<Note>,
    /// For each node of the mesh its place among [`Contents::nodes`], without those that were added.
    pub(super) nodes: Vec<usize>,
    /// The nodes after these, which were added inside faces and cells.
    pub(super) completed: Vec<Completed>,
    /// For each cell of the mesh its place among [`Contents::elements`].
    pub(super) cells: Vec<usize>,
}

/// The mesh that a file describes, its regions named.
pub(super) fn import<const D: usize>(contents: &Contents) -> Result<Imported<D>, Flaw> {
    let mut notes = Vec::new();
    let mut cells = cells::Cells::new(contents, &mut notes)?;
    cells.name_cells(contents)?;
    facets::name_facets(&mut cells, contents, &mut notes)?;
    facets::note_groups(&cells.mesh, contents, &mut notes);
    let nodes = cells.nodes();
    let completed = cells.completed;
    Ok(Imported { mesh: cells.mesh, notes, nodes, completed, cells: cells.elements })
}
