//! Linear operators and preconditioners, as Krylov methods see them.

use super::block_matrix::BlockMatrix;
use super::csr::CsrMatrix;
use super::equations::{Equations, Side, WorstRow};
use super::error::{LinearAlgebraError, check_size};
use crate::threads::Threads;

/// Errors of applying an operator or a preconditioner.
pub type OperatorError = Box<dyn std::error::Error + Send + Sync>;

/// A square linear operator: a matrix, or the action of a form's tangent without one.
pub trait LinearOperator {
    /// Number of unknowns.
    fn size(&self) -> usize;

    /// y = A x.
    ///
    /// # Errors
    /// Whatever prevents it, for example a vector of another size.
    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError>;

    /// The matrix, where the operator is one. Krylov methods then see to it that each equation holds relative to the sizes of
    /// its own terms; without entries they see the norm of the residual alone.
    fn entries(&self) -> Option<Entries<'_>> {
        None
    }
}

/// The matrix that a [`LinearOperator`] is.
#[derive(Clone, Copy, Debug)]
pub enum Entries<'a> {
    /// With an index per entry.
    Csr(&'a CsrMatrix),
    /// With an index per block.
    Block(&'a BlockMatrix),
    /// Not kept as one matrix, for example the sum of the matrices of cells.
    #[doc(hidden)]
    Sum(&'a dyn Equations),
}

impl Equations for Entries<'_> {
    fn residual(
        &self,
        threads: Threads,
        x: &[f64],
        b: &[f64],
        rest: &mut Vec<f64>,
        room: &mut Vec<f64>,
    ) -> Result<WorstRow, LinearAlgebraError> {
        match self {
            Entries::Csr(matrix) => Side::plain(matrix).residual(threads, x, b, rest, room),
            Entries::Block(matrix) => matrix.residual(threads, x, b, rest, room),
            Entries::Sum(equations) => equations.residual(threads, x, b, rest, room),
        }
    }

    fn products(&self, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearAlgebraError> {
        match self {
            Entries::Csr(matrix) => Side::plain(matrix).products(x),
            Entries::Block(matrix) => matrix.products(x),
            Entries::Sum(equations) => equations.products(x),
        }
    }

    fn diagonal(&self) -> Vec<f64> {
        match self {
            Entries::Csr(matrix) => matrix.diagonal(),
            Entries::Block(matrix) => matrix.diagonal(),
            Entries::Sum(equations) => equations.diagonal(),
        }
    }
}

/// An approximation of the inverse of an operator.
pub trait Preconditioner {
    /// z ≈ A⁻¹ r. For CG and MINRES it must be linear, symmetric and positive definite.
    ///
    /// # Errors
    /// Whatever prevents it, for example a vector of another size.
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError>;
}

/// A matrix whose products run on some threads.
#[derive(Clone, Copy, Debug)]
pub struct OnThreads<'a, M>(pub &'a M, pub Threads);

impl LinearOperator for OnThreads<'_, BlockMatrix> {
    fn size(&self) -> usize {
        self.0.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError> {
        Ok(self.0.multiply_on(self.1, x, y)?)
    }

    fn entries(&self) -> Option<Entries<'_>> {
        Some(Entries::Block(self.0))
    }
}

impl LinearOperator for OnThreads<'_, CsrMatrix> {
    fn size(&self) -> usize {
        self.0.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError> {
        Ok(self.0.multiply_on(self.1, x, y)?)
    }

    fn entries(&self) -> Option<Entries<'_>> {
        Some(Entries::Csr(self.0))
    }
}

impl LinearOperator for BlockMatrix {
    fn size(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError> {
        OnThreads(self, Threads::ONE).apply(x, y)
    }

    fn entries(&self) -> Option<Entries<'_>> {
        Some(Entries::Block(self))
    }
}

impl LinearOperator for CsrMatrix {
    fn size(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError> {
        OnThreads(self, Threads::ONE).apply(x, y)
    }

    fn entries(&self) -> Option<Entries<'_>> {
        Some(Entries::Csr(self))
    }
}

/// No preconditioning.
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity;

impl Preconditioner for Identity {
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
        z.copy_from_slice(r);
        Ok(())
    }
}

/// The inverse of a matrix's diagonal, which is Jacobi's preconditioner.
#[derive(Clone, Debug, PartialEq)]
pub struct Jacobi(Vec<f64>);

impl Jacobi {
    /// The preconditioner of a matrix without a zero on its diagonal.
    ///
    /// # Errors
    /// A zero, or what is not finite, on the diagonal; the error names the unknown.
    pub fn of(matrix: &CsrMatrix) -> Result<Self, LinearAlgebraError> {
        Jacobi::of_diagonal(matrix.diagonal())
    }

    /// The preconditioner of a matrix with this diagonal.
    ///
    /// # Errors
    /// As [`Jacobi::of`].
    pub fn of_diagonal(diagonal: Vec<f64>) -> Result<Self, LinearAlgebraError> {
        match diagonal.iter().position(|entry| *entry == 0.0 || !entry.is_finite()) {
            Some(unknown) => Err(LinearAlgebraError::Singular { unknown, ratio: diagonal[unknown].abs() }),
            None => Ok(Jacobi(diagonal.into_iter().map(f64::recip).collect())),
        }
    }
}

impl Preconditioner for &Jacobi {
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), OperatorError> {
        check_size("the vector to precondition", self.0.len(), r.len())?;
        check_size("the preconditioned vector", r.len(), z.len())?;
        for ((z, r), inverse) in z.iter_mut().zip(r).zip(&self.0) {
            *z = inverse * r;
        }
        Ok(())
    }
}
