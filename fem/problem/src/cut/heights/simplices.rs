//! A quadrilateral or hexahedron that is cut along heights, as simplices on which the level set function is linear between its nodes: for
//! pictures, distances and the size of parts. Kuhn's simplices follow the axes from one corner of a box to the opposite one.

use crate::cut::Cut;
use crate::cut::pieces::{SimplexPieces, VertexValues};
use crate::cut::simplices::CutSimplex;

/// The orders of the axes along which simplices go.
const ORDERS: [&[[usize; 3]]; 2] =
    [&[[0, 1, 2], [1, 0, 2]], &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]];

/// The simplices of a box that is divided into `parts` along each axis, by the numbers of their corners along each axis.
pub(in crate::cut) fn kuhn<const D: usize>(parts: usize) -> impl Iterator<Item = [[usize; D]; 4]> {
    (0..parts.pow(D as u32)).flat_map(move |index| {
        let first: [usize; D] = std::array::from_fn(|k| index / parts.pow(k as u32) % parts);
        ORDERS[D - 2].iter().map(move |order| {
            let mut corners = [first; 4];
            for k in 1..=D {
                corners[k] = corners[k - 1];
                corners[k][order[k - 1]] += 1;
            }
            corners
        })
    })
}

impl<const D: usize> Cut<D> {
    /// The simplices of a cell with their pieces: those that are integrated over, or of a cell cut along heights a picture of these.
    pub(in crate::cut) fn simplices_of(&self, cell: u32) -> Vec<SimplexPieces<f64, D>> {
        if !self.cuts_by_heights(cell) {
            return VertexValues::<f64>::new(self, cell).simplices().collect();
        }
        let mut lattice = [0.0; 27];
        for (node, place) in self.level_nodes(cell).iter().zip(&self.lattice) {
            lattice[usize::from(*place)] = self.values[*node as usize];
        }
        let parts = self.degree;
        let simplex = |corners: [[usize; D]; 4]| {
            let (mut vertices, mut values) = ([[0.0; D]; 4], [0.0; 4]);
            for (k, corner) in corners.iter().enumerate() {
                vertices[k] = corner.map(|number| number as f64 / parts as f64);
                let places = corner.iter().zip([1, 3, 9]).map(|(number, step)| number * step * 2 / parts);
                values[k] = lattice[places.sum::<usize>()];
            }
            SimplexPieces { vertices, values, cut: CutSimplex::new(&values[..=D]) }
        };
        kuhn::<D>(parts).map(simplex).collect()
    }
}
