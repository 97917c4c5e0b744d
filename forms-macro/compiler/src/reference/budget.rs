//! The budget of the walks over one form. Derivatives inside derivatives multiply: a random form of
//! twenty operators can ask for hours.

use std::cell::Cell;

use super::environment::Environment;
use super::number::Number;

/// A node costs as much as this number of products of coefficients, if its numbers are real.
const NODE: u64 = 50;

/// A number of the environment costs as much as this number of products when it is moved.
const NUMBER: u64 = 5;

/// The work that may still be done, in products of coefficients.
#[derive(Debug)]
pub struct Budget(Cell<u64>);

impl Budget {
    pub fn new(products: u64) -> Self {
        Budget(Cell::new(products))
    }

    pub fn is_exhausted(&self) -> bool {
        self.0.get() == 0
    }

    /// Takes off what these results have cost: every coefficient of one operand meets every one of the other.
    pub(super) fn spend(&self, results: &[Number]) {
        let products: u64 = results.iter().map(|number| (number.length() as u64).pow(2)).sum();
        self.take(NODE + products);
    }

    /// Takes off what it costs to move the environment: each of their numbers gets a further infinitesimal.
    pub(super) fn spend_on_environment(&self, around: &Environment) {
        let numbers: usize =
            around.fields.iter().flatten().map(|jet| jet.iter().map(Vec::len).sum::<usize>()).sum();
        self.take((NUMBER * numbers as u64) << around.level);
    }

    fn take(&self, products: u64) {
        self.0.set(self.0.get().saturating_sub(products));
    }
}
