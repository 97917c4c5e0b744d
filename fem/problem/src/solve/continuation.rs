//! Continuation of a branch of solutions: pseudo-arclength through limit points, bifurcations, other branches.

mod arc;
mod bordered_solver;
mod branch;
mod events;
mod family;
mod inertia;
mod kinks;
mod metric;
mod of_forms;
mod points;
mod start;
mod tracing;
mod turns;

use std::borrow::Cow;
use std::error::Error;
use std::ops::RangeInclusive;
use std::sync::Arc;

pub use branch::{Branch, BranchEnd, BranchEvent, BranchPoint, ContinuationError, ContinuationFailure};
pub use events::EventKind;
use family::Next;
pub use inertia::Inertia;
use of_forms::Forms;
use start::Origin;
use tracing::Steps;

use super::problem::Problem;
use super::{NewtonOptions, PerUnknown, Solved, TangentSolverOptions};
use crate::assemble::Assembler;
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::field::Field;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

/// A form with a parameter λ, and the branch of its solutions (u(s), λ(s)) that is followed by its length s.
///
/// A closure gives the form and its derivative with respect to the parameter, `derivative(balance(u, v), load, 1)`, at each λ. Newton's
/// method solves for u and λ together on a plane across the branch, with one factorisation of the tangent per iterate, so that the branch goes
/// on through limit points. Points in contact may switch in each step. A step that fails is halved; after two that succeed it doubles, as
/// in [`LoadSteps`](super::LoadSteps), up to the largest one.
///
/// *Limit points* are where dλ/ds changes its sign. *Bifurcations* are where eigenvalues of the tangent do, besides: the count of negative
/// ones of a symmetric tangent, the determinant's sign of another. Both are located. Two that fall into one step and cancel each other
/// are not seen: the largest step bounds what may be missed.
///
/// ```
/// # use forms_fem::prelude::*;
/// use forms_fem::solve::Continuation;
///
/// #[forms(dimension = 2)]
/// mod reaction {
///     pub struct Data {
///         pub rate: Param,
///     }
///     #[cells]
///     pub struct Omega;
///     pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         integral(Omega, dot(grad(u), grad(v)) - rate * exp(u) * v)
///     }
///     pub fn by_rate(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         derivative(balance(u, v), rate, 1)
///     }
/// }
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mesh = rectangle([0.0; 2], [1.0; 2], [6, 6], CellShape::Quadrilateral, 1)?;
/// let space = Space::scalar(&mesh, 2)?;
/// let mut rim = Constraints::new(&space);
/// rim.fix("boundary", |_| 0.0)?;
/// let forms = |rate: f64| {
///     let model = reaction::Model::new(reaction::data().rate(rate));
///     [model.balance(), model.by_rate()]
/// };
/// let branch = Continuation::new(&space, forms)
///     .constrained(&rim)
///     .step(1.0)
///     .points(20)
///     .run(|_, solved| Ok(solved.field().evaluate(&[0.5, 0.5])?[0]))?;
/// // Bratu's problem on the square has two solutions below 6.808124, and none above.
/// let limit = branch.limit_points().next().ok_or("it has one")?;
/// assert!((limit.parameter - 6.808124).abs() < 2e-3, "{}", limit.parameter);
/// # Ok(())
/// # }
/// ```
pub struct Continuation<'a, const D: usize, const N: usize = 1> {
    problem: Problem<'a, D, N>,
    forms: Forms<'a, D>,
    origin: Origin<'a, D, N>,
    step: f64,
    steps: Steps,
    until: Option<Until<'a, D, N>>,
    solver: TangentSolverOptions,
    options: NewtonOptions,
}

/// A condition on λ and the solution there.
type Until<'a, const D: usize, const N: usize> = Box<dyn FnMut(f64, &Solved<D, N>) -> bool + 'a>;

/// Most Newton steps at a point: more say that the step is too long.
const ITERATIONS: usize = 20;

impl<'a, const D: usize, const N: usize> Continuation<'a, D, N> {
    /// The space of the unknown, or `[&first, &second]`, and a closure that gives the form and its derivative with respect to λ, which have
    /// the same unknowns and test functions. The branch begins at λ = 0 next to u = 0, and λ first grows by one.
    pub fn new<'s>(
        spaces: impl PerUnknown<'s, Arc<Space<D>>, N>,
        forms: impl Fn(f64) -> [Form<D>; 2] + 'a,
    ) -> Self {
        const { assert!(N > 0, "a problem has an unknown") };
        Self::of_boxed(spaces.per_unknown(), Box::new(forms))
    }

    #[inline(never)]
    fn of_boxed(spaces: [&Arc<Space<D>>; N], forms: Forms<'a, D>) -> Self {
        let [form, _] = forms(0.0);
        Continuation {
            problem: Problem::on_spaces(form, spaces),
            forms,
            origin: Origin::Parameter { value: 0.0, start: None },
            step: 1.0,
            steps: Steps {
                smallest: 1.0 / 1024.0,
                largest: 4.0,
                points: 100,
                range: f64::NEG_INFINITY..=f64::INFINITY,
            },
            until: None,
            solver: TangentSolverOptions::default(),
            options: NewtonOptions { max_iterations: ITERATIONS, ..NewtonOptions::default() },
        }
    }

    /// Conditions on one unknown: the first one on the constraints' space that has none yet. They do not depend on λ.
    pub fn constrained(mut self, constraints: &'a Constraints<D>) -> Self {
        self.problem.constraints.push(Cow::Borrowed(constraints));
        self
    }

    /// The value of λ at the first point, where the solution is found by Newton's method; zero unless it is given.
    pub fn from(mut self, parameter: f64) -> Self {
        self.origin = match self.origin {
            Origin::Parameter { start, .. } => Origin::Parameter { value: parameter, start },
            Origin::Bifurcation { .. } => Origin::Parameter { value: parameter, start: None },
        };
        self
    }

    /// The start of Newton's method at the first point; zero unless it is given.
    pub fn start(mut self, start: impl PerUnknown<'a, Field<D>, N>) -> Self {
        let start = Some(start.per_unknown());
        self.origin = match self.origin {
            Origin::Parameter { value, .. } => Origin::Parameter { value, start },
            Origin::Bifurcation { .. } => Origin::Parameter { value: 0.0, start },
        };
        self
    }

    /// A start on another branch at a bifurcation, in the direction of a null vector (numbered from 0) there. `amplitude` is the largest
    /// change of an unknown up to the first point; its sign chooses the half of the branch.
    pub fn switched(mut self, event: &'a BranchEvent<D, N>, mode: usize, amplitude: f64) -> Self {
        self.origin = Origin::Bifurcation { event, mode, amplitude };
        self
    }

    /// The first change of λ, whose sign is the direction; one unless it is given. On another branch it is only the size of
    /// changes of λ.
    pub fn step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// The smallest and the largest step as multiples of the first one; 1/1024 and 4 unless they are given.
    pub fn between_steps(mut self, smallest: f64, largest: f64) -> Self {
        (self.steps.smallest, self.steps.largest) = (smallest, largest);
        self
    }

    /// The most points; 100 unless it is given.
    pub fn points(mut self, count: usize) -> Self {
        self.steps.points = count;
        self
    }

    /// The range of λ in which the branch is followed. Its last point is at the end of the range that it comes to.
    pub fn within(mut self, range: RangeInclusive<f64>) -> Self {
        self.steps.range = range;
        self
    }

    /// A condition after which the branch ends.
    pub fn until(mut self, condition: impl FnMut(f64, &Solved<D, N>) -> bool + 'a) -> Self {
        self.until = Some(Box::new(condition));
        self
    }

    /// The quadrature rule, in place of one of the degree that the compiler estimates.
    pub fn quadrature(mut self, quadrature: Quadrature<D>) -> Self {
        self.problem = self.problem.quadrature(quadrature);
        self
    }

    /// An assembler that was made before, with its quadrature, its threads, its cells.
    pub fn assembler(mut self, assembler: impl Into<Cow<'a, Assembler<D>>>) -> Self {
        self.problem = self.problem.assembler(assembler);
        self.solver.threads = self.problem.system.assembler.threads();
        self
    }

    /// The number of threads of assembly and factorisation, in place of all.
    pub fn threads(mut self, threads: Threads) -> Self {
        self.problem = self.problem.threads(threads);
        self.solver.threads = threads;
        self
    }

    /// Tolerances and number of steps of Newton's method at each point; at most 20 steps unless they are given.
    pub fn options(mut self, options: NewtonOptions) -> Self {
        self.options = options;
        self
    }

    /// The branch, with what `measure(λ, solution)` returns at each of its points.
    ///
    /// # Errors
    /// [`ContinuationError`] with the reason and the branch so far.
    pub fn run<M>(
        mut self,
        mut measure: impl FnMut(f64, &Solved<D, N>) -> Result<M, Box<dyn Error + Send + Sync>>,
    ) -> Result<Branch<M, D, N>, ContinuationError<M, D, N>> {
        let mut until = self.until.take();
        let mut measured = |parameter: f64, solved: &Solved<D, N>| {
            let measured = measure(parameter, solved)?;
            let stops = until.as_mut().is_some_and(|until| until(parameter, solved));
            Ok((measured, if stops { Next::Stop } else { Next::GoOn }))
        };
        self.trace(&mut measured)
    }
}

#[cfg(test)]
mod tests;
