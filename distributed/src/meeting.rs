//! Meetings of all processes: before they exchange anything, each says what it is about to do. Where they do not all say the same, all
//! of them know it, and none waits for another that will not come.

#![allow(unsafe_code)]

use std::cell::Cell;
use std::ffi::c_int;
use std::fmt;
use std::ptr::null_mut;
use std::time::{Duration, Instant};

use crate::error::PetscError;
use crate::mpi::{self, Handle, call_mpi};

/// Time between two checks whether the other processes have arrived.
const LOOK: Duration = Duration::from_millis(1);

/// Most numbers that go along with a statement.
const ALONG: usize = 6;

/// A call that a process is about to make with the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// A question whether all processes succeeded, with this process's answer.
    Agree { failed: bool },
    /// A number of each process.
    Gather { number: u64 },
    /// Numbers of each process, as many of each.
    List { length: u64 },
    /// A sum of vectors.
    Sum { length: u64 },
    /// No further call.
    End { failed: bool },
    /// Lists from process to process, with a number of their own.
    Exchange { number: u64 },
    /// The same of a process that has nothing to send, because it failed: there is no exchange then.
    NoExchange { number: u64 },
}

/// Counts of a process's messages so far, apart from PETSc's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Collective calls.
    pub collective: u64,
    /// Messages to single processes.
    pub messages: u64,
    /// Bytes in these messages.
    pub bytes: u64,
}

/// A call with the numbers that go along.
type Statement = (Call, [u64; ALONG]);

/// Lists for other processes, by rank.
pub(crate) type Lists = Vec<(usize, Vec<u64>)>;

impl Call {
    fn words(self) -> [u64; 2] {
        match self {
            Call::Agree { failed } => [0, u64::from(failed)],
            Call::Gather { number } => [1, number],
            Call::Sum { length } => [2, length],
            Call::End { failed } => [3, u64::from(failed)],
            Call::Exchange { number } => [4, number],
            Call::List { length } => [5, length],
            Call::NoExchange { number } => [6, number],
        }
    }

    fn of_words(words: [u64; 2]) -> Self {
        match words {
            [0, failed] => Call::Agree { failed: failed != 0 },
            [1, number] => Call::Gather { number },
            [2, length] => Call::Sum { length },
            [4, number] => Call::Exchange { number },
            [5, length] => Call::List { length },
            [6, number] => Call::NoExchange { number },
            [_, failed] => Call::End { failed: failed != 0 },
        }
    }

    /// Whether both can be made together.
    fn fits(self, other: Call) -> bool {
        match (self, other) {
            (Call::Sum { length }, Call::Sum { length: other })
            | (Call::List { length }, Call::List { length: other }) => length == other,
            (
                Call::Exchange { number } | Call::NoExchange { number },
                Call::Exchange { number: other } | Call::NoExchange { number: other },
            ) => number == other,
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
            Call::List { length } => write!(f, "a comparison of {length} numbers"),
            Call::Exchange { number } | Call::NoExchange { number } => {
                write!(f, "an exchange between pieces (number {number:x})")
            }
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
    communicator: Cell<Handle>,
    rank: usize,
    size: usize,
    /// Whether another process made another call, as one that failed does.
    is_left: Cell<bool>,
    traffic: Cell<Traffic>,
}

/// The tag of all messages: two processes exchange them in the order of their calls.
const TAG: c_int = 1;

impl Meetings {
    /// Between all `size` processes of a communicator. This one has the number `rank`.
    pub fn new(among: Handle, rank: usize, size: usize) -> Result<Self, PetscError> {
        let mut communicator = null_mut();
        // SAFETY: MPI has been started, and writes the handle.
        unsafe { call_mpi!(MPI_Comm_dup(among, &mut communicator))? };
        let (communicator, is_left) = (Cell::new(communicator), Cell::new(false));
        Ok(Meetings { communicator, rank, size, is_left, traffic: Cell::default() })
    }

    /// The number of this process.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Whether another process made another call so far.
    pub fn is_left(&self) -> bool {
        self.is_left.get()
    }

    /// Counts of messages so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    fn count(&self, collective: u64, messages: u64, bytes: u64) {
        let Traffic { collective: calls, messages: sent, bytes: size } = self.traffic.get();
        let (collective, messages, bytes) = (calls + collective, sent + messages, size + bytes);
        self.traffic.set(Traffic { collective, messages, bytes });
    }

    /// The communicator, until it is given back.
    fn communicator(&self) -> Result<Handle, PetscError> {
        let at = self.communicator.get();
        if at.is_null() { Err(PetscError::Ended) } else { Ok(at) }
    }

    /// The call that all processes are about to make, which has to be the same.
    pub fn meet(&self, own: Call) -> Result<Vec<Call>, PetscError> {
        Ok(self.meet_with(own, &[])?.into_iter().map(|(call, _)| call).collect())
    }

    /// The same with a few numbers of each process.
    fn meet_with(&self, own: Call, along: &[u64]) -> Result<Vec<Statement>, PetscError> {
        let all = self.statements(own, along, None)?.unwrap_or_default();
        self.same(own, &all.iter().map(|(call, _)| *call).collect::<Vec<_>>())?;
        Ok(all)
    }

    /// As many numbers of each process, in their order: one call for a few of them.
    pub fn gather_lists(&self, own: &[u64]) -> Result<Vec<Vec<u64>>, PetscError> {
        let (mut lists, length) = (vec![vec![]; self.size], own.len() as u64);
        for piece in own.chunks(ALONG) {
            let all = self.meet_with(Call::List { length }, piece)?;
            for (list, (_, numbers)) in lists.iter_mut().zip(all) {
                list.extend_from_slice(&numbers[..piece.len()]);
            }
        }
        Ok(lists)
    }

    /// Takes down whether all processes make the same call.
    pub fn same(&self, own: Call, all: &[Call]) -> Result<(), PetscError> {
        let found = check_same(own, all);
        self.is_left.set(self.is_left.get() || found.is_err());
        found
    }

    /// Sends lists to other processes, and receives one of the given length from each of them: each of them does the same in return, in a
    /// call with the same number.
    pub fn exchange(&self, number: u64, to: Lists, lengths: &[usize]) -> Result<Vec<Vec<u64>>, PetscError> {
        self.exchange_if_all(number, Some(to), lengths)
    }

    /// The same if all processes have lists; else an error on all.
    pub fn exchange_if_all(
        &self,
        number: u64,
        to: Option<Lists>,
        lengths: &[usize],
    ) -> Result<Vec<Vec<u64>>, PetscError> {
        let own = if to.is_some() { Call::Exchange { number } } else { Call::NoExchange { number } };
        let all = self.meet(own)?;
        let count = all.iter().filter(|call| matches!(call, Call::NoExchange { .. })).count();
        let Some(to) = to.filter(|_| count == 0) else { return Err(PetscError::Elsewhere { count }) };
        let (kind, communicator) = (mpi::unsigned(), self.communicator()?);
        let mut from: Vec<Vec<u64>> = lengths.iter().map(|length| vec![0; *length]).collect();
        let count = |list: &[u64]| {
            let too_many = PetscError::TooMany { what: "numbers", count: list.len() };
            c_int::try_from(list.len()).map_err(|_| too_many)
        };
        let mut requests: Vec<Handle> = Vec::with_capacity(2 * to.len());
        let sent: Result<(), PetscError> = (|| {
            for ((rank, _), list) in to.iter().zip(&mut from) {
                let (mut request, count, rank) = (null_mut(), count(list)?, *rank as c_int);
                // SAFETY: a list of as many numbers, which stays where it is until the request is done, or for ever.
                unsafe {
                    let list = list.as_mut_ptr().cast();
                    call_mpi!(MPI_Irecv(list, count, kind, rank, TAG, communicator, &mut request))?;
                }
                requests.push(request);
            }
            for (rank, list) in &to {
                let (mut request, count, rank) = (null_mut(), count(list)?, *rank as c_int);
                // SAFETY: as above.
                unsafe {
                    let list = list.as_ptr().cast();
                    call_mpi!(MPI_Isend(list, count, kind, rank, TAG, communicator, &mut request))?;
                }
                requests.push(request);
            }
            for request in &mut requests {
                // SAFETY: a request that was just made; its status is not asked for.
                unsafe { call_mpi!(MPI_Wait(request, null_mut()))? };
            }
            Ok(())
        })();
        if let Err(error) = sent {
            // MPI may still read and write there.
            std::mem::forget((to, from));
            return Err(error);
        }
        let bytes = to.iter().map(|(_, list)| 8 * list.len() as u64).sum();
        self.count(0, to.len() as u64, bytes);
        Ok(from)
    }

    /// Statements of all processes. `None` if some have not come by the end of `patience`; then there is no further meeting.
    pub fn all(&self, own: Call, patience: Option<Duration>) -> Result<Option<Vec<Call>>, PetscError> {
        let all = self.statements(own, &[], patience)?;
        Ok(all.map(|all| all.into_iter().map(|(call, _)| call).collect()))
    }

    /// The same with the numbers that go along.
    fn statements(
        &self,
        own: Call,
        along: &[u64],
        patience: Option<Duration>,
    ) -> Result<Option<Vec<Statement>>, PetscError> {
        const WORDS: usize = 2 + ALONG;
        let mut words = Box::new([0_u64; WORDS]);
        words[..2].copy_from_slice(&own.words());
        words[2..][..along.len()].copy_from_slice(along);
        let mut all = vec![[0_u64; WORDS]; self.size];
        let read = |words: [u64; WORDS]| {
            let [kind, number, along @ ..] = words;
            (Call::of_words([kind, number]), along)
        };
        let (mut request, mut done) = (null_mut(), 0 as c_int);
        let (kind, communicator) = (mpi::unsigned(), self.communicator()?);
        self.count(1, 0, 0);
        // SAFETY: as many numbers from here as from each process, for which there is room; both lists stay where they are until the
        // request is done, or for ever.
        unsafe {
            let (own, all) = (words.as_ptr().cast(), all.as_mut_ptr().cast());
            let count = WORDS as c_int;
            call_mpi!(MPI_Iallgather(own, count, kind, all, count, kind, communicator, &mut request))?;
        }
        let Some(patience) = patience else {
            // SAFETY: the request that was just made; its status is not asked for.
            unsafe { call_mpi!(MPI_Wait(&mut request, null_mut()))? };
            return Ok(Some(all.into_iter().map(read).collect()));
        };
        let start = Instant::now();
        loop {
            // SAFETY: as above.
            unsafe { call_mpi!(MPI_Test(&mut request, &mut done, null_mut()))? };
            if done != 0 {
                return Ok(Some(all.into_iter().map(read).collect()));
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
        let length = own.len() as u64;
        if own.len() <= ALONG {
            let along: Vec<u64> = own.iter().map(|number| number.to_bits()).collect();
            let mut sums = vec![0.0; own.len()];
            for (_, numbers) in self.meet_with(Call::Sum { length }, &along)? {
                sums.iter_mut().zip(numbers).for_each(|(sum, bits)| *sum += f64::from_bits(bits));
            }
            return Ok(sums);
        }
        self.meet(Call::Sum { length })?;
        let too_many = PetscError::TooMany { what: "numbers", count: own.len() };
        let count = c_int::try_from(own.len()).map_err(|_| too_many)?;
        let mut sum = vec![0.0_f64; own.len()];
        let communicator = self.communicator()?;
        self.count(1, 0, 0);
        // SAFETY: both lists have `count` doubles, on all processes.
        unsafe {
            let (from, to) = (own.as_ptr().cast(), sum.as_mut_ptr().cast());
            call_mpi!(MPI_Allreduce(from, to, count, mpi::double(), mpi::sum(), communicator))?;
        }
        Ok(sum)
    }

    /// Ends all processes, wherever they are.
    pub fn abort(&self) -> ! {
        // SAFETY: a communicator of all processes.
        unsafe { mpi::MPI_Abort(self.communicator.get(), 1) };
        // It does not return; where it does, mpirun ends the others when this process is gone.
        std::process::abort()
    }

    /// Gives the communicator back, on all processes.
    pub fn close(&self) {
        let mut communicator = self.communicator.replace(null_mut());
        // SAFETY: the communicator that was made in `new`, which is not used any more.
        unsafe { mpi::MPI_Comm_free(&mut communicator) };
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
            Call::Exchange { number: 9 },
            Call::List { length: 3 },
            Call::NoExchange { number: 9 },
        ];
        calls.into_iter().for_each(|call| assert_eq!(Call::of_words(call.words()), call));
    }
}
