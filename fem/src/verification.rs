//! Taylor tests of derivatives: f(t) − f(0) − t f′(0) falls with t² if f′(0) is right, and with t if it is not. Where f is
//! affine along the direction (a linear form, or a piecewise linear one between its kinks) it is rounding from the start,
//! which a wrong f′(0) could not bring about.
//!
//! A form's tangent is tested by [`tangent`], a derivative of a number that is computed again for each step (through an
//! adjoint state, by a parameter or by data) by [`taylor`], one by the shape of the domain by [`shape`]. Where a form has
//! kinks the expansion holds only as long as no quadrature point crosses one. A test gets the points that are "on"
//! ([`Assembler::active_set`]), halves its step until they are those of the start, and its report says where they were not.
//!
//! ```
//! use forms_fem::prelude::*;
//! use forms_fem::verification;
//!
//! #[forms(dimension = 2)]
//! mod spring {
//!     #[cells]
//!     pub struct Omega;
//!     pub fn stored(u: Unknown<Scalar>) -> Energy {
//!         integral(Omega, dot(grad(u), grad(u)) / 2 + exp(u) + pos_part(u - 1) * u)
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?;
//! let space = Space::scalar(&mesh, 2)?;
//! let u = Field::interpolate(&space, |x| 1.5 * x[0] + x[1] * x[1])?;
//! let direction = Field::interpolate(&space, |x| (3.0 * x[0] - x[1]).sin())?;
//! let form = spring::Model::default().stored();
//!
//! let report = verification::tangent(&Assembler::new(&mesh), &form, &[&u], &[&direction], 1.0)?;
//! println!("{report}"); // steps, remainders, orders, and where the active set was another one
//! assert!(report.second_order()? > 1.9);
//! assert!(!report.steps[0].same_active_set); // a step of 1 carries points over the kink
//! # Ok(())
//! # }
//! ```

mod kinked_diameters;
#[cfg(test)]
mod tests;

use std::fmt;

use crate::contract::Form;
use thiserror::Error;

use crate::assemble::{Assembler, AssemblyError};
use crate::field::{Field, FieldError};
use crate::linear_algebra::vector::norm;
use crate::mesh::Mesh;
use crate::movement::MovementError;
pub use kinked_diameters::KinkedDiameters;

/// Steps with the active set of the start that a test takes, each half of the one before.
const STEPS: usize = 7;
/// Halvings until the active set must be that of the start.
const MOST_HALVINGS: usize = 30;
/// Remainders below this part of what they are differences of are rounding.
const ROUNDING: f64 = 1e-12;
/// A remainder that is rounding tells something if an error of f′(0) by this part would have been seen.
const SEEN: f64 = 1e-6;
/// An order that is lower than the one expected by more than this does not pass.
const SLACK: f64 = 0.1;
/// Number of the smallest steps that are judged: at large ones terms of higher order matter, too.
const JUDGED: usize = 3;

/// A sample at a step: a number or a vector, and which switches are on there.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// f(t): one entry for a number, all entries of a vector.
    pub value: Vec<f64>,
    /// The switches per quadrature point, as [`Assembler::active_set`] gives them; `None` without kinks.
    pub active_set: Option<Vec<u32>>,
}

impl From<f64> for Sample {
    fn from(value: f64) -> Self {
        vec![value].into()
    }
}

impl From<Vec<f64>> for Sample {
    fn from(value: Vec<f64>) -> Self {
        Sample { value, active_set: None }
    }
}

/// One step of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaylorStep {
    /// t.
    pub step: f64,
    /// ‖f(t) − f(0) − t f′(0)‖₂.
    pub remainder: f64,
    /// log₂ of the remainder before over this one; none at the first step, and none across a change of the active set.
    pub order: Option<f64>,
    /// Whether the active set is that of the start.
    pub same_active_set: bool,
}

/// A whole test. It prints as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TaylorReport {
    /// The steps, each half of the one before.
    pub steps: Vec<TaylorStep>,
    /// The remainder \[unit of f\] below which it is rounding.
    pub rounding: f64,
    /// ‖f′(0)‖₂ along the direction, as it was given \[unit of f\].
    pub slope: f64,
    /// Cells whose diameter has a kink at the steps that are judged: of a test by the [`shape`] of the domain.
    pub kinked_diameters: Option<KinkedDiameters>,
}

/// Outcomes of a test that shows nothing, or shows a mistake. Each holds the report.
#[derive(Clone, Error, PartialEq)]
#[allow(missing_docs)]
pub enum TaylorFailure {
    /// The remainder falls too slowly: the derivative is wrong, or a kink was crossed that the test was not told of.
    #[error(
        "the remainder falls with the order {lowest:.3} instead of {expected}: the derivative is not that of the function\n{report}"
    )]
    Order {
        /// The order of a right derivative.
        expected: u8,
        lowest: f64,
        report: TaylorReport,
    },
    /// The remainder falls too slowly along a movement for which the diameter of cells has a kink: a function that reads `h` has
    /// no derivative there. Whether the derivative is right, the test does not say.
    #[error(
        "the remainder falls with the order {lowest:.3} instead of {expected}: {kinked}. A function that reads h has no \
         derivative there: move along another field, or take a mesh whose cells have one longest distance, of rectangles \
         with a node shifted. A function that does not read h has another derivative than this one\n{report}"
    )]
    Diameter {
        /// The order of a right derivative.
        expected: u8,
        lowest: f64,
        /// The cells.
        kinked: KinkedDiameters,
        report: TaylorReport,
    },
    /// The remainder is round-off, which it would also be for a wrong derivative, or it exceeds round-off at only one step.
    #[error(
        "the remainder is rounding before its order can be seen: the steps are too small, and the test says nothing\n{report}"
    )]
    Rounding { report: TaylorReport },
    /// The active set changes at every step.
    #[error(
        "the active set is another one at every step: the state lies on a kink, or the first step is much too large\n{report}"
    )]
    ActiveSet { report: TaylorReport },
    /// A remainder is no number.
    #[error("a remainder is not finite\n{report}")]
    NotFinite { report: TaylorReport },
}

// It is what `main` and `unwrap` show: the table, not a structure of numbers on one line.
impl fmt::Debug for TaylorFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl TaylorReport {
    /// The lowest order of the remainder over the three smallest steps that keep the active set and are not rounding, if it
    /// is near enough to two (above 1.9). Infinity for a function that [is affine](Self::is_affine) along the direction: its
    /// remainder has no order, and passes.
    ///
    /// # Errors
    /// [`TaylorFailure`]: a lower order, or a test that shows nothing.
    pub fn second_order(&self) -> Result<f64, TaylorFailure> {
        self.order(2)
    }

    /// The lowest order of a remainder without the second derivative's part, which falls with the third order.
    ///
    /// # Errors
    /// [`TaylorFailure`]: a lower order, or a test that shows nothing.
    pub fn third_order(&self) -> Result<f64, TaylorFailure> {
        self.order(3)
    }

    fn order(&self, expected: u8) -> Result<f64, TaylorFailure> {
        let report = || self.clone();
        if self.steps.iter().any(|step| !step.remainder.is_finite()) {
            return Err(TaylorFailure::NotFinite { report: report() });
        }
        if !self.steps.iter().any(|step| step.same_active_set) {
            return Err(TaylorFailure::ActiveSet { report: report() });
        }
        if self.is_affine() {
            return Ok(f64::INFINITY);
        }
        let telling = self.steps.iter().filter(|step| step.remainder > self.rounding);
        match telling.filter_map(|step| step.order).rev().take(JUDGED).reduce(f64::min) {
            None => Err(TaylorFailure::Rounding { report: report() }),
            Some(lowest) if lowest > f64::from(expected) - SLACK => Ok(lowest),
            Some(lowest) => Err(match self.kinked_diameters.clone() {
                Some(kinked) => TaylorFailure::Diameter { expected, lowest, kinked, report: report() },
                None => TaylorFailure::Order { expected, lowest, report: report() },
            }),
        }
    }

    /// Whether the remainders are rounding at all steps that keep the active set, where one at least is so large that a
    /// derivative wrong by a millionth would have shown: the function is affine along the direction between its kinks, and
    /// the derivative is right.
    pub fn is_affine(&self) -> bool {
        let mut kept = self.steps.iter().filter(|step| step.same_active_set).peekable();
        let largest = kept.peek().map_or(0.0, |step| step.step.abs());
        // Without a slope the function is constant, and every change that is not rounding would have shown.
        let told = self.slope == 0.0 || self.rounding <= SEEN * largest * self.slope;
        kept.peek().is_some() && told && kept.all(|step| step.remainder <= self.rounding)
    }
}

impl fmt::Display for TaylorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:>12}  {:>12}  {:>7}", "step", "remainder", "order")?;
        for TaylorStep { step, remainder, order, same_active_set } in &self.steps {
            let order = order.map_or_else(|| "-".to_owned(), |order| format!("{order:.3}"));
            write!(f, "{step:>12.3e}  {remainder:>12.3e}  {order:>7}")?;
            if !same_active_set {
                write!(f, "  another active set")?;
            } else if *remainder <= self.rounding {
                write!(f, "  rounding")?;
            }
            writeln!(f)?;
        }
        if self.is_affine() {
            writeln!(f, "affine along this direction: no remainder but rounding")?;
        }
        Ok(())
    }
}

/// Taylor test of f′(0), given as `derivative`, of a number or vector f(t) that the caller computes: the criterion after a
/// parameter or a datum has changed by t and the state has been solved for again, or anything else. Steps begin with
/// `first` and are halved until the active set is that of the start, then six times more.
///
/// # Errors
/// Those of `value`.
pub fn taylor<E>(
    first: f64,
    derivative: &[f64],
    mut value: impl FnMut(f64) -> Result<Sample, E>,
) -> Result<TaylorReport, E> {
    let start = value(0.0)?;
    let [scale, slope] = [&start.value[..], derivative].map(norm);
    let rounding = ROUNDING * scale.max(first.abs() * slope);
    let mut report = TaylorReport { steps: Vec::new(), rounding, slope, kinked_diameters: None };
    let (mut step, mut kept) = (first, 0);
    while kept < STEPS && (kept > 0 || report.steps.len() < MOST_HALVINGS) {
        let moved = value(step)?;
        let fits = moved.value.len() == start.value.len() && derivative.len() == start.value.len();
        let parts = moved.value.iter().zip(&start.value).zip(derivative);
        let square: f64 = parts.map(|((moved, start), slope)| (moved - start - step * slope).powi(2)).sum();
        let remainder = if fits { square.sqrt() } else { f64::NAN };
        let same_active_set = moved.active_set == start.active_set;
        let before = report.steps.last().filter(|before| before.same_active_set && same_active_set);
        let order = before.map(|before| (before.remainder / remainder).log2());
        report.steps.push(TaylorStep { step, remainder, order, same_active_set });
        kept = if same_active_set { kept + 1 } else { 0 };
        step *= 0.5;
    }
    Ok(report)
}

/// Errors that prevent a test.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum VerificationError {
    /// Data that do not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// A direction that does not fit, or a state that is not finite.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The number of directions is not that of the unknowns.
    #[error("{unknowns} unknowns were given, but {directions} directions")]
    Directions {
        /// Unknowns given.
        unknowns: usize,
        directions: usize,
    },
    /// All directions are zero: nothing would be tested.
    #[error("the directions are zero, and a test along them says nothing")]
    NoDirection,
}

/// Taylor test of a form's tangent: its residual along directions of its unknowns, one for each.
///
/// # Errors
/// Names of the sizes that do not fit.
pub fn tangent<const D: usize>(
    assembler: &Assembler<D>,
    form: &Form<D>,
    unknowns: &[&Field<D>],
    directions: &[&Field<D>],
    first: f64,
) -> Result<TaylorReport, VerificationError> {
    if unknowns.len() != directions.len() {
        let (unknowns, directions) = (unknowns.len(), directions.len());
        return Err(VerificationError::Directions { unknowns, directions });
    }
    if directions.iter().all(|direction| direction.values().iter().all(|value| *value == 0.0)) {
        return Err(VerificationError::NoDirection);
    }
    let spaces: Vec<_> = unknowns.iter().map(|unknown| unknown.space()).collect();
    let derivative = assembler.action(form, unknowns, directions, &spaces)?;
    taylor(first, &derivative, |step| {
        let moved = unknowns
            .iter()
            .zip(directions)
            .map(|(unknown, direction)| Field::combination(&[(1.0, *unknown), (step, *direction)]));
        let moved = moved.collect::<Result<Vec<_>, FieldError>>()?;
        let moved: Vec<&Field<D>> = moved.iter().collect();
        let active_set = assembler.active_set(form, &moved)?;
        Ok(Sample { value: assembler.residual(form, &moved, &spaces)?, active_set })
    })
}

/// Taylor test of a derivative by the shape of the domain along a movement: `value` computes the number on a mesh that has moved,
/// whose spaces number their nodes as before ([`Field::carried_to`]). `derivative` is the derivative along `movement`. Where
/// the diameter h of cells has a kink along it, the report says so: a function that reads h has no derivative there.
///
/// # Errors
/// Those of `value`; a movement that turns a cell inside out at the first step, by the cell's number.
pub fn shape<E: From<MovementError>, const D: usize>(
    movement: &Field<D>,
    first: f64,
    derivative: f64,
    mut value: impl FnMut(&Mesh<D>) -> Result<Sample, E>,
) -> Result<TaylorReport, E> {
    let mut report = taylor(first, &[derivative], |step| match step == 0.0 {
        true => value(movement.space().mesh()),
        false => value(&movement.move_mesh(step)?),
    })?;
    let judged = report.steps.iter().rev().nth(JUDGED).or(report.steps.first());
    report.kinked_diameters = judged.and_then(|judged| KinkedDiameters::along(movement, judged.step));
    Ok(report)
}
