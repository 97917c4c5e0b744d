//! Matrix or transposed matrix, as the argument of a solve.

/// A system with the matrix itself, or with its transposed one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transpose {
    /// A x = b.
    No,
    /// Aᵀ x = b.
    Yes,
}
