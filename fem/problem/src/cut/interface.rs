//! The interface as pieces in space, the slope of the level set function on it, and the signed distance to it or to a given surface.

use super::simplices::linear_gradient;
use super::{Cut, CutError};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::locate::PieceTree;
use crate::mesh::{Mesh, RigidSurface};
use crate::space::Space;
use crate::threads::Threads;

/// A piece of the interface: a segment in the plane, a triangle in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfacePiece<const D: usize> {
    /// The cell that it is in.
    pub cell: u32,
    /// Its corners in the cell's reference coordinates.
    pub corners: [[f64; D]; D],
}

/// The signed distance to a closed surface \[length\], negative inside, at the vertices of a mesh: a level set function of degree 1 for
/// [`Cut::by`], from an STL file for instance. The body is that of the surface with errors of O(h²) where it is smooth; edges are bevelled within a cell,
/// and what is thinner than a cell may be lost. It uses all threads.
///
/// ```
/// use forms_fem::cut::{Cut, signed_distance};
/// use forms_fem::mesh::RigidSurface;
/// use forms_fem::prelude::*;
///
/// // A square on one of its corners.
/// let square = RigidSurface::along(&[[0.0, -0.8], [0.8, 0.0], [0.0, 0.8], [-0.8, 0.0], [0.0, -0.8]])?;
/// let mesh = rectangle([-1.0; 2], [1.0; 2], [40, 40], CellShape::Triangle, 1)?;
/// let body = Assembler::new(&mesh).cut_by(&signed_distance(&square, &mesh)?)?;
/// let area = body.functional(&form!(|| -> Functional { integral(cells("all"), 1) }))?;
/// assert!((area - 1.28).abs() < 2e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`CutError::Surface`] for a surface that is open; [`CutError::Mesh`].
#[inline(never)]
pub fn signed_distance<const D: usize>(
    surface: &RigidSurface<D>,
    mesh: &Mesh<D>,
) -> Result<Field<D>, CutError> {
    let distance =
        surface.signed_distance().map_err(|error| CutError::Surface { text: error.to_string() })?;
    let space = Space::scalar(mesh, 1).map_err(|error| CutError::Mesh { text: error.to_string() })?;
    let (threads, places) = (Threads::all(), space.positions());
    let parts = places.chunks(places.len().div_ceil(threads.count()).max(1)).collect();
    let values = threads
        .run(parts, |part: &[[f64; D]]| part.iter().map(|place| distance.at(place)).collect::<Vec<f64>>());
    Field::from_values(&space, values.concat()).map_err(|error| CutError::Mesh { text: error.to_string() })
}

impl<const D: usize> Cut<D> {
    /// The pieces of the interface by their corners \[length\]: segments in the plane, triangles in space. Of a curved interface they are between
    /// points on lines that join nodes.
    #[inline(never)]
    pub fn interface(&self) -> Vec<[[f64; D]; D]> {
        let placed = |InterfacePiece { cell, corners }: InterfacePiece<D>| {
            corners.map(|corner| self.mesh().map(cell as usize, &corner).0)
        };
        self.interface_pieces().into_iter().map(placed).collect()
    }

    /// The pieces of the interface with their cells, in which fields are evaluated ([`Field::evaluate_in`]).
    pub fn interface_pieces(&self) -> Vec<InterfacePiece<D>> {
        let mut pieces = Vec::new();
        for &cell in self.cut_cells() {
            for simplex in self.simplices_of(cell) {
                for piece in simplex.cut.zeros.iter() {
                    let places = simplex.places(piece);
                    pieces.push(InterfacePiece { cell, corners: std::array::from_fn(|k| places[k]) });
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
            for simplex in self.simplices_of(*cell) {
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
    /// [`CutError::OtherMesh`] for a function on another mesh.
    #[inline(never)]
    pub fn distance(&self, phi: &Field<D>) -> Result<Field<D>, CutError> {
        let space = phi.space();
        if !space.mesh().is_same(self.mesh()) || space.unknowns() != self.node_count() {
            return Err(CutError::OtherMesh);
        }
        let pieces = PieceTree::new(self.interface());
        let signed = |(x, own): (&[f64; D], &f64)| match pieces.distance(x) {
            f64::INFINITY => *own,
            // A node on the interface keeps its side.
            distance => distance.max(f64::MIN_POSITIVE).copysign(*own),
        };
        let values = space.positions().iter().zip(phi.values()).map(signed).collect();
        let failed = |error: crate::field::FieldError| CutError::Mesh { text: error.to_string() };
        Field::from_values(space, values).map_err(failed)
    }
}

instantiate!(cut_interface: Cut::<D>::interface, Cut::<D>::slopes, Cut::<D>::distance, signed_distance::<D>);
