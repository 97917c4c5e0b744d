//! A compiled form with its spaces and constraints as a problem that solves itself.

mod affine;
mod agreement;
mod diagnosis;
mod equations;
mod free_bodies;
mod setting;
mod step;
mod touching_start;
mod untyped;

use std::borrow::Cow;
use std::cell::OnceCell;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::Form;

use self::untyped::Solver;
#[doc(hidden)]
pub use self::untyped::StepMemory;
pub(super) use self::untyped::UntypedProblem;
use super::any_form::{AnyForm, Held};
use super::communicator::Communicator;
use super::linear_part::Assembled;
use super::{
    ActivePoints, FieldUnknowns, Increment, LinearSolver, NewtonError, NewtonOptions, NewtonStep,
    NonlinearProblem, PartlyLinear, PerUnknown, Products, RigidLoads, Solved, Tangent,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern, Terms};
use crate::constraints::Constraints;
use crate::field::Field;
use crate::space::Space;

/// A form with N unknowns, each on its own space; test function k belongs to the space of unknown k. In
/// vectors and matrices the unknowns of the spaces follow one after the other.
///
/// A form that is affine in its unknowns is solved as one linear system; any other by semismooth Newton from zero, with the
/// constraints imposed. Everything else has a default: the quadrature, the linear solver, Newton's options.
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
/// let form = stokes::Model::default().flow();
/// let solved = Problem::new(&form, [&velocities, &pressures]).constrained(&walls).constrained(&level).solve()?;
/// let [u, p] = solved.fields;
/// # Ok(())
/// # }
/// ```
pub struct Problem<'a, F, const D: usize, const N: usize = 1> {
    untyped: UntypedProblem<'a, D, N>,
    form: PhantomData<&'a F>,
}

/// The reason for which a problem was not solved, with the iterates up to it.
pub type SolveError = NewtonError;

impl<'a, F: Form<D>, const D: usize, const N: usize> Problem<'a, F, D, N> {
    /// The form on the space of its unknown, or on `[&first, &second]`, the spaces of its unknowns in the order of its
    /// arguments. Nothing is computed yet; [`Problem::solve`] reports what does not fit.
    pub fn new<'s>(form: &'a F, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        Self::holding(Held::Lent(form), spaces)
    }

    /// The same with a form that the problem keeps.
    pub fn owning<'s>(form: F, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        Self::holding(Held::Own(Box::new(form)), spaces)
    }

    fn holding<'s>(form: Held<'a, D>, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        const { assert!(N > 0, "a problem has an unknown") };
        Problem { untyped: UntypedProblem::new(form, spaces.per_unknown()), form: PhantomData }
    }

    /// Conditions on one unknown: the first one on the constraints' space that has none yet.
    pub fn constrained(mut self, constraints: &'a Constraints<D>) -> Self {
        self.untyped.constraints.push(Cow::Borrowed(constraints));
        self
    }

    /// These constraints with zero for the prescribed values and the same relations, as for adjoint states and increments.
    pub fn vanishing(mut self, constraints: &Constraints<D>) -> Self {
        self.untyped.constraints.push(Cow::Owned(constraints.homogeneous()));
        self
    }

    /// Forces and couples on rigid surfaces, on the first unknown on their space.
    pub fn loaded(mut self, loads: &'a RigidLoads<D>) -> Self {
        self.untyped.system.loads.push(loads);
        self
    }

    /// Another assembler than the default one: for its quadrature, its threads, its cells.
    pub fn assembler(mut self, assembler: impl Into<Cow<'a, Assembler<D>>>) -> Self {
        self.untyped.system.assembler = assembler.into();
        self
    }

    /// Lets the iterate choose who assembles the nonlinear integrals, as when facets are split where a scalar of the
    /// iterate changes its sign ([`Assembler::split_at_zeros`]). There is then no active set of fixed points in Newton's
    /// history. What no iterate changes is assembled as before.
    pub fn assembler_at(
        mut self,
        choose: impl Fn(&[Field<D>]) -> Result<Assembler<D>, AssemblyError> + 'a,
    ) -> Self {
        self.untyped.system.assembler_at = Some(Box::new(choose));
        self
    }

    /// A matrix pattern that was made for these spaces before ([`Problem::pattern`]). It must hold every entry of this form.
    pub fn with_pattern(mut self, pattern: &Arc<BlockPattern<D>>) -> Self {
        self.untyped.system.pattern = OnceCell::from(Arc::clone(pattern));
        self
    }

    /// The first iterate, on which the constraints are imposed; zero unless it is given.
    pub fn start(mut self, start: impl PerUnknown<'a, Field<D>, N>) -> Self {
        self.untyped.start = Some(start.per_unknown());
        self
    }

    /// A load step of [`LoadSteps::advance`](super::LoadSteps::advance): Newton's method begins on the secant through the last two
    /// states, and from the last state where it fails from there. Afterwards the motion from the last state to the solution is
    /// followed for each pairing whose surfaces an unknown displaces, and a step that may have passed through is refused
    /// ([`Assembler::follow`]).
    pub fn increment<S>(mut self, increment: &'a Increment<'_, S>) -> Self
    where
        &'a S: PerUnknown<'a, Field<D>, N>,
    {
        let before = increment.before.per_unknown();
        self.untyped.start = Some(increment.start().per_unknown());
        self.untyped.last_state = Some(before);
        self
    }

    /// Another linear solver than a [`TangentSolver`](super::TangentSolver) of the problem's own. It keeps the last matrix and what it factored,
    /// for adjoint problems as well.
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.untyped.solver = Solver::Lent(solver);
        self
    }

    /// Tolerances, number of steps and line search of Newton's method.
    pub fn options(mut self, options: NewtonOptions) -> Self {
        self.untyped.options = options;
        self
    }

    /// Is called with the start and each iterate.
    pub fn each_step(mut self, progress: impl FnMut(&NewtonStep) + 'a) -> Self {
        self.untyped.progress = Some(Box::new(progress));
        self
    }

    /// Remarks on the problem itself, as that a parameter is too small: [`Solved::notes`] and the error of a solve that fails repeat
    /// them.
    pub fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.untyped.notes.extend(notes);
        self
    }

    /// Solves on several processes; each assembles the integrals over its part of the cells. The linear solver
    /// has to take matrices that are sums over the processes ([`LinearSolver::set_processes`]); another one is refused where there are
    /// several. So are problems that are not the same on all of them.
    pub fn on(mut self, communicator: &'a dyn Communicator) -> Self {
        self.untyped.communicator = Some(communicator);
        // Each process has the positions of its own entries alone.
        self.untyped.system.pattern = OnceCell::new();
        self
    }

    /// The matrix pattern, for other forms on the same spaces.
    ///
    /// # Errors
    /// When the form has other unknowns than the spaces, a region does not exist, or the matrix is too large
    /// to be numbered.
    pub fn pattern(&self) -> Result<&Arc<BlockPattern<D>>, AssemblyError> {
        self.untyped.system.pattern()
    }

    /// Seconds spent in assembly so far.
    pub fn assembly_seconds(&self) -> f64 {
        self.untyped.seconds
    }

    /// Solves the problem.
    ///
    /// # Errors
    /// [`SolveError`] with the reason, and of Newton's method the history and the last iterate.
    pub fn solve(&mut self) -> Result<Solved<D, N>, SolveError> {
        self.untyped.solve()
    }

    /// The places among the values of the tangent that an update may change, as ascending ranges of whole blocks:
    /// those of the nodes that nonlinear integrals couple. An update takes a time proportional to their number and
    /// to that of the cells and facets of these integrals, whatever the size of the mesh.
    ///
    /// # Errors
    /// If assembly fails.
    pub fn changed_places(&mut self) -> Result<&[Range<usize>], AssemblyError> {
        Ok(self.untyped.ready()?.1.touched())
    }
}

/// A form without its type, and what belongs to its solution.
#[doc(hidden)]
pub struct OwnedForm<'a, const D: usize> {
    pub form: Box<dyn AnyForm<D> + 'a>,
    pub assembler: &'a Assembler<D>,
    pub pattern: &'a Arc<BlockPattern<D>>,
    pub constraints: &'a Constraints<D>,
    pub start: &'a Field<D>,
    pub options: NewtonOptions,
}

/// The solution of a form without its type, for those who make one form after the other.
#[doc(hidden)]
pub fn solve_owned<const D: usize>(
    owned: OwnedForm<'_, D>,
    solver: &mut dyn LinearSolver,
    memory: &mut StepMemory,
) -> Result<Solved<D>, SolveError> {
    let OwnedForm { form, assembler, pattern, constraints, start, options } = owned;
    let mut untyped: UntypedProblem<'_, D, 1> = UntypedProblem::new(Held::Own(form), [start.space()]);
    untyped.system.assembler = Cow::Borrowed(assembler);
    untyped.system.pattern = OnceCell::from(Arc::clone(pattern));
    untyped.constraints.push(Cow::Borrowed(constraints));
    untyped.start = Some([start]);
    untyped.solver = Solver::Lent(solver);
    untyped.options = options;
    untyped.memory = std::mem::take(memory);
    let solved = untyped.solve();
    let matrix = untyped.assembled.take().map(Assembled::into_matrix);
    *memory = StepMemory { matrix, ..untyped.memory };
    solved
}

/// A problem as the system of equations that Newton's method solves.
impl<F: Form<D>, const D: usize, const N: usize> NonlinearProblem for Problem<'_, F, D, N> {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        self.untyped.residual(u)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        self.untyped.tangent(u)
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        self.untyped.active_points(u)
    }

    fn fields(&self) -> Vec<FieldUnknowns> {
        self.untyped.fields()
    }

    fn products(&mut self, u: &[f64], x: &[f64]) -> Result<Products, AssemblyError> {
        self.untyped.products(u, x)
    }

    fn sizes_of_terms(&mut self, u: &[f64], terms: Terms) -> Result<Option<Vec<f64>>, AssemblyError> {
        self.untyped.sizes_of_terms(u, terms)
    }

    fn partly_linear(&mut self) -> Option<&mut dyn PartlyLinear> {
        self.untyped.partly_linear()
    }
}
