//! Sets of active quadrature points: those in contact, in slip or in plastic flow.

use std::hash::{DefaultHasher, Hash, Hasher};

/// A set of active quadrature points: how many, and a fingerprint that tells sets apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActivePoints {
    /// Number of active points.
    pub count: usize,
    /// Hash of their numbers.
    pub fingerprint: u64,
}

impl ActivePoints {
    /// The set of these point numbers, which must come in the same order for the same set.
    pub fn from_numbers(numbers: impl IntoIterator<Item = usize>) -> Self {
        let mut hasher = DefaultHasher::new();
        let mut count = 0;
        for number in numbers {
            number.hash(&mut hasher);
            count += 1;
        }
        Self { count, fingerprint: hasher.finish() }
    }
}
