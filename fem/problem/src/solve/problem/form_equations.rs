//! Equations of any form behind one type, so that Newton's method for them is compiled once, in this crate.

use crate::assemble::{AssemblyError, Terms};
use crate::linear_algebra::BlockMatrix;
use crate::solve::{
    ActivePoints, Elimination, FieldUnknowns, LinearSolver, NewtonError, NewtonOptions, NewtonSolution,
    NewtonStep, NonlinearProblem, NonlinearTangent, Products, Start, Tangent, newton_eliminating,
};

/// [`newton_eliminating`] for the problem of any form, compiled once: a user's form brings its kernels, not Newton's method.
///
/// # Errors
/// As [`newton()`].
pub(super) fn newton_for_form(
    problem: &mut FormEquations<'_>,
    elimination: Elimination,
    start: Start,
    solver: &mut dyn LinearSolver,
    options: &NewtonOptions,
    progress: &mut dyn FnMut(&NewtonStep),
) -> Result<NewtonSolution, NewtonError<AssemblyError>> {
    newton_eliminating(problem, elimination, start, solver, options, progress)
}

/// A problem with nothing known but its equations.
pub(super) struct FormEquations<'a>(pub &'a mut dyn NonlinearProblem<Error = AssemblyError>);

impl NonlinearProblem for FormEquations<'_> {
    type Error = AssemblyError;

    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        self.0.residual(u)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        self.0.tangent(u)
    }

    fn linear_part(&mut self) -> Result<Option<&BlockMatrix>, AssemblyError> {
        self.0.linear_part()
    }

    fn has_symmetric_linear_part(&self) -> bool {
        self.0.has_symmetric_linear_part()
    }

    fn nonlinear_residual(&mut self, u: &[f64]) -> Result<Option<Vec<f64>>, AssemblyError> {
        self.0.nonlinear_residual(u)
    }

    fn nonlinear_tangent(&mut self, u: &[f64]) -> Result<Option<NonlinearTangent<'_>>, AssemblyError> {
        self.0.nonlinear_tangent(u)
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        self.0.active_points(u)
    }

    fn fields(&self) -> Vec<FieldUnknowns> {
        self.0.fields()
    }

    fn products(&mut self, u: &[f64], x: &[f64]) -> Result<Products, AssemblyError> {
        self.0.products(u, x)
    }

    fn summed_up(&mut self, own: Vec<f64>) -> Result<Vec<f64>, AssemblyError> {
        self.0.summed_up(own)
    }

    fn sizes_of_terms(&mut self, u: &[f64], terms: Terms) -> Result<Option<Vec<f64>>, AssemblyError> {
        self.0.sizes_of_terms(u, terms)
    }
}
