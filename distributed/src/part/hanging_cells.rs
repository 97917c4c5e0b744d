//! Copies of cells that parts of a mesh with hanging nodes have: large and small cells where nodes hang, and those behind interior facets.

use std::collections::{BTreeSet, HashMap};

use forms_fem::mesh::{Facet, Mesh};

/// The copies of a process.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Copies {
    /// Their cells in the whole mesh. Those of processes with higher rank come first.
    pub cells: Vec<u32>,
    /// Number of the first ones, on whose facets to own cells this process integrates.
    pub behind: usize,
}

/// The places where nodes hang: small facets that are parts of larger ones.
pub(super) struct HangingFacets<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    /// Each small facet, and the larger one.
    pairs: Vec<[Facet; 2]>,
    /// The pairs on whose larger facet a vertex hangs.
    hanging: HashMap<u32, Vec<usize>>,
    /// The pairs whose larger facet has a vertex.
    giving: HashMap<u32, Vec<usize>>,
}

/// The copies of each process, where nodes hang in the mesh; `cells` are those that each process has, ascending.
pub(super) fn copies<const D: usize>(mesh: &Mesh<D>, cells: &[Vec<u32>]) -> Option<Vec<Copies>> {
    let facets = HangingFacets::of(mesh)?;
    let mut owners = vec![0; mesh.cell_count()];
    for (rank, cells) in cells.iter().enumerate() {
        cells.iter().for_each(|cell| owners[*cell as usize] = rank);
    }
    let mut near: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); cells.len()];
    for [one, other] in mesh.interior_facets() {
        let ranks = [one, other].map(|facet| owners[facet.cell as usize]);
        if ranks[0] != ranks[1] {
            let behind = if ranks[0] < ranks[1] { other } else { one };
            near[ranks[0].min(ranks[1])].insert(behind.cell);
        }
    }
    let of_rank = |(rank, mut near): (usize, BTreeSet<u32>)| {
        facets.add_near(&cells[rank], &mut near);
        let mut copies: Vec<u32> = near.into_iter().filter(|cell| owners[*cell as usize] != rank).collect();
        let is_lower = |cell: &u32| owners[*cell as usize] < rank;
        copies.sort_by_key(|cell| (is_lower(cell), owners[*cell as usize]));
        let behind = copies.iter().filter(|cell| !is_lower(cell)).count();
        Copies { cells: copies, behind }
    };
    Some(near.into_iter().enumerate().map(of_rank).collect())
}

impl<'m, const D: usize> HangingFacets<'m, D> {
    /// Those of a mesh, or of a part of one, if there are any.
    pub fn of(mesh: &'m Mesh<D>) -> Option<Self> {
        let pairs: Vec<[Facet; 2]> = mesh.facet_parts().map(|(small, large, _)| [small, large]).collect();
        if pairs.is_empty() {
            return None;
        }
        let (mut hanging, mut giving): (HashMap<u32, Vec<usize>>, HashMap<u32, Vec<usize>>) =
            Default::default();
        for (number, [_, large]) in pairs.iter().enumerate() {
            mesh.facet_vertices(*large).for_each(|vertex| giving.entry(vertex).or_default().push(number));
        }
        let mut facets = HangingFacets { mesh, pairs, hanging: HashMap::new(), giving };
        for number in 0..facets.pairs.len() {
            for vertex in facets.vertices_that_hang(number) {
                hanging.entry(vertex).or_default().push(number);
            }
        }
        facets.hanging = hanging;
        Some(facets)
    }

    /// The vertices of a small facet that the larger one does not have.
    fn vertices_that_hang(&self, number: usize) -> Vec<u32> {
        let [small, large] = self.pairs[number];
        let others: Vec<u32> = self.mesh.facet_vertices(large).collect();
        self.mesh.facet_vertices(small).filter(|vertex| !others.contains(vertex)).collect()
    }

    fn pairs_at(places: &HashMap<u32, Vec<usize>>, vertex: u32) -> impl Iterator<Item = usize> + '_ {
        places.get(&vertex).into_iter().flatten().copied()
    }

    /// The larger cells on which a vertex hangs.
    pub fn larger_cells(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        Self::pairs_at(&self.hanging, vertex).map(|number| self.pairs[number][1].cell)
    }

    /// Adds the cells that a process with these ones needs: where its own vertices hang, all cells of the relation; those whose unknowns
    /// depend on its own ones, because the owner of a row adds up; and with each of all these cells the larger ones on which its vertices hang.
    pub fn add_near(&self, own: &[u32], near: &mut BTreeSet<u32>) {
        let vertices = own.iter().flat_map(|cell| self.mesh.cell_vertices(*cell as usize)).copied();
        let mut known: BTreeSet<u32> = vertices.collect();
        for number in known.iter().flat_map(|vertex| Self::pairs_at(&self.hanging, *vertex)) {
            near.extend(self.pairs[number].map(|facet| facet.cell));
        }
        // What depends on an unknown that hangs depends on those that give it.
        let mut left: Vec<u32> = known.iter().copied().collect();
        while let Some(vertex) = left.pop() {
            for number in Self::pairs_at(&self.giving, vertex) {
                near.insert(self.pairs[number][0].cell);
                left.extend(
                    self.vertices_that_hang(number).into_iter().filter(|vertex| known.insert(*vertex)),
                );
            }
        }
        let mut left: Vec<u32> = near.iter().copied().collect();
        while let Some(cell) = left.pop() {
            for vertex in self.mesh.cell_vertices(cell as usize) {
                left.extend(self.larger_cells(*vertex).filter(|large| near.insert(*large)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use forms_fem::element::CellShape;
    use forms_fem::mesh::{MeshError, OctreeMesh, rectangle};

    /// Four squares in a row, the last one divided: 0, 1, 2, and 3 to 6.
    fn row() -> Result<Mesh<2>, MeshError> {
        let row = rectangle([0.0; 2], [4.0, 1.0], [4, 1], CellShape::Quadrilateral, 1)?;
        Ok(OctreeMesh::new(row)?.refined(&[3])?.0.mesh().clone())
    }

    #[test]
    fn both_sides_of_a_hanging_node_have_its_cells() -> Result<(), MeshError> {
        let mesh = row()?;
        let cells = [vec![0], vec![1, 2], vec![3, 4, 5, 6]];
        let found = copies(&mesh, &cells).unwrap_or_default();
        // The first process has no vertex where the node hangs, and the cell behind its facet.
        let expected = [(vec![1], 1), (vec![3, 6], 2), (vec![2], 0)];
        assert_eq!(found, expected.map(|(cells, behind)| Copies { cells, behind }));
        // Two that have the hanging node.
        let cells = [vec![0, 1, 2], vec![3, 4, 5], vec![6]];
        let found = copies(&mesh, &cells).unwrap_or_default();
        let expected = [(vec![3, 6], 2), (vec![6, 2], 1), (vec![2, 3], 0)];
        assert_eq!(found, expected.map(|(cells, behind)| Copies { cells, behind }));
        Ok(())
    }

    #[test]
    fn meshes_without_hanging_nodes_have_no_copies() -> Result<(), MeshError> {
        let mesh = rectangle([0.0; 2], [4.0, 1.0], [4, 1], CellShape::Quadrilateral, 1)?;
        assert_eq!(copies(&mesh, &[vec![0, 1], vec![2, 3]]), None);
        Ok(())
    }
}
