//! Coarsening: divisions undone where all parts of a cell are marked and no neighbour is too fine.

use std::collections::HashMap;

use super::parts::{facet_parts, leaves_of};
use super::{Divided, OctreeMesh, Origin, lies_outside};
use crate::instantiate;
use crate::mesh::nesting::{Nesting, Parts};
use crate::mesh::{Facet, Mesh, MeshError};

impl<const D: usize> OctreeMesh<D> {
    /// The mesh with divisions undone: those of cells whose parts are all marked, and undivided, where cells do not differ by more than one
    /// division afterwards. A cell loses one division at most; cells of the first mesh stay. Refined and then coarsened until nothing
    /// changes, with all cells marked, a mesh is the first one again, to the numbers of its cells and nodes.
    ///
    /// Nodes keep their places, except for those that begin to hang: they go to the facet of the larger cell. The order of those that stay is
    /// kept. The [`Nesting`] says which cell each of this mesh's is now a part of.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{OctreeMesh, rectangle};
    ///
    /// let coarse = OctreeMesh::new(rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellShape::Quadrilateral, 1)?)?;
    /// let (fine, _) = coarse.refined(&[0])?;
    /// let (again, nesting) = fine.coarsened(&[0, 1, 2, 3])?;
    /// assert_eq!(again.mesh().cells(), coarse.mesh().cells());
    /// assert_eq!(nesting.fine_cells(0), 0..4);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::MarkedCell`] for a cell that does not exist.
    #[inline(never)]
    pub fn coarsened(&self, marked: &[u32]) -> Result<(Self, Nesting<D>), MeshError> {
        let (old, shape) = (&self.mesh, self.shape());
        let stays = self.stays(&old.marked_cells(marked)?);
        // What stays of the divided cells, under new numbers.
        let mut numbers = Vec::with_capacity(stays.len());
        let mut divided = Divided::default();
        let renumbered = |numbers: &[u32], origin: Option<Origin>| {
            origin.map(|origin| Origin { whole: numbers[origin.whole as usize], ..origin })
        };
        for (whole, stays) in stays.iter().enumerate() {
            numbers.push(divided.origins.len() as u32);
            if *stays {
                divided.origins.push(renumbered(&numbers, self.divided.origins[whole]));
                divided.nodes.extend_from_slice(self.divided.cell(whole));
            }
        }
        let (mut cells, mut origins) = (Vec::new(), Vec::new());
        let mut parts = Parts::new(shape);
        for (cell, origin) in self.origins.iter().enumerate() {
            match origin.filter(|origin| !stays[origin.whole as usize]) {
                None => {
                    parts.next_coarse();
                    parts.add(&[]);
                    cells.extend_from_slice(old.cell(cell));
                    origins.push(renumbered(&numbers, *origin));
                }
                Some(Origin { whole, part }) => {
                    if part == 0 {
                        parts.next_coarse();
                        cells.extend_from_slice(self.divided.cell(whole as usize));
                        origins.push(renumbered(&numbers, self.divided.origins[whole as usize]));
                    }
                    parts.add(&[part]);
                }
            }
        }
        let nesting = parts.nesting();
        let (nodes, node_numbers) = old.nodes_of_cells(&mut cells);
        divided.nodes.iter_mut().for_each(|node| *node = node_numbers[*node as usize]);
        let mut mesh = Mesh::of_sound_cells(old.degree, nodes, vec![(shape, cells)])?;
        mesh.join_parts(facet_parts(&mesh, &divided, &origins));
        put_hanging_nodes_on_facets(&mut mesh)?;
        let whole_of = |cell: u32| {
            let whole = nesting.coarse_cell(cell as usize) as u32;
            whole..whole + 1
        };
        let whole_facet = |facet: Facet| {
            let (cell, whole) = (facet.cell as usize, nesting.coarse_cell(facet.cell as usize));
            match self.origins[cell].filter(|_| nesting.divisions(cell) > 0) {
                Some(origin) if !lies_outside(shape, origin.part, facet.local) => vec![],
                _ => vec![Facet { cell: whole as u32, ..facet }],
            }
        };
        mesh.inherit_regions(old, &whole_of, &whole_facet)?;
        Ok((OctreeMesh { mesh, origins, divided }, nesting))
    }

    /// Which of the divided cells stay so. Small ones are asked first, so that larger neighbours see the result.
    fn stays(&self, marked: &[u32]) -> Vec<bool> {
        let (divided, shape) = (&self.divided, self.shape());
        let parts = 1 << D;
        let leaves = leaves_of(divided, &self.origins, parts);
        let is_marked = |leaf: &Option<u32>| leaf.is_some_and(|cell| marked.binary_search(&cell).is_ok());
        let edge = |a: u32, b: u32| [a.min(b), a.max(b)];
        // How many divided cells have an edge.
        let mut dividing: HashMap<[u32; 2], u32> = HashMap::new();
        let mut levels: Vec<u32> = Vec::with_capacity(divided.count());
        for (whole, origin) in divided.origins.iter().enumerate() {
            levels.push(origin.map_or(0, |origin| levels[origin.whole as usize] + 1));
            let nodes = divided.cell(whole);
            for [a, b] in shape.edges() {
                *dividing.entry(edge(nodes[*a], nodes[*b])).or_default() += 1;
            }
        }
        let mut order: Vec<usize> = (0..divided.count()).collect();
        order.sort_by_key(|whole| std::cmp::Reverse(levels[*whole]));
        let mut stays = vec![true; divided.count()];
        for whole in order {
            let leaves = &leaves[whole * parts..][..parts];
            if !leaves.iter().all(is_marked) {
                continue;
            }
            let nodes = divided.cell(whole);
            // The part at a has the middle of the edge from a to b at its own b.
            let middle =
                |a: usize, b: usize| leaves[a].map_or(nodes[a], |cell| self.mesh.cell(cell as usize)[b]);
            let is_free = |[a, b]: &[usize; 2]| {
                let middle = middle(*a, *b);
                let halves = [edge(nodes[*a], middle), edge(middle, nodes[*b])];
                halves.iter().all(|half| dividing.get(half).is_none_or(|count| *count == 0))
            };
            if shape.edges().iter().all(is_free) {
                stays[whole] = false;
                for [a, b] in shape.edges() {
                    dividing.entry(edge(nodes[*a], nodes[*b])).and_modify(|count| *count -= 1);
                }
            }
        }
        stays
    }
}

/// Puts the nodes that begin to hang on the larger cells' facets: on curved boundaries they stood elsewhere.
fn put_hanging_nodes_on_facets<const D: usize>(mesh: &mut Mesh<D>) -> Result<(), MeshError> {
    // Facets may hang on facets with such nodes in their turn, level by level.
    for _ in 0..u32::BITS {
        let mut nodes = mesh.nodes.clone();
        let mut moved = false;
        for (node, large, reference) in mesh.nodes_on_parts() {
            let there = mesh.map(large.cell as usize, &reference).0;
            let position = &mut nodes[node as usize];
            // Rounding moves nothing.
            let size = mesh.diameter(large.cell as usize);
            let same = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-13 * size + 4.0 * f64::EPSILON * y.abs();
            if !position.iter().zip(&there).all(same) {
                *position = there;
                moved = true;
            }
        }
        if !moved {
            break;
        }
        mesh.put_nodes(nodes);
    }
    mesh.check_places()
}

instantiate!(octree_coarsening: OctreeMesh::<D>::coarsened);
