//! Inner products of movements: what makes a derivative, which is a functional, a movement of the whole body.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::error::ShapeOptimisationError;
use crate::assemble::{Assembler, BlockPattern, Parts};
use crate::constraints::Constraints;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::forms;
use crate::linear_algebra::BlockMatrix;
use crate::mesh::BOUNDARY;
use crate::solve::{Elimination, TangentSolver, solve_linear};
use crate::space::Space;

/// The inner product as a form.
#[forms(crate = crate)]
pub mod movement_product {
    /// Weights of its parts.
    pub struct Data {
        /// Of the values.
        pub value: Param,
        /// Of the gradients.
        pub slope: Param,
        /// Of the shears and strains.
        pub shear: Param,
        /// Of the dilations.
        pub dilation: Param,
        /// Of the gradients along the boundary.
        pub tangential: Param,
    }
    /// The body.
    #[cells]
    pub struct Omega;
    /// The boundary of the body.
    #[facets]
    pub struct Boundary;

    /// ∇_Γ w: the gradient along the boundary.
    fn along_boundary(w: Vector) -> Tensor {
        grad(w) - outer(grad(w) * n, n)
    }

    /// ∫ value G·Θ + slope ∇G:∇Θ + 2 shear ε(G):ε(Θ) + dilation div G div Θ + ∫_∂Ω tangential ∇_Γ G:∇_Γ Θ.
    pub fn product(G: Unknown<Vector>, Theta: Test<Vector>) -> Form {
        integral(
            Omega,
            value * dot(G, Theta)
                + slope * inner(grad(G), grad(Theta))
                + 2 * shear * inner(eps(G), eps(Theta))
                + dilation * div(G) * div(Theta),
        ) + integral(Boundary, tangential * inner(along_boundary(G), along_boundary(Theta)))
    }
}

/// ∫ value G·Θ + slope ∇G:∇Θ + 2 shear ε(G):ε(Θ) + dilation div G div Θ over the body, and ∫ tangential ∇_Γ G:∇_Γ Θ over its
/// boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InnerProduct {
    /// Weight of the values \[1/length²\], compared with the others.
    pub value: f64,
    /// Weight of the gradients.
    pub slope: f64,
    /// Weight of the shears and strains: a shear modulus.
    pub shear: f64,
    /// Weight of the dilations: Lamé's first parameter.
    pub dilation: f64,
    /// Weight of the gradients along the boundary \[length\], compared with the others: waves that are shorter than this move less.
    pub tangential: f64,
}

impl InnerProduct {
    /// H¹: ∇G:∇Θ + G·Θ/ℓ². Movements of the boundary reach about ℓ into the body.
    pub fn h1(length: f64) -> Self {
        InnerProduct {
            value: 1.0 / (length * length),
            slope: 1.0,
            shear: 0.0,
            dilation: 0.0,
            tangential: 0.0,
        }
    }

    /// The inner product of an elastic body with Young's modulus 1 and a Poisson's ratio in (−1, 1/2): keeps cells in shape better.
    pub fn elasticity(poisson: f64) -> Self {
        let shear = 0.5 / (1.0 + poisson);
        let dilation = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        InnerProduct { value: 0.0, slope: 0.0, shear, dilation, tangential: 0.0 }
    }

    /// For each functional g the movement G with ⟨G, Θ⟩ = g\[Θ\] for all Θ that `held` admits: of all movements as long as
    /// G, g grows most along G.
    ///
    /// # Errors
    /// If nothing determines the movement, or sizes disagree.
    pub fn represent<const D: usize>(
        &self,
        held: &Constraints<D>,
        functionals: &[&[f64]],
    ) -> Result<Vec<Vec<f64>>, ShapeOptimisationError>
    where
        Dim: Dimension<D>,
    {
        let movements: &Arc<Space<D>> = held.space();
        let data = movement_product::data()
            .value(self.value)
            .slope(self.slope)
            .shear(self.shear)
            .dilation(self.dilation)
            .tangential(self.tangential);
        let form = movement_product::Model::new(data).product();
        let pattern = BlockPattern::for_form(&form, &[movements], &[movements])?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        let zero = Field::zero(movements);
        let assembler = Assembler::new(movements.mesh());
        assembler.add_tangent(&form, &[&zero], &[movements], Parts::ALL, &pattern, &mut matrix)?;
        let mut elimination = Elimination::of(&[held])?;
        let mut solver = TangentSolver::default();
        let solve = |functional: &&[f64]| {
            Ok(solve_linear(&matrix, functional, &mut elimination, &mut solver)?.solution)
        };
        functionals.iter().map(solve).collect()
    }

    /// The movement with the same values on the boundary and the least norm: of all movements that give the body this shape
    /// the one that takes its inside along most smoothly. What represents a functional, extended so, represents it among
    /// these: inner nodes do not go where the discretisation's error makes a criterion smaller.
    ///
    /// # Errors
    /// As [`InnerProduct::represent`].
    pub fn extend<const D: usize>(
        &self,
        movements: &Arc<Space<D>>,
        movement: &[f64],
    ) -> Result<Vec<f64>, ShapeOptimisationError>
    where
        Dim: Dimension<D>,
    {
        let mut held = Constraints::new(movements);
        for node in movements.nodes_on(BOUNDARY)? {
            for component in 0..D {
                let unknown = node as usize * D + component;
                held.fix_node(node as usize, component, movement.get(unknown).copied().unwrap_or(0.0))?;
            }
        }
        if held.prescribed().len() == movements.unknowns() {
            return Ok(movement.to_vec());
        }
        let nothing = vec![0.0; movements.unknowns()];
        Ok(self.represent(&held, &[&nothing])?.into_iter().flatten().collect())
    }
}
