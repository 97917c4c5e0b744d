//! A compiled form with its spaces and constraints as a problem that solves itself.

mod affine;
mod diagnosis;
mod equations;
mod form_equations;
mod setting;

use std::borrow::Cow;
use std::cell::OnceCell;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use forms_core::contract::Form;

use self::form_equations::{FormEquations, newton_for_form};
use super::apart::Apart;
use super::communicator::Communicator;
use super::linear_part::{Assembled, Held, System};
use super::{
    Elimination, LinearSolver, NewtonError, NewtonFailure, NewtonOptions, NewtonStep, PerUnknown, Solved,
    Start, TangentSolver,
};
use crate::assemble::{Assembler, AssemblyError, BlockPattern};
use crate::constraints::Constraints;
use crate::field::Field;
use crate::history::commits;
use crate::space::Space;

/// A form with N unknowns, each on its own space; test function k belongs to the space of unknown k. In
/// vectors and matrices the unknowns of the spaces stand one after the other.
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
    system: System<'a, F, D, N>,
    constraints: Vec<Cow<'a, Constraints<D>>>,
    start: Option<[&'a Field<D>; N]>,
    solver: Solver<'a>,
    options: NewtonOptions,
    progress: Option<EachStep<'a>>,
    communicator: Option<&'a dyn Communicator>,
    assembled: Option<Assembled>,
    /// Where pairs slide and the solver condenses.
    apart: Option<Apart<D>>,
    seconds: f64,
}

/// The problem's own linear solver, or one that is lent to it.
enum Solver<'a> {
    Own(Box<TangentSolver>),
    Lent(&'a mut dyn LinearSolver),
}

impl Solver<'_> {
    fn get(&mut self) -> &mut dyn LinearSolver {
        match self {
            Solver::Own(solver) => &mut **solver,
            Solver::Lent(solver) => &mut **solver,
        }
    }
}

/// Is called with the start and each iterate.
type EachStep<'a> = Box<dyn FnMut(&NewtonStep) + 'a>;

/// The reason for which a problem was not solved, with the iterates up to it.
pub type SolveError = NewtonError<AssemblyError>;

impl<'a, F: Form<D>, const D: usize, const N: usize> Problem<'a, F, D, N> {
    /// The form on the space of its unknown, or on `[&first, &second]`, the spaces of its unknowns in the order of its
    /// arguments. Nothing is computed yet; what does not fit is told by [`Problem::solve`].
    pub fn new<'s>(form: &'a F, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        Self::holding(Held::Lent(form), spaces)
    }

    /// The same with a form that the problem keeps.
    pub fn owning<'s>(form: F, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        Self::holding(Held::Own(form), spaces)
    }

    fn holding<'s>(form: Held<'a, F>, spaces: impl PerUnknown<'s, Arc<Space<D>>, N>) -> Self {
        const { assert!(N > 0, "a problem has an unknown") };
        let spaces = spaces.per_unknown().map(Arc::clone);
        let assembler = Cow::Owned(Assembler::new(spaces[0].mesh()));
        let system = System { form, assembler, assembler_at: None, spaces, pattern: OnceCell::new() };
        Problem {
            system,
            constraints: vec![],
            start: None,
            solver: Solver::Own(Box::default()),
            options: NewtonOptions::default(),
            progress: None,
            communicator: None,
            assembled: None,
            apart: None,
            seconds: 0.0,
        }
    }

    /// Conditions on one unknown: the first one on the constraints' space that has none yet.
    pub fn constrained(mut self, constraints: &'a Constraints<D>) -> Self {
        self.constraints.push(Cow::Borrowed(constraints));
        self
    }

    /// These constraints with zero for the prescribed values and the same relations, as for adjoint states and increments.
    pub fn vanishing(mut self, constraints: &Constraints<D>) -> Self {
        self.constraints.push(Cow::Owned(constraints.homogeneous()));
        self
    }

    /// Another assembler than the default one: for its quadrature, its threads, its cells.
    pub fn assembler(mut self, assembler: impl Into<Cow<'a, Assembler<D>>>) -> Self {
        self.system.assembler = assembler.into();
        self
    }

    /// Lets the iterate choose who assembles the nonlinear integrals, as when facets are split where a scalar of the
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

    /// Another linear solver than a [`TangentSolver`] of the problem's own. It keeps the last matrix and what it factored,
    /// for adjoint problems as well.
    pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
        self.solver = Solver::Lent(solver);
        self
    }

    /// Tolerances, number of steps and line search of Newton's method.
    pub fn options(mut self, options: NewtonOptions) -> Self {
        self.options = options;
        self
    }

    /// Is called with the start and each iterate.
    pub fn each_step(mut self, progress: impl FnMut(&NewtonStep) + 'a) -> Self {
        self.progress = Some(Box::new(progress));
        self
    }

    /// Solves on several processes, each of which assembles the integrals over its part of the cells. The linear solver
    /// has to take matrices that are sums over the processes.
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

    /// Solves the problem.
    ///
    /// # Errors
    /// [`SolveError`] with the reason, and of Newton's method the history and the last iterate.
    pub fn solve(&mut self) -> Result<Solved<D, N>, SolveError> {
        let begun = Instant::now();
        self.share_cells()?;
        let constraints = self.all_constraints()?;
        let constraints = constraints.each_ref().map(|one| &**one);
        let elimination = Elimination::of(&constraints).map_err(NewtonFailure::Mismatch)?;
        let mut solver = std::mem::replace(&mut self.solver, Solver::Own(Box::default()));
        let found = match affine::is_affine(&*self.system.form) {
            true => self.solve_affine(elimination, solver.get()),
            false => self.iterate(elimination, constraints, solver.get()),
        };
        let report = solver.get().report();
        self.solver = solver;
        let (u, residual, history) = found?;
        Ok(Solved {
            fields: self.system.fields(&u),
            history,
            residual,
            report,
            assembly_seconds: self.seconds,
            seconds: begun.elapsed().as_secs_f64(),
            pairs: self.system.pairs(&u)?,
            assembler: self.system.assembler.clone().into_owned(),
        })
    }

    /// Semismooth Newton from the start.
    fn iterate(
        &mut self,
        elimination: Elimination,
        constraints: [&Constraints<D>; N],
        solver: &mut dyn LinearSolver,
    ) -> Result<Found, SolveError> {
        let u: Vec<f64> = match self.start {
            Some(start) => {
                self.check_spaces("start", start.map(|field| field.space()))?;
                start.iter().flat_map(|field| field.values()).copied().collect()
            }
            None => vec![0.0; self.system.unknowns()],
        };
        let guess = self.extrapolate_prescribed(&u, constraints);
        self.apart = None;
        let options = self.options.clone();
        let mut progress = self.progress.take();
        let mut ignored = |_: &NewtonStep| ();
        let told: &mut dyn FnMut(&NewtonStep) = match &mut progress {
            Some(progress) => &mut **progress,
            None => &mut ignored,
        };
        let start = Start { u, guess };
        let found = newton_for_form(&mut FormEquations(self), elimination, start, solver, &options, told);
        self.progress = progress;
        let found = found.map_err(|mut error| {
            if let NewtonFailure::LinearSolver(source) = error.why {
                let named = match Elimination::of(&constraints) {
                    Ok(elimination) => self.named(source, &elimination),
                    Err(_) => source,
                };
                error.why = NewtonFailure::LinearSolver(named);
            }
            error.notes = self.lost_pairs(&error.u);
            error
        })?;
        Ok((found.u, found.residual, found.history))
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

/// u, R(u) and the history.
type Found = (Vec<f64>, Vec<f64>, Vec<NewtonStep>);
