//! Sum factorisation: on quadrilaterals and hexahedra, sums over nodes or points run along one axis after the other.
//!
//! There a basis function is a product φ(ξ) = f_a(ξ₀) f_b(ξ₁) f_c(ξ₂), and the points of a Gauss rule are a grid. What a
//! sum over (k + 1)^D nodes costs at each of as many points, sums along the axes share. Fields at the points,
//! element vectors and the matrices of scalar forms are made so where counted operations say that it pays
//! (S. A. Orszag, Spectral methods for problems in complex geometries, J. Comput. Phys. 37, 1980).

mod contraction;
mod derivatives;
mod matrices;
mod moments;
mod product_tables;
mod vectors;

pub(in crate::assemble) use derivatives::{Derivatives, unit};
pub(in crate::assemble) use matrices::{MatrixStages, PairSums, matrix_operations};
pub(in crate::assemble) use moments::Moments;
pub(in crate::assemble) use product_tables::ProductTables;
pub(in crate::assemble) use vectors::{Integration, Interpolation, Stages, axis_operations};
