//! A formulation of contact, which knows no problem.

use crate::case::Case;
use crate::filled::{Filled, Step};
use crate::membrane::Membrane;
use crate::outcome::{Outcome, Refusal, not_defined};
use crate::rubber::{Pressed, Rubber};
use crate::sliding::{Slid, Sliding};
use crate::two_bodies::{AfterLoad, TwoBodies};

/// The mesh of bodies that touch a rigid obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meshing {
    /// It fits the body.
    Fitted,
    /// The body is cut from it by a level set function.
    Cut,
}

/// A formulation of contact.
pub trait Formulation: Sync {
    /// Its name in tables, with its parameters.
    fn name(&self) -> String;

    /// The mesh that it gets.
    fn meshing(&self) -> Meshing {
        Meshing::Fitted
    }

    /// The solution of a case.
    ///
    /// # Errors
    /// [`Refusal`], which is a result, too.
    fn solve(&self, case: &Case) -> Result<Outcome, Refusal>;

    /// The solution of a membrane over an obstacle, which is contact in the volume.
    ///
    /// # Errors
    /// As [`Formulation::solve`].
    fn cover(&self, _membrane: &Membrane) -> Result<Outcome, Refusal> {
        Err(not_defined("not written for contact in the volume"))
    }

    /// The path of bodies whose gap has a mesh.
    ///
    /// # Errors
    /// As [`Formulation::solve`].
    fn close(&self, _filled: &Filled) -> Result<Vec<Step>, Refusal> {
        Err(not_defined("it has no use for a mesh of the gap"))
    }

    /// The path of a nearly incompressible body on a flat.
    ///
    /// # Errors
    /// As [`Formulation::solve`].
    fn press(&self, _rubber: &Rubber) -> Result<Pressed, Refusal> {
        Err(not_defined("not written for a body with a field of mean stress"))
    }

    /// The path of two bodies with friction.
    ///
    /// # Errors
    /// As [`Formulation::solve`].
    fn rub(&self, _bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        Err(not_defined("not written for friction"))
    }

    /// The path of two bodies in space.
    ///
    /// # Errors
    /// As [`Formulation::solve`].
    fn stack(&self, _bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        Err(not_defined("not written for space"))
    }

    /// The path of two bodies that slide along each other at finite strains.
    ///
    /// # Errors
    /// As [`Formulation::solve`].
    fn slide(&self, _bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        Err(not_defined("not written for surfaces that slide"))
    }
}
