//! Simplices cut by a function that is linear on them: the pieces on which it is negative, and those of its zeros.
//!
//! The signs at the vertices say which corners a piece has; only the places of these depend on the values. All numbers are generic, so that
//! derivatives by the values come from the same lines.

use std::ops::Deref;

use super::number::Number;
use crate::mesh::small_matrices::inverse;

/// A corner of a piece: a vertex of the simplex (both numbers are the same), or the zero on the edge between two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CutCorner {
    pub from: u8,
    pub to: u8,
}

/// The corners of a simplex of D dimensions, the first D + 1 of four.
pub(crate) type CutPiece = [CutCorner; 4];

impl CutCorner {
    fn vertex(vertex: usize) -> Self {
        CutCorner { from: vertex as u8, to: vertex as u8 }
    }

    fn zero(a: usize, b: usize) -> Self {
        CutCorner { from: a as u8, to: b as u8 }
    }

    /// The corner's place in a simplex with these vertices and values at them.
    pub fn place<R: Number, const D: usize>(self, vertices: &[[f64; D]], values: &[R]) -> [R; D] {
        let (a, b) = (usize::from(self.from), usize::from(self.to));
        if a == b {
            return vertices[a].map(R::from);
        }
        let t = values[a] / (values[a] - values[b]);
        std::array::from_fn(|k| t * (vertices[b][k] - vertices[a][k]) + vertices[a][k])
    }
}

/// Pieces of one simplex: three at most, without an allocation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pieces {
    list: [CutPiece; 3],
    count: usize,
}

impl Pieces {
    const NONE: Self = Pieces { list: [[CutCorner { from: 0, to: 0 }; 4]; 3], count: 0 };

    /// Adds a piece; corners that it does not have are the first vertex.
    fn push<const C: usize>(&mut self, corners: [CutCorner; C]) {
        self.list[self.count][..C].copy_from_slice(&corners);
        self.count += 1;
    }
}

impl Deref for Pieces {
    type Target = [CutPiece];

    fn deref(&self) -> &[CutPiece] {
        &self.list[..self.count]
    }
}

/// A simplex in pieces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutSimplex {
    /// Pieces on which the function is negative.
    pub inside: Pieces,
    /// Pieces of its zeros, with one corner fewer each.
    pub zeros: Pieces,
}

impl CutSimplex {
    /// The pieces for values at the vertices. No value is zero.
    pub fn new<R: Number>(values: &[R]) -> Self {
        let (mut inner, mut outer, mut count) = ([0; 4], [0; 4], [0; 2]);
        for (k, value) in values.iter().enumerate() {
            let (list, count) =
                if value.value() < 0.0 { (&mut inner, &mut count[0]) } else { (&mut outer, &mut count[1]) };
            list[*count] = k;
            *count += 1;
        }
        let (vertex, zero) = (CutCorner::vertex, CutCorner::zero);
        let mut cut = CutSimplex { inside: Pieces::NONE, zeros: Pieces::NONE };
        match (&inner[..count[0]], &outer[..count[1]]) {
            (&[a, b, c], []) => cut.inside.push([a, b, c].map(vertex)),
            (&[a, b, c, d], []) => cut.inside.push([a, b, c, d].map(vertex)),
            (&[a, b], []) => cut.inside.push([a, b].map(vertex)),
            (&[a], &[b]) => {
                cut.inside.push([vertex(a), zero(a, b)]);
                cut.zeros.push([zero(a, b)]);
            }
            (&[a], &[b, c]) => {
                cut.inside.push([vertex(a), zero(a, b), zero(a, c)]);
                cut.zeros.push([zero(a, b), zero(a, c)]);
            }
            (&[a], &[b, c, d]) => {
                let zeros = [zero(a, b), zero(a, c), zero(a, d)];
                cut.inside.push([vertex(a), zeros[0], zeros[1], zeros[2]]);
                cut.zeros.push(zeros);
            }
            (&[a, b], &[c]) => {
                cut.inside.push([vertex(a), vertex(b), zero(b, c)]);
                cut.inside.push([vertex(a), zero(b, c), zero(a, c)]);
                cut.zeros.push([zero(a, c), zero(b, c)]);
            }
            (&[a, b, c], &[d]) => {
                let tops = [zero(a, d), zero(b, d), zero(c, d)];
                prism([vertex(a), vertex(b), vertex(c)], tops)
                    .into_iter()
                    .for_each(|piece| cut.inside.push(piece));
                cut.zeros.push(tops);
            }
            (&[a, b], &[c, d]) => {
                let ends = [[vertex(a), zero(a, c), zero(a, d)], [vertex(b), zero(b, c), zero(b, d)]];
                prism(ends[0], ends[1]).into_iter().for_each(|piece| cut.inside.push(piece));
                cut.zeros.push([zero(a, c), zero(b, c), zero(a, d)]);
                cut.zeros.push([zero(b, c), zero(a, d), zero(b, d)]);
            }
            // Nothing is inside; a simplex has two to four vertices.
            _ => {}
        }
        cut
    }
}

/// A prism as three tetrahedra.
fn prism([a, b, c]: [CutCorner; 3], [d, e, f]: [CutCorner; 3]) -> [CutPiece; 3] {
    [[a, b, c, d], [b, c, d, e], [c, d, e, f]]
}

/// The gradient of the linear function with these values at the D + 1 vertices of a simplex.
pub(crate) fn linear_gradient<R: Number, const D: usize>(vertices: &[[f64; D]], values: &[R]) -> [R; D] {
    let edges: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|k| vertices[i + 1][k] - vertices[0][k]));
    let inverse = inverse(&edges).unwrap_or([[0.0; D]; D]);
    std::array::from_fn(|k| (0..D).map(|i| (values[i + 1] - values[0]) * inverse[k][i]).sum())
}

/// The determinant of a small matrix of any numbers.
pub(crate) fn determinant_of<R: Number, const D: usize>(a: &[[R; D]; D]) -> R {
    if D == 2 {
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    }
    let terms = (0..D).map(|k| {
        let (i, j) = ((k + 1) % D, (k + 2) % D);
        a[0][k] * (a[1][i] * a[2][j] - a[1][j] * a[2][i])
    });
    terms.sum()
}

/// The edges of a piece from its first corner.
pub(crate) fn edges_of<R: Number, const D: usize>(corners: &[[R; D]; 4]) -> [[R; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|k| corners[i + 1][k] - corners[0][k]))
}

#[cfg(test)]
mod tests {
    use super::super::number::Varied;
    use super::*;

    fn volume<const D: usize>(pieces: &[CutPiece], vertices: &[[f64; D]], values: &[f64]) -> f64 {
        let of_piece = |piece: &CutPiece| {
            determinant_of(&edges_of(&piece.map(|corner| corner.place(vertices, values)))).abs()
        };
        pieces.iter().map(of_piece).sum()
    }

    /// The pieces inside and those outside fill the simplex, for every choice of signs; corners of zeros are zeros.
    fn fill<const D: usize>(vertices: &[[f64; D]]) {
        let sizes = [0.3, 1.1, 0.7, 2.0];
        for signs in 0..1_usize << (D + 1) {
            let values: Vec<f64> =
                (0..=D).map(|k| if signs >> k & 1 == 1 { -sizes[k] } else { sizes[k] }).collect();
            let opposite: Vec<f64> = values.iter().map(|value| -value).collect();
            let (own, other) = (CutSimplex::new(&values), CutSimplex::new(&opposite));
            let sum = volume(&own.inside, vertices, &values) + volume(&other.inside, vertices, &opposite);
            assert!((sum - 1.0).abs() < 1e-14, "{signs:b}: {sum}");
            assert_eq!(own.zeros.len(), other.zeros.len());
            let slope = linear_gradient(vertices, &values);
            for corner in own.zeros.iter().flat_map(|piece| &piece[..D]) {
                let place: [f64; D] = corner.place(vertices, &values);
                let value: f64 =
                    values[0] + (0..D).map(|k| slope[k] * (place[k] - vertices[0][k])).sum::<f64>();
                assert!(value.abs() < 1e-14, "{value}");
            }
        }
    }

    #[test]
    fn pieces_fill_a_simplex() {
        fill(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        fill(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn places_have_derivatives() {
        let vertices = [[0.1, 0.0], [1.0, 0.2], [0.3, 0.9]];
        let values = [-0.4, 0.7, 0.2];
        for corner in CutSimplex::new(&values).inside.iter().flat_map(|piece| &piece[..3]) {
            let seeded: [Varied; 3] = std::array::from_fn(|k| Varied::of_node(values[k], k));
            let found = corner.place(&vertices, &seeded);
            for by in 0..3 {
                let at = |step: f64| {
                    let mut moved = values;
                    moved[by] += step;
                    corner.place(&vertices, &moved)
                };
                let (next, last) = (at(1e-6), at(-1e-6));
                for k in 0..2 {
                    assert!((found[k].slopes[by] - (next[k] - last[k]) / 2e-6).abs() < 1e-9);
                }
            }
        }
    }
}
