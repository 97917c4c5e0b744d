//! Objects of PETSc whose owners are gone, until all processes destroy them together.

#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};

use crate::petsc::{Code, Object};

/// A function that destroys an object, and sets the handle to null.
pub(crate) type Destroy = unsafe extern "C" fn(*mut Object) -> Code;

/// An object that nothing uses any more.
#[derive(Debug)]
pub(crate) struct Dropped {
    pub number: u64,
    pub object: Object,
    pub destroy: Destroy,
}

/// Objects that wait for their destruction.
#[derive(Debug, Default)]
pub(crate) struct DroppedObjects {
    /// Objects made so far.
    made: Cell<u64>,
    list: RefCell<Vec<Dropped>>,
}

impl DroppedObjects {
    pub fn next(&self) -> u64 {
        self.made.replace(self.made.get() + 1)
    }

    pub fn keep(&self, dropped: Dropped) {
        self.list.borrow_mut().push(dropped);
    }

    /// Their numbers, ascending.
    pub fn numbers(&self) -> Vec<u64> {
        let mut list = self.list.borrow_mut();
        list.sort_unstable_by_key(|dropped| dropped.number);
        list.iter().map(|dropped| dropped.number).collect()
    }

    /// Destroys the objects in the order of their numbers, which are the same on all processes.
    pub fn destroy(&self) {
        let mut list = self.list.take();
        list.sort_unstable_by_key(|dropped| dropped.number);
        for mut dropped in list {
            // SAFETY: a handle whose owner is gone, and the function for its kind.
            unsafe { (dropped.destroy)(&mut dropped.object) };
        }
    }
}
