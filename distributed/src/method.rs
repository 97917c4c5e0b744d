//! Methods of solution of PETSc's solvers.

/// The relative residual that iterations reach where nothing else is asked for.
pub const TOLERANCE: f64 = 1e-10;

/// Methods of solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// LU by MUMPS, for any matrix.
    Direct,
    /// LDLᵀ by MUMPS, for symmetric matrices, with a count of negative pivots: for eigenproblems.
    Symmetric,
    /// Conjugate gradients with smoothed aggregation (GAMG), with the rigid motions if the unknown is a displacement: for
    /// symmetric positive definite matrices.
    ConjugateGradients {
        /// Relative residual ‖b − A x‖₂ / ‖b‖₂ to reach.
        tolerance: f64,
        /// Most iterations.
        max_iterations: u16,
    },
    /// GMRES, for any matrix, such as that of contact with θ ≠ 1: with smoothed aggregation for one unknown, and for two by their blocks
    /// with the Schur complement, where GAMG serves the first unknown and the complement's diagonal the second. Multipliers on facets are one
    /// block, for which MUMPS factors the complement with the diagonal's inverse.
    Gmres {
        /// Relative residual ‖b − A x‖₂ / ‖b‖₂ to reach.
        tolerance: f64,
        /// Most iterations.
        max_iterations: u16,
    },
}

impl Method {
    /// Conjugate gradients to a relative residual of [`TOLERANCE`], in at most 500 iterations.
    pub fn conjugate_gradients() -> Self {
        Method::ConjugateGradients { tolerance: TOLERANCE, max_iterations: 500 }
    }

    /// GMRES to a relative residual of [`TOLERANCE`], in at most 500 iterations.
    pub fn gmres() -> Self {
        Method::Gmres { tolerance: TOLERANCE, max_iterations: 500 }
    }

    /// Whether it solves by a factor.
    pub(crate) fn is_direct(self) -> bool {
        matches!(self, Method::Direct | Method::Symmetric)
    }

    /// The method of a name: `direct`, `symmetric`, `cg` or `gmres`.
    ///
    /// # Errors
    /// [`UnknownMethod`].
    pub fn named(name: &str) -> Result<Self, UnknownMethod> {
        match name {
            "direct" => Ok(Method::Direct),
            "symmetric" => Ok(Method::Symmetric),
            "cg" => Ok(Method::conjugate_gradients()),
            "gmres" => Ok(Method::gmres()),
            name => Err(UnknownMethod { name: name.to_owned() }),
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Method::Direct | Method::Symmetric => "MUMPS",
            Method::ConjugateGradients { .. } => "CG with GAMG",
            Method::Gmres { .. } => "GMRES",
        }
    }
}

/// There is no method of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no method is called \"{name}\": there are \"direct\" and \"symmetric\" (MUMPS), \"cg\" (conjugate gradients with GAMG) and \
     \"gmres\""
)]
pub struct UnknownMethod {
    /// The name that was asked for.
    pub name: String,
}
