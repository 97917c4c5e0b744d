//! The number of threads that a computation may use.
//!
//! Results do not depend on it, to the last bit: work is cut into pieces whose sums are formed in a fixed order.

use std::num::NonZeroUsize;
use std::str::FromStr;
use std::sync::{Mutex, Once, PoisonError};

use rayon::prelude::*;

/// A number of threads, from one to [`Threads::MOST`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Threads(NonZeroUsize);

/// Below this many numbers, handing work to other threads takes longer than doing it.
const WORTHWHILE: usize = 1 << 15;

impl Threads {
    /// The calling thread alone.
    pub const ONE: Threads = Threads(NonZeroUsize::MIN);

    /// The largest number of threads: more than any machine has cores, and few enough to be started.
    pub const MOST: usize = 1024;

    /// This many threads; zero counts as one, and more than [`Threads::MOST`] as that.
    pub fn new(count: usize) -> Self {
        Threads(NonZeroUsize::new(count.min(Self::MOST)).unwrap_or(NonZeroUsize::MIN))
    }

    /// One per core, or as many as the environment variable `RAYON_NUM_THREADS` says, [`Threads::MOST`] at most.
    pub fn all() -> Self {
        start_pool();
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

    /// Results of the tasks, in their order. There are at most as many tasks as threads.
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
    start_pool();
    (0..count).into_par_iter().with_max_len(1).for_each(work);
}

/// Starts the pool where the environment asks for more threads than [`Threads::MOST`]: rayon would ask the system for all of
/// them, and panic where it gets none. All else that the environment says is left to rayon.
fn start_pool() {
    static STARTED: Once = Once::new();
    STARTED.call_once(|| {
        // The second is an older name of the first.
        let asked =
            ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"].into_iter().find_map(|name| std::env::var(name).ok());
        if asked.and_then(|text| text.parse::<usize>().ok()).is_some_and(|count| count > Threads::MOST) {
            // A program that has started the pool by itself keeps its own.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(Threads::MOST).build_global();
        }
    });
}

impl Default for Threads {
    /// [`Threads::all`].
    fn default() -> Self {
        Threads::all()
    }
}

impl FromStr for Threads {
    type Err = String;

    /// The number in a text, as a user gives it to a program.
    ///
    /// # Errors
    /// One line: the text is no whole number from one to [`Threads::MOST`].
    fn from_str(text: &str) -> Result<Self, String> {
        if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err("a whole number of threads is needed".into());
        }
        match text.parse::<usize>() {
            Ok(0) => Err("at least one thread is needed".into()),
            Ok(count) if count <= Self::MOST => Ok(Threads::new(count)),
            _ => Err(format!("at most {} threads are started", Self::MOST)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Threads;

    #[test]
    fn numbers_that_nobody_means_are_bounded() {
        assert_eq!([0, 1, 2, 1024].map(|count| Threads::new(count).count()), [1, 1, 2, 1024]);
        for count in [1025, 100_000_000, 1_000_000_000_000, usize::MAX] {
            assert_eq!(Threads::new(count).count(), Threads::MOST);
            let results = Threads::new(count).run((0..100).collect(), |number: usize| 2 * number);
            assert_eq!(results.iter().sum::<usize>(), 9900);
        }
    }

    #[test]
    fn texts_are_read() {
        let found = |text: &str| text.parse().map(Threads::count);
        assert_eq!((found("1"), found("1024")), (Ok(1), Ok(1024)));
        assert_eq!(found("0"), Err("at least one thread is needed".into()));
        for text in ["1025", "100000000", "1000000000000", "18446744073709551615", &"9".repeat(60)] {
            assert_eq!(found(text), Err("at most 1024 threads are started".into()), "{text}");
        }
        for text in ["", "-1", "2.5", "many", "1e3", "+2 "] {
            assert_eq!(found(text), Err("a whole number of threads is needed".into()), "{text}");
        }
    }
}
