//! The inner product of changes of φ: what makes a derivative, which is a functional, a function.

use crate::assemble::{Assembler, BlockPattern, Parts};
use crate::constraints::Constraints;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::forms;
use crate::linear_algebra::BlockMatrix;
use crate::shape_optimisation::ShapeOptimisationError;
use crate::solve::{Elimination, TangentSolver, solve_linear};

/// The inner product as a form.
#[forms(crate = crate)]
pub mod level_set_product {
    /// Weight of the gradients.
    pub struct Data {
        /// α² \[length²\].
        pub square: Param,
    }
    /// The background.
    #[cells]
    pub struct Omega;

    /// ∫ w v + α² ∇w·∇v.
    pub fn product(w: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, w * v + square * dot(grad(w), grad(v)))
    }
}

/// The matrix of the inner product, with its factors.
pub(super) struct ChangeProduct<const D: usize> {
    matrix: BlockMatrix,
    elimination: Elimination,
    solver: TangentSolver,
}

impl<const D: usize> ChangeProduct<D>
where
    Dim: Dimension<D>,
{
    /// The product with the length α, and zero where changes are held.
    ///
    /// # Errors
    /// Data that do not fit, or constraints that contradict each other.
    pub fn new(smoothing: f64, held: &Constraints<D>) -> Result<Self, ShapeOptimisationError> {
        let space = held.space();
        let data = level_set_product::data().square(smoothing * smoothing);
        let form = level_set_product::Model::new(data).product();
        let pattern = BlockPattern::for_form(&form, &[space], &[space])?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        let assembler = Assembler::new(space.mesh());
        let zero = Field::zero(space);
        assembler.add_tangent(&form, &[&zero], &[space], Parts::ALL, &pattern, &mut matrix)?;
        let (elimination, solver) = (Elimination::of(&[held])?, TangentSolver::default());
        Ok(ChangeProduct { matrix, elimination, solver })
    }

    /// The change w with ⟨w, v⟩ = g\[v\] for all v.
    ///
    /// # Errors
    /// A singular matrix, or sizes that disagree.
    pub fn represent(&mut self, functional: &[f64]) -> Result<Vec<f64>, ShapeOptimisationError> {
        Ok(solve_linear(&self.matrix, functional, &mut self.elimination, &mut self.solver)?.solution)
    }
}
