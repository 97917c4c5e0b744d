//! The processes that MPI started together, and what they agree on.

use std::cell::RefCell;
use std::error::Error;
use std::fmt::Display;
use std::marker::PhantomData;
use std::ops::Range;
use std::process::ExitCode;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use forms_fem::mesh::Mesh;
use forms_fem::output::{StandardOutput, one_line, program, tell};
use forms_fem::solve::{CommunicationError, Communicator};

use crate::error::{DistributedError, PetscError};
use crate::petsc::{self, call};
use crate::rows::Rows;
use crate::vector::DistributedVector;

/// Time for a line on the standard error stream to reach the one who started the processes.
const FORWARDING: Duration = Duration::from_millis(500);

static STARTED: AtomicBool = AtomicBool::new(false);

/// MPI and PETSc, started; they end when this is dropped. All processes must make the same calls in the same order.
#[derive(Debug)]
pub struct World {
    /// PETSc is used from the thread that started it.
    here: PhantomData<*const ()>,
    output: RefCell<StandardOutput>,
}

impl World {
    /// Starts MPI and PETSc. PETSc reads its options from the environment variable `PETSC_OPTIONS` alone.
    ///
    /// # Errors
    /// [`PetscError::StartedAlready`], or what PETSc says.
    pub fn start() -> Result<Self, PetscError> {
        if STARTED.swap(true, Ordering::SeqCst) {
            return Err(PetscError::StartedAlready);
        }
        // SAFETY: the first calls of PETSc in this process; the handler returns codes and prints nothing.
        unsafe {
            call!(PetscInitializeNoArguments())?;
            call!(PetscPushErrorHandler(Some(petsc::PetscReturnErrorHandler), ptr::null_mut()))?;
        }
        Ok(World { here: PhantomData, output: RefCell::default() })
    }

    /// A program on all processes: says on each why it failed there, and on the first if its standard output could not be
    /// written.
    pub fn run(run: impl FnOnce(&World) -> Result<(), Box<dyn Error>>) -> ExitCode {
        let mut failed = false;
        let ended = program(|out| -> Result<(), String> {
            let world = World::start().map_err(|error| error.to_string())?;
            let outcome = run(&world);
            *out = world.output.take();
            // Before the processes part, where all wait for each other, and with a moment for what is said to be forwarded:
            // `mpirun` ends all of them when the first ends with a failure, and drops what it has not read.
            if let Err(error) = outcome {
                // One text, one write: the lines of several processes do not mingle.
                tell(format!("error: process {}: {}", world.rank(), one_line(&error.to_string())));
                std::thread::sleep(FORWARDING);
                failed = true;
            }
            Ok(())
        });
        if failed { ExitCode::FAILURE } else { ended }
    }

    /// Prints a line, on the first process.
    pub fn print(&self, line: impl Display) {
        if self.rank() == 0 {
            self.output.borrow_mut().line(line);
        }
    }

    /// The number of this process, from 0.
    pub fn rank(&self) -> usize {
        // SAFETY: written once by PetscInitialize, before there was a world.
        unsafe { petsc::PetscGlobalRank as usize }
    }

    /// Number of processes.
    pub fn size(&self) -> usize {
        // SAFETY: as for the rank.
        unsafe { petsc::PetscGlobalSize as usize }
    }

    pub(crate) fn communicator(&self) -> petsc::Communicator {
        // SAFETY: as for the rank.
        unsafe { petsc::PETSC_COMM_WORLD }
    }

    /// This process's part of `count` things in a row: parts differ by one at most.
    pub fn part(&self, count: usize) -> Range<usize> {
        let (rank, size) = (self.rank(), self.size());
        rank * count / size..(rank + 1) * count / size
    }

    /// The cells of a mesh that this process assembles: a piece of the curve along which the mesh's cells are walked and
    /// its nodes numbered, so that the cells are together, and most of their rows are this process's.
    pub fn own_cells<'m, const D: usize>(&self, mesh: &'m Mesh<D>) -> &'m [u32] {
        &mesh.cell_order().cells()[self.part(mesh.cell_count())]
    }

    /// The sums over all processes of as many numbers of each; the same on all.
    ///
    /// # Errors
    /// PETSc's error.
    pub fn sum(&self, numbers: &[f64]) -> Result<Vec<f64>, PetscError> {
        DistributedVector::new(self, Rows::of_nodes(self, numbers.len(), 1)?)?.sum(numbers)
    }

    /// A result of this process, if all have one. Else an error on all, so that none waits for another for ever.
    ///
    /// # Errors
    /// This process's own error, or that there was one elsewhere.
    pub fn agree<T, E: Error>(&self, own: Result<T, E>) -> Result<T, DistributedError<E>> {
        let failed = self.sum(&[f64::from(u8::from(own.is_err()))])?[0];
        match own {
            Err(error) => Err(DistributedError::Here(error)),
            Ok(_) if failed > 0.0 => Err(DistributedError::Elsewhere { count: failed as usize }),
            Ok(own) => Ok(own),
        }
    }
}

impl Communicator for World {
    fn rank(&self) -> usize {
        World::rank(self)
    }

    fn part(&self, count: usize) -> Range<usize> {
        World::part(self, count)
    }

    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        World::sum(self, own).map_err(|error| CommunicationError::Exchange(error.to_string()))
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // The others may wait for this one, which PetscFinalize would join: MPI ends them all.
            std::process::abort();
        }
        // SAFETY: started in `start`; all objects borrow the world and are gone.
        unsafe { petsc::PetscFinalize() };
    }
}
