//! History: values at quadrature points that a step reads, and that are updated for the next step.

use std::fmt;
use std::marker::PhantomData;

use crate::source::{FieldValue, HistoryHandle, Source};

/// A member of `Data` declared as `History<Scalar>`, `History<Vector>` or `History<Tensor>`: what a material
/// remembers, as plastic strain. `V` is `f64`, `[f64; D]` or `[[f64; D]; D]`. The backend makes it.
///
/// Forms read the committed values. A step writes new ones (several histories may be written from the same
/// committed state) and then commits them all, or reverts, and can be repeated from the old state.
///
/// Clones share the values, and a form holds such a clone: after a commit every form that was built with it
/// reads the new values.
pub struct History<V, const D: usize> {
    source: Source<D>,
    handle: HistoryHandle,
    value: PhantomData<V>,
}

impl<V: FieldValue, const D: usize> History<V, D> {
    /// The history kept by a backend, which answers for the number of components.
    pub fn from_handle(handle: HistoryHandle) -> Self {
        History { source: Source::History(handle.clone()), handle, value: PhantomData }
    }

    /// Commitment of the written values: forms read them from now on.
    pub fn commit(&self) {
        self.handle.commit();
    }

    /// Return to the last commit: values that were written since are lost.
    pub fn revert(&self) {
        self.handle.revert();
    }

    /// For the backend.
    pub fn handle(&self) -> &HistoryHandle {
        &self.handle
    }

    /// The source of a form's values.
    pub fn source(&self) -> &Source<D> {
        &self.source
    }
}

impl<V, const D: usize> Clone for History<V, D> {
    fn clone(&self) -> Self {
        History { source: self.source.clone(), handle: self.handle.clone(), value: PhantomData }
    }
}

impl<V, const D: usize> fmt::Debug for History<V, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "History({} components)", self.handle.components())
    }
}
