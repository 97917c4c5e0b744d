//! The interface as pieces in space, the slope of the level set function on it, and the signed distance to it.

use super::simplices::linear_gradient;
use super::{Cut, VertexValues};
use crate::field::Field;
use crate::instantiate::instantiate;

impl<const D: usize> Cut<D> {
    /// The pieces of the interface by their corners \[length\]: segments in the plane, triangles in space.
    #[inline(never)]
    pub fn interface(&self) -> Vec<[[f64; D]; D]> {
        let mut pieces = Vec::new();
        for cell in self.cut_cells() {
            for simplex in VertexValues::<f64>::new(self, *cell, None).simplices() {
                for piece in simplex.cut.zeros.iter() {
                    let places = simplex.places(piece);
                    pieces.push(std::array::from_fn(|k| self.mesh().map(*cell as usize, &places[k]).0));
                }
            }
        }
        pieces
    }

    /// The least and the largest |∇φ| on the cut cells, with cells as simplices between their vertices: 1 for a distance.
    #[inline(never)]
    pub fn slopes(&self) -> [f64; 2] {
        let mut range = [f64::INFINITY, 0.0_f64];
        for cell in self.cut_cells() {
            for simplex in VertexValues::<f64>::new(self, *cell, None).simplices::<D>() {
                if !simplex.cut.zeros.is_empty() {
                    let places = simplex.vertices.map(|place| self.mesh().map(*cell as usize, &place).0);
                    let slope = linear_gradient(&places[..=D], &simplex.values[..=D]);
                    let size = slope.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
                    range = [range[0].min(size), range[1].max(size)];
                }
            }
        }
        range
    }

    /// The signed distance to the interface \[length\] at the nodes of a function's space: a step of its own in a descent, when
    /// [`Cut::slopes`] are far from 1. Signs at the nodes stay, so that the same cells are cut; the interface moves by O(h²).
    ///
    /// ```
    /// use forms_fem::cut::Cut;
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([-1.0; 2], [1.0; 2], [32, 32], CellShape::Triangle, 1)?;
    /// let steep = Field::interpolate(&Space::scalar(&mesh, 1)?, |x| 10.0 * (x[0] * x[0] + x[1] * x[1] - 0.49))?;
    /// let cut = Cut::by(&steep)?;
    /// assert!(cut.slopes()[0] > 10.0);
    /// let distance = cut.distance(&steep)?;
    /// assert!((distance.evaluate(&[0.0, 0.0])?[0] + 0.7).abs() < 2e-3);
    /// let slopes = Cut::by(&distance)?.slopes();
    /// assert!(slopes[0] > 0.9 && slopes[1] < 1.1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CutError::OtherMesh`](super::CutError::OtherMesh) for a function on another mesh.
    #[inline(never)]
    pub fn distance(&self, phi: &Field<D>) -> Result<Field<D>, super::CutError> {
        let space = phi.space();
        if !space.mesh().is_same(self.mesh()) || space.unknowns() != self.node_count() {
            return Err(super::CutError::OtherMesh);
        }
        // Along the first axis: of each piece its centre and half its extent.
        let mut pieces: Vec<(f64, [[f64; D]; D])> = Vec::new();
        let mut reach = 0.0_f64;
        for piece in self.interface() {
            let ends = piece.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x[0]), b.max(x[0])));
            reach = reach.max(0.5 * (ends.1 - ends.0));
            pieces.push((0.5 * (ends.0 + ends.1), piece));
        }
        pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let nearest = |x: &[f64; D]| {
            let middle = pieces.partition_point(|(centre, _)| *centre < x[0]);
            let mut best = f64::INFINITY;
            for (centre, piece) in &pieces[middle..] {
                if centre - x[0] - reach > best {
                    break;
                }
                best = best.min(to_piece(x, piece));
            }
            for (centre, piece) in pieces[..middle].iter().rev() {
                if x[0] - centre - reach > best {
                    break;
                }
                best = best.min(to_piece(x, piece));
            }
            best
        };
        let signed = |(x, own): (&[f64; D], &f64)| match pieces.is_empty() {
            true => *own,
            // A node on the interface keeps its side.
            false => nearest(x).max(f64::MIN_POSITIVE).copysign(*own),
        };
        let values = space.positions().iter().zip(phi.values()).map(signed).collect();
        let failed = |error: crate::field::FieldError| super::CutError::Mesh { text: error.to_string() };
        Field::from_values(space, values).map_err(failed)
    }
}

/// The distance of a point to a segment in the plane or a triangle in space.
fn to_piece<const D: usize>(x: &[f64; D], piece: &[[f64; D]; D]) -> f64 {
    let edges = (0..D).map(|k| to_segment(x, &piece[k], &piece[(k + 1) % D]));
    let on_edges = edges.fold(f64::INFINITY, f64::min);
    if D == 2 {
        return on_edges;
    }
    // Inside the triangle the foot on its plane is the nearest.
    let minus = |a: &[f64; D], b: &[f64; D]| -> [f64; D] { std::array::from_fn(|k| a[k] - b[k]) };
    let inner = |a: &[f64; D], b: &[f64; D]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (e, f, r) = (minus(&piece[1], &piece[0]), minus(&piece[2], &piece[0]), minus(x, &piece[0]));
    let (ee, ef, ff, er, fr) = (inner(&e, &e), inner(&e, &f), inner(&f, &f), inner(&e, &r), inner(&f, &r));
    let determinant = ee * ff - ef * ef;
    let (s, t) = ((er * ff - fr * ef) / determinant, (fr * ee - er * ef) / determinant);
    if determinant > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        let foot: [f64; D] = std::array::from_fn(|k| r[k] - s * e[k] - t * f[k]);
        return inner(&foot, &foot).sqrt();
    }
    on_edges
}

fn to_segment<const D: usize>(x: &[f64; D], a: &[f64; D], b: &[f64; D]) -> f64 {
    let (mut square, mut product) = (0.0, 0.0);
    for k in 0..D {
        square += (b[k] - a[k]) * (b[k] - a[k]);
        product += (x[k] - a[k]) * (b[k] - a[k]);
    }
    let t = if square > 0.0 { (product / square).clamp(0.0, 1.0) } else { 0.0 };
    (0..D).map(|k| (x[k] - a[k] - t * (b[k] - a[k])).powi(2)).sum::<f64>().sqrt()
}

instantiate!(cut_interface: Cut::<D>::interface, Cut::<D>::slopes, Cut::<D>::distance);

#[cfg(test)]
mod tests {
    use super::to_piece;

    #[test]
    fn distances_to_a_triangle() {
        let piece = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let cases = [
            ([0.2, 0.2, 0.5], 0.5),
            ([-3.0, 0.0, 4.0], 5.0),
            ([1.0, 1.0, 0.0], 0.5_f64.sqrt()),
            ([0.5, -2.0, 0.0], 2.0),
        ];
        for (x, expected) in cases {
            assert!((to_piece(&x, &piece) - expected).abs() < 1e-14, "{x:?}");
        }
    }
}
