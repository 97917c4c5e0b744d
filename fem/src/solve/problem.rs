//! A compiled form with one unknown as a system of equations: a [`MixedProblem`] of one space.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::Form;

use super::{
    ActivePoints, LinearProblemError, LinearSolver, MixedProblem, MixedSolved, NewtonError, NewtonOptions,
    NewtonStep, NonlinearProblem, Tangent,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern};
use crate::constraints::Constraints;
use crate::field::Field;
use crate::linear_algebra::BlockMatrix;
use crate::space::Space;

/// A form with one unknown and one test function, on one space. [`MixedProblem`] takes several.
pub struct FormProblem<'a, F, const D: usize> {
    whole: MixedProblem<'a, F, D, 1>,
}

/// A solution by Newton's method.
#[derive(Clone, Debug)]
pub struct Solved<const D: usize> {
    /// The unknown.
    pub field: Field<D>,
    /// The start and each iterate.
    pub history: Vec<NewtonStep>,
    /// R(u) on all unknowns: reactions where values are prescribed, about zero elsewhere.
    pub residual: Vec<f64>,
}

impl<'a, F: Form<D>, const D: usize> FormProblem<'a, F, D> {
    /// Prepares the matrix pattern of the form on a space.
    ///
    /// # Errors
    /// When the form has several unknowns, a region does not exist, or the matrix is too large to be
    /// numbered.
    pub fn new(
        form: &'a F,
        assembler: &'a Assembler<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Self, AssemblyError> {
        Ok(FormProblem { whole: MixedProblem::new(form, assembler, [space])? })
    }

    /// The same on a pattern made for this space before, which must hold every entry of this form.
    pub fn with_pattern(
        form: &'a F,
        assembler: &'a Assembler<D>,
        space: &Arc<Space<D>>,
        pattern: &Arc<BlockPattern<D>>,
    ) -> Self {
        FormProblem { whole: MixedProblem::with_pattern(form, assembler, [space], pattern) }
    }

    /// Lets the iterate choose who assembles the nonlinear integrals; see [`MixedProblem::with_assembler_at`].
    pub fn with_assembler_at(
        self,
        choose: impl Fn(&Field<D>) -> Result<Assembler<D>, AssemblyError> + 'a,
    ) -> Self {
        FormProblem { whole: self.whole.with_assembler_at(move |fields| choose(&fields[0])) }
    }

    /// The matrix pattern, for other forms on the same space.
    pub fn pattern(&self) -> &Arc<BlockPattern<D>> {
        self.whole.pattern()
    }

    /// Seconds spent in assembly so far.
    pub fn assembly_seconds(&self) -> f64 {
        self.whole.assembly_seconds()
    }

    /// The places among the values of the tangent that an iteration changes; see
    /// [`MixedProblem::changed_places`].
    ///
    /// # Errors
    /// If assembly fails.
    pub fn changed_places(&mut self) -> Result<&[Range<usize>], AssemblyError> {
        self.whole.changed_places()
    }

    /// Whether a field is one of this problem's unknown.
    pub(super) fn check_space(&self, field: &Field<D>) -> Result<(), AssemblyError> {
        self.whole.check_spaces("coefficients", [field.space()])
    }

    /// Solves R(u) = 0 by semismooth Newton from u = `start` with the constraints imposed on it.
    ///
    /// # Errors
    /// [`NewtonError`] with the reason, the history and the last iterate.
    pub fn solve(
        &mut self,
        start: &Field<D>,
        constraints: &Constraints<D>,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<Solved<D>, NewtonError<AssemblyError>> {
        let found = self.whole.solve([start], [constraints], solver, options, progress)?;
        let MixedSolved { fields: [field], history, residual } = found;
        Ok(Solved { field, history, residual })
    }

    /// Solves a form that is affine in its unknown: one assembly, one linear system. The solver keeps the
    /// matrix and what it factored.
    ///
    /// # Errors
    /// What does not fit, or why the system was not solved.
    pub fn solve_affine(
        &mut self,
        constraints: &Constraints<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Field<D>, LinearProblemError> {
        let [field] = self.whole.solve_affine([constraints], solver)?;
        Ok(field)
    }
}

impl<F: Form<D>, const D: usize> NonlinearProblem for FormProblem<'_, F, D> {
    type Error = AssemblyError;

    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        self.whole.residual(u)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        self.whole.tangent(u)
    }

    fn linear_part(&mut self) -> Result<Option<&BlockMatrix>, AssemblyError> {
        self.whole.linear_part()
    }

    fn nonlinear_residual(&mut self, u: &[f64]) -> Result<Option<Vec<f64>>, AssemblyError> {
        self.whole.nonlinear_residual(u)
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        self.whole.active_points(u)
    }

    fn field_sizes(&self) -> Vec<usize> {
        self.whole.field_sizes()
    }
}
