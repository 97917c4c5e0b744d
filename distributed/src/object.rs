//! Objects of PETSc. To destroy one, all processes may have to wait for each other, and a process that drops one may have failed, while
//! the others are elsewhere: what is dropped is kept until all processes destroy it together.

use std::ptr::null_mut;

use crate::dropped_objects::{Destroy, Dropped};
use crate::error::PetscError;
use crate::petsc::Object;
use crate::world::World;

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
