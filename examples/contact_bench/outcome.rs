//! The answer of a formulation on a case, or the reason why there is none.

use std::any::Any;
use std::error::Error;
use std::fmt;

use forms_fem::assemble::PointValues;
use forms_fem::output::one_line;
use forms_fem::prelude::*;

/// Pressures at points of the own surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pressures {
    /// Places on the undeformed surface.
    pub positions: Vec<[f64; 2]>,
    /// Weights of a quadrature over the surface.
    pub weights: Vec<f64>,
    /// The pressure, positive where it presses \[stress\].
    pub values: Vec<f64>,
}

impl From<PointValues<2>> for Pressures {
    fn from(found: PointValues<2>) -> Self {
        let values = found.values.iter().map(|value| value[0]).collect();
        Pressures { positions: found.positions, weights: found.weights, values }
    }
}

impl Pressures {
    /// The integral of a function of place and pressure.
    pub fn integral(&self, of: impl Fn([f64; 2], f64) -> f64) -> f64 {
        let points = self.positions.iter().zip(&self.weights).zip(&self.values);
        points.map(|((x, weight), value)| weight * of(*x, *value)).sum()
    }

    /// The resultant.
    pub fn force(&self) -> f64 {
        self.integral(|_, pressure| pressure)
    }

    /// The largest pressure.
    pub fn peak(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }
}

/// A solution.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The displacement.
    pub u: Field<2>,
    /// The pressure on the own surface.
    pub pressures: Pressures,
    /// Forces of contact on the nodes of all bodies, by unknown of the displacement.
    pub forces: Vec<f64>,
    /// The residual of the whole form by unknown of the displacement: reactions where values are prescribed.
    pub residual: Vec<f64>,
    /// The whole form, where the solution is that of one form, and its unknowns.
    pub form: Option<Form<2>>,
    /// The unknowns, the displacement first.
    pub fields: Vec<Field<2>>,
    /// Newton steps of each solve, one after the other.
    pub newton: Vec<usize>,
    /// Steps of an outer iteration, if there is one.
    pub outer: Option<usize>,
}

impl Outcome {
    /// This outcome as the solution of a whole form, which gives it a tangent.
    pub fn of_form(self, form: Form<2>) -> Self {
        Outcome { form: Some(form), ..self }
    }

    /// The outcome of the last of several solves.
    pub fn after(self, newton: Vec<usize>) -> Self {
        Outcome { outer: Some(newton.len()), newton, ..self }
    }
}

/// A reason why there is no solution.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The formulation does not exist for the problem.
    NotDefined(String),
    /// It failed.
    Failed(String),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Refusal::NotDefined(why) | Refusal::Failed(why)) = self;
        f.write_str(why)
    }
}

impl<E: Error + 'static> From<E> for Refusal {
    /// The reason in one line; below it the points that switched back and forth, where Newton's method failed so.
    fn from(error: E) -> Self {
        let why = one_line(&error.to_string());
        let any: &dyn Any = &error;
        let newton = any.downcast_ref::<NewtonError>();
        match newton.and_then(|error| error.oscillation.as_ref()) {
            Some(oscillation) => Refusal::Failed(format!("{why}\n{oscillation}")),
            None => Refusal::Failed(why),
        }
    }
}

/// The refusal of a formulation that does not exist for a problem.
pub fn not_defined(why: &str) -> Refusal {
    Refusal::NotDefined(why.to_owned())
}
