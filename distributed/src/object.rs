//! Objects of PETSc. To destroy one, all processes may have to wait for each other, and a process that drops one may have failed, while
//! the others are elsewhere: what is dropped is kept until all processes destroy it together.

#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::ptr::null_mut;

use crate::error::PetscError;
use crate::petsc::{Code, Object};
use crate::world::World;

/// A function that destroys an object, and sets the handle to null.
pub(crate) type Destroy = unsafe extern "C" fn(*mut Object) -> Code;

/// An object, until it is dropped.
#[derive(Debug)]
pub(crate) struct Owned<'w> {
    world: &'w World,
    /// The same on all processes: they make objects in the same order.
    number: u64,
    object: Object,
    destroy: Destroy,
}

impl<'w> Owned<'w> {
    /// The object that a call creates and writes to the given place.
    pub fn made(
        world: &'w World,
        destroy: Destroy,
        make: impl FnOnce(*mut Object) -> Result<(), PetscError>,
    ) -> Result<Self, PetscError> {
        let mut made = Owned { world, number: world.dropped().next(), object: null_mut(), destroy };
        make(&mut made.object)?;
        Ok(made)
    }

    pub fn handle(&self) -> Object {
        self.object
    }
}

impl Drop for Owned<'_> {
    fn drop(&mut self) {
        if !self.object.is_null() {
            self.world.dropped().keep(Dropped {
                number: self.number,
                object: self.object,
                destroy: self.destroy,
            });
        }
    }
}

/// An object that nothing uses any more.
#[derive(Debug)]
struct Dropped {
    number: u64,
    object: Object,
    destroy: Destroy,
}

/// Objects that wait for their destruction.
#[derive(Debug, Default)]
pub(crate) struct DroppedObjects {
    /// Objects made so far.
    made: Cell<u64>,
    list: RefCell<Vec<Dropped>>,
}

impl DroppedObjects {
    fn next(&self) -> u64 {
        self.made.replace(self.made.get() + 1)
    }

    fn keep(&self, dropped: Dropped) {
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
