//! Newton's options, iterates, solution and failures.

use std::fmt;

use super::bounded::{BoundFailure, HeldUnknown};
use super::line_search::LineSearch;
#[cfg(doc)]
use super::newton;
use super::oscillation::Oscillation;
use crate::assemble::AssemblyError;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::communicator::CommunicationError;
use crate::solve::linear_solver::SolverError;

/// The end of Newton's method: its tolerances, and whether steps are shortened on the way.
///
/// An iterate is the solution when
///
/// 1. every equation holds next to the terms that it is made of: |R_i| ≤ `relative_tolerance` × S_i + rounding in each free row i, where
///    S_i is the sum of the amounts that cells and facets contribute to the row, and rounding is 10³ε Σ_j |K_ij u_j|
///    (Arioli, Demmel and Duff 1989), and
/// 2. the correction that is still to be expected, −K⁻¹R with the last tangent, is at most 100 `relative_tolerance` of the variation of
///    each component of each field (Deuflhard 2011).
///
/// Neither depends on the start, nor on how far the residual has dropped. An iterate that meets the first condition only is corrected.
/// If corrections do not become shorter, they are what rounding makes of the solution: it is accepted up to 10⁻⁶ of the largest
/// value of the component, and refused beyond ([`NewtonFailure::Uncertain`]).
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Tolerance of residuals and corrections, as above.
    pub relative_tolerance: f64,
    /// Converged in any case at ‖R‖₂ ≤ `absolute_tolerance` over all fields \[unit of R\]. Zero, the default, leaves it to the rows.
    pub absolute_tolerance: f64,
    /// Most steps.
    pub max_iterations: usize,
    /// Whether steps are shortened where a whole one is too long.
    pub line_search: LineSearch,
    /// The way to prescribed values that differ from the start.
    pub prescribed_values: PrescribedValues,
}

/// The way to prescribed values that differ from the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PrescribedValues {
    /// They are imposed on the start, with all else as it was. Where nothing can be computed there, or what is kept positive is not so, first steps
    /// take them along, and are shortened like all others.
    #[default]
    AtOnce,
    /// The first step takes them along: K(u₀) δ = −R(u₀) with the prescribed part of δ, so that the body follows. Where few nodes are moved by as
    /// much as a cell, it saves the steps that repair the cells next to them. Where contact is searched for, [`PrescribedValues::AtOnce`] is
    /// the better choice. If nothing can be computed after that step, they are imposed at once.
    ByTangent,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            relative_tolerance: 1e-10,
            absolute_tolerance: 0.0,
            max_iterations: 50,
            line_search: LineSearch::Off,
            prescribed_values: PrescribedValues::AtOnce,
        }
    }
}

/// One iterate in Newton's history, and the step that led to it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NewtonStep {
    /// 0 for the start.
    pub iteration: usize,
    /// ‖R‖₂ on free unknowns \[unit of R\].
    pub residual: f64,
    /// Residual divided by the residual at the start (0 if that is 0).
    pub relative_residual: f64,
    /// ‖R‖₂ of each field, in the order of the form's unknowns.
    pub field_residuals: Vec<f64>,
    /// Number of active quadrature points at this iterate.
    pub active_points: Option<usize>,
    /// Whether the active set differs from that of the iterate before.
    pub active_set_changed: Option<bool>,
    /// ‖δu‖₂ of the step that led here; none at the start.
    pub step: Option<f64>,
    /// Krylov iterations of that step (0 for a direct solution).
    pub linear_iterations: Option<usize>,
    /// The part of the Newton step that was taken: 1 unless a line search shortened it.
    pub damping: Option<f64>,
    /// Unknowns of the system of that step, where it was condensed to those that the nonlinearity touches.
    pub condensed_unknowns: Option<usize>,
    /// Unknowns that are held at bounds at this iterate, where there are bounds.
    pub held_unknowns: Option<usize>,
}

impl NewtonStep {
    /// The start of an iteration, with ‖R‖₂ there.
    pub fn start(residual: f64) -> Self {
        NewtonStep {
            iteration: 0,
            residual,
            relative_residual: if residual == 0.0 { 0.0 } else { 1.0 },
            field_residuals: vec![residual],
            active_points: None,
            active_set_changed: None,
            step: None,
            linear_iterations: None,
            damping: None,
            condensed_unknowns: None,
            held_unknowns: None,
        }
    }
}

/// The solution and how it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonSolution {
    /// All unknowns, with the prescribed values.
    pub u: Vec<f64>,
    /// R(u) on all unknowns: the reactions on the prescribed ones, about zero on the others.
    pub residual: Vec<f64>,
    /// The start and each iterate.
    pub history: Vec<NewtonStep>,
    /// The unknowns at their bounds, ascending.
    pub held: Vec<HeldUnknown>,
}

impl NewtonSolution {
    /// Number of Newton steps.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }
}

/// A reason why Newton's method failed.
#[derive(Debug, thiserror::Error)]
pub enum NewtonFailure {
    /// The iterations are used up.
    #[error("no convergence within {iterations} iterations")]
    NotConverged {
        /// Steps made.
        iterations: usize,
    },
    /// An earlier iterate came back: its residual again and again, or once with its active set.
    /// [`LineSearch::OnResidual`] often helps.
    #[error(
        "it repeats itself: iteration {first} came back after {period} more, with the same residual; \
         shorter steps may help (LineSearch::OnResidual)"
    )]
    Cycling {
        /// Iterate that was reached again.
        first: usize,
        /// Steps in between.
        period: usize,
    },
    /// Iterates came back with the set of unknowns that bounds hold, and the tangent is not symmetric, so that there is no potential to go
    /// along.
    #[error(
        "the unknowns that bounds hold repeat themselves: those of iteration {first} came back after {period} more, and the tangent \
         is not symmetric; LineSearch::OnResidual or a nearer start may help"
    )]
    BoundsCycle {
        /// Iterate that was reached again.
        first: usize,
        /// Steps in between.
        period: usize,
        /// Unknowns that the last iterate holds or frees.
        unknowns: Vec<usize>,
    },
    /// A bound that does not fit its unknown.
    #[error("the bounds of unknown {unknown} cannot be kept: {why}")]
    Bounds {
        /// Its number among all.
        unknown: usize,
        /// The reason.
        why: BoundFailure,
    },
    /// Steps hardly change u any more, but the residual is above the tolerance, and above the rounding of the forces that
    /// balance in it: it cannot be computed any better, or the tangent is not its derivative.
    #[error(
        "the residual stagnates above the tolerance, though steps are small: it is not computed more accurately, or the \
         tangent is not its derivative"
    )]
    Stagnated,
    /// All equations hold up to rounding, but rounding moves the solution by more than 10⁻⁶ of itself: the problem is too
    /// ill-conditioned, as where a stiff part is held by a much softer one.
    #[error(
        "every equation holds up to rounding, but rounding moves the solution by {part:.1e} of itself: the problem is too \
         ill-conditioned for double precision, as where a stiff part is held by a much softer one"
    )]
    Uncertain {
        /// The last correction as a part of the largest value of its component.
        part: f64,
    },
    /// The solution is one that was to be avoided.
    #[error(
        "the solution is the known one number {number} (numbered from 0), though it was deflated: perhaps there is no other one,          or another start or radius finds it"
    )]
    KnownSolution {
        /// Its number among the known ones.
        number: usize,
    },
    /// Newton's method starts at a solution that is to be avoided.
    #[error(
        "the start is the known solution number {number} (numbered from 0): give another start (`Problem::start`)"
    )]
    StartsAtKnownSolution {
        /// Its number among the known ones.
        number: usize,
    },
    /// The start is not one: what is to be kept positive is not so there.
    #[error("the start itself is not feasible: {0}")]
    InfeasibleStart(#[source] AssemblyError),
    /// What is to be kept positive is so at the start, but not with the prescribed values on it.
    #[error("the start is feasible, but not with the prescribed values imposed on it: {0}")]
    InfeasibleConditions(#[source] AssemblyError),
    /// The residual became NaN or infinite.
    #[error("the residual is not finite")]
    NotFinite,
    /// A line search on the potential was asked for, but an unsymmetric tangent has no potential.
    #[error(
        "a line search on the potential needs one, but the tangent is not symmetric (asymmetry {asymmetry:e}); \
         LineSearch::OnResidual needs none"
    )]
    NoPotential {
        /// [`BlockMatrix::asymmetry`](crate::linear_algebra::BlockMatrix::asymmetry) of the tangent.
        asymmetry: f64,
    },
    /// No step along a descent direction, however short, lowers the potential, or gives a finite residual.
    #[error("the line search found no step that it could take")]
    NoDescent,
    /// The linear solver failed.
    #[error("the linear solver failed: {0}")]
    LinearSolver(#[from] SolverError),
    /// Sizes disagree, or prescribed values are unfit.
    #[error("the problem does not fit together: {0}")]
    Mismatch(#[from] LinearAlgebraError),
    /// The solution of a load step is one that it cannot have led to, as that surfaces went through each other.
    #[error("the solution of the step is refused: {0}")]
    Refused(#[source] AssemblyError),
    /// An exchange between processes failed.
    #[error(transparent)]
    Exchange(#[from] CommunicationError),
    /// Assembly of the residual, the tangent or the active set failed.
    #[error("assembly failed: {0}")]
    Assembly(#[from] AssemblyError),
}

/// The equation that is off by the most of its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstEquation {
    /// Its unknown among all.
    pub unknown: usize,
    /// |R_i| as a part of the size of the terms in the row.
    pub off: f64,
}

/// A failure of Newton's method with the history up to it.
///
/// The last iterate is in `u`, all unknowns of the first space, then those of the second, and so on: to look at where the iteration went,
/// or to go on from there. It is empty where the problem was not assembled at all.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?;
/// let space = Space::scalar(&mesh, 1)?;
/// let mut walls = Constraints::new(&space);
/// walls.fix("boundary", |_| 0.0)?;
/// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| {
///     integral(cells("all"), (1.0 + 10.0 * u * u) * dot(grad(u), grad(v)) - 50.0 * v)
/// });
/// let options = NewtonOptions { max_iterations: 3, ..NewtonOptions::default() };
/// let Err(error) = Problem::new(&form, &space).constrained(&walls).options(options).solve() else {
///     panic!("three steps are too few here");
/// };
/// assert_eq!(error.history.len(), 4); // the start and three iterates
///
/// // A field again: for a picture, a file, or as the start of a further attempt.
/// let last = Field::from_values(&space, error.u)?;
/// let solved = Problem::new(&form, &space).constrained(&walls).start(&last).solve()?;
/// assert!(solved.field().evaluate(&[0.5, 0.5])?[0] > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(thiserror::Error)]
#[error("{}: {why}{}", stage(history), and(notes))]
pub struct NewtonError {
    /// The reason.
    pub why: NewtonFailure,
    /// The iterates before the failure.
    pub history: Vec<NewtonStep>,
    /// The last iterate: all unknowns, space after space, with the prescribed values ([`Field::from_values`](crate::field::Field::from_values)).
    pub u: Vec<f64>,
    /// The equation that held worst at the last iterate that was judged, if one did not hold.
    pub worst: Option<Box<WorstEquation>>,
    /// The points that switched back and forth, where a law of the form has branches and its points have places on the undeformed mesh.
    pub oscillation: Option<Box<Oscillation>>,
    /// Remarks of the problem, as that points of sliding pairs have lost each other.
    pub notes: Vec<String>,
}

fn and(notes: &[String]) -> String {
    notes.iter().map(|note| format!("; {note}")).collect()
}

/// The stage of a failure: without an iterate there was no Newton's method yet, as in an affine problem.
fn stage(history: &[NewtonStep]) -> String {
    match history.len() {
        0 => "the problem was not solved".to_owned(),
        count => format!("Newton's method failed at iteration {}", count - 1),
    }
}

impl From<NewtonFailure> for NewtonError {
    fn from(why: NewtonFailure) -> Self {
        NewtonError { why, history: vec![], u: vec![], worst: None, oscillation: None, notes: vec![] }
    }
}

impl From<AssemblyError> for NewtonError {
    fn from(error: AssemblyError) -> Self {
        NewtonFailure::Assembly(error).into()
    }
}

impl From<SolverError> for NewtonError {
    fn from(error: SolverError) -> Self {
        NewtonFailure::LinearSolver(error).into()
    }
}

/// Iterates that [`NewtonError`] prints.
const PRINTED: usize = 6;

/// Fields whose residuals are in the line of an iterate.
const SHOWN_FIELDS: usize = 6;

// It is what `main` prints of an error that it returns: lines for a reader, not every unknown and every field.
impl fmt::Debug for NewtonError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")?;
        let earlier = self.history.len().saturating_sub(PRINTED);
        if !self.history.is_empty() {
            write!(
                f,
                "\n{:>9}  {:>11}  {:>11}  {:>7}  {:>13}",
                "iteration", "residual", "step", "damping", "active points"
            )?;
        }
        if earlier > 0 {
            write!(f, "\n{:>9}  ({earlier} before)", "...")?;
        }
        for step in &self.history[earlier..] {
            write!(f, "\n{step}")?;
        }
        if let Some(oscillation) = &self.oscillation {
            write!(f, "\n{oscillation}")?;
        }
        write!(f, "\n{} unknowns", self.u.len())
    }
}

impl fmt::Display for NewtonStep {
    /// One line of a table: iteration, residual, step, damping, active points, and the residuals of several fields.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.4e}"));
        let damping = self.damping.map_or_else(|| "-".to_owned(), |damping| format!("{damping:.4}"));
        let active = self.active_points.map_or_else(|| "-".to_owned(), |count| count.to_string());
        let (residual, step) = (shown(Some(self.residual)), shown(self.step));
        write!(f, "{:>9}  {residual:>11}  {step:>11}  {damping:>7}  {active:>13}", self.iteration)?;
        if self.field_residuals.len() > 1 {
            let shown = self.field_residuals.iter().take(SHOWN_FIELDS).map(|value| format!("{value:.3e}"));
            write!(f, "  by field {}", shown.collect::<Vec<_>>().join(", "))?;
        }
        if self.field_residuals.len() > SHOWN_FIELDS {
            write!(f, ", ...")?;
        }
        Ok(())
    }
}
