//! A formulation of contact, which knows no problem.

use crate::case::Case;
use crate::outcome::{Outcome, Refusal};

/// A formulation of contact.
pub trait Formulation: Sync {
    /// Its name in tables, with its parameters.
    fn name(&self) -> String;

    /// The solution of a case.
    ///
    /// # Errors
    /// [`Refusal`], which is a result, too.
    fn solve(&self, case: &Case) -> Result<Outcome, Refusal>;
}
