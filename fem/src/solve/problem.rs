//! A compiled form with one unknown as a system of equations: what Newton's method and linear solvers ask
//! for, with the integrals that no iterate changes assembled once.

use std::sync::Arc;
use std::time::Instant;

use forms_core::contract::Form;

use super::{
    ActivePoints, Elimination, LinearSolver, NewtonError, NewtonOptions, NewtonStep, NonlinearProblem,
    newton, solve_linear,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::constraints::Constraints;
use crate::field::Field;
use crate::history::commits;
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError};
use crate::solve::SolverError;
use crate::space::Space;

/// A form with one unknown and one test function, on one space.
pub struct FormProblem<'a, F, const D: usize> {
    form: &'a F,
    assembler: &'a Assembler<D>,
    space: Arc<Space<D>>,
    pattern: Arc<BlockPattern>,
    /// Residual at 0 and tangent of the integrals that are constant or linear in the unknown, and how often the
    /// form's histories had been committed then.
    fixed: Option<(u64, Arc<(Vec<f64>, CsrMatrix)>)>,
    seconds: f64,
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

/// Why an affine problem was not solved.
#[derive(Debug, thiserror::Error)]
pub enum LinearProblemError {
    /// The form or its data do not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The system could not be solved.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

impl From<LinearAlgebraError> for LinearProblemError {
    fn from(source: LinearAlgebraError) -> Self {
        LinearProblemError::Solver(source.into())
    }
}

impl<'a, F: Form<D>, const D: usize> FormProblem<'a, F, D> {
    /// Prepares the matrix pattern of the form on a space.
    ///
    /// # Errors
    /// When the matrix is too large to be numbered.
    pub fn new(
        form: &'a F,
        assembler: &'a Assembler<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Self, AssemblyError> {
        let pattern = BlockPattern::new(&[space], &[space])
            .map_err(|source| AssemblyError::LinearAlgebra { form: form.name(), source })?;
        Ok(Self::with_pattern(form, assembler, space, &Arc::new(pattern)))
    }

    /// The same on a pattern made for this space before.
    pub fn with_pattern(
        form: &'a F,
        assembler: &'a Assembler<D>,
        space: &Arc<Space<D>>,
        pattern: &Arc<BlockPattern>,
    ) -> Self {
        let (space, pattern) = (space.clone(), pattern.clone());
        FormProblem { form, assembler, space, pattern, fixed: None, seconds: 0.0 }
    }

    /// The matrix pattern, for other forms on the same space.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Seconds spent in assembly so far.
    pub fn assembly_seconds(&self) -> f64 {
        self.seconds
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
        let start = start.values().to_vec();
        let space = self.space.clone();
        let found = newton(self, constraints.prescribed(), start, solver, options, progress)?;
        let field = Field { space, values: Arc::new(found.u) };
        Ok(Solved { field, history: found.history, residual: found.residual })
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
        let zero = vec![0.0; self.space.unknowns()];
        let mut load = self.residual(&zero)?;
        let matrix = self.tangent(&zero)?;
        for value in &mut load {
            *value = -*value;
        }
        let mut elimination = Elimination::new(load.len(), constraints.prescribed())?;
        let solution = solve_linear(&matrix, &load, &mut elimination, solver)?;
        Ok(Field { space: self.space.clone(), values: Arc::new(solution.solution) })
    }

    fn fixed(&mut self) -> Result<Arc<(Vec<f64>, CsrMatrix)>, AssemblyError> {
        let commits = commits(self.form.inputs());
        if let Some((then, fixed)) = &self.fixed
            && *then == commits
        {
            return Ok(fixed.clone());
        }
        let start = Instant::now();
        let zero = Field::zero(&self.space);
        let spaces = [&self.space];
        let residual = self.assembler.residual_parts(self.form, &[&zero], &spaces, Parts::FIXED)?;
        let mut matrix = CsrMatrix::zero(self.pattern.pattern());
        self.assembler.add_tangent(self.form, &[&zero], &spaces, Parts::FIXED, &self.pattern, &mut matrix)?;
        let fixed = Arc::new((residual, matrix));
        self.fixed = Some((commits, fixed.clone()));
        self.seconds += start.elapsed().as_secs_f64();
        Ok(fixed)
    }

    fn field(&self, u: &[f64]) -> Field<D> {
        Field { space: self.space.clone(), values: Arc::new(u.to_vec()) }
    }

    fn fit(&self, source: LinearAlgebraError) -> AssemblyError {
        AssemblyError::LinearAlgebra { form: self.form.name(), source }
    }
}

impl<F: Form<D>, const D: usize> NonlinearProblem for FormProblem<'_, F, D> {
    type Error = AssemblyError;

    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let field = self.field(u);
        let fixed = self.fixed()?;
        let mut residual = fixed.0.clone();
        let linear = fixed.1.multiply(u).map_err(|source| self.fit(source))?;
        let start = Instant::now();
        let nonlinear =
            self.assembler.residual_parts(self.form, &[&field], &[&self.space], Parts::NONLINEAR)?;
        for ((sum, linear), nonlinear) in residual.iter_mut().zip(linear).zip(nonlinear) {
            *sum += linear + nonlinear;
        }
        self.seconds += start.elapsed().as_secs_f64();
        Ok(residual)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<CsrMatrix, AssemblyError> {
        let field = self.field(u);
        let mut matrix = self.fixed()?.1.clone();
        let start = Instant::now();
        self.assembler.add_tangent(
            self.form,
            &[&field],
            &[&self.space],
            Parts::NONLINEAR,
            &self.pattern,
            &mut matrix,
        )?;
        self.seconds += start.elapsed().as_secs_f64();
        Ok(matrix)
    }

    fn linear_part(&mut self) -> Result<Option<CsrMatrix>, AssemblyError> {
        Ok(Some(self.fixed()?.1.clone()))
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        let field = self.field(u);
        let start = Instant::now();
        let set = self.assembler.active_set(self.form, &[&field])?;
        self.seconds += start.elapsed().as_secs_f64();
        // A point with several switches counts once; which of them are on tells sets apart.
        Ok(set.map(|bits| {
            let on = bits.iter().enumerate().filter(|(_, bits)| **bits != 0);
            ActivePoints::from_numbers(on.map(|(point, bits)| point << 32 | *bits as usize))
        }))
    }
}
