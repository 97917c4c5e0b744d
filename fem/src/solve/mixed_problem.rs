//! A compiled form with several unknowns as a system of equations: what Newton's method and linear solvers
//! ask for, with the integrals that no iterate changes assembled once.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use forms_core::contract::{Form, Role};

use super::{
    ActivePoints, Elimination, LinearSolver, NewtonError, NewtonFailure, NewtonOptions, NewtonStep,
    NonlinearProblem, newton, solve_linear,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::constraints::Constraints;
use crate::field::Field;
use crate::history::commits;
use crate::linear_algebra::{BlockMatrix, CsrMatrix, LinearAlgebraError};
use crate::solve::SolverError;
use crate::space::Space;

/// Residual at 0 and tangent of the integrals that are constant or linear in the unknowns.
type Fixed = (Vec<f64>, BlockMatrix);

/// A form with N unknowns, each on its own space; test function k belongs to the space of unknown k. In
/// vectors and matrices the unknowns of the spaces stand one after the other.
///
/// ```no_run
/// # use forms_fem::prelude::*;
/// # #[forms(dimension = 2)]
/// # mod stokes {
/// #     #[cells]
/// #     pub struct Omega;
/// #     pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
/// #         integral(Omega, inner(grad(u), grad(v)) - p * div(v) - q * div(u))
/// #     }
/// # }
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?);
/// let (velocities, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
/// let mut walls = Constraints::new(&velocities);
/// walls.fix("boundary", |x| [x[1], 0.0])?;
/// let mut level = Constraints::new(&pressures);
/// level.fix_nearest(&[0.0, 0.0], 0.0)?; // the pressure is determined up to a constant
///
/// let (form, assembler) = (stokes::flow(&stokes::Omega::on("all")), Assembler::new(&mesh));
/// let mut problem = MixedProblem::new(&form, &assembler, [&velocities, &pressures])?;
/// let [u, p] = problem.solve_affine([&walls, &level], &mut TangentSolver::default())?;
/// # Ok(())
/// # }
/// ```
pub struct MixedProblem<'a, F, const D: usize, const N: usize> {
    form: &'a F,
    assembler: &'a Assembler<D>,
    spaces: [Arc<Space<D>>; N],
    pattern: Arc<BlockPattern<D>>,
    /// What no iterate changes, and how often the form's histories had been committed when it was assembled.
    fixed: Option<(u64, Arc<Fixed>)>,
    seconds: f64,
}

/// A solution of a [`MixedProblem`] by Newton's method.
#[derive(Clone, Debug)]
pub struct MixedSolved<const D: usize, const N: usize> {
    /// The unknowns.
    pub fields: [Field<D>; N],
    /// The start and each iterate.
    pub history: Vec<NewtonStep>,
    /// R on all unknowns, space after space: reactions where values are prescribed, about zero elsewhere.
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

impl<'a, F: Form<D>, const D: usize, const N: usize> MixedProblem<'a, F, D, N> {
    /// Prepares the matrix pattern of the form: blocks that the form leaves empty are not stored.
    ///
    /// # Errors
    /// When the form has other unknowns than the spaces, a region does not exist, or the matrix is too large
    /// to be numbered.
    pub fn new(
        form: &'a F,
        assembler: &'a Assembler<D>,
        spaces: [&Arc<Space<D>>; N],
    ) -> Result<Self, AssemblyError> {
        let pattern = BlockPattern::for_form(form, &spaces, &spaces)?;
        Ok(Self::with_pattern(form, assembler, spaces, &Arc::new(pattern)))
    }

    /// The same on a pattern made for these spaces before, which must hold every entry of this form.
    pub fn with_pattern(
        form: &'a F,
        assembler: &'a Assembler<D>,
        spaces: [&Arc<Space<D>>; N],
        pattern: &Arc<BlockPattern<D>>,
    ) -> Self {
        let (spaces, pattern) = (spaces.map(Arc::clone), pattern.clone());
        MixedProblem { form, assembler, spaces, pattern, fixed: None, seconds: 0.0 }
    }

    /// The matrix pattern, for other forms on the same spaces.
    pub fn pattern(&self) -> &Arc<BlockPattern<D>> {
        &self.pattern
    }

    /// Seconds spent in assembly so far.
    pub fn assembly_seconds(&self) -> f64 {
        self.seconds
    }

    /// Solves R(u) = 0 by semismooth Newton from the fields of `start` with the constraints imposed on them.
    ///
    /// # Errors
    /// [`NewtonError`] with the reason, the history and the last iterate.
    pub fn solve(
        &mut self,
        start: [&Field<D>; N],
        constraints: [&Constraints<D>; N],
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<MixedSolved<D, N>, NewtonError<AssemblyError>> {
        let u = start.iter().flat_map(|field| field.values()).copied().collect();
        let given = start.map(|field| field.space());
        let checked = self.check_spaces("start", given).and_then(|()| self.prescribed(constraints));
        let prescribed = match checked {
            Ok(prescribed) => prescribed,
            Err(error) => {
                return Err(NewtonError { why: NewtonFailure::Assembly(error), history: vec![], u });
            }
        };
        let found = newton(self, &prescribed, u, solver, options, progress).map_err(|mut error| {
            if let NewtonFailure::LinearSolver(source) = error.why {
                error.why = NewtonFailure::LinearSolver(self.named(source, &prescribed));
            }
            error
        })?;
        let fields = self.fields(&found.u);
        Ok(MixedSolved { fields, history: found.history, residual: found.residual })
    }

    /// Solves a form that is affine in its unknowns: one assembly, one linear system. The solver keeps the
    /// matrix and what it factored.
    ///
    /// # Errors
    /// What does not fit, or why the system was not solved.
    pub fn solve_affine(
        &mut self,
        constraints: [&Constraints<D>; N],
        solver: &mut dyn LinearSolver,
    ) -> Result<[Field<D>; N], LinearProblemError> {
        let prescribed = self.prescribed(constraints)?;
        let zero = vec![0.0; self.spaces.iter().map(|space| space.unknowns()).sum()];
        let mut load = self.residual(&zero)?;
        let matrix = self.tangent(&zero)?;
        for value in &mut load {
            *value = -*value;
        }
        let mut elimination = Elimination::new(load.len(), &prescribed)?;
        let solution = solve_linear(&matrix, &load, &mut elimination, solver)
            .map_err(|error| self.named(error, &prescribed))?;
        Ok(self.fields(&solution.solution))
    }

    /// The constraints of all spaces as those of the whole vector.
    fn prescribed(&self, constraints: [&Constraints<D>; N]) -> Result<BTreeMap<usize, f64>, AssemblyError> {
        self.check_spaces("constraints", constraints.map(|constraints| constraints.space()))?;
        let mut all = BTreeMap::new();
        let mut offset = 0;
        for (space, constraints) in self.spaces.iter().zip(constraints) {
            all.extend(constraints.prescribed().iter().map(|(unknown, value)| (offset + unknown, *value)));
            offset += space.unknowns();
        }
        Ok(all)
    }

    fn check_spaces(&self, what: &'static str, given: [&Arc<Space<D>>; N]) -> Result<(), AssemblyError> {
        match self.spaces.iter().zip(given).position(|(own, given)| !own.numbers_as(given)) {
            None => Ok(()),
            Some(number) => {
                let (form, field) = (self.form.name(), self.unknown_name(number));
                Err(AssemblyError::OtherSpace { form, field, what })
            }
        }
    }

    fn unknown_name(&self, number: usize) -> &'static str {
        let fields = self.form.fields();
        fields.iter().find(|field| field.role == Role::Unknown(number)).map_or("unknown", |field| field.name)
    }

    /// A singular matrix is reported with the field and the place of an unknown that it does not determine.
    fn named(&self, error: SolverError, prescribed: &BTreeMap<usize, f64>) -> SolverError {
        let SolverError::LinearAlgebra(LinearAlgebraError::Singular { unknown, ratio }) = error else {
            return error;
        };
        let size = self.spaces.iter().map(|space| space.unknowns()).sum();
        let free = (0..size).filter(|index| !prescribed.contains_key(index)).nth(unknown);
        let mut index = free.unwrap_or(0);
        for (number, space) in self.spaces.iter().enumerate() {
            if index < space.unknowns() {
                let components = space.components();
                return SolverError::Undetermined {
                    field: self.unknown_name(number),
                    component: (components > 1).then_some(index % components),
                    position: space.positions()[index / components].to_vec(),
                    ratio,
                };
            }
            index -= space.unknowns();
        }
        error
    }

    fn fields(&self, u: &[f64]) -> [Field<D>; N] {
        let mut offset = 0;
        self.spaces.each_ref().map(|space| {
            let values = u[offset..offset + space.unknowns()].to_vec();
            offset += space.unknowns();
            Field { space: space.clone(), values: Arc::new(values) }
        })
    }

    fn fixed(&mut self) -> Result<Arc<Fixed>, AssemblyError> {
        let commits = commits(self.form.inputs());
        if let Some((then, fixed)) = &self.fixed
            && *then == commits
        {
            return Ok(fixed.clone());
        }
        let start = Instant::now();
        let zero = self.spaces.each_ref().map(Field::zero);
        let (zero, spaces) = (zero.each_ref(), self.spaces.each_ref());
        let residual = self.assembler.residual_parts(self.form, &zero, &spaces, Parts::FIXED)?;
        let mut matrix = BlockMatrix::zero(self.pattern.sparsity());
        self.assembler.assemble_tangent(
            self.form,
            &zero,
            &spaces,
            Parts::FIXED,
            &self.pattern,
            &mut matrix,
        )?;
        let fixed = Arc::new((residual, matrix));
        self.fixed = Some((commits, fixed.clone()));
        self.seconds += start.elapsed().as_secs_f64();
        Ok(fixed)
    }

    fn fit(&self, source: LinearAlgebraError) -> AssemblyError {
        AssemblyError::LinearAlgebra { form: self.form.name(), source }
    }
}

impl<F: Form<D>, const D: usize, const N: usize> NonlinearProblem for MixedProblem<'_, F, D, N> {
    type Error = AssemblyError;

    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let fields = self.fields(u);
        let fixed = self.fixed()?;
        let mut residual = fixed.0.clone();
        let linear = fixed.1.multiply(u).map_err(|source| self.fit(source))?;
        let start = Instant::now();
        let spaces = self.spaces.each_ref();
        let nonlinear =
            self.assembler.residual_parts(self.form, &fields.each_ref(), &spaces, Parts::NONLINEAR)?;
        for ((sum, linear), nonlinear) in residual.iter_mut().zip(linear).zip(nonlinear) {
            *sum += linear + nonlinear;
        }
        self.seconds += start.elapsed().as_secs_f64();
        Ok(residual)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<CsrMatrix, AssemblyError> {
        let fields = self.fields(u);
        let mut matrix = self.fixed()?.1.clone();
        let start = Instant::now();
        self.assembler.add_tangent(
            self.form,
            &fields.each_ref(),
            &self.spaces.each_ref(),
            Parts::NONLINEAR,
            &self.pattern,
            &mut matrix,
        )?;
        self.seconds += start.elapsed().as_secs_f64();
        Ok(matrix.into_csr())
    }

    fn linear_part(&mut self) -> Result<Option<CsrMatrix>, AssemblyError> {
        Ok(Some(self.fixed()?.1.to_csr()))
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        let fields = self.fields(u);
        let start = Instant::now();
        let set = self.assembler.active_set(self.form, &fields.each_ref())?;
        self.seconds += start.elapsed().as_secs_f64();
        // A point with several switches counts once; which of them are on tells sets apart.
        Ok(set.map(|bits| {
            let on = bits.iter().enumerate().filter(|(_, bits)| **bits != 0);
            ActivePoints::from_numbers(on.map(|(point, bits)| point << 32 | *bits as usize))
        }))
    }
}
