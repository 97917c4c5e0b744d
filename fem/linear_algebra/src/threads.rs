//! The number of threads that a computation may use.
//!
//! Results do not depend on it, to the last bit: work is cut into pieces whose sums are formed in a fixed order.

use std::num::NonZeroUsize;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// A number of threads, at least one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Threads(NonZeroUsize);

/// Below this many numbers, handing work to other threads takes longer than doing it.
const WORTHWHILE: usize = 1 << 15;

impl Threads {
    /// The calling thread alone.
    pub const ONE: Threads = Threads(NonZeroUsize::MIN);

    /// The given number of threads; zero counts as one.
    pub fn new(count: usize) -> Self {
        Threads(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN))
    }

    /// One per core, or as many as the environment variable `RAYON_NUM_THREADS` says.
    pub fn all() -> Self {
        Threads::new(rayon::current_num_threads())
    }

    /// The number.
    pub fn count(self) -> usize {
        self.0.get()
    }

    /// Number of parts into which a loop over the given number of numbers is worth cutting.
    #[doc(hidden)]
    pub fn for_work(self, numbers: usize) -> usize {
        if numbers < WORTHWHILE { 1 } else { self.count() }
    }

    /// Runs the tasks, no more than there are threads, and gives their results in their order.
    #[doc(hidden)]
    pub fn run<T: Send, R: Send>(self, tasks: Vec<T>, work: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
        if self == Threads::ONE || tasks.len() < 2 {
            return tasks.into_iter().map(work).collect();
        }
        let (tasks, results): (Vec<_>, Vec<_>) =
            tasks.into_iter().map(|task| (Mutex::new(Some(task)), Mutex::new(None))).unzip();
        on_threads(tasks.len(), &|number| {
            let task = tasks[number].lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(task) = task {
                let result = work(task);
                *results[number].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            }
        });
        // Each number was called once, or its panic has come here.
        results
            .into_iter()
            .filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner))
            .collect()
    }
}

/// Calls `work` with each number below `count`, each as a task of its own. Not generic: what rayon needs is compiled
/// once and not for every kernel.
fn on_threads(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(work);
}

impl Default for Threads {
    /// [`Threads::all`].
    fn default() -> Self {
        Threads::all()
    }
}
