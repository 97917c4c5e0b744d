//! The gradient of the criterion by the shape: the volume form of the whole discrete problem (14) with an adjoint state.
//! With p of (21) it is the exact derivative of J_h by the positions of the mesh's nodes, as long as no quadrature point
//! changes the sign of β_h. The compiler derives it.

use forms_fem::contract::FieldValue;
use forms_fem::movement::{MovementError, diameters_to_movements};
use forms_fem::prelude::*;
use forms_fem::space::SpaceError;
use thiserror::Error;

use crate::contact_problem::ContactProblem;
use crate::law::WithShapeGradient;

/// The convention for h_T in γ = γ₀ / h_T while the shape moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Diameters {
    /// h_T stays as it was: γ is a number per cell.
    Frozen,
    /// The diameter of the moved cell.
    Moving,
}

/// A function of position, here ∇u_D: entry \[i\]\[j\] is ∂u_D,i/∂x_j.
pub type ImposedSlope<'a, const D: usize> = &'a dyn Fn(&[f64; D]) -> [[f64; D]; D];

/// DJ as a vector: the contribution of each component of each node's movement.
#[derive(Clone, Debug)]
pub struct ShapeGradient<const D: usize> {
    /// The movements Θ that it takes: the space of the mesh's geometry.
    pub movements: Arc<Space<D>>,
    /// One number per unknown of `movements` \[criterion/length\].
    pub values: Vec<f64>,
}

/// Errors of shape gradients.
#[derive(Debug, Error)]
pub enum ShapeError {
    /// Data that do not fit; a function of position without its gradient, by name.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// No space of movements.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// Movements that do not fit.
    #[error(transparent)]
    Movement(#[from] MovementError),
    /// The movement is in another space than the gradient.
    #[error("the movement has {found} coefficients, the gradient {expected}: it lives on another space")]
    Length {
        /// Entries of the gradient.
        expected: usize,
        /// Coefficients of the movement.
        found: usize,
    },
    /// ∇u_D is not finite.
    #[error("the gradient of the imposed displacement is not finite at {position:?}")]
    Slope {
        /// Position \[length\].
        position: Vec<f64>,
    },
}

impl<const D: usize> ShapeGradient<D> {
    /// DJ\[Θ\].
    ///
    /// # Errors
    /// [`ShapeError::Length`] for a movement on another space.
    pub fn along(&self, movement: &Field<D>) -> Result<f64, ShapeError> {
        let (expected, found) = (self.values.len(), movement.values().len());
        if !movement.space().mesh().is_same(self.movements.mesh()) || expected != found {
            return Err(ShapeError::Length { expected, found });
        }
        Ok(self.values.iter().zip(movement.values()).map(|(gradient, by)| gradient * by).sum())
    }
}

impl<const D: usize, L: WithShapeGradient<D>> ContactProblem<D, L> {
    /// The volume form of the shape derivative at a displacement u and an adjoint state p that vanishes on Γ_D. Data are
    /// fixed in space: functions of position need their gradients (`Given::function_with_gradient`). If u_D depends on
    /// x, its nodal values change by ∇u_D Θ where Γ_D moves, and `imposed` says how; without it they are kept.
    ///
    /// # Errors
    /// [`ShapeError`] names what does not fit.
    pub fn shape_gradient(
        &self,
        u: &Field<D>,
        p: &Field<D>,
        diameters: Diameters,
        imposed: Option<ImposedSlope<D>>,
    ) -> Result<ShapeGradient<D>, ShapeError> {
        let assembler = &self.assembler_at(u)?;
        let movements = Space::of_geometry(assembler.mesh())?;
        let mut values = assembler.linear_form(&self.law.shape_gradient(u, p), &movements)?;
        if diameters == Diameters::Moving {
            let cells = Space::discontinuous_scalar(assembler.mesh(), 0)?;
            let per_cell = assembler.linear_form(&self.law.diameter_gradient(u, p), &cells)?;
            add(&mut values, &diameters_to_movements(&movements, &per_cell)?);
        }
        if let Some(slope) = imposed {
            add(&mut values, &self.through_imposed_displacement(u, p, slope, &movements)?);
        }
        Ok(ShapeGradient { movements, values })
    }

    /// (J′(u) + R′(u)ᵀ p) on the rows of Γ_D, times the rate ∇u_D Θ of the values imposed there.
    fn through_imposed_displacement(
        &self,
        u: &Field<D>,
        p: &Field<D>,
        slope: ImposedSlope<D>,
        movements: &Arc<Space<D>>,
    ) -> Result<Vec<f64>, ShapeError> {
        let reaction = self.assembler_at(u)?.residual(&self.law.adjoint(u), &[p], &[&self.space])?;
        let mut by_axis = vec![vec![0.0; self.space.node_count()]; D];
        for &unknown in self.constraints.prescribed().keys() {
            let (node, component) = (unknown / D, unknown % D);
            let position = &self.space.positions()[node];
            let slope = slope(position);
            let mut components = vec![0.0; D * D];
            slope.write(&mut components);
            if !components.iter().all(|entry| entry.is_finite()) {
                return Err(ShapeError::Slope { position: position.to_vec() });
            }
            for (axis, sums) in by_axis.iter_mut().enumerate() {
                sums[node] += reaction[unknown] * slope[component][axis];
            }
        }
        // How far each node of V^h moves with the nodes of the geometry.
        let embedding = self.space.embedding(movements)?;
        let mut values = vec![0.0; movements.unknowns()];
        for (axis, sums) in by_axis.iter().enumerate() {
            let shares = embedding
                .multiply_transposed(sums)
                .map_err(|source| AssemblyError::LinearAlgebra { form: "adjoint", source })?;
            for (node, share) in shares.into_iter().enumerate() {
                values[node * D + axis] += share;
            }
        }
        Ok(values)
    }
}

fn add(sum: &mut [f64], other: &[f64]) {
    sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += other);
}
