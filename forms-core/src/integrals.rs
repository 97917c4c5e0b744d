//! Integrals of a compiled function, and the backend that takes their kernels.

use crate::adaptation::Adaptation;
use crate::form::{Constants, FieldDescription, Integral};
use crate::kernel::{BilinearKernel, ExpressionKernel, LinearKernel};

/// A backend, given by its types for the kernels of compiled functions in a dimension.
pub trait Backend<const D: usize>: Sized + 'static {
    /// The kernel of an integral that is linear in a test function.
    type Linear: Send + Sync + 'static;
    /// The kernel of an integral that is linear in a test and in a trial function.
    type Bilinear: Send + Sync + 'static;
    /// The kernel of a density, a derived field, or switches.
    type Expression: Send + Sync + 'static;

    /// Takes a kernel that is linear in a test function.
    fn linear<K: LinearKernel<D>>(kernel: K) -> Self::Linear;
    /// Takes a kernel that is linear in a test and in a trial function.
    fn bilinear<K: BilinearKernel<D>>(kernel: K) -> Self::Bilinear;
    /// Takes a kernel without test function.
    fn expression<K: ExpressionKernel<D>>(kernel: K) -> Self::Expression;
}

/// A backend whose kernels can be terms of sums. Without it values can neither be added nor scaled.
pub trait CombiningBackend<const D: usize>: Backend<D> {
    /// A linear kernel with a factor, which reads fields with other numbers.
    fn adapt_linear(kernel: &Self::Linear, adaptation: Adaptation) -> Self::Linear;
    /// The same of a bilinear kernel.
    fn adapt_bilinear(kernel: &Self::Bilinear, adaptation: Adaptation) -> Self::Bilinear;
    /// The same of a kernel without test function.
    fn adapt_expression(kernel: &Self::Expression, adaptation: Adaptation) -> Self::Expression;
}

/// One integral of a function: its description, and its kernel as the backend keeps it.
#[derive(Clone, Debug)]
pub struct Term<K> {
    /// Region, test and trial function, dependence, degree.
    pub integral: &'static Integral,
    /// The kernel.
    pub kernel: K,
}

/// The integrals of one compiled function in one dimension, with their kernels. `#[forms]` implements it; users meet values that
/// hold them, as [`Form`](crate::function::Form). What a function does not have is an empty list.
pub trait Integrals<const D: usize>: 'static {
    /// The fields, by index.
    fn fields() -> &'static [FieldDescription];
    /// Shape of the value of a derived field.
    fn shape() -> &'static [usize] {
        &[]
    }
    /// The residual, one term per region and dependence.
    fn residual<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// One term for all of a region, where several depend on the unknowns.
    fn joined_residual<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// The tangent, one term per region and dependence.
    fn tangent<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Bilinear>> {
        vec![]
    }
    /// The tangent, one term for all of a region, where the residual is joined. Only element kernels compile it.
    fn joined_tangent<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Bilinear>> {
        vec![]
    }
    /// The tangent applied to a direction.
    fn action<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// Integrands times the first component of what displaces their points, whose derivative along that motion completes the residual.
    fn motion<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// The means over own facets that other integrals read, times the functions with [`Role::MeanTest`](crate::form::Role::MeanTest).
    fn means<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Linear>> {
        vec![]
    }
    /// The derivatives of the means by the unknowns.
    fn means_by_unknowns<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Bilinear>> {
        vec![]
    }
    /// The derivatives of the residual by the means that it reads: their trial function is 1.
    fn residual_by_means<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Bilinear>> {
        vec![]
    }
    /// The switches of integrals that have kinks.
    fn switches<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Expression>> {
        vec![]
    }
    /// The densities of a functional, or the value of a derived field, whose region has no meaning.
    fn density<B: Backend<D>>(_: Constants<'_>) -> Vec<Term<B::Expression>> {
        vec![]
    }
}
