//! Coarsening: bisections undone where all cells at a new vertex are parts of them.

use super::marked_edges::step;
use super::{BisectedMesh, Bisection, Origin, Part, opposite, simplex};
use crate::instantiate;
use crate::mesh::nesting::{Nesting, Parts};
use crate::mesh::{Facet, Mesh, MeshError};

impl<const D: usize> BisectedMesh<D> {
    /// The mesh with bisections undone: those at the vertices around which all cells are marked and have the vertex from the bisection that
    /// they come from, so that no node hangs. A cell loses one bisection at most; cells of the first mesh stay. Refined and
    /// then coarsened until nothing changes, with all cells marked, a mesh is the first one again, to the numbers of its cells and nodes.
    ///
    /// Nodes keep their places, and the order of those that stay is kept. The [`Nesting`] says which cell each of this mesh's is now a part
    /// of.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{BisectedMesh, rectangle};
    ///
    /// let coarse = BisectedMesh::new(rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellShape::Triangle, 1)?)?;
    /// let (fine, _) = coarse.refined(&[0])?;
    /// let all: Vec<u32> = (0..fine.mesh().cell_count() as u32).collect();
    /// let (again, nesting) = fine.coarsened(&all)?;
    /// assert_eq!(again.mesh().cells(), coarse.mesh().cells());
    /// assert_eq!(nesting.fine_cells(0), 0..2);
    /// # Ok::<(), forms_fem::mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::MarkedCell`] for a cell that does not exist.
    #[inline(never)]
    pub fn coarsened(&self, marked: &[u32]) -> Result<(Self, Nesting<D>), MeshError> {
        let old = &self.mesh;
        let shape = simplex::<D>();
        let undone = self.undone(&old.marked_cells(marked)?);
        // What stays of the bisections, under new numbers.
        let mut numbers: Vec<u32> = Vec::with_capacity(self.bisections.len());
        let mut stays = vec![true; self.bisections.len()];
        undone.iter().for_each(|first| stays[self.bisection_of(*first)] = false);
        let mut count = 0;
        for stays in &stays {
            numbers.push(count);
            count += u32::from(*stays);
        }
        let renumbered =
            |origin: &Origin| Origin { bisection: numbers[origin.bisection as usize], ..*origin };
        let bisections = self.bisections.iter().zip(&stays).filter(|(_, stays)| **stays);
        let bisections: Vec<Bisection> = bisections
            .map(|(kept, _)| Bisection { origin: kept.origin.as_ref().map(renumbered), ..*kept })
            .collect();

        let (mut cells, mut marks, mut origins) = (Vec::new(), Vec::new(), Vec::new());
        let mut parts = Parts::new(shape);
        let mut undone = undone.into_iter().peekable();
        let mut cell = 0;
        while cell < old.cell_count() {
            parts.next_coarse();
            if undone.next_if_eq(&cell).is_some() {
                let whole = self.bisections[self.bisection_of(cell)];
                let edge = whole.marks.refinement_edge();
                cells.extend(self.whole(cell, edge));
                marks.push(whole.marks);
                origins.push(whole.origin.as_ref().map(renumbered));
                Part::BOTH.into_iter().for_each(|part| parts.add(&[step(edge, part)]));
                cell += 2;
            } else {
                cells.extend_from_slice(old.cell(cell));
                marks.push(self.marks[cell]);
                origins.push(self.origins[cell].as_ref().map(renumbered));
                parts.add(&[]);
                cell += 1;
            }
        }
        let nesting = parts.nesting();
        let (nodes, _) = old.nodes_of_cells(&mut cells);
        let mut mesh = Mesh::of_sound_cells(old.degree, nodes, vec![(shape, cells)])?;
        let whole_of = |cell: u32| {
            let whole = nesting.coarse_cell(cell as usize) as u32;
            whole..whole + 1
        };
        let whole_facet = |facet: Facet| {
            let (cell, whole) = (facet.cell as usize, nesting.coarse_cell(facet.cell as usize));
            let divided = shape.edges()[marks[whole].refinement_edge()];
            let separates =
                |part: Part| opposite(shape, part.kept_and_new(divided)[0]) == usize::from(facet.local);
            match self.origins[cell].filter(|_| nesting.divisions(cell) > 0) {
                Some(origin) if separates(origin.part) => vec![],
                _ => vec![Facet { cell: whole as u32, local: facet.local }],
            }
        };
        mesh.inherit_regions(old, &whole_of, &whole_facet)?;
        Ok((BisectedMesh { mesh, marks, origins, bisections }, nesting))
    }

    /// The first cell of each pair of parts that are put together again, in ascending order.
    fn undone(&self, marked: &[u32]) -> Vec<usize> {
        let mesh = &self.mesh;
        let pairs = marked.windows(2).filter(|pair| pair[0] + 1 == pair[1]).filter_map(|pair| {
            let [first, second] = [pair[0] as usize, pair[1] as usize];
            let bisection = self.origins[first]?.bisection;
            // Two parts that are leaves have consecutive numbers.
            (self.origins[second]?.bisection == bisection).then_some(first)
        });
        let pairs: Vec<usize> = pairs.collect();
        let (mut cells_at, mut parts_at) = (vec![0_u32; mesh.node_count()], vec![0; mesh.node_count()]);
        for cell in 0..mesh.cell_count() {
            mesh.cell_vertices(cell).iter().for_each(|vertex| cells_at[*vertex as usize] += 1);
        }
        pairs.iter().for_each(|first| parts_at[self.new_vertex(*first)] += 2);
        let is_free = |first: &usize| {
            let vertex = self.new_vertex(*first);
            cells_at[vertex] == parts_at[vertex]
        };
        pairs.into_iter().filter(is_free).collect()
    }

    /// The bisection whose first part a cell is.
    fn bisection_of(&self, first: usize) -> usize {
        self.origins[first].map_or(0, |origin| origin.bisection as usize)
    }

    /// The vertex that the bisection has given to its first part.
    fn new_vertex(&self, first: usize) -> usize {
        let edge = self.bisections[self.bisection_of(first)].marks.refinement_edge();
        let [_, new] = Part::KeepsFirst.kept_and_new(simplex::<D>().edges()[edge]);
        self.mesh.cell(first)[new] as usize
    }

    /// The nodes of the cell that was bisected along an edge, from those of its parts.
    fn whole(&self, first: usize, edge: usize) -> Vec<u32> {
        let shape = simplex::<D>();
        let [_, b] = shape.edges()[edge];
        let [keeps_a, keeps_b] = [first, first + 1].map(|part| self.mesh.cell(part));
        let mut nodes = keeps_a.to_vec();
        nodes[b] = keeps_b[b];
        for (number, ends) in shape.edges().iter().enumerate().take(nodes.len() - D - 1) {
            if number == edge {
                nodes[D + 1 + number] = keeps_a[b];
            } else if ends.contains(&b) {
                nodes[D + 1 + number] = keeps_b[D + 1 + number];
            }
        }
        nodes
    }
}

instantiate!(bisection_coarsening: BisectedMesh::<D>::coarsened);
