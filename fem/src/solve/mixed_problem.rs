//! A compiled form with several unknowns as a system of equations: what Newton's method and linear solvers
//! ask for, with the integrals that no iterate changes assembled once.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use forms_core::contract::Form;

use super::assembled_once::{Assembled, System};
use super::{
    ActivePoints, Elimination, LinearSolver, NewtonError, NewtonFailure, NewtonOptions, NewtonStep,
    NonlinearProblem, Start, Tangent, newton_eliminating, solve_linear,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern};
use crate::constraints::Constraints;
use crate::field::Field;
use crate::history::commits;
use crate::linear_algebra::{BlockMatrix, LinearAlgebraError, free_motions};
use crate::solve::SolverError;
use crate::space::Space;

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
    system: System<'a, F, D, N>,
    assembled: Option<Assembled>,
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
    /// Prepares the matrix pattern of the form: blocks that the form leaves empty are not stored, nor those that the
    /// assembler's cells leave empty.
    ///
    /// # Errors
    /// When the form has other unknowns than the spaces, a region does not exist, or the matrix is too large
    /// to be numbered.
    pub fn new(
        form: &'a F,
        assembler: &'a Assembler<D>,
        spaces: [&Arc<Space<D>>; N],
    ) -> Result<Self, AssemblyError> {
        let pattern = BlockPattern::for_share(form, &spaces, &spaces, assembler)?;
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
        let system = System { form, assembler, assembler_at: None, spaces, pattern };
        MixedProblem { system, assembled: None, seconds: 0.0 }
    }

    /// Lets the iterate choose who assembles the nonlinear integrals, as when facets are split where a scalar of the
    /// iterate changes its sign ([`Assembler::split_at_zeros`]). There is then no active set of fixed points in Newton's
    /// history. What no iterate changes is assembled as before.
    pub fn with_assembler_at(
        mut self,
        choose: impl Fn(&[Field<D>]) -> Result<Assembler<D>, AssemblyError> + 'a,
    ) -> Self {
        self.system.assembler_at = Some(Box::new(choose));
        self
    }

    /// The matrix pattern, for other forms on the same spaces.
    pub fn pattern(&self) -> &Arc<BlockPattern<D>> {
        &self.system.pattern
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
        let checked = self.check_spaces("start", given).and_then(|()| self.elimination(constraints));
        let elimination = match checked {
            Ok(Ok(elimination)) => elimination,
            Ok(Err(error)) => {
                return Err(NewtonError { why: NewtonFailure::Mismatch(error), history: vec![], u });
            }
            Err(error) => {
                return Err(NewtonError { why: NewtonFailure::Assembly(error), history: vec![], u });
            }
        };
        let guess = self.guess(&u, constraints);
        let start = Start { u, guess };
        let found = newton_eliminating(self, elimination, start, solver, options, progress).map_err(
            |mut error| {
                if let NewtonFailure::LinearSolver(source) = error.why {
                    let named = match Elimination::of(&constraints) {
                        Ok(elimination) => self.named(source, &elimination),
                        Err(_) => source,
                    };
                    error.why = NewtonFailure::LinearSolver(named);
                }
                error
            },
        )?;
        let fields = self.system.fields(&found.u);
        Ok(MixedSolved { fields, history: found.history, residual: found.residual })
    }

    /// Where the first iterates may be: each vector field on the mesh moved by 1.05 times the mean of its prescribed
    /// values, for a body that is moved at one side follows nearly as it is. None where nothing is moved.
    fn guess(&self, u: &[f64], constraints: [&Constraints<D>; N]) -> Option<Vec<f64>> {
        let mut guess = u.to_vec();
        let mut offset = 0;
        let mut moved = false;
        for (space, constraints) in self.system.spaces.iter().zip(constraints) {
            for component in 0..if space.components() == D { D } else { 0 } {
                let of_component =
                    constraints.prescribed().iter().filter(|(unknown, _)| *unknown % D == component);
                let (count, sum) =
                    of_component.fold((0.0, 0.0), |(count, sum), (_, value)| (count + 1.0, sum + value));
                if sum != 0.0 {
                    let values = guess[offset..offset + space.unknowns()].iter_mut();
                    values.skip(component).step_by(D).for_each(|value| *value += 1.05 * sum / count);
                    moved = true;
                }
            }
            offset += space.unknowns();
        }
        moved.then_some(guess)
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
        let mut elimination = self.elimination(constraints)??;
        let zero = vec![0.0; self.system.unknowns()];
        let mut load = self.residual(&zero)?;
        for value in &mut load {
            *value = -*value;
        }
        let tangent = self.tangent(&zero)?;
        let found = solve_linear(&tangent.matrix, &load, &mut elimination, solver);
        let solution = found.map_err(|error| self.named(error, &elimination))?;
        Ok(self.system.fields(&solution.solution))
    }

    /// The constraints of all spaces as those of the whole vector.
    fn elimination(
        &self,
        constraints: [&Constraints<D>; N],
    ) -> Result<Result<Elimination, LinearAlgebraError>, AssemblyError> {
        self.check_spaces("constraints", constraints.map(|constraints| constraints.space()))?;
        Ok(Elimination::of(&constraints))
    }

    pub(super) fn check_spaces(
        &self,
        what: &'static str,
        given: [&Arc<Space<D>>; N],
    ) -> Result<(), AssemblyError> {
        match self.system.spaces.iter().zip(given).position(|(own, given)| !own.numbers_as(given)) {
            None => Ok(()),
            Some(number) => {
                let (form, field) = (self.system.form.name(), self.system.unknown_name(number));
                Err(AssemblyError::OtherSpace { form, field, what })
            }
        }
    }

    /// A singular matrix is reported with the field and the place of an unknown that it does not determine, an equation
    /// that does not hold with those of its unknown.
    fn named(&self, error: SolverError, elimination: &Elimination) -> SolverError {
        let unknown = match error {
            SolverError::LinearAlgebra(
                LinearAlgebraError::Singular { unknown, .. }
                | LinearAlgebraError::IllConditioned { unknown, .. }
                | LinearAlgebraError::Inaccurate { row: unknown, .. },
            ) => unknown,
            _ => return error,
        };
        let mut index = elimination.free().get(unknown).copied().unwrap_or(0);
        for (number, space) in self.system.spaces.iter().enumerate() {
            if index < space.unknowns() {
                let components = space.components();
                let field = self.system.unknown_name(number);
                let component = (components > 1).then_some(index % components);
                let position = space.positions()[index / components].to_vec();
                return match error {
                    SolverError::LinearAlgebra(LinearAlgebraError::Inaccurate { backward_error, .. }) => {
                        SolverError::Inaccurate { field, component, position, backward_error }
                    }
                    SolverError::LinearAlgebra(LinearAlgebraError::IllConditioned { condition, .. }) => {
                        // A body that can move rigidly is singular, whatever rounding makes of its matrix.
                        let (motions, ratio) = (self.free_motions(number, elimination), 1.0 / condition);
                        if motions.is_empty() {
                            SolverError::IllConditioned { field, component, position, condition }
                        } else {
                            SolverError::Undetermined { field, component, position, ratio, motions }
                        }
                    }
                    SolverError::LinearAlgebra(LinearAlgebraError::Singular { ratio, .. }) => {
                        let motions = self.free_motions(number, elimination);
                        SolverError::Undetermined { field, component, position, ratio, motions }
                    }
                    error => error,
                };
            }
            index -= space.unknowns();
        }
        error
    }

    /// The rigid motions of an unknown that nothing resists, where it is a vector on the mesh.
    fn free_motions(&self, number: usize, elimination: &Elimination) -> Vec<String> {
        let (spaces, space) = (&self.system.spaces, &self.system.spaces[number]);
        let Some(assembled) = self.assembled.as_ref().filter(|_| space.components() == D) else {
            return vec![];
        };
        let offset = spaces[..number].iter().map(|space| space.unknowns()).sum();
        // What cannot be said is left out: the error is reported in any case.
        let hindrance = |motion: &[f64], forces: &[f64]| elimination.hindrance(motion, forces);
        free_motions(assembled.matrix(), offset, space.positions(), hindrance).unwrap_or_default()
    }

    /// The system, with what no iterate changes assembled.
    fn ready(&mut self) -> Result<(&System<'a, F, D, N>, &mut Assembled), AssemblyError> {
        let commits = commits(self.system.form.inputs());
        let assembled = match self.assembled.take() {
            Some(assembled) if assembled.commits == commits => assembled,
            earlier => {
                let start = Instant::now();
                let assembled = self.system.assemble(commits, earlier)?;
                self.seconds += start.elapsed().as_secs_f64();
                assembled
            }
        };
        Ok((&self.system, self.assembled.insert(assembled)))
    }

    /// The places among the values of the tangent that an update may change, as ascending ranges of whole blocks:
    /// those of the nodes that nonlinear integrals couple. An update takes a time proportional to their number and
    /// to that of the cells and facets of these integrals, whatever the size of the mesh.
    ///
    /// # Errors
    /// If assembly fails.
    pub fn changed_places(&mut self) -> Result<&[Range<usize>], AssemblyError> {
        Ok(self.ready()?.1.touched())
    }
}

impl<F: Form<D>, const D: usize, const N: usize> NonlinearProblem for MixedProblem<'_, F, D, N> {
    type Error = AssemblyError;

    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let (system, assembled) = self.ready()?;
        let start = Instant::now();
        let residual = system.residual(assembled, u);
        self.seconds += start.elapsed().as_secs_f64();
        residual
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let (system, assembled) = self.ready()?;
        let start = Instant::now();
        system.update(assembled, u)?;
        self.seconds += start.elapsed().as_secs_f64();
        let (_, assembled) = self.ready()?;
        Ok(Tangent { matrix: Cow::Borrowed(assembled.matrix()), changed: assembled.changed() })
    }

    fn linear_part(&mut self) -> Result<Option<&BlockMatrix>, AssemblyError> {
        Ok(self.ready()?.1.linear_part())
    }

    fn nonlinear_residual(&mut self, u: &[f64]) -> Result<Option<Vec<f64>>, AssemblyError> {
        let (system, _) = self.ready()?;
        let start = Instant::now();
        let residual = system.nonlinear_residual(u);
        self.seconds += start.elapsed().as_secs_f64();
        residual.map(Some)
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        if self.system.assembler_at.is_some() {
            return Ok(None);
        }
        let start = Instant::now();
        let set = self.system.assembler.active_set_of(self.system.form, &self.system.views(u)?)?;
        self.seconds += start.elapsed().as_secs_f64();
        // A point with several switches counts once; which of them are on tells sets apart.
        Ok(set.map(|bits| {
            let on = bits.iter().enumerate().filter(|(_, bits)| **bits != 0);
            ActivePoints::from_numbers(on.map(|(point, bits)| point << 32 | *bits as usize))
        }))
    }

    fn field_sizes(&self) -> Vec<usize> {
        self.system.spaces.iter().map(|space| space.unknowns()).collect()
    }
}
