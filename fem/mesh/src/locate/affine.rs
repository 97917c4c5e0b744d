//! The inverse of an affine cell's map.

use crate::mesh::Mesh;
use crate::mesh::small_matrices::inverse;

/// The inverse of an affine cell's map: one step of Newton's method from the centre, of any length.
#[derive(Clone, Copy, Debug)]
pub struct AffineInverse<const D: usize> {
    centre: [f64; D],
    /// The centre's image \[length\].
    image: [f64; D],
    /// The inverse of the Jacobian \[1/length\].
    inverse: [[f64; D]; D],
}

impl<const D: usize> AffineInverse<D> {
    /// That of a cell; none where the cell's map is not affine, or has no inverse.
    pub(super) fn of(mesh: &Mesh<D>, cell: usize) -> Option<Self> {
        let shape = mesh.cell_shape(cell);
        if !mesh.is_affine_on(shape) {
            return None;
        }
        // The Jacobian's columns are the edges from the first vertex.
        let (centre, vertices) = (shape.centre::<D>(), mesh.cell(cell));
        let [first, others @ ..] = vertices else { return None };
        let (first, others) = (&mesh.nodes()[*first as usize], &others[..D]);
        let edge = |i: usize, j: usize| mesh.nodes()[others[j] as usize][i] - first[i];
        let jacobian: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|j| edge(i, j)));
        let image = |i: usize| first[i] + (0..D).map(|j| jacobian[i][j] * centre[j]).sum::<f64>();
        let image = std::array::from_fn(image);
        Some(AffineInverse { centre, image, inverse: inverse(&jacobian)? })
    }

    /// Reference coordinates of a point; none where they are not finite.
    #[inline]
    pub fn place(&self, point: &[f64; D]) -> Option<[f64; D]> {
        let step = |i: usize| (0..D).map(|j| self.inverse[i][j] * (point[j] - self.image[j])).sum::<f64>();
        let reference: [f64; D] = std::array::from_fn(|i| self.centre[i] + step(i));
        reference.iter().all(|coordinate| coordinate.is_finite()).then_some(reference)
    }
}
