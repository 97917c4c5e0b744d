//! Hanging facets: small facets that are parts of a larger one, which cells on its other side have divided.

use std::collections::{BTreeMap, BTreeSet};

use super::conformity::SAME_PLACE;
use super::{Facet, Mesh, MeshError};
use crate::disjoint_sets::DisjointSets;
use crate::instantiate;
use crate::locate::nearest_on_facet;

impl<const D: usize> Mesh<D> {
    /// Pairs of a small facet and the larger one that it is a part of, in the order of the larger ones: where coarse cells meet fine
    /// ones in an [`super::OctreeMesh`], whose facets there are interior ones, or in a mesh of [`Mesh::from_nonconforming_blocks`],
    /// whose facets there are exterior ones.
    ///
    /// # Errors
    /// [`MeshError::NotNested`] for facets that lie on each other in part; [`MeshError::Piece`] where a mesh with the latter is divided among
    /// processes.
    pub fn hanging_facets(&self) -> Result<Vec<[Facet; 2]>, MeshError> {
        self.hanging_facets_if(&|_, _| true)
    }

    /// Pairs of [`Mesh::hanging_facets`] whose cells are of one body: cells that share a vertex are. Bodies may touch in whatever way.
    ///
    /// # Errors
    /// As there.
    #[doc(hidden)]
    pub fn hanging_facets_of_bodies(&self) -> Result<Vec<[Facet; 2]>, MeshError> {
        let bodies = self.bodies();
        self.hanging_facets_if(&|one, other| bodies[one.cell as usize] == bodies[other.cell as usize])
    }

    /// The pairs for which something holds.
    #[inline(never)]
    fn hanging_facets_if(
        &self,
        is_asked: &dyn Fn(Facet, Facet) -> bool,
    ) -> Result<Vec<[Facet; 2]>, MeshError> {
        self.without_hanging_outside()?;
        let hanging = if self.is_piece() { vec![] } else { self.touching().hanging_nodes };
        let mut facets_at: BTreeMap<u32, Vec<Facet>> =
            hanging.iter().map(|hanging| (hanging.node, vec![])).collect();
        for &facet in self.boundary_facets() {
            for vertex in self.facet_vertices(facet) {
                if let Some(facets) = facets_at.get_mut(&vertex) {
                    facets.push(facet);
                }
            }
        }
        let mut pairs: BTreeSet<[Facet; 2]> = BTreeSet::new();
        for hanging in hanging {
            let large = hanging.facet;
            for &small in facets_at[&hanging.node].iter().filter(|small| is_asked(**small, large)) {
                let beside = self.point_beside(hanging.node, small);
                if small == large || self.reference_on_facet(large, &beside).is_none() {
                    continue;
                }
                let place = |vertex: u32| self.nodes[vertex as usize];
                if self.facet_vertices(small).any(|v| self.reference_on_facet(large, &place(v)).is_none()) {
                    return Err(MeshError::NotNested {
                        facets: [small, large],
                        position: hanging.position.to_vec(),
                    });
                }
                pairs.insert([large, small]);
            }
        }
        let of_trees = self.facet_parts().filter(|(small, large, _)| is_asked(*small, *large));
        pairs.extend(of_trees.map(|(small, large, _)| [large, small]));
        Ok(pairs.into_iter().map(|[large, small]| [small, large]).collect())
    }

    /// The body of each cell, by a number that its cells have in common: cells that share a vertex are of one body.
    fn bodies(&self) -> Vec<u32> {
        let mut bodies = DisjointSets::new(self.nodes().len());
        for cell in 0..self.cell_count() {
            let vertices = self.cell_vertices(cell);
            vertices[1..].iter().for_each(|vertex| bodies.join(vertices[0], *vertex));
        }
        (0..self.cell_count()).map(|cell| bodies.root(self.cell_vertices(cell)[0])).collect()
    }

    /// A point of a facet near one of its vertices, on the way to its centre: it tells facets that run along another one from
    /// those that only meet it there.
    fn point_beside(&self, vertex: u32, facet: Facet) -> [f64; D] {
        let (cell, local) = (facet.cell as usize, usize::from(facet.local));
        let shape = self.cell_shape(cell);
        let centre = shape.facet_centre::<D>(local);
        let place = self.cell_vertices(cell).iter().position(|other| *other == vertex).unwrap_or(0);
        let corner = shape.vertex_points()[place];
        self.map(cell, &std::array::from_fn(|k| corner[k] + 0.01 * (centre[k] - corner[k]))).0
    }

    /// The reference coordinates, in a facet's cell, of a point that lies on the facet within a millionth of its size.
    #[doc(hidden)]
    pub fn reference_on_facet(&self, facet: Facet, point: &[f64; D]) -> Option<[f64; D]> {
        let corner = |vertex: u32| self.nodes[vertex as usize];
        let corners: Vec<[f64; D]> = self.facet_vertices(facet).map(corner).collect();
        let squared =
            |a: &[f64; D], b: &[f64; D]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
        let size = corners.iter().map(|corner| squared(corner, &corners[0])).fold(0.0, f64::max).sqrt();
        let (reference, distance) = nearest_on_facet(self, facet, point, SAME_PLACE)?;
        (distance <= SAME_PLACE * size).then_some(reference)
    }
}

instantiate!(hanging_facets: Mesh::<D>::hanging_facets_if, Mesh::<D>::reference_on_facet);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    /// A column of large squares next to one of smaller ones, each on nodes of its own: the given numbers in the height, of length 1.
    fn columns(large: usize, small: usize) -> Result<Mesh<2>, MeshError> {
        let left = rectangle([0.0, 0.0], [1.0, 1.0], [1, large], CellShape::Quadrilateral, 1)?;
        let right = rectangle([1.0, 0.0], [2.0, 1.0], [1, small], CellShape::Quadrilateral, 1)?;
        let nodes = [left.nodes(), right.nodes()].concat();
        let behind = right.cells().iter().map(|node| node + left.node_count() as u32);
        let cells = left.cells().iter().copied().chain(behind).collect();
        Mesh::from_nonconforming_blocks(1, nodes, vec![(CellShape::Quadrilateral, cells)])
    }

    #[test]
    fn halves_and_thirds_lie_on_their_facets() -> Result<(), MeshError> {
        for (large, small) in [(1, 2), (2, 6), (3, 6)] {
            let mesh = columns(large, small)?;
            let pairs = mesh.hanging_facets()?;
            assert_eq!(pairs.len(), small);
            for [part, whole] in pairs {
                // The right side of the large squares and the left one of the others.
                assert_eq!((part.local, whole.local), (3, 1));
                assert_eq!((part.cell as usize - large) * large / small, whole.cell as usize);
            }
        }
        // Facets that are the same are cracks.
        assert_eq!(columns(2, 2)?.hanging_facets()?.len(), 0);
        Ok(())
    }

    #[test]
    fn facets_that_lie_across_others_are_named() -> Result<(), MeshError> {
        let error = columns(2, 3)?.hanging_facets().err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains("lie on each other in part, at [1.0, "), "{error}");
        // A corner on a side that it leaves at once: nothing is a part of anything.
        let nodes = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [1.0, 1.0], [1.5, 2.0], [0.5, 2.0]];
        let blocks = vec![(CellShape::Quadrilateral, vec![0, 1, 2, 3]), (CellShape::Triangle, vec![4, 5, 6])];
        let mesh = Mesh::from_nonconforming_blocks(1, nodes.to_vec(), blocks)?;
        assert_eq!((mesh.conformity().hanging_nodes.len(), mesh.hanging_facets()?.len()), (1, 0));
        // One that leaves it later.
        let nodes = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [1.9, 1.0], [3.0, 1.0], [3.0, 2.0]];
        let blocks = vec![(CellShape::Quadrilateral, vec![0, 1, 2, 3]), (CellShape::Triangle, vec![4, 5, 6])];
        let mesh = Mesh::from_nonconforming_blocks(1, nodes.to_vec(), blocks)?;
        assert!(matches!(mesh.hanging_facets(), Err(MeshError::NotNested { .. })));
        Ok(())
    }
}
