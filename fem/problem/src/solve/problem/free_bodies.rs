//! Bodies that nothing holds, and rigid tools that an unknown is not given on, by name.

use forms_mesh::disjoint_sets::DisjointSets;

use super::Problem;
use crate::instantiate::instantiate;
use crate::linear_algebra::{free_motions, free_motions_of_body};
use crate::solve::{Elimination, Floating};
use crate::space::Space;

/// The nodes of the cells that hang together with those of a node, by common nodes; none where it belongs to no body's cell.
fn body_of<const D: usize>(space: &Space<D>, node: usize) -> Option<Vec<u32>> {
    let mesh = space.mesh();
    let mut bodies = DisjointSets::new(space.node_count());
    for cell in mesh.body_cells() {
        let Some((&first, others)) = space.cell_nodes(cell).split_first() else { continue };
        others.iter().for_each(|other| bodies.join(first, *other));
    }
    let all: Vec<u32> = (0..space.node_count() as u32).map(|node| bodies.root(node)).collect();
    let own = all[node];
    let nodes: Vec<u32> =
        (0..space.node_count() as u32).filter(|other| all[*other as usize] == own).collect();
    (nodes.len() > 1).then_some(nodes)
}

/// The name of the cells that have these nodes (in ascending order), and no others; that of all cells does not say which body.
fn name_of<const D: usize>(space: &Space<D>, nodes: &[u32]) -> Option<String> {
    let names = space.mesh().cell_region_names().filter(|name| *name != crate::mesh::EVERYWHERE);
    let mut own = names.filter(|name| space.nodes_on(name).is_ok_and(|found| found == nodes));
    own.next().map(str::to_owned)
}

/// The rigid surface whose cell has a node.
fn tool_at<const D: usize>(space: &Space<D>, node: usize) -> Option<String> {
    let mesh = space.mesh();
    if space.facet_region().is_some() {
        return None;
    }
    let mut tools = mesh.rigid_surface_names();
    let carries = |name: &&str| {
        let cell = mesh.carrier(name).map(|facet| facet.cell);
        cell.is_some_and(|cell| space.cell_nodes(cell as usize).contains(&(node as u32)))
    };
    tools.find(carries).map(str::to_owned)
}

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// The part that floats at a node of an unknown that the matrix does not determine: a rigid tool, the node's body with its motions, or all bodies
    /// together with theirs.
    pub(super) fn floating(&self, number: usize, node: usize, elimination: &Elimination) -> Floating {
        let (spaces, space) = (&self.system.spaces, &*self.system.spaces[number]);
        let is_displacement = space.shape() == [D] && space.facet_region().is_none();
        if let Some(name) = tool_at(space, node) {
            // The first vector on cells is the displacement, to which motions of tools are prescribed.
            let is_vector = |space: &Space<D>| space.shape() == [D] && space.facet_region().is_none();
            let displaces = is_displacement && !spaces[..number].iter().any(|space| is_vector(space));
            return Floating::Tool { name, displaces };
        }
        let Some(assembled) = self.assembled.as_ref().filter(|_| is_displacement) else {
            return Floating::Nothing;
        };
        let offset = spaces[..number].iter().map(|space| space.unknowns()).sum();
        let (matrix, positions) = (&assembled.matrix, space.positions());
        // What cannot be said is left out: the error is reported in any case.
        let residual = |motion: &[f64], forces: &[f64]| elimination.null_space_residual(motion, forces);
        let body = body_of(space, node).filter(|nodes| nodes.len() < space.node_count());
        let of_body = body.map(|nodes| {
            let motions = free_motions_of_body(matrix, offset, positions, &nodes, &residual);
            (motions.unwrap_or_default(), nodes)
        });
        if let Some((motions, nodes)) = of_body.filter(|(motions, _)| !motions.is_empty()) {
            return Floating::Body { name: name_of(space, &nodes), motions };
        }
        let motions = free_motions(matrix, offset, positions, &residual).unwrap_or_default();
        if motions.is_empty() { Floating::Nothing } else { Floating::Whole { motions } }
    }
}

instantiate!(free_bodies: body_of::<D>, tool_at::<D>);
