//! The signed distance to a closed surface, as of a body that an STL file gives.

use super::{RigidSurface, RigidSurfaceError};
use crate::locate::PieceTree;

/// The signed distance to a closed surface: negative inside. It is exact at each point; the side is that of the winding number, so that edges and
/// corners of any kind are right, and bodies that overlap are united (their distance is that to the nearest facet of either).
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::mesh::RigidSurface;
///
/// let bar = RigidSurface::along(&[[0.0, 2.0], [1.0, 2.0], [1.0, 3.0], [0.0, 3.0], [0.0, 2.0]])?;
/// let distance = bar.signed_distance()?;
/// assert_eq!(distance.at(&[0.5, 2.25]), -0.25);
/// assert_eq!(distance.at(&[4.0, 7.0]), 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SignedDistance<const D: usize> {
    tree: PieceTree<D>,
    /// Winding numbers above this are inside.
    threshold: f64,
}

impl<const D: usize> RigidSurface<D> {
    /// The signed distance to the surface. Of one whose outward side looks inward, as that of a mould, the void is outside.
    ///
    /// # Errors
    /// [`RigidSurfaceError::Open`] for a surface with a rim.
    #[inline(never)]
    pub fn signed_distance(&self) -> Result<SignedDistance<D>, RigidSurfaceError> {
        if let Some((facet, position)) = self.open {
            let (rim, position) = (self.rim, position.to_vec());
            return Err(RigidSurfaceError::Open { rim, facet, position });
        }
        let corners = |facet: &[u32; D]| facet.map(|point| self.points[point as usize]);
        let tree = PieceTree::new(self.facets.iter().map(corners).collect());
        Ok(SignedDistance {
            tree,
            threshold: self.enclosed().map_or(0.5, |enclosed| 0.5_f64.copysign(enclosed)),
        })
    }
}

impl<const D: usize> SignedDistance<D> {
    /// The distance of a point \[length\], negative inside.
    #[inline(never)]
    pub fn at(&self, x: &[f64; D]) -> f64 {
        let distance = self.tree.distance(x);
        if self.tree.winding(x) > self.threshold { -distance } else { distance }
    }
}
