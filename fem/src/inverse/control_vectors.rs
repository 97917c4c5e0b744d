//! Products and extremes of vectors of control values; where processes have parts of a mesh, those of all.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

use super::bounds::{Bounds, BoundsMismatch};
use crate::linear_algebra::vector::{dot, norm};
use crate::solve::{CommunicationError, DividedVectors};

/// Answers on vectors of control values. On parts of a mesh each process has the values of its part; numbers and shared nodes count once, and
/// all processes get the same bits.
///
/// After an exchange that failed numbers are NaN and verdicts false; [`ControlVectors::check`] has the error.
#[derive(Clone, Default)]
pub struct ControlVectors(Option<Rc<Division>>);

struct Division {
    vectors: Rc<dyn DividedVectors>,
    /// Whether this process counts a value, of each.
    counted: Vec<bool>,
    failure: RefCell<Option<CommunicationError>>,
}

impl fmt::Debug for ControlVectors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("ControlVectors").field(&self.0.is_some()).finish()
    }
}

impl ControlVectors {
    /// Answers of all processes that have such vectors, each with the values that it counts.
    pub(super) fn on_parts(vectors: Rc<dyn DividedVectors>, counted: Vec<bool>) -> Self {
        ControlVectors(Some(Rc::new(Division { vectors, counted, failure: RefCell::default() })))
    }

    /// The error of an exchange that failed.
    ///
    /// # Errors
    /// That one.
    pub fn check(&self) -> Result<(), CommunicationError> {
        let failure = self.0.as_ref().and_then(|division| division.failure.borrow().clone());
        failure.map_or(Ok(()), Err)
    }

    /// The product a·b of two vectors.
    pub fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        self.dots(&[(a, b)])[0]
    }

    /// Products of several pairs of vectors, by one exchange.
    pub fn dots(&self, pairs: &[(&[f64], &[f64])]) -> Vec<f64> {
        let Some(division) = &self.0 else { return pairs.iter().map(|(a, b)| dot(a, b)).collect() };
        let product = |(a, b): &(&[f64], &[f64])| {
            let counted = a.iter().zip(*b).zip(&division.counted).filter(|(_, counted)| **counted);
            counted.map(|((a, b), _)| a * b).sum()
        };
        division.folded(pairs.iter().map(product).collect(), |a, b| a + b)
    }

    /// The norm of a vector.
    pub fn norm(&self, a: &[f64]) -> f64 {
        if self.0.is_none() { norm(a) } else { self.dot(a, a).sqrt() }
    }

    /// The sum of a number of each value, given by its place.
    pub(super) fn sum(&self, count: usize, term: impl Fn(usize) -> f64) -> f64 {
        let Some(division) = &self.0 else { return (0..count).map(term).sum() };
        let own = (0..count).filter(|place| division.counted[*place]).map(term).sum();
        division.folded(vec![own], |a, b| a + b)[0]
    }

    /// The largest of all processes' numbers; NaN if there is one.
    pub(super) fn largest(&self, own: f64) -> f64 {
        let Some(division) = &self.0 else { return own };
        let larger = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
        division.folded(vec![own], larger)[0]
    }

    /// Whether something holds on all processes.
    pub(super) fn all(&self, own: bool) -> bool {
        if self.0.is_none() { own } else { self.largest(f64::from(u8::from(!own))) == 0.0 }
    }

    /// Checks that bounds fit on all processes.
    pub(super) fn check_bounds(&self, bounds: &Bounds, m: &[f64]) -> Result<(), BoundsMismatch> {
        let own = bounds.check(m);
        if self.all(own.is_ok()) { Ok(()) } else { own.and(Err(BoundsMismatch::Elsewhere)) }
    }
}

impl Division {
    /// Numbers of all processes, joined at each place in the order of ranks.
    fn folded(&self, own: Vec<f64>, join: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        if own.is_empty() || self.failure.borrow().is_some() {
            return vec![f64::NAN; own.len()];
        }
        match self.vectors.gather_lists(&own) {
            Ok(all) => {
                let each = |place: usize| all.iter().map(|list| list[place]).reduce(&join);
                (0..own.len()).map(|place| each(place).unwrap_or(own[place])).collect()
            }
            Err(error) => {
                *self.failure.borrow_mut() = Some(error);
                vec![f64::NAN; own.len()]
            }
        }
    }
}
