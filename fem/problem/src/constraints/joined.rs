//! Conditions of several processes joined into those of all, by numbers that unknowns have on all of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::equations::{Substituted, pivot};
use super::{Conditions, Relation};

/// An unknown that is to be given by others: dependent = Σ coefficient × unknown + value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dependence {
    pub dependent: usize,
    pub terms: Vec<(usize, f64)>,
    pub value: f64,
}

impl Dependence {
    /// All terms on the left.
    fn equation(&self) -> Vec<(usize, f64)> {
        let others = self.terms.iter().map(|(unknown, a)| (*unknown, -a));
        [(self.dependent, 1.0)].into_iter().chain(others).collect()
    }
}

impl Conditions {
    /// Conditions that prescribe these values.
    pub(crate) fn prescribing(prescribed: BTreeMap<usize, f64>) -> Self {
        let largest = prescribed.values().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        Conditions { prescribed, largest, ..Conditions::default() }
    }

    /// Whether a dependence follows from these conditions.
    pub(crate) fn imply(&self, dependence: &Dependence) -> bool {
        let equation = dependence.equation();
        let Substituted { rest, right, scale, .. } = self.substituted(&equation, dependence.value);
        rest.is_empty() && self.is_rounding(&equation, right, scale)
    }

    /// Adds a dependence; it gives another of its unknowns where earlier ones give the dependent one.
    ///
    /// # Errors
    /// The difference by which it contradicts the earlier ones.
    pub(crate) fn add(&mut self, dependence: &Dependence) -> Result<(), f64> {
        let equation = dependence.equation();
        let Substituted { mut rest, right, scale, .. } = self.substituted(&equation, dependence.value);
        let of_dependent = rest.get(&dependence.dependent).map(|a| (dependence.dependent, *a));
        let Some((given, divisor)) = of_dependent.or_else(|| pivot(&rest)) else {
            return if self.is_rounding(&equation, right, scale) { Ok(()) } else { Err(right) };
        };
        rest.remove(&given);
        let terms = rest.into_iter().map(|(unknown, a)| (unknown, -a / divisor)).collect();
        self.give(given, Relation { terms, value: right / divisor, origin: Arc::from("another process") });
        Ok(())
    }

    /// Prescribes a value of a hanging unknown, unless those that give it are prescribed.
    ///
    /// # Errors
    /// As [`Conditions::add`].
    pub(crate) fn add_at_hanging(&mut self, dependent: usize, value: f64) -> Result<(), f64> {
        if self.prescribed.contains_key(&dependent) {
            return Ok(());
        }
        self.add(&Dependence { dependent, terms: vec![], value })
    }

    /// The prescribed unknowns, and the relations.
    pub(crate) fn into_parts(self) -> (BTreeMap<usize, f64>, BTreeMap<usize, Relation>) {
        (self.prescribed, self.relations)
    }
}
