//! Vectors over the free unknowns of spaces on a part.

use std::fmt;
use std::rc::Rc;

use super::divided_vectors::SpacesOnPart;
use crate::error::PetscError;

/// The free unknowns among all of spaces on a part.
#[derive(Clone)]
pub(crate) struct DividedUnknowns {
    pub(super) vectors: Rc<SpacesOnPart>,
    pub(super) free: Vec<usize>,
}

impl fmt::Debug for DividedUnknowns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DividedUnknowns").field("free", &self.free.len()).finish_non_exhaustive()
    }
}

impl DividedUnknowns {
    /// The processes whose parts meet this one.
    pub fn neighbours(&self) -> Vec<usize> {
        self.vectors.neighbours()
    }

    fn full(&self, reduced: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut full = vec![0.0; self.vectors.count()];
        self.free.iter().zip(reduced).for_each(|(unknown, value)| full[*unknown] = value);
        full
    }

    fn reduced(&self, full: &[f64]) -> Vec<f64> {
        self.free.iter().map(|unknown| full[*unknown]).collect()
    }

    /// Values of free unknowns, from the processes that own them.
    pub fn spread(&self, reduced: impl Iterator<Item = f64>) -> Result<Vec<f64>, PetscError> {
        let mut full = self.full(reduced);
        self.vectors.copy_from_owners(&mut full)?;
        Ok(self.reduced(&full))
    }
}
