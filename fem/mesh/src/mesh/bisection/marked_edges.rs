//! Marked edges of a simplex: which edge its bisection divides, and which those of its parts.

use crate::element::CellShape;

/// The edge that the next bisection of a triangle or a tetrahedron divides, by its number among [`CellShape::edges`], and what it
/// leaves to the two parts.
///
/// A triangle leaves to each part the edge opposite the new vertex (newest vertex bisection; W. F. Mitchell, Adaptive
/// refinement for arbitrary finite-element spaces with hierarchical bases, 1991). A tetrahedron has a marked edge on each face,
/// and a flag, by the rules of D. N. Arnold, A. Mukherjee and L. Pouly, Locally adapted tetrahedral meshes using
/// bisection, SIAM J. Sci. Comput. 22 (2000): from every conforming mesh whose cells agree on the marked edges of their faces, refinement ends in a
/// conforming mesh, and the descendants of a tetrahedron are similar to one of finitely many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MarkedEdges {
    /// The edge that is divided next; of a tetrahedron it is the marked one of both faces that have it.
    refinement_edge: u8,
    /// The marked edges of a tetrahedron's faces, each opposite the vertex of its number.
    of_faces: [u8; 4],
    /// Whether a tetrahedron whose marked edges lie in a plane is the child of another such one.
    flagged: bool,
}

/// For each pair of vertices the edge between them, that of a tetrahedron or of a triangle.
const EDGES: [[u8; 4]; 4] = [[0, 0, 2, 3], [0, 0, 1, 4], [2, 1, 0, 5], [3, 4, 5, 0]];

/// The part of a bisected cell that keeps its vertex a, or its vertex b, of the divided edge (a, b). The other one gives its
/// place among the part's vertices to the new vertex, so that both parts have the cell's orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    KeepsFirst,
    KeepsSecond,
}

impl Part {
    pub(super) const BOTH: [Part; 2] = [Part::KeepsFirst, Part::KeepsSecond];

    /// The kept vertex of the divided edge, and the place of the new vertex.
    pub(super) fn kept_and_new(self, [a, b]: [usize; 2]) -> [usize; 2] {
        match self {
            Part::KeepsFirst => [a, b],
            Part::KeepsSecond => [b, a],
        }
    }
}

impl MarkedEdges {
    /// The longest edge of the cell and of each of its faces, in an order of all edges of the mesh in which no two are equal.
    pub(super) fn longest<K: PartialOrd>(shape: CellShape, rank: impl Fn(usize) -> K) -> Self {
        let edges = shape.edges();
        let longest = |without: Option<usize>| {
            let mut best: Option<(K, usize)> = None;
            for (number, edge) in edges.iter().enumerate() {
                if without.is_some_and(|vertex| edge.contains(&vertex)) {
                    continue;
                }
                let key = rank(number);
                if best.as_ref().is_none_or(|(largest, _)| key > *largest) {
                    best = Some((key, number));
                }
            }
            best.map_or(0, |(_, number)| number as u8)
        };
        let of_faces = match shape {
            CellShape::Tetrahedron => std::array::from_fn(|vertex| longest(Some(vertex))),
            _ => [0; 4],
        };
        MarkedEdges { refinement_edge: longest(None), of_faces, flagged: false }
    }

    /// The number of the edge that is divided next.
    pub(super) fn refinement_edge(self) -> usize {
        usize::from(self.refinement_edge)
    }

    /// The marked edges of a part.
    pub(super) fn of_part(self, shape: CellShape, part: Part) -> Self {
        let divided = shape.edges()[self.refinement_edge()];
        let [kept, new] = part.kept_and_new(divided);
        let others = (0..shape.vertices()).filter(|vertex| !divided.contains(vertex));
        if shape == CellShape::Triangle {
            let refinement_edge = others.map(|other| EDGES[kept][other]).next().unwrap_or(0);
            return MarkedEdges { refinement_edge, ..self };
        }
        let mut others = others;
        let (c, d) = (others.next().unwrap_or(0), others.next().unwrap_or(0));
        let mut of_faces = [0; 4];
        // The face that was one of the cell's keeps its mark; on halves of faces the edge opposite the new vertex is marked.
        of_faces[new] = self.of_faces[new];
        of_faces[c] = EDGES[kept][d];
        of_faces[d] = EDGES[kept][c];
        let meeting = self.vertex_of_the_plane([c, d]);
        of_faces[kept] = match meeting {
            Some(vertex) if self.flagged => EDGES[new][vertex],
            _ => EDGES[c][d],
        };
        MarkedEdges {
            refinement_edge: self.of_faces[new],
            of_faces,
            flagged: meeting.is_some() && !self.flagged,
        }
    }

    /// Of the two vertices that are not divided the one at which the marked edges of their faces meet, if these lie in a plane
    /// with the refinement edge.
    fn vertex_of_the_plane(self, others: [usize; 2]) -> Option<usize> {
        let [a, b] = CellShape::Tetrahedron.edges()[self.refinement_edge()];
        others
            .into_iter()
            .find(|&vertex| self.of_faces[b] == EDGES[a][vertex] && self.of_faces[a] == EDGES[b][vertex])
    }
}

#[cfg(test)]
impl MarkedEdges {
    /// Whether the marked edges of a tetrahedron's faces lie in a plane.
    pub(super) fn lie_in_a_plane(self) -> bool {
        let divided = CellShape::Tetrahedron.edges()[self.refinement_edge()];
        let others: Vec<usize> = (0..4).filter(|vertex| !divided.contains(vertex)).collect();
        self.vertex_of_the_plane([others[0], others[1]]).is_some()
    }
}

/// A step of a nesting: the part that the division of an edge gives.
pub(super) fn step(edge: usize, part: Part) -> u8 {
    2 * edge as u8 + u8::from(part == Part::KeepsSecond)
}

/// The vertex that a step of a nesting replaces, and the ends of the edge in whose middle the new one lies.
pub(in crate::mesh) fn step_of_bisection(shape: CellShape, step: u8) -> (usize, [usize; 2]) {
    let ends = shape.edges()[usize::from(step / 2)];
    let [_, new] = Part::BOTH[usize::from(step % 2)].kept_and_new(ends);
    (new, ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_edges_is_that_of_the_shapes() {
        for shape in [CellShape::Triangle, CellShape::Tetrahedron] {
            for (number, &[a, b]) in shape.edges().iter().enumerate() {
                assert_eq!((EDGES[a][b], EDGES[b][a]), (number as u8, number as u8));
            }
        }
    }

    /// The refinement edge is the marked one of both of its faces, whatever the edges' lengths and for all descendants.
    #[test]
    fn faces_at_the_refinement_edge_have_it_marked() {
        let shape = CellShape::Tetrahedron;
        let mut all: Vec<MarkedEdges> = Vec::new();
        for order in 0..720 {
            let mut ranks: Vec<usize> = (0..6).collect();
            let mut code = order;
            for k in (1..6).rev() {
                ranks.swap(k, code % (k + 1));
                code /= k + 1;
            }
            let first = MarkedEdges::longest(shape, |edge| ranks[edge]);
            let mut generation = vec![first];
            for _ in 0..6 {
                for marks in &generation {
                    let [a, b] = shape.edges()[marks.refinement_edge()];
                    for face in (0..4).filter(|face| *face != a && *face != b) {
                        assert_eq!(marks.of_faces[face], marks.refinement_edge, "{marks:?}");
                    }
                    for (face, edge) in marks.of_faces.iter().enumerate() {
                        assert!(!shape.edges()[usize::from(*edge)].contains(&face), "{marks:?}");
                    }
                }
                generation = generation
                    .iter()
                    .flat_map(|marks| Part::BOTH.map(|part| marks.of_part(shape, part)))
                    .collect();
                all.extend(&generation);
            }
        }
        assert!(all.iter().any(|marks| marks.flagged) && all.iter().any(|marks| !marks.flagged));
    }
}
