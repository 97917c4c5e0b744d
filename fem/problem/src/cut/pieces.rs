//! Pieces of a cut cell, of its interface and of its facets, in reference coordinates, with the points of rules on them.

use super::number::Number;
use super::simplices::{CutPiece, CutSimplex, determinant_of, edges_of, linear_gradient};
use super::{Cut, CutSide};
use crate::element::CellShape;
use crate::mesh::Facet;
use crate::quadrature::{Piece, QuadratureRule};

/// The simplices of a cell that are cut one by one, by its vertices.
fn simplices_of(shape: CellShape) -> &'static [&'static [usize]] {
    match shape {
        CellShape::Triangle => &[&[0, 1, 2]],
        CellShape::Quadrilateral => &[&[0, 1, 2], &[0, 2, 3]],
        CellShape::Tetrahedron | CellShape::Hexahedron => &[&[0, 1, 2, 3]],
    }
}

/// The values of a level set function at the vertices of a cell.
pub(crate) struct VertexValues<R> {
    shape: CellShape,
    values: [R; 4],
}

impl<R: Number> VertexValues<R> {
    /// The values of a cell.
    pub fn new<const D: usize>(cut: &Cut<D>, cell: u32) -> Self {
        let values = cut.vertex_values(cell);
        let values = std::array::from_fn(|k| R::of_node(values[k], k));
        VertexValues { shape: cut.mesh().cell_shape(cell as usize), values }
    }

    /// The simplices of the cell.
    pub fn simplices<const D: usize>(&self) -> impl Iterator<Item = SimplexPieces<R, D>> {
        let points = self.shape.vertex_points();
        simplices_of(self.shape).iter().map(move |numbers| {
            let (mut vertices, mut values) = ([[0.0; D]; 4], [R::zero(); 4]);
            for (k, vertex) in numbers.iter().enumerate() {
                vertices[k] = std::array::from_fn(|axis| points[*vertex][axis]);
                values[k] = self.values[*vertex];
            }
            SimplexPieces { vertices, values, cut: CutSimplex::new(&values[..=D]) }
        })
    }

    /// The pieces of a facet inside, on its own reference cell.
    pub fn pieces_of_facet<const D: usize>(&self, local: u8) -> Vec<[[R; 2]; 3]> {
        let numbers = self.shape.facet_vertices(usize::from(local));
        let values: Vec<R> = numbers.iter().map(|vertex| self.values[*vertex]).collect();
        let vertices: &[[f64; 2]] = &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][..D];
        let corners = |piece: &CutPiece| -> [[R; 2]; 3] {
            std::array::from_fn(|k| match k < D {
                true => piece[k].place(vertices, &values),
                false => [R::zero(); 2],
            })
        };
        CutSimplex::new(&values).inside.iter().map(corners).collect()
    }

    /// The points of a rule on each piece inside, in reference coordinates with their weights there.
    pub fn points_inside<const D: usize>(&self, rule: &QuadratureRule<D>, points: &mut Vec<R>) {
        for simplex in self.simplices::<D>() {
            for piece in simplex.cut.inside.iter() {
                let corners = simplex.places(piece);
                let edges = edges_of(&corners);
                let volume = determinant_of(&edges).abs();
                for (point, weight) in rule.points.iter().zip(&rule.weights) {
                    points.extend(
                        (0..D).map(|k| (0..D).fold(corners[0][k], |sum, i| sum + edges[i][k] * point[i])),
                    );
                    points.push(volume * *weight);
                }
            }
        }
    }

    /// The points of a rule on each piece of the interface, in reference coordinates, with their weights and the unit normal there. The
    /// rule is one on facets.
    pub fn points_of_interface<const D: usize>(&self, rule: &QuadratureRule<2>, points: &mut Vec<R>) {
        for simplex in self.simplices::<D>() {
            if simplex.cut.zeros.is_empty() {
                continue;
            }
            let slope = linear_gradient(&simplex.vertices[..=D], &simplex.values[..=D]);
            let size = slope.iter().map(|entry| *entry * *entry).sum::<R>().sqrt();
            for piece in simplex.cut.zeros.iter() {
                let corners = simplex.places(piece);
                let edges = edges_of(&corners);
                let area = area(&edges);
                for (point, weight) in rule.points.iter().zip(&rule.weights) {
                    points.extend(
                        (0..D).map(|k| (0..D - 1).fold(corners[0][k], |sum, i| sum + edges[i][k] * point[i])),
                    );
                    points.push(area * *weight);
                    points.extend(slope.iter().map(|entry| *entry / size));
                }
            }
        }
    }

    /// The points of a rule on each piece of a facet, as [`points_on_pieces`] lists them.
    pub fn points_on_facet<const D: usize>(&self, local: u8, rule: &QuadratureRule<2>, points: &mut Vec<R>) {
        points_on_pieces::<R, D>((self.shape, local), &self.pieces_of_facet::<D>(local), rule, points);
    }
}

/// The points of a rule on each piece of a facet of a shape, in reference coordinates of the cell with their weights on the facet's own.
pub(super) fn points_on_pieces<R: Number, const D: usize>(
    (shape, local): (CellShape, u8),
    pieces: &[[[R; 2]; 3]],
    rule: &QuadratureRule<2>,
    points: &mut Vec<R>,
) {
    let numbers = shape.facet_vertices(usize::from(local));
    let vertices = shape.vertex_points();
    let corner = |k: usize| vertices[numbers[k]];
    for [origin, along, across] in pieces {
        let edges = [along, across].map(|end| [end[0] - origin[0], end[1] - origin[1]]);
        let measure = match D {
            2 => edges[0][0].abs(),
            _ => (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]).abs(),
        };
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let place = [0, 1].map(|k| (0..D - 1).fold(origin[k], |sum, i| sum + edges[i][k] * point[i]));
            points.extend((0..D).map(|k| {
                let rates = (1..D).map(|i| corner(i)[k] - corner(0)[k]);
                rates.zip(place).fold(R::from(corner(0)[k]), |sum, (rate, s)| sum + s * rate)
            }));
            points.push(measure * *weight);
        }
    }
}

/// The length of the first edge in the plane, the area of the parallelogram of the first two in space.
fn area<R: Number, const D: usize>(edges: &[[R; D]; D]) -> R {
    let inner = |a: &[R; D], b: &[R; D]| -> R { a.iter().zip(b).map(|(a, b)| *a * *b).sum() };
    let first = inner(&edges[0], &edges[0]);
    if D == 2 {
        return first.sqrt();
    }
    let (second, mixed) = (inner(&edges[1], &edges[1]), inner(&edges[0], &edges[1]));
    (first * second - mixed * mixed).sqrt()
}

/// One simplex of a cell with its pieces.
pub(crate) struct SimplexPieces<R, const D: usize> {
    pub vertices: [[f64; D]; 4],
    pub values: [R; 4],
    pub cut: CutSimplex,
}

impl<R: Number, const D: usize> SimplexPieces<R, D> {
    /// The corners of a piece; those that it does not have are no places.
    pub fn places(&self, piece: &CutPiece) -> [[R; D]; 4] {
        piece.map(|corner| corner.place(&self.vertices[..=D], &self.values[..=D]))
    }
}

impl<const D: usize> Cut<D> {
    /// The pieces of a facet inside, on the facet's own reference cell; `None` for a whole one.
    pub(crate) fn pieces_of_facet(&self, facet: Facet) -> Option<Vec<Piece>> {
        match self.side_of_facet(facet) {
            CutSide::Inside => None,
            CutSide::Outside => Some(vec![]),
            CutSide::Cut => {
                Some(VertexValues::<f64>::new(self, facet.cell).pieces_of_facet::<D>(facet.local))
            }
        }
    }
}
