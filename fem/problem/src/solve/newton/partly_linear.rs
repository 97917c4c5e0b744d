//! Nonlinear problem with a linear part: R(u) = K u + N(u) + R₀, where N reads and touches few unknowns.

use super::NonlinearProblem;
use crate::assemble::AssemblyError;
use crate::linear_algebra::BlockMatrix;

/// A problem R(u) = K u + N(u) + R₀ with a linear part K and a nonlinear part N on few unknowns, as contact terms are.
pub trait PartlyLinear: NonlinearProblem {
    /// K, the part of every tangent that does not depend on u. None where it is not known, or where tangents differ from it
    /// everywhere; the other methods are then not called.
    ///
    /// # Errors
    /// If assembly fails.
    fn linear_part(&mut self) -> Result<Option<LinearPart<'_>>, AssemblyError>;

    /// N(u). It reads only the unknowns in whose rows or columns some tangent differs from the linear part.
    ///
    /// # Errors
    /// If assembly fails.
    fn nonlinear_residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError>;

    /// The derivative of N at u in a matrix of its own, where the positions of its entries follow the iterate. The tangent is the
    /// sum of K and this matrix. None where the positions are fixed: then [`Tangent::changed`](super::Tangent::changed) names
    /// the places where the tangent differs from K.
    ///
    /// # Errors
    /// If assembly fails.
    fn nonlinear_tangent(&mut self, u: &[f64]) -> Result<Option<NonlinearTangent<'_>>, AssemblyError>;
}

/// The linear part, lent by the problem that keeps it.
#[derive(Clone, Copy, Debug)]
pub struct LinearPart<'a> {
    /// All rows and columns.
    pub matrix: &'a BlockMatrix,
    /// Whether it is proved to be symmetric, except for rounding.
    pub is_symmetric: bool,
}

/// The tangent of the nonlinear part only, lent by the problem that keeps it.
#[derive(Clone, Copy, Debug)]
pub struct NonlinearTangent<'a> {
    /// All rows and columns.
    pub matrix: &'a BlockMatrix,
    /// The rows with entries, ascending.
    pub rows: &'a [usize],
    /// The unknowns that the nonlinear part reads at any iterate, ascending.
    pub reads: &'a [usize],
}
