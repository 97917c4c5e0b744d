//! The work of a direct solver, and its path.

use std::fmt;

use crate::linear_algebra::{Candidate, Counts, SharedWork};

/// The way in which a system was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverPath {
    /// By the factor of the linear part and a dense system on the unknowns that change.
    Condensed,
    /// By a Cholesky factor.
    Cholesky,
    /// By a Cholesky factor with signs of a symmetric saddle point, and refinement.
    SignedCholesky,
    /// By a Bunch–Kaufman factor of a symmetric matrix that is not positive definite.
    Indefinite,
    /// By GMRES with the factor of a symmetrised matrix.
    Gmres,
    /// By an LU factor.
    Lu,
}

impl fmt::Display for SolverPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SolverPath::Condensed => "condensed to the unknowns that change",
            SolverPath::Cholesky => "Cholesky",
            SolverPath::SignedCholesky => "Cholesky with signs",
            SolverPath::Indefinite => "Bunch–Kaufman",
            SolverPath::Gmres => "GMRES with the factor of the symmetrised tangent",
            SolverPath::Lu => "LU",
        })
    }
}

/// The work of a [`super::TangentSolver`] or a [`super::CondensedSolver`] since it was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverReport {
    /// Symbolic analyses.
    pub analyses: usize,
    /// Numeric factorisations that succeeded.
    pub factorisations: usize,
    /// Those of them that were LBLᵀ because the symmetric part was not positive definite.
    pub indefinite_factorisations: usize,
    /// Those of them that were Cholesky factors with signs, of symmetric saddle points.
    pub signed_factorisations: usize,
    /// LU factorisations: of saddle points that are not symmetric, and where the other factors failed.
    pub lu_factorisations: usize,
    /// Systems solved.
    pub solves: usize,
    /// GMRES iterations of each solve, in order; 0 for a direct one.
    pub iterations: Vec<usize>,
    /// Seconds in symbolic analysis.
    pub analysis_seconds: f64,
    /// Seconds in numeric factorisation, failed attempts included.
    pub factorisation_seconds: f64,
    /// Seconds in solves, without factorisations.
    pub solve_seconds: f64,
    /// Largest relative residual of a solve.
    pub largest_residual: f64,
    /// Numbers stored in the factor.
    pub factor_entries: usize,
    /// Counted work of the last Cholesky factorisation, and how far threads can share it.
    pub factorisation_work: Option<SharedWork>,
    /// Counted work of a solve with its triangle, and how far threads can share it.
    pub solve_work: Option<SharedWork>,
    /// The orderings that the last analysis compared, the one that was taken first.
    pub orderings: Vec<Candidate>,
    /// Condition number in the 1-norm, where it was asked for ([`super::TangentSolver::estimate_condition`]).
    pub condition: Option<f64>,
    /// Number of negative eigenvalues of the last matrix that was factored by Cholesky with signs or by Bunch–Kaufman, so far
    /// as its solutions were accurate. For a stable equilibrium under multipliers it is the number of multipliers.
    pub negative_eigenvalues: Option<usize>,
    /// Unknowns of one cell or facet each that were eliminated from the last matrix, and why others were not; none where a form has no such
    /// unknowns, or the solver does not look for them.
    pub local_unknowns: Option<Counts>,
    /// The way that the last solve took.
    pub path: Option<SolverPath>,
    /// Unknowns to which a [`super::CondensedSolver`] condensed; none where no Schur complement was used.
    pub condensed_unknowns: Option<usize>,
}
