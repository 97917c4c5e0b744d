//! Energies of any type behind one, as criteria.

use crate::assemble::{Assembler, AssemblyError};
use crate::contract::{Form, Functional};
use crate::field::Field;

/// An energy of one unknown, without its type.
pub(super) trait AnyEnergy<const D: usize> {
    /// See [`Assembler::energy`].
    fn value(&self, assembler: &Assembler<D>, state: &Field<D>) -> Result<f64, AssemblyError>;
    /// Its first variation at a state, an entry per unknown.
    fn slope(&self, assembler: &Assembler<D>, state: &Field<D>) -> Result<Vec<f64>, AssemblyError>;
    /// Its second variation at a state along a change, an entry per unknown.
    fn curvature(
        &self,
        assembler: &Assembler<D>,
        state: &Field<D>,
        change: &Field<D>,
    ) -> Result<Vec<f64>, AssemblyError>;
}

impl<F: Form<D> + Functional<D>, const D: usize> AnyEnergy<D> for F {
    fn value(&self, assembler: &Assembler<D>, state: &Field<D>) -> Result<f64, AssemblyError> {
        assembler.energy(self, &[state])
    }

    fn slope(&self, assembler: &Assembler<D>, state: &Field<D>) -> Result<Vec<f64>, AssemblyError> {
        assembler.residual(self, &[state], &[state.space()])
    }

    fn curvature(
        &self,
        assembler: &Assembler<D>,
        state: &Field<D>,
        change: &Field<D>,
    ) -> Result<Vec<f64>, AssemblyError> {
        assembler.action(self, &[state], &[change], &[state.space()])
    }
}
