//! A compiled form with its spaces and constraints as a problem that solves itself.

mod affine;
pub mod agreement;
mod bounded;
mod deflated;
mod diagnosis;
mod equations;
mod free_bodies;
pub mod linear_problems;
mod positivity;
mod setting;
mod solution;
mod step;
mod switching;
mod touching_start;

use std::borrow::Cow;
use std::cell::OnceCell;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;

pub use self::linear_problems::LinearProblems;
pub use self::positivity::PositivityError;
use self::solution::{EachStep, Solver};
use super::communicator::Communicator;
use super::deflation::{Deflation, Repulsion};
use super::divided::DividedVectors;
use super::linear_and_nonlinear::SplitSystem;
use super::linear_part::{Assembled, System};
use super::{
    HeldUnknown, Increment, LinearSolver, LocalUnknowns, NewtonError, NewtonOptions, NewtonStep, PerUnknown,
    RigidLoads, Solved, StepMemory,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern};
use crate::bounds::Bounds;
use crate::constraints::Constraints;
use crate::contract::{Form, Functional};
use crate::field::Field;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

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
/// # let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?;
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
pub struct Problem<'a, const D: usize, const N: usize = 1> {
    pub(in crate::solve) system: System<'a, D, N>,
    pub(in crate::solve) constraints: Vec<Cow<'a, Constraints<D>>>,
    pub(in crate::solve) bounds: Vec<&'a Bounds<D>>,
    /// Functionals whose integrands are kept positive.
    pub(in crate::solve) positive: Vec<Functional<D>>,
    /// The points that switch, for the account of a failure.
    pub(in crate::solve) switches: switching::SwitchRecord<D>,
    /// The unknowns that the last solution has at bounds.
    pub(in crate::solve) held: Vec<HeldUnknown>,
    pub(in crate::solve) start: Option<[&'a Field<D>; N]>,
    /// The state from which a load step goes; the start is its prediction.
    pub(in crate::solve) last_state: Option<[&'a Field<D>; N]>,
    /// The load factor of that state, and of the step's end.
    pub(in crate::solve) factors: Option<[f64; 2]>,
    /// Known solutions, and the same as seen from the start.
    pub(in crate::solve) deflation: Option<Deflation<D, N>>,
    pub(in crate::solve) repulsion: Option<Repulsion>,
    /// Facets at which nonlinear integrals are expected to act.
    pub(in crate::solve) expected: Option<&'a str>,
    pub(in crate::solve) solver: Solver<'a>,
    pub(in crate::solve) options: NewtonOptions,
    pub(in crate::solve) progress: Option<EachStep<'a>>,
    pub(in crate::solve) communicator: Option<&'a dyn Communicator>,
    /// The division of vectors over all unknowns, if processes have pieces of the mesh.
    pub(in crate::solve) divided: Option<Rc<dyn DividedVectors>>,
    pub(in crate::solve) assembled: Option<Assembled>,
    /// Both parts, if pairs slide and the solver condenses.
    pub(in crate::solve) split: Option<SplitSystem<D>>,
    /// Spent in assembly so far.
    pub(in crate::solve) seconds: f64,
    /// The memory that earlier steps left.
    pub(in crate::solve) memory: StepMemory,
    /// Remarks of whoever made the problem.
    pub(in crate::solve) notes: Vec<String>,
}

/// The reason for which a problem was not solved, with the iterates up to it.
pub type SolveError = NewtonError;

impl<'a, const D: usize, const N: usize> Problem<'a, D, N> {
    /// The form on the space of its unknown, or on `[&first, &second]`, the spaces of its unknowns in the order of its
    /// arguments. Nothing is computed yet; [`Problem::solve`] reports what does not fit.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let problem = Problem::new(&form, &space);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new<'s>(form: &Form<D>, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        const { assert!(N > 0, "a problem has an unknown") };
        Self::on_spaces(form.clone(), spaces.per_unknown())
    }

    #[inline(never)]
    pub(in crate::solve) fn on_spaces(form: Form<D>, spaces: [&Arc<Space<D>>; N]) -> Self {
        let assembler = Cow::Owned(Assembler::new(spaces[0].mesh()));
        let spaces = spaces.map(Arc::clone);
        Problem {
            system: System {
                form,
                assembler,
                assembler_at: None,
                spaces,
                pattern: OnceCell::new(),
                loads: vec![],
            },
            constraints: vec![],
            bounds: vec![],
            positive: vec![],
            switches: switching::SwitchRecord::default(),
            held: vec![],
            start: None,
            last_state: None,
            factors: None,
            deflation: None,
            repulsion: None,
            expected: None,
            solver: Solver::Own(Box::default()),
            options: NewtonOptions::default(),
            progress: None,
            communicator: None,
            divided: None,
            assembled: None,
            split: None,
            seconds: 0.0,
            memory: StepMemory::default(),
            notes: vec![],
        }
    }

    /// Conditions on one unknown: the first one on the constraints' space that has none yet.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let u = Problem::new(&form, &space).constrained(&held).solve()?.into_field();
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn constrained(mut self, constraints: &'a Constraints<D>) -> Self {
        self.constraints.push(Cow::Borrowed(constraints));
        self
    }

    /// These constraints with zero for the prescribed values and the same relations, as for adjoint states and increments.
    pub fn homogeneous(mut self, constraints: &Constraints<D>) -> Self {
        self.constraints.push(Cow::Owned(constraints.homogeneous()));
        self
    }

    /// Forces and couples on rigid surfaces, on the first unknown on their space.
    pub fn loaded(mut self, loads: &'a RigidLoads<D>) -> Self {
        self.system.loads.push(loads);
        self
    }

    /// The quadrature rule, in place of one of the degree that the compiler estimates.
    pub fn quadrature(mut self, quadrature: Quadrature<D>) -> Self {
        self.system.assembler =
            Cow::Owned(self.system.assembler.as_ref().clone().with_quadrature(quadrature));
        self
    }

    /// The number of threads in place of all: of assembly, and of the problem's own linear solver with its ordering. A solver that is given
    /// has its own.
    pub fn threads(mut self, threads: Threads) -> Self {
        self.system.assembler = Cow::Owned(self.system.assembler.as_ref().clone().with_threads(threads));
        if let Solver::Own(solver) = &mut self.solver {
            **solver = LocalUnknowns::on(threads);
        }
        self
    }

    /// An assembler that was made for more than this problem, with its quadrature, its cells, and its threads, which the problem's own linear
    /// solver has then, too.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    /// let problem = Problem::new(&form, &space).assembler(&assembler);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn assembler(mut self, assembler: impl Into<Cow<'a, Assembler<D>>>) -> Self {
        self.system.assembler = assembler.into();
        if let Solver::Own(solver) = &mut self.solver {
            **solver = LocalUnknowns::on(self.system.assembler.threads());
        }
        self
    }

    /// A function that chooses the assembler of the nonlinear integrals by the iterate, as when facets are split where a scalar of the
    /// iterate changes its sign ([`Assembler::split_at_zeros`]). There is then no active set of fixed points in Newton's
    /// history. What no iterate changes is assembled as before.
    pub fn assembler_at(
        mut self,
        choose: impl Fn(&[Field<D>]) -> Result<Assembler<D>, AssemblyError> + 'a,
    ) -> Self {
        self.system.assembler_at = Some(Box::new(choose));
        self
    }

    /// A matrix pattern that was made for these spaces before ([`Problem::pattern`]). It must hold every entry of this form.
    pub fn with_pattern(mut self, pattern: &Arc<BlockPattern<D>>) -> Self {
        self.system.pattern = OnceCell::from(Arc::clone(pattern));
        self
    }

    /// The first iterate, on which the constraints are imposed; zero unless it is given.
    pub fn start(mut self, start: impl PerUnknown<'a, Field<D>, N>) -> Self {
        self.start = Some(start.per_unknown());
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
        self.start = Some(increment.start().per_unknown());
        self.last_state = Some(before);
        self.factors = Some([increment.from, increment.factor]);
        self
    }

    /// The linear solver, in place of a [`TangentSolver`](super::TangentSolver) of the problem's own. It keeps the last matrix and what it factored,
    /// for adjoint problems as well.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let mut solver = TangentSolver::default();
    /// Problem::new(&form, &space).constrained(&held).solver(&mut solver).solve()?;
    /// println!("{:?}", solver.report());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = Solver::Lent(solver);
        self
    }

    /// A facet region where the nonlinear integrals of this problem and of later ones with the same solver are likely to act: the facets
    /// that touch the ground in any position of a wheel that rolls, say. A [`CondensedSolver`](super::CondensedSolver) then begins with a
    /// factor that serves all of these problems, unless the region is so large that this does not pay. Results do not depend on it except
    /// for rounding, and other solvers do not use it.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("bottom", |_| 0.0)?;
    /// let mut solver = CondensedSolver::default();
    /// // One factor for all springs on the upper side.
    /// for stiffness in [1.0, 10.0, 100.0] {
    ///     let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) + v)
    ///         - integral(facets("top"), stiffness * neg_part(u) * v), stiffness: Param);
    ///     let problem = Problem::new(&form, &space).constrained(&held).expecting_changes_at("top");
    ///     problem.solver(&mut solver).solve()?;
    /// }
    /// assert_eq!(solver.report().factorisations, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn expecting_changes_at(mut self, facets: &'a str) -> Self {
        self.expected = Some(facets);
        self
    }

    /// Tolerances, number of steps and line search of Newton's method.
    pub fn options(mut self, options: NewtonOptions) -> Self {
        self.options = options;
        self
    }

    /// Is called with the start and each iterate.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let problem = Problem::new(&form, &space).constrained(&held);
    /// problem.each_step(|step| println!("{}: {:.1e}", step.iteration, step.residual)).solve()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn each_step(mut self, progress: impl FnMut(&NewtonStep) + 'a) -> Self {
        self.progress = Some(Box::new(progress));
        self
    }

    /// Remarks on the problem itself, as that a parameter is too small: [`Solved::notes`] and the error of a solve that fails repeat
    /// them.
    pub fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// Solution on several processes; each assembles the integrals over its part of the cells. The linear solver
    /// has to take matrices that are sums over the processes ([`LinearSolver::set_processes`]); another one is refused where there are
    /// several. So are problems that are not the same on all of them. On processes that have pieces of a mesh vectors are divided, too, and the
    /// fields of the solution are those of this process's piece.
    pub fn on(mut self, communicator: &'a dyn Communicator) -> Self {
        self.communicator = Some(communicator);
        // Each process has the positions of its own entries alone.
        self.system.pattern = OnceCell::new();
        self
    }

    /// The matrix pattern, for other forms on the same spaces.
    ///
    /// # Errors
    /// When the form has other unknowns than the spaces, a region does not exist, or the matrix is too large
    /// to be numbered.
    pub fn pattern(&self) -> Result<&Arc<BlockPattern<D>>, AssemblyError> {
        self.system.pattern()
    }

    /// Seconds spent in assembly so far.
    pub fn assembly_seconds(&self) -> f64 {
        self.seconds
    }

    /// The places among the values of the tangent that an update may change, as ascending ranges of whole blocks:
    /// those of the nodes that nonlinear integrals couple. An update takes a time proportional to their number and
    /// to that of the cells and facets of these integrals, whatever the size of the mesh.
    ///
    /// # Errors
    /// If assembly fails.
    pub fn changed_places(&mut self) -> Result<&[Range<usize>], AssemblyError> {
        Ok(&self.ready()?.1.touched.places)
    }
}

/// A form with the data of its solution.
#[doc(hidden)]
pub struct OwnedForm<'a, const D: usize> {
    pub form: Form<D>,
    pub assembler: &'a Assembler<D>,
    /// The pattern of an earlier solution on the same processes, if there is one.
    pub pattern: Option<&'a Arc<BlockPattern<D>>>,
    /// The processes that solve together.
    pub communicator: Option<&'a dyn Communicator>,
    /// Conditions, for each unknown.
    pub constraints: &'a [&'a Constraints<D>],
    /// The first iterate, a field for each unknown.
    pub start: &'a [&'a Field<D>],
    /// Functionals whose integrands are kept positive.
    pub positive: Vec<Functional<D>>,
    pub options: NewtonOptions,
}

/// The solution of an [`OwnedForm`].
#[doc(hidden)]
pub struct SolvedForm<const D: usize> {
    pub fields: Vec<Field<D>>,
    /// The pattern of the tangent, on several processes of this one's part.
    pub pattern: Option<Arc<BlockPattern<D>>>,
    pub residual: Vec<f64>,
    pub history: Vec<NewtonStep>,
}

/// The solution of a form with up to four unknowns, for callers that make one form after the other.
///
/// # Errors
/// As [`Problem::solve`]; [`AssemblyError::TooManyUnknowns`].
#[doc(hidden)]
pub fn solve_owned<const D: usize>(
    owned: OwnedForm<'_, D>,
    solver: &mut dyn LinearSolver,
    memory: &mut StepMemory,
) -> Result<SolvedForm<D>, SolveError> {
    match *owned.start {
        [one] => solve_on([one], owned, solver, memory),
        [one, two] => solve_on([one, two], owned, solver, memory),
        [one, two, three] => solve_on([one, two, three], owned, solver, memory),
        [one, two, three, four] => solve_on([one, two, three, four], owned, solver, memory),
        _ => Err(AssemblyError::TooManyUnknowns { form: owned.form.name(), most: 4 }.into()),
    }
}

fn solve_on<const D: usize, const N: usize>(
    start: [&Field<D>; N],
    owned: OwnedForm<'_, D>,
    solver: &mut dyn LinearSolver,
    memory: &mut StepMemory,
) -> Result<SolvedForm<D>, SolveError> {
    let OwnedForm { form, assembler, pattern, communicator, constraints, positive, options, .. } = owned;
    let mut problem: Problem<'_, D, N> = Problem::on_spaces(form, start.map(Field::space));
    problem.system.assembler = Cow::Borrowed(assembler);
    problem.communicator = communicator;
    problem.system.pattern = pattern.map_or_else(OnceCell::new, |known| OnceCell::from(Arc::clone(known)));
    problem.constraints.extend(constraints.iter().map(|constraints| Cow::Borrowed(*constraints)));
    problem.start = Some(start);
    problem.positive = positive;
    problem.solver = Solver::Lent(solver);
    problem.options = options;
    problem.memory = std::mem::take(memory);
    let solved = problem.solve();
    let pattern = problem.system.pattern.take();
    let matrix = problem.assembled.take().map(|assembled| assembled.matrix);
    *memory = StepMemory { matrix, ..std::mem::take(&mut problem.memory) };
    let Solved { fields, residual, history, .. } = solved?;
    Ok(SolvedForm { fields: fields.into(), pattern, residual, history })
}

#[cfg(test)]
mod tests;
