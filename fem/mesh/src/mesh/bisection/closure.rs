//! Closure of a marking: the cells that are bisected so that the marked ones are and no node hangs.

use super::edge_nodes::EdgeNodes;
use super::marked_edges::{MarkedEdges, Part};
use super::{BisectedMesh, simplex};
use crate::element::CellShape;
use crate::mesh::MeshError;

/// Sentinel: end of list, or no children.
const NONE: u32 = u32::MAX;

/// The cells of a mesh with their descendants, each a leaf or bisected.
pub(super) struct Closure<const D: usize> {
    shape: CellShape,
    /// Degree of the geometry map.
    degree: usize,
    /// Nodes per cell.
    per_cell: usize,
    /// Node coordinates \[length\], the new ones last.
    pub(super) nodes: Vec<[f64; D]>,
    /// Node numbers, cell after cell.
    cells: Vec<u32>,
    marks: Vec<MarkedEdges>,
    /// The first of the two parts of each cell.
    parts: Vec<u32>,
    /// The middles of edges that have been divided.
    divided: EdgeNodes,
    /// The nodes in the middle of new edges, for cells of degree 2.
    middles: EdgeNodes,
    /// For each node the first entry in the list of the cells that have it as a vertex; entries are places of vertices, cell
    /// after cell.
    first_at: Vec<u32>,
    /// The entry after each.
    next_at: Vec<u32>,
}

impl<const D: usize> Closure<D> {
    /// The closure of a marking, given in ascending order.
    ///
    /// Where an edge gets a node, all cells at it are bisected until none has the edge. Proofs that this ends for every first mesh: Arnold, Mukherjee
    /// and Pouly (2000) in space, and M. Karkulik, D. Pavlicek and D. Praetorius, On 2D newest vertex
    /// bisection, Constr. Approx. 38 (2013), in the plane.
    pub(super) fn of(coarse: &BisectedMesh<D>, marked: &[u32]) -> Result<Self, MeshError> {
        let mesh = &coarse.mesh;
        let shape = simplex::<D>();
        let mut closure = Closure {
            shape,
            degree: mesh.degree,
            per_cell: mesh.element_of(shape).nodes(),
            nodes: mesh.nodes.clone(),
            cells: mesh.cells.clone(),
            marks: coarse.marks.clone(),
            parts: vec![NONE; mesh.cell_count()],
            divided: EdgeNodes::default(),
            middles: EdgeNodes::default(),
            first_at: vec![NONE; mesh.node_count()],
            next_at: Vec::new(),
        };
        closure.check_room()?;
        closure.next_at.reserve(closure.parts.len() * (D + 1));
        (0..closure.parts.len()).for_each(|cell| closure.list(cell));
        let mut waiting: Vec<u32> = marked.iter().rev().copied().collect();
        while let Some(cell) = waiting.pop() {
            if closure.parts[cell as usize] == NONE {
                closure.bisect(cell as usize, &mut waiting)?;
            }
        }
        Ok(closure)
    }

    /// Node numbers of a cell, its vertices first.
    pub(super) fn cell(&self, cell: usize) -> &[u32] {
        &self.cells[cell * self.per_cell..][..self.per_cell]
    }

    /// The marked edges of a cell.
    pub(super) fn marks(&self, cell: usize) -> MarkedEdges {
        self.marks[cell]
    }

    /// The first of the two parts of a cell; the second one follows it.
    pub(super) fn parts(&self, cell: usize) -> Option<usize> {
        let first = self.parts[cell];
        (first != NONE).then_some(first as usize)
    }

    /// Check that the numbers of vertices and nodes suffice for one more bisection.
    fn check_room(&self) -> Result<(), MeshError> {
        if (self.parts.len() + 2) * (D + 1) >= NONE as usize {
            return Err(MeshError::TooLarge { what: "cells" });
        }
        if self.nodes.len() + 2 * D >= NONE as usize {
            return Err(MeshError::TooLarge { what: "nodes" });
        }
        Ok(())
    }

    /// Puts a cell, the last one, into the lists of its vertices.
    fn list(&mut self, cell: usize) {
        for place in 0..=D {
            let vertex = self.cells[cell * self.per_cell + place] as usize;
            self.next_at.push(self.first_at[vertex]);
            self.first_at[vertex] = (cell * (D + 1) + place) as u32;
        }
    }

    /// Bisects a leaf. The leaves that now have a divided edge wait.
    fn bisect(&mut self, cell: usize, waiting: &mut Vec<u32>) -> Result<(), MeshError> {
        self.check_room()?;
        let marks = self.marks[cell];
        let [a, b] = self.shape.edges()[marks.refinement_edge()];
        let ends = [a, b].map(|vertex| self.cell(cell)[vertex]);
        let middle = match self.divided.get(ends) {
            Some(middle) => middle,
            None => {
                let middle = match self.degree {
                    1 => self.new_node(&[(0.5, ends[0]), (0.5, ends[1])]),
                    _ => self.cell(cell)[D + 1 + marks.refinement_edge()],
                };
                self.divided.insert(ends, middle);
                self.leaves_at(ends, |leaf| waiting.push(leaf));
                middle
            }
        };
        let first = self.parts.len();
        self.parts[cell] = first as u32;
        for (index, part) in Part::BOTH.into_iter().enumerate() {
            let [kept, new] = part.kept_and_new([a, b]);
            let start = cell * self.per_cell;
            self.cells.extend_from_within(start..start + self.per_cell);
            let number = first + index;
            self.cells[number * self.per_cell + new] = middle;
            self.marks.push(marks.of_part(self.shape, part));
            self.parts.push(NONE);
            if self.degree == 2 {
                self.set_middles(cell, number, [kept, new]);
            }
            self.list(number);
            if self.has_divided_edge(number, [kept, new]) {
                waiting.push(number as u32);
            }
        }
        Ok(())
    }

    /// Calls for each leaf that has an edge.
    fn leaves_at(&self, [x, y]: [u32; 2], mut call: impl FnMut(u32)) {
        // New nodes have the shorter lists.
        let (at, other) = if x > y { (x, y) } else { (y, x) };
        let mut entry = self.first_at[at as usize];
        while entry != NONE {
            let cell = entry as usize / (D + 1);
            if self.parts[cell] == NONE && self.cell(cell)[..=D].contains(&other) {
                call(cell as u32);
            }
            entry = self.next_at[entry as usize];
        }
    }

    /// Whether another cell has divided an edge of a new part, given by the places of the kept and the new vertex.
    fn has_divided_edge(&self, cell: usize, [kept, new]: [usize; 2]) -> bool {
        let nodes = self.cell(cell);
        self.shape.edges().iter().any(|&[p, q]| {
            // In the plane no other cell has the edge that separates the parts.
            let separates = D == 2 && (p == new || q == new) && p != kept && q != kept;
            !separates && self.divided.get([nodes[p], nodes[q]]).is_some()
        })
    }

    /// The nodes of a part, of degree 2, in the middle of the edges at its new vertex: on the whole cell's half edge, and between
    /// the new vertex and the others, by the whole cell's quadratic map.
    fn set_middles(&mut self, whole: usize, part: usize, [kept, new]: [usize; 2]) {
        for (number, &[p, q]) in self.shape.edges().iter().enumerate() {
            let other = match (p == new, q == new) {
                (true, _) => q,
                (_, true) => p,
                _ => continue,
            };
            let ends = [p, q].map(|place| self.cell(part)[place]);
            let node = match self.middles.get(ends) {
                Some(node) => node,
                None => {
                    let old = self.cell(whole);
                    let between = |a: usize, b: usize| {
                        let joins = |edge: &[usize; 2]| *edge == [a, b] || *edge == [b, a];
                        old[D + 1 + self.shape.edges().iter().position(joins).unwrap_or(0)]
                    };
                    let divided = between(kept, new);
                    let node = if other == kept {
                        self.new_node(&[(0.375, old[kept]), (0.75, divided), (-0.125, old[new])])
                    } else {
                        self.new_node(&[
                            (0.25, divided),
                            (0.5, between(kept, other)),
                            (0.5, between(new, other)),
                            (-0.125, old[kept]),
                            (-0.125, old[new]),
                        ])
                    };
                    self.middles.insert(ends, node);
                    node
                }
            };
            self.cells[part * self.per_cell + D + 1 + number] = node;
        }
    }

    /// A node at a weighted sum of others' places.
    fn new_node<const N: usize>(&mut self, terms: &[(f64, u32); N]) -> u32 {
        let mut position = [0.0; D];
        for (weight, node) in terms {
            for (x, y) in position.iter_mut().zip(self.nodes[*node as usize]) {
                *x += weight * y;
            }
        }
        self.nodes.push(position);
        self.first_at.push(NONE);
        self.nodes.len() as u32 - 1
    }
}
