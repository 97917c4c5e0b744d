//! Reactions: the forces by which constraints hold a body.

use std::sync::Arc;

use forms_core::contract::Form;
use thiserror::Error;

use super::{FormProblem, MixedSolved, NonlinearProblem, Solved};
use crate::assemble::AssemblyError;
use crate::field::Field;
use crate::mesh::MeshError;
use crate::space::Space;

/// A reaction that does not exist.
#[derive(Debug, Error)]
pub enum ReactionError {
    /// No such region.
    #[error(transparent)]
    Region(#[from] MeshError),
    /// No such unknown.
    #[error("there is no unknown {number}; the problem has {count} (numbered from 0)")]
    Unknown {
        /// The number asked for.
        number: usize,
        /// Their number.
        count: usize,
    },
    /// The residual of the field.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}

/// The sum of a space's part of a residual over the nodes of a region, one number per component.
fn resultant<const D: usize>(
    space: &Arc<Space<D>>,
    residual: &[f64],
    region: &str,
) -> Result<Vec<f64>, ReactionError> {
    let components = space.components();
    let mut sums = vec![0.0; components];
    for node in space.nodes_on(region)? {
        let at_node = &residual[node as usize * components..][..components];
        sums.iter_mut().zip(at_node).for_each(|(sum, value)| *sum += value);
    }
    Ok(sums)
}

impl<const D: usize> Solved<D> {
    /// The resultant of the forces by which the constraints hold the nodes of a facet or cell region, one number per
    /// component \[the form's residual: force, or force per depth in the plane; of a scalar unknown, flux\]: ΣR(u) over these
    /// nodes. Where values are prescribed these are the supports' forces on the body; where unknowns are related, as by
    /// sliding, periodic conditions or a rigid body, they are the forces that keep the relations. The load
    /// on free nodes is balanced there, and contact that stands in the form is no constraint: neither counts.
    ///
    /// A node on the edge of two regions counts in both: over the whole boundary the forces of supports balance the loads.
    ///
    /// # Errors
    /// [`ReactionError::Region`].
    pub fn reaction(&self, region: &str) -> Result<Vec<f64>, ReactionError> {
        resultant(self.field.space(), &self.residual, region)
    }
}

impl<const D: usize, const N: usize> MixedSolved<D, N> {
    /// The resultant of the forces by which the constraints of an unknown hold the nodes of a region; see
    /// [`Solved::reaction`].
    ///
    /// # Errors
    /// [`ReactionError::Region`], [`ReactionError::Unknown`].
    pub fn reaction(&self, unknown: usize, region: &str) -> Result<Vec<f64>, ReactionError> {
        let field = self.fields.get(unknown).ok_or(ReactionError::Unknown { number: unknown, count: N })?;
        let offset = self.fields[..unknown].iter().map(|field| field.values().len()).sum();
        resultant(field.space(), &self.residual[offset..], region)
    }
}

impl<F: Form<D>, const D: usize> FormProblem<'_, F, D> {
    /// The resultant of the forces by which constraints hold the nodes of a region at a solution that was found in any way, as
    /// by [`FormProblem::solve_affine`]; see [`Solved::reaction`].
    ///
    /// # Errors
    /// [`ReactionError::Region`], [`ReactionError::Assembly`] where the field does not fit.
    pub fn reaction(&mut self, solution: &Field<D>, region: &str) -> Result<Vec<f64>, ReactionError> {
        self.check_space(solution)?;
        let residual = self.residual(solution.values())?;
        resultant(solution.space(), &residual, region)
    }
}
