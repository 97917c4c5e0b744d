//! Nonlinear problem: what Newton's method needs to know, and what it can gain from.

use std::rc::Rc;

use super::{ActivePoints, FieldUnknowns, PartlyLinear, Products, Tangent};
use crate::assemble::{AssemblyError, Terms};
use crate::solve::DividedVectors;

/// A system R(u) = 0 with a (generalised) derivative. Vectors and matrices have all unknowns, the prescribed
/// ones included. Residual and tangent are required; the rest has defaults. A problem that is not assembled from a form
/// reports its errors by [`AssemblyError::other`].
pub trait NonlinearProblem {
    /// R(u), one entry per unknown.
    ///
    /// # Errors
    /// If assembly fails.
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError>;

    /// An element of the generalised derivative of R at u.
    ///
    /// # Errors
    /// If assembly fails.
    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError>;

    /// The fields of the unknowns, one after the other. What is left over is one more field, and all unknowns are one field of one
    /// component if none is named. Each component is judged by its own size.
    fn fields(&self) -> Vec<FieldUnknowns> {
        vec![]
    }

    /// The division of vectors over all unknowns among processes, if there is one. Norms and judgements are then those of all processes.
    fn divided(&self) -> Option<Rc<dyn DividedVectors>> {
        None
    }

    /// The quadrature points that are active at u, if the problem has such a notion: where a switch of a piecewise law is
    /// on.
    ///
    /// # Errors
    /// If assembly fails.
    fn active_points(&mut self, _u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        Ok(None)
    }

    /// The largest part of a step δ, at most 1, that may be taken from u. Beyond it, quantities that have to stay positive would not, as the
    /// volume of a cell or the gap under a barrier. It is asked once per Newton step, before the line search.
    ///
    /// # Errors
    /// If assembly fails, or no part of the step may be taken.
    fn largest_step(&mut self, _u: &[f64], _step: &[f64]) -> Result<f64, AssemblyError> {
        Ok(1.0)
    }

    /// K x, and Σ_j |K_ij x_j| of each row, with a tangent K at u or at an iterate near it: the forces that balance where unknown j
    /// is of the size x_j \[unit of R\]. Rounding of R is a small multiple of those of u. Where several processes have parts of the
    /// tangent, they are the sums over all of them.
    ///
    /// # Errors
    /// If assembly fails.
    fn products(&mut self, u: &[f64], x: &[f64]) -> Result<Products, AssemblyError> {
        Ok(self.tangent(u)?.products(x))
    }

    /// The size of the terms that are summed in each entry of R(u) \[unit of R\], if the problem knows it. They may be large
    /// where u is zero, as the stresses of a body that was deformed permanently.
    ///
    /// # Errors
    /// If assembly fails.
    fn sizes_of_terms(&mut self, _u: &[f64], _terms: Terms) -> Result<Option<Vec<f64>>, AssemblyError> {
        Ok(None)
    }

    /// The factor of a Newton step at u, as deflation of known solutions has one. A line search then shortens the step that is left.
    fn factor_of_step(&mut self, _u: &[f64], _step: &[f64]) -> f64 {
        1.0
    }

    /// The problem as a sum of a linear and a nonlinear part, if it can be taken apart. A [`CondensedSolver`](crate::solve::CondensedSolver)
    /// then factors the linear part once, and iterates on the unknowns that the nonlinear part touches.
    fn partly_linear(&mut self) -> Option<&mut dyn PartlyLinear> {
        None
    }
}
