//! Linear equations between unknowns, brought to a form in which some unknowns are given by free ones.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Conditions, Constraints, ConstraintsError};

/// An unknown that is given by others: Σ coefficient × unknown + value. The others are free.
#[derive(Clone, Debug, PartialEq)]
pub struct Relation {
    /// Free unknowns with their coefficients, ascending.
    pub terms: Vec<(usize, f64)>,
    /// The addend.
    pub value: f64,
    /// Which condition it came from.
    pub(super) origin: Arc<str>,
}

// What is left of coefficients, or of a right-hand side, after substitutions that cancel.
const ROUNDING: f64 = 1e-12;

impl<const D: usize> Constraints<D> {
    /// Adds Σ coefficient × unknown = `value`. Unknowns that are given already are substituted; of the rest the one
    /// with the largest coefficient is then given by the others, here and in all earlier relations. An equation that
    /// follows from the earlier ones changes nothing.
    pub(super) fn add_equation(
        &mut self,
        place: &str,
        terms: &[(usize, f64)],
        value: f64,
    ) -> Result<(), ConstraintsError> {
        let Substituted { mut rest, right, scale, earlier } = self.conditions.substituted(terms, value);
        let Some((pivot, divisor)) = pivot(&rest) else {
            return self.check_remainder(place, terms, right, scale, earlier);
        };
        rest.remove(&pivot);
        let terms = rest.into_iter().map(|(unknown, a)| (unknown, -a / divisor)).collect();
        Arc::make_mut(&mut self.conditions)
            .give(pivot, Relation { terms, value: right / divisor, origin: place.into() });
        Ok(())
    }

    /// Adds u_dependent = Σ coefficient × unknown + `value`, by which the dependent unknown is given, here and in all earlier
    /// relations.
    pub(super) fn add_relation(
        &mut self,
        place: &str,
        dependent: usize,
        terms: &[(usize, f64)],
        value: f64,
    ) -> Result<(), ConstraintsError> {
        let equation: Vec<(usize, f64)> =
            [(dependent, 1.0)].into_iter().chain(terms.iter().map(|(unknown, a)| (*unknown, -a))).collect();
        let Substituted { mut rest, right, scale, earlier } = self.conditions.substituted(&equation, value);
        if rest.is_empty() {
            return self.check_remainder(place, &equation, right, scale, earlier);
        }
        let Some(divisor) = rest.remove(&dependent) else {
            let node = dependent / self.space.components();
            return Err(ConstraintsError::AlreadyGiven {
                name: place.to_owned(),
                unknown: dependent,
                position: self.space.positions()[node].to_vec(),
                earlier: earlier.map_or_else(String::new, |origin| origin.to_string()),
            });
        };
        let terms = rest.into_iter().map(|(unknown, a)| (unknown, -a / divisor)).collect();
        let relation = Relation { terms, value: right / divisor, origin: place.into() };
        Arc::make_mut(&mut self.conditions).give(dependent, relation);
        Ok(())
    }

    /// Checks that an equation without an unknown follows from the earlier ones.
    fn check_remainder(
        &self,
        place: &str,
        terms: &[(usize, f64)],
        right: f64,
        scale: f64,
        earlier: Option<Arc<str>>,
    ) -> Result<(), ConstraintsError> {
        if self.conditions.is_rounding(terms, right, scale) {
            return Ok(());
        }
        let node = terms[0].0 / self.space.components();
        Err(ConstraintsError::Contradiction {
            place: place.to_owned(),
            earlier: earlier.map_or_else(String::new, |origin| origin.to_string()),
            node,
            position: self.space.positions()[node].to_vec(),
            difference: right,
        })
    }
}

/// The unknown with the largest coefficient, the first of several.
pub(super) fn pivot(terms: &BTreeMap<usize, f64>) -> Option<(usize, f64)> {
    let larger = |best: (usize, f64), next: (usize, f64)| {
        if next.1.abs() > best.1.abs() * (1.0 + ROUNDING) { next } else { best }
    };
    terms.iter().map(|(unknown, a)| (*unknown, *a)).reduce(larger)
}

/// An equation between free unknowns: what earlier conditions give is put in.
pub(super) struct Substituted {
    pub(super) rest: BTreeMap<usize, f64>,
    pub(super) right: f64,
    /// The largest size on the right-hand side.
    pub(super) scale: f64,
    /// The last condition that was put in.
    earlier: Option<Arc<str>>,
}

impl Conditions {
    /// An equation with what is known put in.
    pub(super) fn substituted(&self, terms: &[(usize, f64)], value: f64) -> Substituted {
        let mut rest = BTreeMap::new();
        let mut right = value;
        let mut scale = value.abs();
        let mut earlier: Option<Arc<str>> = None;
        for &(unknown, coefficient) in terms {
            if let Some(known) = self.prescribed.get(&unknown) {
                right -= coefficient * known;
                scale = scale.max((coefficient * known).abs());
                earlier = self.origins.get(&unknown).cloned().or(earlier);
            } else if let Some(relation) = self.relations.get(&unknown) {
                right -= coefficient * relation.value;
                scale = scale.max((coefficient * relation.value).abs());
                for &(free, inner) in &relation.terms {
                    *rest.entry(free).or_insert(0.0) += coefficient * inner;
                }
                earlier = Some(relation.origin.clone());
            } else {
                *rest.entry(unknown).or_insert(0.0) += coefficient;
            }
        }
        let largest = terms.iter().fold(0.0_f64, |largest, (_, a)| largest.max(a.abs()));
        rest.retain(|_, a: &mut f64| a.abs() > ROUNDING * largest);
        Substituted { rest, right, scale, earlier }
    }

    /// Whether what is left of the right-hand side of an equation is rounding: a value of sin 2πx is zero up to that of the largest one.
    pub(super) fn is_rounding(&self, terms: &[(usize, f64)], right: f64, scale: f64) -> bool {
        let coefficient = terms.iter().fold(0.0_f64, |largest, (_, a)| largest.max(a.abs()));
        right.abs() <= ROUNDING * scale.max(coefficient * self.largest)
    }

    /// Makes a free unknown a given one, also where other relations use it.
    pub(super) fn give(&mut self, unknown: usize, relation: Relation) {
        for user in self.users.remove(&unknown).unwrap_or_default() {
            let Some(mut old) = self.relations.remove(&user) else { continue };
            let mut terms: BTreeMap<usize, f64> = old.terms.drain(..).collect();
            if let Some(factor) = terms.remove(&unknown) {
                old.value += factor * relation.value;
                for &(free, inner) in &relation.terms {
                    *terms.entry(free).or_insert(0.0) += factor * inner;
                }
            }
            old.terms = terms.into_iter().collect();
            self.store(user, old);
        }
        self.store(unknown, relation);
    }

    fn store(&mut self, unknown: usize, relation: Relation) {
        if relation.terms.is_empty() {
            self.largest = self.largest.max(relation.value.abs());
            self.prescribed.insert(unknown, relation.value);
            self.origins.insert(unknown, relation.origin);
            return;
        }
        for (free, _) in &relation.terms {
            self.users.entry(*free).or_default().insert(unknown);
        }
        self.relations.insert(unknown, relation);
    }
}
