//! Sparse matrices and linear solvers.
//!
//! [`BlockMatrix`] is what assembly writes: blocks of node pairs on a shared [`BlockSparsity`]. [`CsrMatrix`] is
//! what solvers read: values on a shared [`SparsityPattern`]; a [`Restriction`] takes the free rows and columns out
//! of either. [`Analysis`] orders a symmetric pattern once, [`SymmetricFactor`] is a
//! Cholesky factor on it, with signs where the matrix is a saddle point, or a Bunch–Kaufman factor; [`UnpivotedLu`] is a factor of an
//! unsymmetric matrix on the same analysis, [`LuFactor`] one with partial pivoting of any square matrix, and [`gmres()`] solves what is nearly symmetric. [`cg()`] and [`minres()`] solve with any [`LinearOperator`] and
//! [`Preconditioner`]; [`Multigrid`] is the one for large systems in 3D.

mod ahead;
pub mod analysis;
mod asymmetry;
pub mod back_substitution;
#[doc(hidden)]
pub mod backward_error;
pub mod block_elimination;
mod block_graph;
pub mod block_matrix;
pub mod block_product;
pub mod block_sparsity;
mod cell_blocks;
pub mod cells;
pub mod cg;
pub mod cholesky;
pub mod condensation;
pub mod condition;
pub mod csr;
pub mod determinant;
mod dissection;
pub mod eigenpairs;
mod elimination;
#[doc(hidden)]
pub mod equations;
#[doc(hidden)]
pub mod equilibration;
pub mod error;
pub mod gmres;
pub mod krylov;
#[doc(hidden)]
pub mod large_pages;
pub mod lu;
pub mod minres;
pub mod multigrid;
pub mod operator;
pub mod ordering;
pub mod partial_solves;
pub mod pattern;
mod residual_history;
pub mod restriction;
pub mod rigid_motions;
#[doc(hidden)]
pub mod singularity;
#[doc(hidden)]
pub mod small_inverse;
pub mod spectrum;
pub mod symbolic;
pub mod symmetric_eigen;
mod task_graph;
pub mod threads;
pub mod transpose;
pub mod vector;
mod wide_registers;

pub use analysis::Analysis;
pub use back_substitution::PartialBackSubstitution;
pub use backward_error::check_residual;
pub use block_elimination::{BlockElimination, Counts, Eliminated, Groups, MultiplierNode};
pub use block_matrix::BlockMatrix;
pub use block_sparsity::{BlockRows, BlockSparsity, NodeSet};
pub use cells::Cells;
pub use cg::cg;
pub use cholesky::{Refined, Remainder, SymmetricFactor, UnpivotedLu};
pub use condensation::{Condensation, CondensedSide, DenseFactor};
pub use condition::{ConditionEstimate, condition_estimate};
pub use csr::{CsrMatrix, Entry};
pub use determinant::{Sign, determinant_sign};
pub use eigenpairs::{EigenError, Eigenpair, Positive, SymmetricPencil};
pub use error::LinearAlgebraError;
pub use gmres::{GmresError, GmresOptions, GmresReport, gmres};
pub use krylov::{KrylovError, KrylovOptions, KrylovReport};
pub use lu::LuFactor;
pub use minres::minres;
pub use multigrid::{Multigrid, MultigridOptions};
pub use operator::{Entries, Identity, Jacobi, LinearOperator, OnThreads, OperatorError, Preconditioner};
pub use ordering::{Candidate, Chosen, Ordering};
pub use pattern::SparsityPattern;
pub use residual_history::ResidualHistory;
pub use restriction::{Restriction, WeightedRestriction, Weights};
pub use rigid_motions::{free_motions, free_motions_of_body, rigid_motions};
pub use spectrum::{Spectrum, spectrum};
pub use symbolic::Fill;
pub use symmetric_eigen::SymmetricEigen;
pub use task_graph::SharedWork;
pub use transpose::Transpose;
