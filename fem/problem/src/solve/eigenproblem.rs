//! Eigenproblems of two forms: vibrations and buckling.

mod on_processes;

use std::borrow::Cow;
use std::sync::Arc;

use thiserror::Error;

use self::on_processes::PencilOfAll;
use super::communicator::{Communicator, agreed};
use super::local_unknowns::{LeftPencil, groups_of};
use super::problem::Problem;
use super::{Elimination, LinearSolver, NonlinearProblem, PerUnknown, Processes, SolverError};
use crate::assemble::{Assembler, AssemblyError};
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::linear_algebra::eigenpairs::eigenpairs_above;
use crate::linear_algebra::{Counts, EigenError, Eigenpair, LinearAlgebraError, Positive, SymmetricPencil};
use crate::space::Space;

/// Two forms with N unknowns, whose tangents K and M or K_G make an eigenproblem.
///
/// Vibrations are K x = λ M x with λ = ω², buckling is K x = −λ K_G x, where K_G is the geometric stiffness of the stress that a load
/// brings about and λ the factor by which the load is multiplied. Forms that are not linear are linearised about a state. Modes are
/// zero where the constraints prescribe values, and follow their relations.
///
/// The eigenvalues are those next above a shift, by shift and invert and Lanczos' method; multiple ones are returned with their multiplicity, and
/// a count by the signs of pivots has confirmed that none is missing ([`SymmetricPencil::eigenpairs_above`]).
///
/// Unknowns of one cell each, as pressures, are eliminated where the second form does not touch them. So the stiffness of a nearly
/// incompressible body with its pressure is positive definite, as buckling needs.
///
/// ```
/// # use forms_fem::prelude::*;
/// # use forms_fem::solve::Eigenproblem;
/// # #[forms(dimension = 2)]
/// # mod membrane {
/// #     #[cells]
/// #     pub struct Omega;
/// pub fn tension(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///     integral(Omega, dot(grad(u), grad(v)))
/// }
/// pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///     integral(Omega, u * v)
/// }
/// # }
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Quadrilateral, 1)?;
/// # let space = Space::scalar(&mesh, 2)?;
/// # let mut rim = Constraints::new(&space);
/// # rim.fix("boundary", |_| 0.0)?;
/// # let model = membrane::Model::default();
/// let modes = Eigenproblem::vibration(&model.tension(), &model.mass(), &space).constrained(&rim).smallest(4)?;
/// let squares: Vec<f64> = modes.iter().map(|mode| mode.value / std::f64::consts::PI.powi(2)).collect();
/// // 2, 5, 5, 8: the second and third are one eigenvalue with two modes.
/// assert!(squares.iter().zip([2.0, 5.0, 5.0, 8.0]).all(|(found, exact)| (found - exact).abs() < 0.01));
/// # Ok(())
/// # }
/// ```
pub struct Eigenproblem<'a, const D: usize, const N: usize = 1> {
    stiffness: Problem<'a, D, N>,
    other: Problem<'a, D, N>,
    positive: Positive,
    about: Option<[&'a Field<D>; N]>,
    local_unknowns: Option<Counts>,
    /// Of several processes.
    solver: Option<&'a mut dyn LinearSolver>,
}

/// An eigenvalue with its mode.
#[derive(Clone, Debug)]
pub struct Eigenmode<const D: usize, const N: usize = 1> {
    /// λ: the square ω² of the angular frequency, or the factor of the load.
    pub value: f64,
    /// The mode, a field per unknown; xᵀ M x = 1, of buckling xᵀ K x = 1.
    pub fields: [Field<D>; N],
    /// An exact eigenvalue of the discrete problem is not farther than this \[λ\].
    pub error_bound: f64,
    /// ‖K x − λ M x‖ relative to the norm of its terms.
    pub residual: f64,
}

impl<const D: usize> Eigenmode<D, 1> {
    /// The mode of the one unknown.
    pub fn field(&self) -> &Field<D> {
        &self.fields[0]
    }
}

/// Eigenproblems that were not solved.
#[derive(Debug, Error)]
pub enum EigenproblemError {
    /// Forms that do not fit, or could not be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Contact pairs whose points slide with the unknown.
    #[error("`{form}` has pairs of surfaces that its unknown displaces: eigenproblems have fixed pairs")]
    Sliding {
        /// The form.
        form: &'static str,
    },
    /// The shift is an eigenvalue, as zero is of a body that can move rigidly.
    #[error("the shift {shift:e} is an eigenvalue, up to rounding ({why}): take one below it, with `above`")]
    ShiftIsEigenvalue {
        /// The shift.
        shift: f64,
        /// Which unknown, or which motion, is not determined there.
        why: SolverError,
    },
    /// Pairs that were not found.
    #[error(transparent)]
    Eigen(EigenError),
    /// Constraints that do not fit.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
    /// The solver of several processes failed at a shift.
    #[error("the linear solver failed at the shift {shift:e}: {why}")]
    Solver {
        /// The shift.
        shift: f64,
        /// Its error.
        why: SolverError,
    },
    /// Several processes without a solver of theirs.
    #[error("an eigenproblem on several processes needs `.solver(..)`, which adds up their matrices")]
    NoSolver,
    /// A solver that does not count pivots.
    #[error(
        "the linear solver does not tell how many eigenvalues of a matrix are negative, so that some might be missed: take one that \
         factors symmetric matrices (`Method::Symmetric` of forms-distributed)"
    )]
    NoCount,
}

impl From<EigenError> for EigenproblemError {
    fn from(error: EigenError) -> Self {
        EigenproblemError::Eigen(error)
    }
}

impl<'a, const D: usize, const N: usize> Eigenproblem<'a, D, N> {
    /// K x = λ M x of a form and its mass, which is positive, or zero on some unknowns; spaces as for a
    /// [`Problem`].
    pub fn vibration<'s>(
        stiffness: &Form<D>,
        mass: &Form<D>,
        spaces: impl PerUnknown<'s, Arc<Space<D>>, N>,
    ) -> Self {
        Self::of([stiffness, mass], spaces.per_unknown(), Positive::Second)
    }

    /// K x = −λ K_G x of a form that is positive definite under the constraints, and of the geometric stiffness.
    pub fn buckling<'s>(
        stiffness: &Form<D>,
        geometric: &Form<D>,
        spaces: impl PerUnknown<'s, Arc<Space<D>>, N>,
    ) -> Self {
        Self::of([stiffness, geometric], spaces.per_unknown(), Positive::First)
    }

    #[inline(never)]
    fn of([stiffness, other]: [&Form<D>; 2], spaces: [&Arc<Space<D>>; N], positive: Positive) -> Self {
        Eigenproblem {
            stiffness: Problem::on_spaces(stiffness.clone(), spaces),
            other: Problem::on_spaces(other.clone(), spaces),
            positive,
            about: None,
            local_unknowns: None,
            solver: None,
        }
    }

    /// Conditions on one unknown: the first one on the constraints' space that has none yet. Modes are zero where they prescribe values.
    pub fn constrained(mut self, constraints: &'a Constraints<D>) -> Self {
        self.stiffness.constraints.push(Cow::Borrowed(constraints));
        self
    }

    /// The assembler, in place of the default one: for its quadrature, its threads.
    pub fn assembler(mut self, assembler: &'a Assembler<D>) -> Self {
        self.stiffness.system.assembler = Cow::Borrowed(assembler);
        self.other.system.assembler = Cow::Borrowed(assembler);
        self
    }

    /// Solution on several processes, with [`Eigenproblem::solver`]. Each assembles its cells' part of both matrices; on a part of a mesh the
    /// modes are those of this process's part. Nothing is eliminated beforehand.
    pub fn on(mut self, communicator: &'a dyn Communicator) -> Self {
        (self.stiffness, self.other) = (self.stiffness.on(communicator), self.other.on(communicator));
        self
    }

    /// The solver of several processes. It adds up their matrices and counts negative eigenvalues: a `PetscSolver` with
    /// `Method::Symmetric`.
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = Some(solver);
        self
    }

    /// The state about which forms are linearised; zero unless it is given.
    pub fn about(mut self, state: impl PerUnknown<'a, Field<D>, N>) -> Self {
        self.about = Some(state.per_unknown());
        self
    }

    /// Numbers of unknowns of one cell each that the last solution eliminated; none if it eliminated nothing.
    pub fn local_unknowns(&self) -> Option<Counts> {
        self.local_unknowns
    }

    /// The smallest positive eigenvalues, in ascending order.
    ///
    /// # Errors
    /// [`EigenproblemError`]; of a body that can move rigidly zero is an eigenvalue: [`Eigenproblem::above`] takes a shift below it.
    pub fn smallest(&mut self, count: usize) -> Result<Vec<Eigenmode<D, N>>, EigenproblemError> {
        self.above(0.0, count)
    }

    /// The next eigenvalues above a shift \[λ\], in ascending order.
    ///
    /// # Errors
    /// [`EigenproblemError`]: the shift is an eigenvalue, there are fewer, a pair did not converge, a matrix is not symmetric or not
    /// positive.
    #[inline(never)]
    pub fn above(&mut self, shift: f64, count: usize) -> Result<Vec<Eigenmode<D, N>>, EigenproblemError> {
        let slides = [&self.stiffness, &self.other].into_iter().find(|problem| problem.system.form.slides());
        if let Some(problem) = slides {
            return Err(EigenproblemError::Sliding { form: problem.system.form.name() });
        }
        let constraints = self.stiffness.all_constraints()?;
        let constraints = constraints.each_ref().map(|one| &**one);
        let mut elimination = Elimination::of(&constraints)?;
        for problem in [&mut self.stiffness, &mut self.other] {
            let shared = problem.share_cells();
            agreed(problem.communicator, problem.system.form.name(), shared)?;
            problem.agree_on_problem(&constraints)?;
            elimination = problem.divide(elimination)?;
        }
        let state = match self.about {
            Some(state) => {
                self.stiffness.check_spaces("state", state.map(|field| field.space()))?;
                state.iter().flat_map(|field| field.values()).copied().collect()
            }
            None => vec![0.0; self.stiffness.system.unknowns()],
        };
        if self.stiffness.communicator.is_some() {
            return self.above_on_processes(state, elimination, shift, count);
        }
        let asked = count;
        if elimination.free().is_empty() && asked > 0 {
            return Err(EigenproblemError::Eigen(EigenError::TooFew { asked, found: 0, shift }));
        }
        let first = elimination.reduce_matrix(&self.stiffness.tangent(&state)?.matrix)?;
        let mut second = elimination.reduce_matrix(&self.other.tangent(&state)?.matrix)?;
        if self.positive == Positive::First {
            second.values_mut().iter_mut().for_each(|entry| *entry = -*entry);
        }
        let groups = groups_of(&self.stiffness.system.spaces.each_ref(), &elimination);
        let left = LeftPencil::of(&first, &second, &groups)?;
        self.local_unknowns = left.as_ref().map(LeftPencil::counts);
        let matrices = left.as_ref().map_or((&first, &second), |left| (&left.first, &left.second));
        let pencil = SymmetricPencil::new(matrices.0, matrices.1, self.positive);
        let found = pencil.and_then(|pencil| pencil.eigenpairs_above(shift, count));
        let pairs = found.map_err(|error| {
            let error = left.as_ref().map_or(error.clone(), |left| left.of_all(error));
            self.named(error, &elimination)
        })?;
        let completed = |mut pair: Eigenpair| {
            if let Some(left) = &left {
                pair.vector = left.complete(&pair.vector)?;
            }
            self.mode(pair, &elimination)
        };
        pairs.into_iter().map(completed).collect()
    }

    fn mode(&self, pair: Eigenpair, elimination: &Elimination) -> Result<Eigenmode<D, N>, EigenproblemError> {
        let fields = self.stiffness.system.fields(&elimination.extend_by_zero(&pair.vector)?);
        let Eigenpair { value, error_bound, residual, .. } = pair;
        Ok(Eigenmode { value, fields, error_bound, residual })
    }

    /// The same, where each process has a part of the matrices.
    fn above_on_processes(
        &mut self,
        mut state: Vec<f64>,
        mut elimination: Elimination,
        shift: f64,
        count: usize,
    ) -> Result<Vec<Eigenmode<D, N>>, EigenproblemError> {
        let form = self.stiffness.system.form.name();
        let Some(all) = self.stiffness.communicator else { return Ok(vec![]) };
        let processes = Processes::new(Some(all), self.stiffness.divided.clone());
        if let Some(divided) = processes.divided() {
            let spread = divided.spread(&mut state);
            spread.map_err(|source| AssemblyError::Communication { form, source })?;
        }
        let solver = self.solver.take().ok_or(EigenproblemError::NoSolver)?;
        let reduced = (|| {
            let first = elimination.reduce_matrix(&self.stiffness.tangent(&state)?.matrix)?;
            let mut second = elimination.reduce_matrix(&self.other.tangent(&state)?.matrix)?;
            if self.positive == Positive::First {
                second.values_mut().iter_mut().for_each(|entry| *entry = -*entry);
            }
            Ok([first, second])
        })();
        let found = reduced.and_then(|matrices| {
            let (free, size) = (elimination.free(), self.stiffness.system.unknowns());
            let parts = ((all, &processes, form), (matrices, self.positive), (free, size));
            let pencil = PencilOfAll::new(parts.0, parts.1, parts.2, &mut *solver)?;
            eigenpairs_above(&pencil, shift, count)
        });
        self.solver = Some(solver);
        found?.into_iter().map(|pair| self.mode(pair, &elimination)).collect()
    }

    /// A shift that is an eigenvalue is reported with the unknown or the motion that is not determined.
    fn named(&self, error: EigenError, elimination: &Elimination) -> EigenproblemError {
        match error {
            EigenError::ShiftIsEigenvalue { shift, source } => {
                let why = self.stiffness.named(SolverError::LinearAlgebra(source), elimination);
                EigenproblemError::ShiftIsEigenvalue { shift, why }
            }
            error => EigenproblemError::Eigen(error),
        }
    }
}

instantiate!(
    eigenproblem:
    Eigenproblem::<D, 1>::of,
    Eigenproblem::<D, 1>::above,
    Eigenproblem::<D, 2>::of,
    Eigenproblem::<D, 2>::above,
);
