//! The processes that MPI started together, and what they agree on.

#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::error::Error;
use std::fmt::Display;
use std::marker::PhantomData;
use std::ops::Range;
use std::process::ExitCode;
use std::ptr;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use forms_fem::mesh::Mesh;
use forms_fem::output::{StandardOutput, one_line, program, tell};
use forms_fem::solve::communicator::Fingerprint;
use forms_fem::solve::{CommunicationError, Communicator};

use crate::dropped_objects::DroppedObjects;
use crate::error::{DistributedError, PetscError};
use crate::meeting::{Call, Meetings, Traffic};
use crate::petsc::{self, call};

/// Time for a line on the standard error stream to reach the one who started the processes.
const FORWARDING: Duration = Duration::from_millis(500);

/// Time in which the others have to take notice that a process failed. After it all of them are ended, wherever they are.
const PATIENCE: Duration = Duration::from_secs(5);

static STARTED: AtomicBool = AtomicBool::new(false);

/// MPI and PETSc, started; they end when this is dropped. All processes must make the same calls in the same order.
///
/// If they do not, because one of them has failed or their data differ, the calls return errors that say so, and no process waits
/// for another in vain. A panic ends all processes.
#[derive(Debug)]
pub struct World {
    /// PETSc is used from the thread that started it.
    here: PhantomData<*const ()>,
    output: RefCell<StandardOutput>,
    meetings: Rc<Meetings>,
    dropped: DroppedObjects,
    /// Whether this process has told the others that it makes no further call.
    ended: Cell<bool>,
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
        Ok(World {
            here: PhantomData,
            output: RefCell::default(),
            // SAFETY: written once by PetscInitialize.
            meetings: Rc::new(unsafe {
                let [rank, size] = [petsc::PetscGlobalRank as usize, petsc::PetscGlobalSize as usize];
                Meetings::new(petsc::PETSC_COMM_WORLD, rank, size)?
            }),
            dropped: DroppedObjects::default(),
            ended: Cell::new(false),
        })
    }

    /// A program on all processes. Each process reports why it failed, and the first one also if its standard output could not be
    /// written. An error on one process ends all: the others get errors from their next common call, and are ended if they do not
    /// reach one within five seconds.
    pub fn run(run: impl FnOnce(&World) -> Result<(), Box<dyn Error>>) -> ExitCode {
        let mut failed = false;
        let ended = program(|out| -> Result<(), String> {
            let world = World::start().map_err(|error| error.to_string())?;
            let outcome = run(&world);
            *out = world.output.take();
            if let Err(error) = &outcome {
                // One text, one write: the lines of several processes do not mingle.
                tell(format!("error: process {}: {}", world.rank(), one_line(&error.to_string())));
                failed = true;
            }
            world.end(outcome.is_err());
            if failed {
                // `mpirun` ends all processes when the first ends with a failure, and drops what it has not read.
                std::thread::sleep(FORWARDING);
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

    pub(crate) fn meetings(&self) -> &Rc<Meetings> {
        &self.meetings
    }

    /// Counts of this process's messages so far, apart from PETSc's.
    pub fn traffic(&self) -> Traffic {
        self.meetings.traffic()
    }

    pub(crate) fn dropped(&self) -> &DroppedObjects {
        &self.dropped
    }

    /// This process's part of `count` things in a row: parts differ by one at most.
    pub fn part(&self, count: usize) -> Range<usize> {
        self.part_of(self.rank(), count)
    }

    /// A process's part of `count` things in a row.
    pub(crate) fn part_of(&self, rank: usize, count: usize) -> Range<usize> {
        rank * count / self.size()..(rank + 1) * count / self.size()
    }

    /// The cells of a mesh that this process assembles: a piece of the curve along which the mesh's cells are walked and
    /// its nodes numbered, so that the cells are together, and most of their rows are this process's.
    pub fn own_cells<'m, const D: usize>(&self, mesh: &'m Mesh<D>) -> &'m [u32] {
        &mesh.cell_order().cells()[self.part(mesh.cell_count())]
    }

    /// Sums over all processes, entry by entry; all give equally long lists. The result is the same on all processes, and in every run with the same
    /// number of processes.
    ///
    /// # Errors
    /// [`PetscError::Failed`] or [`PetscError::OtherCalls`] where others do not add up as many numbers; MPI's error.
    pub fn sum(&self, numbers: &[f64]) -> Result<Vec<f64>, PetscError> {
        self.meetings.sum(numbers)
    }

    /// A number of each process, in their order.
    ///
    /// # Errors
    /// As [`World::sum`].
    pub fn gather(&self, number: u64) -> Result<Vec<u64>, PetscError> {
        let numbers = self.meet(Call::Gather { number })?.into_iter().filter_map(|call| match call {
            Call::Gather { number } => Some(number),
            _ => None,
        });
        Ok(numbers.collect())
    }

    /// A list that the first process sends to another; none elsewhere. All processes make this call, with the same `to`.
    pub(crate) fn list_of_first(&self, to: usize, list: Vec<u64>) -> Result<Option<Vec<u64>>, PetscError> {
        let (sender, receiver) = (self.rank() == 0, self.rank() == to);
        let length = self.gather(list.len() as u64)?[0] as usize;
        if to == 0 {
            return Ok(sender.then_some(list));
        }
        let (lists, lengths) = match (sender, receiver) {
            (true, _) => (vec![(to, list)], vec![0]),
            (_, true) => (vec![(0, vec![])], vec![length]),
            _ => (vec![], vec![]),
        };
        let found = self.meetings.exchange(to as u64, lists, &lengths)?;
        Ok(found.into_iter().next().filter(|_| receiver))
    }

    /// The error of the first process, on all.
    pub(crate) fn succeed_on_first<T>(&self, own: Result<T, String>) -> Result<Option<T>, PetscError> {
        if self.gather(u64::from(own.is_err()))?[0] == 0 {
            return Ok(own.ok());
        }
        let mut message = own.err().unwrap_or_default();
        for rank in 1..self.size() {
            let bytes = message.bytes().map(u64::from).collect();
            if let Some(text) = self.list_of_first(rank, bytes)? {
                message =
                    String::from_utf8_lossy(&text.into_iter().map(|byte| byte as u8).collect::<Vec<_>>())
                        .into();
            }
        }
        Err(PetscError::Unfit { message })
    }

    /// The result of this process if all processes have one, otherwise an error on all, so that none waits forever.
    ///
    /// # Errors
    /// This process's own error, or that there was one elsewhere.
    pub fn agree<T, E: Error>(&self, own: Result<T, E>) -> Result<T, DistributedError<E>> {
        let all = self.meet(Call::Agree { failed: own.is_err() });
        let own = own.map_err(DistributedError::Here)?;
        match failures(&all?) {
            0 => Ok(own),
            count => Err(DistributedError::Elsewhere { count }),
        }
    }

    /// The same of calls of PETSc. One that fails here may leave the others inside of it: where they do not come, all processes end.
    pub(crate) fn agree_on_calls<T>(&self, own: Result<T, PetscError>) -> Result<T, PetscError> {
        match own {
            Ok(own) => match failures(&self.meet(Call::Agree { failed: false })?) {
                0 => Ok(own),
                count => Err(PetscError::Elsewhere { count }),
            },
            Err(error) => {
                self.meet_or_end_all(Call::Agree { failed: true }, &error)?;
                Err(error)
            }
        }
    }

    /// An error where a number is not the same on all processes.
    pub(crate) fn check_same(&self, what: &'static str, number: u64) -> Result<(), PetscError> {
        let all = self.gather(number)?;
        if all.iter().all(|other| *other == all[0]) { Ok(()) } else { Err(PetscError::Different { what }) }
    }

    /// Destroys the objects that were dropped, if all processes dropped the same ones. Otherwise they are kept for a later time.
    pub(crate) fn destroy_dropped(&self) -> Result<(), PetscError> {
        let numbers = self.gather(Fingerprint::default().numbers(self.dropped.numbers()).finish())?;
        if numbers.iter().all(|other| *other == numbers[0]) {
            self.dropped.destroy();
        }
        Ok(())
    }

    fn meet(&self, own: Call) -> Result<Vec<Call>, PetscError> {
        self.meetings.meet(own)
    }

    fn meet_or_end_all(&self, own: Call, why: &PetscError) -> Result<(), PetscError> {
        let Some(all) = self.meetings.all(own, Some(PATIENCE))? else { self.end_all(&why.to_string()) };
        self.meetings.same(own, &all)
    }

    /// Says why, and ends all processes, wherever they are.
    fn end_all(&self, why: &str) -> ! {
        tell(format!("error: process {} ends all processes: {}", self.rank(), one_line(why)));
        std::thread::sleep(FORWARDING);
        self.meetings.abort()
    }

    /// Waits until all processes make no further call. Those that want to make one get an error.
    fn end(&self, failed: bool) {
        self.ended.set(true);
        let (own, start) = (Call::End { failed }, Instant::now());
        loop {
            let patience = failed.then(|| PATIENCE.saturating_sub(start.elapsed()));
            match self.meetings.all(own, patience) {
                Ok(Some(all)) if all.iter().all(|call| matches!(call, Call::End { .. })) => {
                    if all.iter().all(|call| *call == Call::End { failed: false }) {
                        self.destroy_at_end();
                    }
                    return;
                }
                Ok(Some(_)) => {}
                Ok(None) => self.end_all("it failed, and the others took no notice"),
                Err(error) => self.end_all(&error.to_string()),
            }
        }
    }

    fn destroy_at_end(&self) {
        if let Err(error) = self.destroy_dropped() {
            self.end_all(&error.to_string());
        }
    }
}

/// Number of processes that failed.
fn failures(all: &[Call]) -> usize {
    all.iter().filter(|call| **call == Call::Agree { failed: true }).count()
}

impl Communicator for World {
    fn gather_lists(&self, own: &[u64]) -> Result<Vec<Vec<u64>>, CommunicationError> {
        self.meetings.gather_lists(own).map_err(|error| CommunicationError::Exchange(error.to_string()))
    }

    fn rank(&self) -> usize {
        World::rank(self)
    }

    fn size(&self) -> usize {
        World::size(self)
    }

    fn part(&self, count: usize) -> Range<usize> {
        World::part(self, count)
    }

    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        World::sum(self, own).map_err(|error| CommunicationError::Exchange(error.to_string()))
    }

    fn gather(&self, own: u64) -> Result<Vec<u64>, CommunicationError> {
        World::gather(self, own).map_err(|error| CommunicationError::Exchange(error.to_string()))
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // The others may wait for this one.
            self.end_all("it panicked");
        }
        if !self.ended.get() {
            self.end(false);
        }
        self.meetings.close();
        // SAFETY: started in `start`; all objects borrow the world and are gone.
        unsafe { petsc::PetscFinalize() };
        // All processes are ended with the first that ends in an error: the one with the cause has time to say it.
        if self.meetings.is_left() {
            std::thread::sleep(FORWARDING);
        }
    }
}
