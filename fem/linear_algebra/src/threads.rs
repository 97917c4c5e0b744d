//! The number of threads that a computation may use.
//!
//! Results do not depend on it, to the last bit: work is cut into pieces whose sums are formed in a fixed order.

use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::str::FromStr;
use std::sync::{Mutex, Once, OnceLock, PoisonError};

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

    /// The environment variable with the number of threads of a program.
    pub const VARIABLE: &'static str = "FORMS_THREADS";

    /// The number in the environment variable `FORMS_THREADS`. Without it as many as the process may use: one for each core of its affinity, or less
    /// where a container has a limit. [`Threads::MOST`] at most. A value that is no such number counts as one; [`Threads::from_environment`] says what
    /// is wrong with it.
    pub fn all() -> Self {
        start_pool();
        // Where a program has started a pool by itself, that may be smaller.
        match from_environment() {
            Ok(None) => Threads::new(rayon::current_num_threads()),
            Ok(Some(asked)) => *asked,
            Err(_) => Threads::ONE,
        }
    }

    /// The number that the environment variable `FORMS_THREADS` has at the first call; none without it.
    ///
    /// # Errors
    /// One line that names the variable: its value is no whole number from one to [`Threads::MOST`].
    pub fn from_environment() -> Result<Option<Self>, String> {
        from_environment().clone()
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

    /// Work on some items. Each thread takes the next one that is left, so that items may differ in their cost.
    pub(crate) fn share<T: Send>(self, items: Vec<T>, work: impl Fn(T) + Send + Sync) {
        let workers = self.count().min(items.len()).max(1);
        let items = Mutex::new(items.into_iter());
        let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
        self.run(vec![(); workers], |()| {
            while let Some(item) = next() {
                work(item);
            }
        });
    }

    /// Results of two tasks of different kinds.
    pub(crate) fn both<A: Send, B: Send>(
        self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if self == Threads::ONE {
            return (one(), other());
        }
        start_pool();
        rayon::join(one, other)
    }
}

/// Calls `work` with each number below `count`, each as a task of its own. Not generic: what rayon needs is compiled
/// once and not for every kernel.
fn on_threads(count: usize, work: &(dyn Fn(usize) + Sync)) {
    start_pool();
    (0..count).into_par_iter().with_max_len(1).for_each(work);
}

/// Reads the environment variable once.
fn from_environment() -> &'static Result<Option<Threads>, String> {
    static FOUND: OnceLock<Result<Option<Threads>, String>> = OnceLock::new();
    FOUND.get_or_init(|| read(std::env::var_os(Threads::VARIABLE)))
}

/// The number in the value of the environment variable.
fn read(value: Option<OsString>) -> Result<Option<Threads>, String> {
    let Some(value) = value else { return Ok(None) };
    let text = value.to_string_lossy();
    let named = |error| format!("{} is \"{text}\": {error}", Threads::VARIABLE);
    text.trim().parse().map(Some).map_err(named)
}

/// Starts the pool with the number of threads that the environment asks for, [`Threads::MOST`] at most: of more the system might have
/// none left. Without such a number rayon takes what the process may use.
fn start_pool() {
    static STARTED: Once = Once::new();
    STARTED.call_once(|| {
        // These are rayon's own; the second is an older name of the first.
        let of_rayon = || {
            let text = ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"]
                .into_iter()
                .find_map(|name| std::env::var(name).ok());
            text.and_then(|text| text.parse::<usize>().ok()).filter(|count| *count > Threads::MOST)
        };
        let asked = match from_environment() {
            Ok(Some(asked)) => Some(asked.count()),
            Ok(None) => of_rayon().map(|_| Threads::MOST),
            Err(_) => Some(1),
        };
        if let Some(count) = asked {
            // A program that has started the pool by itself keeps its own.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(count).build_global();
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
    use super::{Threads, read};

    #[test]
    fn the_environment_says_a_number_or_what_is_wrong_with_it() {
        assert_eq!(read(None), Ok(None));
        assert_eq!(read(Some(" 3 ".into())), Ok(Some(Threads::new(3))));
        let message = "FORMS_THREADS is \"many\": a whole number of threads is needed";
        assert_eq!(read(Some("many".into())), Err(message.into()));
        for text in ["", "0", "-2", "2.5", "1025"] {
            let error = read(Some(text.into())).unwrap_err();
            assert!(error.starts_with(&format!("FORMS_THREADS is \"{text}\": ")), "{error}");
        }
    }

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
