//! Meetings of all processes: before they exchange anything, each says what it is about to do. Where they do not all say the same, all
//! of them know it, and none waits for another that will not come.

#![allow(unsafe_code)]

use std::ffi::c_int;
use std::fmt;
use std::ptr::null_mut;
use std::time::{Duration, Instant};

use crate::error::PetscError;
use crate::mpi::{self, Handle, call_mpi};

/// Time between two checks whether the other processes have arrived.
const LOOK: Duration = Duration::from_millis(1);

/// A call that a process is about to make with the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// A question whether all processes succeeded, with this process's answer.
    Agree { failed: bool },
    /// A number of each process.
    Gather { number: u64 },
    /// A sum of vectors.
    Sum { length: u64 },
    /// No further call.
    End { failed: bool },
}

impl Call {
    fn words(self) -> [u64; 2] {
        match self {
            Call::Agree { failed } => [0, u64::from(failed)],
            Call::Gather { number } => [1, number],
            Call::Sum { length } => [2, length],
            Call::End { failed } => [3, u64::from(failed)],
        }
    }

    fn of_words(words: [u64; 2]) -> Self {
        match words {
            [0, failed] => Call::Agree { failed: failed != 0 },
            [1, number] => Call::Gather { number },
            [2, length] => Call::Sum { length },
            [_, failed] => Call::End { failed: failed != 0 },
        }
    }

    /// Whether both can be made together.
    fn fits(self, other: Call) -> bool {
        match (self, other) {
            (Call::Sum { length }, Call::Sum { length: other }) => length == other,
            (one, other) => one.words()[0] == other.words()[0],
        }
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Call::Agree { .. } => f.write_str("a question whether all succeeded"),
            Call::Gather { .. } => f.write_str("a comparison"),
            Call::Sum { length } => write!(f, "a sum of {length} numbers"),
            Call::End { .. } => f.write_str("the end"),
        }
    }
}

/// Checks that all processes make the same call. The error names the processes that make another one.
pub(crate) fn check_same(own: Call, all: &[Call]) -> Result<(), PetscError> {
    let others = |is_one: &dyn Fn(&Call) -> bool| -> Vec<usize> {
        all.iter().enumerate().filter(|(_, call)| is_one(call)).map(|(rank, _)| rank).collect()
    };
    let failed = others(&|call| *call == Call::End { failed: true });
    if let (false, false) = (failed.is_empty(), matches!(own, Call::End { .. })) {
        return Err(PetscError::Failed { processes: failed });
    }
    let Some(other) = all.iter().find(|call| !own.fits(**call)).copied() else { return Ok(()) };
    let processes = others(&|call| *call == other);
    Err(PetscError::OtherCalls { processes, elsewhere: other.to_string(), here: own.to_string() })
}

/// The processes' way to talk, apart from PETSc's messages.
#[derive(Debug)]
pub(crate) struct Meetings {
    communicator: Handle,
    size: usize,
}

impl Meetings {
    /// Between all `size` processes of a communicator.
    pub fn new(among: Handle, size: usize) -> Result<Self, PetscError> {
        let mut communicator = null_mut();
        // SAFETY: MPI has been started, and writes the handle.
        unsafe { call_mpi!(MPI_Comm_dup(among, &mut communicator))? };
        Ok(Meetings { communicator, size })
    }

    /// Statements of all processes. `None` if some have not come by the end of `patience`; then there is no further meeting.
    pub fn all(&self, own: Call, patience: Option<Duration>) -> Result<Option<Vec<Call>>, PetscError> {
        let words = Box::new(own.words());
        let mut all = vec![[0_u64; 2]; self.size];
        let (mut request, mut done) = (null_mut(), 0 as c_int);
        let kind = mpi::unsigned();
        // SAFETY: two numbers from here and two from each process, for which there is room; both lists stay where they are until the
        // request is done, or for ever.
        unsafe {
            let (own, all) = (words.as_ptr().cast(), all.as_mut_ptr().cast());
            call_mpi!(MPI_Iallgather(own, 2, kind, all, 2, kind, self.communicator, &mut request))?;
        }
        let Some(patience) = patience else {
            // SAFETY: the request that was just made; its status is not asked for.
            unsafe { call_mpi!(MPI_Wait(&mut request, null_mut()))? };
            return Ok(Some(all.into_iter().map(Call::of_words).collect()));
        };
        let start = Instant::now();
        loop {
            // SAFETY: as above.
            unsafe { call_mpi!(MPI_Test(&mut request, &mut done, null_mut()))? };
            if done != 0 {
                return Ok(Some(all.into_iter().map(Call::of_words).collect()));
            }
            if start.elapsed() > patience {
                // MPI may still write there.
                std::mem::forget((words, all));
                return Ok(None);
            }
            std::thread::sleep(LOOK);
        }
    }

    /// The sums over all processes of as many numbers of each: added in an order that follows from the number of processes only, with
    /// the same bits on all.
    pub fn sum(&self, own: &[f64]) -> Result<Vec<f64>, PetscError> {
        let too_many = PetscError::TooMany { what: "numbers", count: own.len() };
        let count = c_int::try_from(own.len()).map_err(|_| too_many)?;
        let mut sum = vec![0.0_f64; own.len()];
        // SAFETY: both lists have `count` doubles, on all processes.
        unsafe {
            let (from, to) = (own.as_ptr().cast(), sum.as_mut_ptr().cast());
            call_mpi!(MPI_Allreduce(from, to, count, mpi::double(), mpi::sum(), self.communicator))?;
        }
        Ok(sum)
    }

    /// Ends all processes, wherever they are.
    pub fn abort(&self) -> ! {
        // SAFETY: a communicator of all processes.
        unsafe { mpi::MPI_Abort(self.communicator, 1) };
        // It does not return; where it does, mpirun ends the others when this process is gone.
        std::process::abort()
    }

    /// Gives the communicator back, on all processes.
    pub fn close(&mut self) {
        // SAFETY: the communicator that was made in `new`, which is not used any more.
        unsafe { mpi::MPI_Comm_free(&mut self.communicator) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_that_others_do_not_make_is_an_error_that_names_them() {
        let sum = |length| Call::Sum { length };
        let said = |own, all: &[Call]| check_same(own, all).unwrap_err().to_string();
        check_same(sum(3), &[sum(3), sum(3)]).unwrap();
        check_same(Call::Gather { number: 1 }, &[Call::Gather { number: 1 }, Call::Gather { number: 2 }])
            .unwrap();
        let same = "all processes have to make the same calls in the same order";
        assert_eq!(
            said(sum(3), &[sum(3), sum(4)]),
            format!("process 1 is at a sum of 4 numbers, this process at a sum of 3 numbers: {same}")
        );
        let (ended, failed) = (Call::End { failed: false }, Call::End { failed: true });
        assert_eq!(
            said(sum(3), &[ended, sum(3), ended]),
            format!("processes 0 and 2 are at the end, this process at a sum of 3 numbers: {same}")
        );
        assert_eq!(said(sum(3), &[sum(3), failed]), "process 1 failed, and says why itself");
        assert!(check_same(failed, &[sum(3), failed]).is_err());
        check_same(failed, &[ended, failed]).unwrap();
    }

    #[test]
    fn words_are_read_back() {
        let calls = [
            Call::Agree { failed: true },
            Call::Gather { number: u64::MAX },
            Call::Sum { length: 7 },
            Call::End { failed: false },
        ];
        calls.into_iter().for_each(|call| assert_eq!(Call::of_words(call.words()), call));
    }
}
