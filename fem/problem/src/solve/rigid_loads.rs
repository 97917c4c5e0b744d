//! Forces and couples on rigid surfaces whose motion is unknown.

use std::sync::Arc;

use thiserror::Error;

use crate::constraints::RigidMap;
use crate::instantiate::instantiate;
use crate::mesh::small_matrices::inverse;
use crate::mesh::{CarriedSurface, Mesh};
use crate::space::Space;

/// Given forces and couples on rigid surfaces, as a linear functional of the displacements of the cells that carry them: for a problem in
/// which [`Constraints::rigid_body`](crate::constraints::Constraints::rigid_body) leaves their motion unknown. The form knows nothing of
/// them. At the solution contact holds what is given here.
#[derive(Clone, Debug)]
pub struct RigidLoads<const D: usize> {
    pub(super) space: Arc<Space<D>>,
    /// By the cell that carries: unknowns and forces on them.
    pub(super) entries: Vec<(u32, Vec<(usize, f64)>)>,
}

/// A load that cannot be given.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum RigidLoadError {
    /// No such rigid surface.
    #[error("there is no rigid surface \"{name}\"; the mesh has {}", listed(existing))]
    Unknown { name: String, existing: Vec<String> },
    /// A space without displacements on cells.
    #[error("loads on \"{name}\" need a space on cells with {expected} components of degree 1 or more")]
    Space {
        name: String,
        /// D.
        expected: usize,
    },
    /// A number that is NaN or infinite.
    #[error("{what} on \"{name}\" is not finite: {value:?}")]
    NotFinite {
        name: String,
        /// "the force", "the point", "the couple".
        what: &'static str,
        value: Vec<f64>,
    },
    /// A couple with another number of components than there are rotations.
    #[error("the couple on \"{name}\" has {found} components; there are {expected} rotations")]
    Couple {
        name: String,
        found: usize,
        /// One in the plane, three in space.
        expected: usize,
    },
    /// A motion that has no inverse.
    #[error("the motion of \"{name}\" is none of a rigid body")]
    Motion { name: String },
}

fn listed(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", "),
    }
}

impl<const D: usize> RigidLoads<D> {
    /// No loads yet, on displacements of a space.
    pub fn new(space: &Arc<Space<D>>) -> Self {
        RigidLoads { space: Arc::clone(space), entries: vec![] }
    }

    fn carrier(&self, name: &str) -> Result<&CarriedSurface<D>, RigidLoadError> {
        let mesh: &Mesh<D> = self.space.mesh();
        let found = mesh.rigid_surface(name).ok_or_else(|| RigidLoadError::Unknown {
            name: name.to_owned(),
            existing: mesh.rigid_surface_names().map(str::to_owned).collect(),
        })?;
        let on_cells = self.space.displaces() && self.space.degree() > 0;
        match on_cells && self.space.shape() == [D] {
            true => Ok(found),
            false => Err(RigidLoadError::Space { name: name.to_owned(), expected: D }),
        }
    }

    /// A force \[force; in the plane per depth\] at a point of the tool, which is where it was before it moved \[length\]; the point
    /// need not lie on the surface. It goes with the tool, and the force keeps its direction.
    ///
    /// # Errors
    /// [`RigidLoadError`].
    #[inline(never)]
    pub fn force(&mut self, name: &str, point: [f64; D], force: [f64; D]) -> Result<(), RigidLoadError> {
        for (what, value) in [("the point", &point), ("the force", &force)] {
            check_finite(name, what, value)?;
        }
        let carried = self.carrier(name)?;
        let reference = carried.reference_of(self.space.mesh(), &point);
        let cell = carried.cell;
        let tables = self.space.cell_element(cell as usize).tabulate(&[reference]);
        let nodes = self.space.cell_nodes(cell as usize).iter().zip(&tables.value);
        let entries =
            nodes.flat_map(|(node, phi)| (0..D).map(move |k| (*node as usize * D + k, phi * force[k])));
        let entries = entries.collect();
        self.entries.push((cell, entries));
        Ok(())
    }

    /// A couple \[force × length; in the plane per depth\]: one number in the plane, counter-clockwise, a vector along its axis in space.
    /// `motion` is where the tool is when it turns on: that of [`Constraints::rigid_body_from`](crate::constraints::Constraints::rigid_body_from).
    ///
    /// # Errors
    /// [`RigidLoadError`].
    #[inline(never)]
    pub fn couple(&mut self, name: &str, couple: &[f64], motion: &RigidMap<D>) -> Result<(), RigidLoadError> {
        check_finite(name, "the couple", couple)?;
        let (found, expected) = (couple.len(), D * (D - 1) / 2);
        if found != expected {
            return Err(RigidLoadError::Couple { name: name.to_owned(), found, expected });
        }
        let carried = self.carrier(name)?;
        let turned = inverse(&motion.rotation).filter(|_| motion.is_motion());
        let turned = turned.ok_or_else(|| RigidLoadError::Motion { name: name.to_owned() })?;
        let (mesh, cell) = (self.space.mesh(), carried.cell);
        let element = self.space.cell_element(cell as usize);
        let middle = mesh.cell_shape(cell as usize).centre();
        let tables = element.tabulate(&[middle]);
        let Some(slopes) = inverse(&mesh.map(cell as usize, &middle).1) else {
            return Err(RigidLoadError::Motion { name: name.to_owned() });
        };
        // M·ω with the angular velocity ω = ½ curl v: ½ M·(∇φ × e_k), ∇ where the tool is.
        let mut entries = Vec::new();
        for (node, slope) in self.space.cell_nodes(cell as usize).iter().zip(&tables.gradient) {
            let before: [f64; D] = std::array::from_fn(|i| (0..D).map(|j| slopes[j][i] * slope[j]).sum());
            let now: [f64; D] = std::array::from_fn(|i| (0..D).map(|j| turned[j][i] * before[j]).sum());
            for k in 0..D {
                entries.push((*node as usize * D + k, 0.5 * turning(couple, &now, k)));
            }
        }
        self.entries.push((cell, entries));
        Ok(())
    }
}

/// M·(∇φ × e_k).
fn turning<const D: usize>(couple: &[f64], slope: &[f64; D], k: usize) -> f64 {
    if D == 2 {
        return couple[0] * if k == 0 { -slope[1] } else { slope[0] };
    }
    let (next, last) = ((k + 1) % D, (k + 2) % D);
    couple[next] * slope[last] - couple[last] * slope[next]
}

fn check_finite(name: &str, what: &'static str, value: &[f64]) -> Result<(), RigidLoadError> {
    match value.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => Err(RigidLoadError::NotFinite { name: name.to_owned(), what, value: value.to_vec() }),
    }
}

instantiate!(rigid_loads: RigidLoads::<D>::force, RigidLoads::<D>::couple);
