//! Work of a step whose equations are affine, part by part.

/// Work of a step of an affine form, or of an explicit step: counts, and seconds of each part. What is left of `seconds` are the
/// fields that the scheme evaluates and those at the end of the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepCost {
    /// Residuals assembled: one, and one more where the equations are looked at in their solution.
    pub residuals: usize,
    /// Matrices assembled and handed to the solver, none where the last one holds.
    pub matrices: usize,
    /// Systems solved.
    pub solves: usize,
    /// Seconds in residuals.
    pub residual_seconds: f64,
    /// Seconds in matrices and their factors.
    pub matrix_seconds: f64,
    /// Seconds in solves.
    pub solve_seconds: f64,
    /// Seconds of the step in all, of the first one with the second rate of the start.
    pub seconds: f64,
}
