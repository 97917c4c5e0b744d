//! Functionals; each process integrates its part. Problems are solved on several processes by
//! [`Problem::on`](forms_fem::solve::Problem::on) the world.

use forms_fem::prelude::*;
use forms_fem::solve::communicator::Fingerprint;

use crate::error::DistributedError;
#[cfg(doc)]
use crate::error::PetscError;
use crate::world::World;

/// The value of a functional: each process integrates over its own cells.
///
/// [`Solved::functional`] has the same value without an exchange: each process integrates over all cells.
///
/// # Errors
/// Data that do not fit, on any process; [`PetscError::Different`] where the processes have different meshes.
pub fn distributed_functional<const D: usize>(
    world: &World,
    assembler: &Assembler<D>,
    functional: &Functional<D>,
) -> Result<f64, DistributedError<AssemblyError>> {
    let cells = world.own_cells(assembler.mesh());
    let own = assembler.clone().on_owned_cells(cells).map_err(|source| AssemblyError::Region {
        form: functional.name(),
        symbol: "this process's cells",
        source,
    });
    let own = world.agree(own.and_then(|local| local.functional(functional)))?;
    world.check_same("meshes", Fingerprint::default().mesh(assembler.mesh()).finish())?;
    Ok(world.sum(&[own])?[0])
}
