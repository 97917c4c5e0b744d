//! Meshes with a band of small cells around the interface of a level set function, which follows it.

use std::sync::Arc;

use thiserror::Error;

use crate::field::Field;
use crate::mesh::{AdaptiveMesh, MeshError};
use crate::space::{Space, SpaceError};

/// A band of small cells around {φ = 0}: cells in which |φ| is below a width are no larger than a size. All others may be as large as those
/// of the first mesh.
///
/// ```
/// use forms_fem::adaptivity::InterfaceBand;
/// use forms_fem::mesh::AdaptiveMesh;
/// use forms_fem::prelude::*;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let coarse = AdaptiveMesh::new(rectangle([-1.0; 2], [1.0; 2], [8, 8], CellShape::Triangle, 1)?)?;
/// // All cells that the interface crosses.
/// let band = InterfaceBand::new(0.0, 0.02)?;
/// let disc = |radius: f64| {
///     move |space: &Arc<Space<2>>| -> Result<_, Box<dyn std::error::Error>> {
///         Ok(Field::interpolate(space, |x| x[0].hypot(x[1]) - radius)?)
///     }
/// };
/// let (mesh, phi) = band.fitted(&coarse, disc(0.7))?;
/// let body = Assembler::new(mesh.mesh()).cut_by(&phi)?;
/// // A uniform mesh with cells as small has 65,536.
/// assert!(5 * mesh.mesh().cell_count() < 65_536);
/// // A field that has changed takes the band along; where it was, cells become large again.
/// let grown = Field::from_values(phi.space(), phi.values().iter().map(|value| value - 0.1).collect())?;
/// let (next, phi) = band.fitted(&mesh, |space| -> Result<_, Box<dyn std::error::Error>> {
///     Ok(grown.onto(space).interpolated()?)
/// })?;
/// assert!(5 * next.mesh().cell_count() < 65_536);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy)]
pub struct InterfaceBand<'a, const D: usize> {
    width: f64,
    size: f64,
    place: Option<Place<'a, D>>,
}

/// Whether a position \[length\] belongs to a place.
type Place<'a, const D: usize> = &'a dyn Fn(&[f64; D]) -> bool;

/// Numbers with which there is no band.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum InterfaceBandError {
    /// A width that is negative or not finite.
    #[error("the width of the band is {width}; it must not be negative")]
    Width { width: f64 },
    /// Cells without a size.
    #[error("the size of the band's cells is {size}; it must be positive")]
    Size { size: f64 },
}

impl<'a, const D: usize> InterfaceBand<'a, D> {
    /// Cells of at most a diameter `size` \[length\] where |φ| < `width` \[unit of φ\]; for a width of zero, those that the interface crosses.
    ///
    /// # Errors
    /// [`InterfaceBandError`].
    pub fn new(width: f64, size: f64) -> Result<Self, InterfaceBandError> {
        if !(width >= 0.0 && width.is_finite()) {
            return Err(InterfaceBandError::Width { width });
        }
        match size > 0.0 {
            true => Ok(InterfaceBand { width, size, place: None }),
            false => Err(InterfaceBandError::Size { size }),
        }
    }

    /// The part of this band whose cells have their centres in a place, as where contact may be.
    pub fn only_in(self, place: &'a dyn Fn(&[f64; D]) -> bool) -> Self {
        InterfaceBand { place: Some(place), ..self }
    }

    /// The cells of φ's mesh that are in the band.
    fn cells(&self, phi: &Field<D>) -> Vec<bool> {
        let (space, mesh) = (phi.space(), phi.space().mesh());
        let is_near = |cell: usize| {
            let values = space.cell_nodes(cell).iter().map(|node| phi.values()[*node as usize]);
            let [least, most] = values.fold([f64::MAX, f64::MIN], |[a, b], v| [a.min(v), b.max(v)]);
            let is_own = self.place.is_none_or(|place| place(&mesh.cell_centre(cell)));
            is_own && least <= self.width && most >= -self.width
        };
        (0..mesh.cell_count()).map(is_near).collect()
    }

    /// The cells in the band that are too large, to be divided.
    pub fn large_cells(&self, phi: &Field<D>) -> Vec<u32> {
        let near = self.cells(phi).into_iter().enumerate();
        let large = near.filter(|(cell, near)| *near && phi.space().mesh().diameter(*cell) > self.size);
        large.map(|(cell, _)| cell as u32).collect()
    }

    /// The mesh with this band, and φ on it. `phi` makes the function on a space of degree 1: from a function of position, or from a
    /// field that it carries over ([`Field::onto`]), whose interface stays where it is. Cells of an earlier band that are not in this one become
    /// as large as they were at first.
    ///
    /// # Errors
    /// Those of `phi`; a mesh that cannot be refined so far.
    pub fn fitted<E: From<MeshError> + From<SpaceError>>(
        &self,
        mesh: &AdaptiveMesh<D>,
        phi: impl Fn(&Arc<Space<D>>) -> Result<Field<D>, E>,
    ) -> Result<(AdaptiveMesh<D>, Field<D>), E> {
        let mut mesh = mesh.clone();
        let mut coarsens = true;
        loop {
            let field = phi(&Space::scalar(mesh.mesh(), 1)?)?;
            if coarsens {
                let near = self.cells(&field);
                let far: Vec<u32> = (0..near.len() as u32).filter(|cell| !near[*cell as usize]).collect();
                let (coarser, _) = mesh.coarsened(&far)?;
                coarsens = coarser.mesh().cell_count() < near.len();
                mesh = coarser;
                continue;
            }
            let large = self.large_cells(&field);
            if large.is_empty() {
                return Ok((mesh, field));
            }
            mesh = mesh.refined_onto(&large, &[])?.0;
        }
    }
}
