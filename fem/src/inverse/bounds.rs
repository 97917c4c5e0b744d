//! Bounds of controls.

use std::cmp::Ordering;

use thiserror::Error;

/// Lower and upper bounds of each control.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Bounds {
    /// No bounds.
    pub fn none(count: usize) -> Self {
        Bounds { lower: vec![f64::NEG_INFINITY; count], upper: vec![f64::INFINITY; count] }
    }

    /// Equal bounds for all controls.
    pub fn between(count: usize, lower: f64, upper: f64) -> Self {
        Bounds { lower: vec![lower; count], upper: vec![upper; count] }
    }

    /// Bounds of one control each.
    pub fn each(lower: Vec<f64>, upper: Vec<f64>) -> Self {
        Bounds { lower, upper }
    }

    /// The lower and the upper bounds.
    pub(super) fn both(&self) -> (&[f64], &[f64]) {
        (&self.lower, &self.upper)
    }

    /// The first control whose bound is not finite.
    pub(super) fn first_infinite(&self) -> Option<usize> {
        let finite = |(lower, upper): (&f64, &f64)| lower.is_finite() && upper.is_finite();
        self.lower.iter().zip(&self.upper).position(|pair| !finite(pair))
    }

    /// The nearest point between the bounds.
    pub(super) fn project(&self, m: &mut [f64]) {
        for ((m, lower), upper) in m.iter_mut().zip(&self.lower).zip(&self.upper) {
            *m = m.max(*lower).min(*upper);
        }
    }

    /// Whether a control stays at its bound as its slope presses it there.
    pub(super) fn hold(&self, place: usize, m: f64, slope: f64) -> bool {
        (m <= self.lower[place] && slope > 0.0) || (m >= self.upper[place] && slope < 0.0)
    }

    /// The multiple of a step at which the first control comes to a bound; infinite without bounds.
    pub(super) fn longest_step(&self, m: &[f64], step: &[f64]) -> f64 {
        let of = |(place, (m, step)): (usize, (&f64, &f64))| match step.partial_cmp(&0.0) {
            Some(Ordering::Greater) => (self.upper[place] - m) / step,
            Some(Ordering::Less) => (self.lower[place] - m) / step,
            _ => f64::INFINITY,
        };
        m.iter().zip(step).enumerate().map(of).fold(f64::INFINITY, f64::min)
    }

    /// The largest change of a control in a gradient step of length one between the bounds \[gradient\]; zero at a minimum.
    pub(super) fn criticality(&self, m: &[f64], gradient: &[f64]) -> f64 {
        let changes =
            m.iter().zip(gradient).enumerate().map(|(place, (m, slope))| {
                ((m - slope).max(self.lower[place]).min(self.upper[place]) - m).abs()
            });
        changes.fold(0.0, f64::max)
    }

    pub(super) fn check(&self, m: &[f64]) -> Result<(), BoundsMismatch> {
        if [self.lower.len(), self.upper.len()] != [m.len(); 2] {
            let (lower, upper, controls) = (self.lower.len(), self.upper.len(), m.len());
            return Err(BoundsMismatch::Length { lower, upper, controls });
        }
        // A bound that is no number is below and above of nothing.
        let ordered = |(lower, upper): (&f64, &f64)| lower <= upper;
        match self.lower.iter().zip(&self.upper).position(|pair| !ordered(pair)) {
            None => Ok(()),
            Some(control) => {
                let (lower, upper) = (self.lower[control], self.upper[control]);
                Err(BoundsMismatch::Order { control, lower, upper })
            }
        }
    }
}

/// Bounds that do not fit.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum BoundsMismatch {
    /// The number of bounds is not that of the controls.
    #[error("{lower} lower and {upper} upper bounds were given for {controls} controls")]
    Length { lower: usize, upper: usize, controls: usize },
    /// A lower bound above the upper one.
    #[error("the lower bound {lower} of control {control} is not below its upper bound {upper}")]
    Order {
        /// The number of the control.
        control: usize,
        lower: f64,
        upper: f64,
    },
    /// Bounds of other processes, on parts of a mesh.
    #[error("the bounds of another process do not fit its controls")]
    Elsewhere,
}
