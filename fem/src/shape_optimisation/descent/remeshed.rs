//! New meshes on the way of a descent: the cells that its steps move, and when they make place for others.

use super::{Descent, Shape, coordinates};
use crate::dimension::{Dim, Dimension};
use crate::mesh::Mesh;
use crate::shape_optimisation::error::{Failure, ShapeOptimisationError};
use crate::shape_optimisation::history::{DescentState, Remeshed};
use crate::shape_optimisation::problem::ShapeProblem;
use crate::shape_optimisation::rotations::Rotations;
use crate::shape_optimisation::stored_mesh::StoredMesh;
use crate::space::Space;

/// Factors of the sizes of cells that are tried one after the other.
const FINER: [f64; 3] = [1.0, 0.75, 0.5];

/// A maker of new meshes for the present shape: the mesh, and a factor for the sizes of its cells.
pub type Remesher<'a, const D: usize> = dyn Fn(&Mesh<D>, f64) -> Result<Mesh<D>, Failure> + 'a;

/// New meshes on the way: how they are made, when, and how far they may change the values.
#[derive(Clone)]
pub struct Remesh<'a, const D: usize> {
    /// The maker.
    pub with: &'a Remesher<'a, D>,
    /// The least scaled Jacobian below which a new mesh is made, once smoothing has not helped.
    pub below: f64,
    /// The change of the criterion, relative to its value at the start, and that of the constraint, from the old mesh to the
    /// new one: where it is larger, finer cells are tried.
    pub tolerance: f64,
}

/// The mesh whose cells are moved, where its nodes were when it was made, with the pattern that its nodes have.
pub struct Base<const D: usize> {
    pub mesh: Mesh<D>,
    pub pattern: Option<Rotations<D>>,
}

impl<const D: usize> Base<D>
where
    Dim: Dimension<D>,
{
    /// The mesh of a state: that of the start, or one that was made since.
    ///
    /// # Errors
    /// Those of a stored mesh that cannot be made again.
    pub fn of(
        state: &DescentState,
        initial: &Mesh<D>,
        pattern: Option<&Rotations<D>>,
    ) -> Result<Self, ShapeOptimisationError> {
        match &state.mesh {
            None => Ok(Base { mesh: initial.clone(), pattern: pattern.cloned() }),
            Some(stored) => {
                let mesh = stored.mesh()?;
                let movements = Space::of_geometry(&mesh)?;
                let pattern = pattern.map(|pattern| pattern.on(&movements)).transpose()?;
                Ok(Base { mesh, pattern })
            }
        }
    }
}

impl<const D: usize> Remesh<'_, D> {
    /// New meshes of a shape, each finer than the one before, as a checkpoint would hold them.
    pub(super) fn meshes<'b>(
        &'b self,
        mesh: &'b Mesh<D>,
    ) -> impl Iterator<Item = Result<(StoredMesh, Mesh<D>), Failure>> + 'b {
        FINER.into_iter().map(move |factor| {
            let stored = StoredMesh::of(&(self.with)(mesh, factor)?)?;
            // From what is stored, so that one that was read has the same order of everything.
            let mesh = stored.mesh()?;
            Ok((stored, mesh))
        })
    }
}

impl<P: ShapeProblem<D>, const D: usize> Descent<'_, P, D>
where
    Dim: Dimension<D>,
{
    /// The shape on a new mesh, with the values on the one before; or why there is none.
    pub(super) fn remeshed(
        &self,
        remesh: &Remesh<D>,
        state: &mut DescentState,
        shape: &mut Shape<P::State, D>,
        base: &mut Base<D>,
    ) -> Result<Result<Remeshed, String>, ShapeOptimisationError> {
        let scale = state.history.first().map_or(shape.values.criterion, |row| row.criterion).abs();
        let mut why = String::new();
        let present = shape.mesh.clone();
        for made in remesh.meshes(&present) {
            let (stored, mesh) = match made {
                Ok(made) => made,
                Err(error) => {
                    why = error.to_string();
                    continue;
                }
            };
            let quality = mesh.quality().scaled_jacobian()[0];
            if quality <= 1.05 * shape.quality.max(self.options.least_quality) {
                why = format!("the new mesh has a least scaled Jacobian of {quality}");
                continue;
            }
            let values = match self.problem.solve(&mesh) {
                Ok(values) => values,
                Err(error) => {
                    why = format!("on the new mesh: {error}");
                    continue;
                }
            };
            let before = (shape.values.criterion, shape.values.constraint);
            let by = (values.criterion - before.0).abs() / scale;
            let off = (values.constraint.unwrap_or(0.0) - before.1.unwrap_or(0.0)).abs();
            // NaN is not within a tolerance.
            if !(by <= remesh.tolerance && off <= remesh.tolerance) {
                why = format!(
                    "on the new mesh the criterion differs by {by:e} of its first value, the constraint by {off:e}"
                );
                continue;
            }
            let remeshed = Remeshed {
                criterion: before.0,
                constraint: before.1,
                quality: shape.quality,
                cells: mesh.cell_count(),
            };
            *shape = Shape { mesh, values, quality };
            state.nodes = coordinates(&shape.mesh);
            state.mesh = Some(stored);
            *base = Base::of(state, &self.initial, self.pattern.as_ref())?;
            return Ok(Ok(remeshed));
        }
        Ok(Err(why))
    }
}
