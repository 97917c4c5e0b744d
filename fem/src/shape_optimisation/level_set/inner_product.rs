//! The inner product of changes of φ: what makes a derivative, which is a functional, a function.

use std::sync::Arc;

use super::options::LevelSetOptions;
use crate::assemble::{Assembler, BlockPattern, Parts};
use crate::constraints::Constraints;
use crate::cut::Cut;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::forms;
use crate::linear_algebra::BlockMatrix;
use crate::shape_optimisation::{Failure, ShapeOptimisationError};
use crate::solve::{Elimination, TangentSolver, solve_linear};

/// The inner product as forms.
#[forms(crate = crate)]
pub mod level_set_product {
    /// Weights of the gradients.
    pub struct Data {
        /// α² \[length²\].
        pub square: Param,
        /// α² ℓ, of the gradients along Γ \[length³\].
        pub along: Param,
    }
    /// The background.
    #[cells]
    pub struct Omega;
    /// Γ.
    #[interface]
    pub struct Gamma;

    /// ∫ w v + α² ∇w·∇v.
    pub fn product(w: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, w * v + square * dot(grad(w), grad(v)))
    }

    /// ∫_Γ α² ℓ ∇_Γ w·∇_Γ v.
    pub fn product_along_interface(w: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let normal_slopes = dot(grad(w), n) * dot(grad(v), n);
        integral(Gamma, along * (dot(grad(w), grad(v)) - normal_slopes))
    }
}

/// The inner product on one background, with its factors.
pub(super) struct ChangeProduct<const D: usize> {
    model: level_set_product::Model<D>,
    pattern: BlockPattern<D>,
    zero: Field<D>,
    /// Without the part on the interface.
    everywhere: BlockMatrix,
    /// On the present interface.
    matrix: BlockMatrix,
    elimination: Elimination,
    solver: TangentSolver,
}

impl<const D: usize> ChangeProduct<D>
where
    Dim: Dimension<D>,
{
    /// The product by the options' lengths α and ℓ, and zero where changes are held; without the part on an interface yet.
    ///
    /// # Errors
    /// Data that do not fit, or constraints that contradict each other.
    pub fn new(options: &LevelSetOptions, held: &Constraints<D>) -> Result<Self, ShapeOptimisationError> {
        let (space, square) = (held.space(), options.smoothing * options.smoothing);
        let data = level_set_product::data().square(square).along(square * options.interface_smoothing);
        let model = level_set_product::Model::new(data);
        let form = model.product();
        let pattern = BlockPattern::for_form(&form, &[space], &[space])?;
        let mut everywhere = BlockMatrix::zero(pattern.sparsity());
        let (assembler, zero) = (Assembler::new(space.mesh()), Field::zero(space));
        assembler.add_tangent(&form, &[&zero], &[space], Parts::ALL, &pattern, &mut everywhere)?;
        let (elimination, solver) = (Elimination::of(&[held])?, TangentSolver::default());
        let matrix = everywhere.clone();
        Ok(ChangeProduct { model, pattern, zero, everywhere, matrix, elimination, solver })
    }

    /// Change of the interface to that of a body.
    ///
    /// # Errors
    /// A body on another mesh.
    pub fn change_interface(&mut self, body: &Arc<Cut<D>>) -> Result<(), Failure> {
        if self.model.data.along == 0.0 {
            return Ok(());
        }
        self.matrix = self.everywhere.clone();
        let (form, space) = (self.model.product_along_interface(), self.zero.space());
        let assembler = Assembler::new(space.mesh()).with_cut(body)?;
        let (unknowns, tests) = ([&self.zero], [space]);
        assembler.add_tangent(&form, &unknowns, &tests, Parts::ALL, &self.pattern, &mut self.matrix)?;
        Ok(())
    }

    /// The change w with ⟨w, v⟩ = g\[v\] for all v.
    ///
    /// # Errors
    /// A singular matrix, or sizes that disagree.
    pub fn represent(&mut self, functional: &[f64]) -> Result<Vec<f64>, ShapeOptimisationError> {
        Ok(solve_linear(&self.matrix, functional, &mut self.elimination, &mut self.solver)?.solution)
    }
}
