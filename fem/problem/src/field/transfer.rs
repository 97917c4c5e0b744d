//! Fields carried from one mesh to another: interpolation, L² projection, and the projection that keeps the integral.
//!
//! ```
//! use forms_fem::prelude::*;
//!
//! let triangles = rectangle([0.0; 2], [2.0, 1.0], [7, 5], CellShape::Triangle, 1)?;
//! let squares = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Quadrilateral, 1)?;
//! let u = Field::interpolate(&Space::scalar(&triangles, 2)?, |x| x[0] * x[1])?;
//! let space = Space::scalar(&squares, 2)?;
//!
//! let at_nodes = u.onto(&space).interpolated()?;
//! let nearest = u.onto(&space).projected()?;
//! let conserving = u.onto(&space).conserved()?;
//! for found in [at_nodes, nearest, conserving] {
//!     assert!((found.evaluate(&[1.3, 0.7])?[0] - 1.3 * 0.7).abs() < 1e-12);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod interpolation;
pub(crate) mod places;
mod projection;

use std::sync::Arc;

use thiserror::Error;

use crate::element::Elements;
use crate::space::Scope;

use super::{Field, FieldError};
use crate::assemble::AssemblyError;
use crate::space::{Space, SpaceError};
use crate::threads::Threads;

/// A field on its way to a space on any mesh of the same body.
///
/// Points of the target that lie outside the field's mesh, as between meshes of a curved body, take the polynomial of the
/// nearest cell, continued: it is of the order of the field, where the value at the nearest point is only of the order of the
/// distance. Results do not depend on the number of threads.
#[derive(Clone, Debug)]
pub struct Transfer<'a, const D: usize> {
    field: &'a Field<D>,
    space: &'a Arc<Space<D>>,
    reach: Option<f64>,
    threads: Threads,
}

/// Errors of carrying a field to another mesh.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum TransferError {
    /// One of the two spaces lives only on facets.
    #[error(
        "fields are carried between spaces on cells, but {which} lives on the facets of \"{region}\" alone"
    )]
    OnFacets {
        /// The field or the space.
        which: &'static str,
        region: String,
    },
    /// One of the two is not known from the reference cell in all cells.
    #[error("fields are not carried to or from spaces of {elements} {scope}, which {which} has")]
    Scope {
        /// The field or the space.
        which: &'static str,
        elements: Elements,
        scope: Scope,
    },
    /// Values of different lengths.
    #[error("the field has {field} components, but the space has {space}")]
    Components {
        /// Components of the field.
        field: usize,
        /// Components of the space.
        space: usize,
    },
    /// A distance that is none.
    #[error("points outside are to be looked for within {distance}, which is no distance")]
    Distance {
        /// The distance given.
        distance: f64,
    },
    /// A point of the target that is too far from the field's mesh.
    #[error("the point {point:?} is further than {reach:e} from the mesh that the field lives on")]
    Outside {
        /// The point: a node of the target, or a quadrature point of its mesh.
        point: Vec<f64>,
        /// The distance up to which points are accepted \[length\].
        reach: f64,
    },
    /// A value that is not finite.
    #[error("the field's value at the point {point:?} is not finite")]
    NotFinite { point: Vec<f64> },
    /// Spaces that are too large.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// Values on the field's own mesh that are not finite.
    #[error(transparent)]
    Values(#[from] FieldError),
    /// A projection that cannot be computed.
    #[error(transparent)]
    Projection(#[from] AssemblyError),
}

impl<const D: usize> Field<D> {
    /// This field on its way to a space on another mesh of the same body, or on its own.
    pub fn onto<'a>(&'a self, space: &'a Arc<Space<D>>) -> Transfer<'a, D> {
        Transfer { field: self, space, reach: None, threads: Threads::all() }
    }
}

impl<const D: usize> Transfer<'_, D> {
    /// Largest distance \[length\] of a target's point from the field's mesh; by default a tenth of the diameter of its
    /// largest cell where nothing is said.
    pub fn within(mut self, distance: f64) -> Self {
        self.reach = Some(distance);
        self
    }

    /// Number of threads.
    pub fn with_threads(mut self, threads: Threads) -> Self {
        self.threads = threads;
        self
    }

    /// The distance up to which points outside are accepted \[length\].
    ///
    /// # Errors
    /// Spaces that do not fit, or a distance that is none.
    fn checked_reach(&self) -> Result<f64, TransferError> {
        for (which, space) in [("the field", self.field.space()), ("the space", self.space)] {
            if let Some(region) = space.facet_region() {
                return Err(TransferError::OnFacets { which, region: region.to_owned() });
            }
            if !space.is_on_all_cells() {
                let (elements, scope) = (space.elements().clone(), space.scope().clone());
                return Err(TransferError::Scope { which, elements, scope });
            }
        }
        let (field, space) = (self.field.space().components(), self.space.components());
        if field != space {
            return Err(TransferError::Components { field, space });
        }
        match self.reach {
            Some(distance) if distance.is_nan() || distance < 0.0 => {
                Err(TransferError::Distance { distance })
            }
            Some(distance) => Ok(distance),
            None => Ok(places::usual_reach(self.field.space().mesh())),
        }
    }
}
