//! Positions of matrices, made on an assembler's threads.

use std::sync::Arc;

use super::BlockPattern;
use crate::assemble::binding::outline::Outline;
use crate::assemble::{Assembler, AssemblyError, Parts};
use crate::contract::Form;
use crate::linear_algebra::LinearAlgebraError;
use crate::space::Space;

impl<const D: usize> Assembler<D> {
    /// [`BlockPattern::for_form`] for the cells that the assembler assembles, made on its threads. It is the same for any
    /// number of them.
    ///
    /// # Errors
    /// As [`BlockPattern::for_form`].
    pub fn pattern(
        &self,
        form: &Form<D>,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<BlockPattern<D>, AssemblyError> {
        BlockPattern::for_cells_of(&Outline::of(form, Parts::ALL), tests, trials, self)
    }

    /// [`BlockPattern::new`], made on the assembler's threads. It is the same for any number of them.
    ///
    /// # Errors
    /// When the matrix is too large to be numbered.
    pub fn pattern_of_spaces(
        &self,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
    ) -> Result<BlockPattern<D>, LinearAlgebraError> {
        BlockPattern::for_spaces(tests, trials, self.threads)
    }
}
