//! Places of the values of units, which tasks fill, and which others read once they are full.

use std::sync::{Mutex, OnceLock, PoisonError};

use crate::elimination::Unit;

/// Memory that a task fills. Whoever takes it has it to himself; once it is published all can read it.
#[derive(Default)]
struct Slot<'v> {
    free: Mutex<Option<&'v mut [f64]>>,
    known: OnceLock<&'v [f64]>,
}

impl<'v> Slot<'v> {
    fn put(&self, values: &'v mut [f64]) {
        *self.free.lock().unwrap_or_else(PoisonError::into_inner) = Some(values);
    }

    fn take(&self) -> Option<&'v mut [f64]> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// The values of one unit.
pub(super) struct Room<'v> {
    /// Place of the first among all values.
    pub(super) start: usize,
    whole: Slot<'v>,
    panels: Vec<Slot<'v>>,
}

impl<'v> Room<'v> {
    pub(super) fn new(unit: &Unit, start: usize, values: &'v mut [f64]) -> Self {
        let mut panels = vec![];
        panels.resize_with(unit.panels, Slot::default);
        let whole = Slot::default();
        whole.put(values);
        Room { start, whole, panels }
    }

    /// The memory of the whole unit.
    pub(super) fn take(&self) -> Option<&'v mut [f64]> {
        self.whole.take()
    }

    /// Lets others read the whole unit.
    pub(super) fn publish(&self, values: &'v mut [f64]) {
        let _ = self.whole.known.set(values);
    }

    /// Cuts the memory of the unit into panels of the given number of values.
    pub(super) fn cut(&self, values: &'v mut [f64], length: usize) {
        self.panels.iter().zip(values.chunks_mut(length)).for_each(|(slot, values)| slot.put(values));
    }

    pub(super) fn take_panel(&self, panel: usize) -> Option<&'v mut [f64]> {
        self.panels[panel].take()
    }

    /// Keeps a panel for the next task that works on it.
    pub(super) fn put_back(&self, panel: usize, values: &'v mut [f64]) {
        self.panels[panel].put(values);
    }

    pub(super) fn publish_panel(&self, panel: usize, values: &'v mut [f64]) {
        let _ = self.panels[panel].known.set(values);
    }

    /// A panel that has been published.
    pub(super) fn panel(&self, panel: usize) -> Option<&'v [f64]> {
        self.panels[panel].known.get().copied()
    }

    /// Values of a supernode at the given place among all, in one piece or panel by panel.
    pub(super) fn blocks(&self, place: std::ops::Range<usize>) -> impl Iterator<Item = &'v [f64]> {
        let whole =
            self.whole.known.get().map(|values| &values[place.start - self.start..place.end - self.start]);
        whole.into_iter().chain(self.panels.iter().filter_map(|slot| slot.known.get().copied()))
    }
}
