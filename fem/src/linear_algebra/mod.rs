//! Sparse matrices and linear solvers.
