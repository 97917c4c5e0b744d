//! The thread of a problem. The problem is made there and stays there, so that callers may be threads of any language, and a panic
//! ends only that thread.

use std::any::Any;
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use forms_fem::inverse::{DifferentiableMap, MapError, Part};
use thiserror::Error;

use crate::parameters::{ParameterError, Parameters};

/// A failure of a problem, with its message.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Failure {
    /// Arrays or parameters that do not fit.
    #[error("{0}")]
    Input(String),
    /// Equations that were not solved, or a problem that could not be made.
    #[error("{0}")]
    Problem(String),
    /// A panic, after which the problem is not used any more.
    #[error("the problem panicked, and cannot be used any more: {0}")]
    Panic(String),
}

impl From<MapError> for Failure {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Length { .. } | MapError::NotFinite { .. } => Failure::Input(error.to_string()),
            MapError::ResultNotFinite { .. } | MapError::Problem(_) => Failure::Problem(error.to_string()),
        }
    }
}

/// A problem in a thread of its own. Calls wait for one another; dropping it ends the thread.
#[derive(Debug)]
pub struct ProblemThread {
    /// `None` only while the thread is dropped.
    requests: Option<Sender<Request>>,
    thread: Option<JoinHandle<()>>,
    shape: Shape,
}

/// Fixed parts of a problem.
#[derive(Clone, Debug)]
struct Shape {
    inputs: Vec<Part>,
    outputs: Vec<Part>,
    start: Vec<f64>,
}

/// A call, as it is carried to the problem.
type Call = Box<dyn FnOnce(&mut dyn DifferentiableMap) -> Result<Vec<f64>, MapError> + Send>;

/// A call, and where its answer goes.
struct Request {
    call: Call,
    answer: Sender<Result<Vec<f64>, Failure>>,
}

/// Stack of a problem's thread \[bytes\]: that of a main thread on Linux.
const STACK: usize = 8 << 20;

impl ProblemThread {
    /// Makes a problem of parameters in a thread of its own.
    ///
    /// # Errors
    /// [`Failure`]: of the constructor, of parameters that it does not know.
    pub fn open<M: DifferentiableMap + 'static>(
        constructor: impl FnOnce(&mut Parameters) -> Result<M, Box<dyn Error>> + Send + 'static,
        mut parameters: Parameters,
    ) -> Result<Self, Failure> {
        let (requests, received) = channel();
        let (opened, shape) = channel();
        let live = move || {
            let made = caught(|| {
                let made = constructor(&mut parameters);
                // An unknown name may be the reason why a constructor fails.
                parameters.all_known().map_err(|why| Failure::Input(why.to_string()))?;
                made.map_err(|why| match why.downcast_ref::<ParameterError>() {
                    Some(why) => Failure::Input(why.to_string()),
                    None => Failure::Problem(why.to_string()),
                })
            });
            let described = made.and_then(|map| {
                caught(|| {
                    let shape = Shape { inputs: map.inputs(), outputs: map.outputs(), start: map.start() };
                    Ok((map, shape))
                })
            });
            match described {
                Ok((map, shape)) => {
                    // Who opened it waits for this.
                    if opened.send(Ok(shape)).is_ok() {
                        serve(map, &received);
                    }
                }
                Err(why) => drop(opened.send(Err(why))),
            }
        };
        let started = std::thread::Builder::new().name("problem".to_owned()).stack_size(STACK).spawn(live);
        let thread = started.map_err(|why| Failure::Problem(format!("no thread for the problem: {why}")))?;
        let shape = shape.recv().unwrap_or_else(|_| Err(ended()))?;
        Ok(ProblemThread { requests: Some(requests), thread: Some(thread), shape })
    }

    /// See [`DifferentiableMap::inputs`].
    pub fn inputs(&self) -> &[Part] {
        &self.shape.inputs
    }

    /// See [`DifferentiableMap::outputs`].
    pub fn outputs(&self) -> &[Part] {
        &self.shape.outputs
    }

    /// See [`DifferentiableMap::start`].
    pub fn start(&self) -> &[f64] {
        &self.shape.start
    }

    /// See [`DifferentiableMap::value`].
    ///
    /// # Errors
    /// [`Failure`].
    pub fn value(&self, m: Vec<f64>) -> Result<Vec<f64>, Failure> {
        self.ask(Box::new(move |map| map.value(&m)))
    }

    /// The value of a map with one output, followed by its gradient.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn value_and_gradient(&self, m: Vec<f64>) -> Result<Vec<f64>, Failure> {
        // The gradient is computed first, because the value comes with it.
        self.ask(Box::new(move |map| {
            let gradient = map.vjp(&m, &[1.0])?;
            let mut both = map.value(&m)?;
            both.extend(gradient);
            Ok(both)
        }))
    }

    /// See [`DifferentiableMap::vjp`].
    ///
    /// # Errors
    /// [`Failure`].
    pub fn vjp(&self, m: Vec<f64>, cotangent: Vec<f64>) -> Result<Vec<f64>, Failure> {
        self.ask(Box::new(move |map| map.vjp(&m, &cotangent)))
    }

    /// See [`DifferentiableMap::jvp`].
    ///
    /// # Errors
    /// [`Failure`].
    pub fn jvp(&self, m: Vec<f64>, direction: Vec<f64>) -> Result<Vec<f64>, Failure> {
        self.ask(Box::new(move |map| map.jvp(&m, &direction)))
    }

    /// See [`DifferentiableMap::jacobian`]; the rows one after the other.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn jacobian(&self, m: Vec<f64>) -> Result<Vec<f64>, Failure> {
        self.ask(Box::new(move |map| Ok(map.jacobian(&m)?.concat())))
    }

    fn ask(&self, call: Call) -> Result<Vec<f64>, Failure> {
        let (answer, answered) = channel();
        let sent = self.requests.as_ref().map(|requests| requests.send(Request { call, answer }));
        match sent {
            Some(Ok(())) => answered.recv().unwrap_or_else(|_| Err(ended())),
            _ => Err(ended()),
        }
    }
}

impl Drop for ProblemThread {
    fn drop(&mut self) {
        self.requests = None;
        if let Some(thread) = self.thread.take() {
            // It has caught its panics, and there is no one to tell of another.
            drop(thread.join());
        }
    }
}

fn ended() -> Failure {
    Failure::Panic("its thread has ended".to_owned())
}

/// Answers requests until no caller is left. After a panic every answer is that panic.
fn serve<M: DifferentiableMap>(map: M, requests: &Receiver<Request>) {
    let mut live = Ok(map);
    while let Ok(Request { call, answer }) = requests.recv() {
        let found = match &mut live {
            Ok(map) => caught(|| call(map).map_err(Failure::from)),
            Err(why) => Err(Failure::clone(why)),
        };
        if let Err(why @ Failure::Panic(_)) = &found
            && let Ok(broken) = std::mem::replace(&mut live, Err(why.clone()))
        {
            // The interrupted value may panic again when it is dropped.
            drop(catch_unwind(AssertUnwindSafe(|| drop(broken))));
        }
        // Who asked may have gone.
        drop(answer.send(found));
    }
}

/// A panic of the called function becomes a failure.
pub(crate) fn caught<T>(call: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    // After a panic the interrupted state is not used again.
    catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| Err(Failure::Panic(message(&*panic))))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it said nothing").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x ↦ (x₀², x₀ x₁), which panics at x₀ > 10 and fails at x₀ < −10.
    struct Products;

    impl DifferentiableMap for Products {
        fn inputs(&self) -> Vec<Part> {
            vec![Part::new("x", 2)]
        }

        fn outputs(&self) -> Vec<Part> {
            vec![Part::new("square", 1), Part::new("product", 1)]
        }

        fn start(&self) -> Vec<f64> {
            vec![1.0, 2.0]
        }

        fn value(&mut self, m: &[f64]) -> Result<Vec<f64>, MapError> {
            assert!(m[0] <= 10.0, "{} is too much", m[0]);
            if m[0] < -10.0 {
                return Err(MapError::Problem("too little".into()));
            }
            Ok(vec![m[0] * m[0], m[0] * m[1]])
        }

        fn vjp(&mut self, m: &[f64], w: &[f64]) -> Result<Vec<f64>, MapError> {
            Ok(vec![2.0 * w[0] * m[0] + w[1] * m[1], w[1] * m[0]])
        }
    }

    fn open(given: &[(&str, f64)]) -> Result<ProblemThread, Failure> {
        let given = given.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let constructor = |parameters: &mut Parameters| {
            let size = parameters.count("size", 2)?;
            if size == 3 {
                return Err("three is not to be had".into());
            }
            assert!(size != 4, "four");
            Ok(Products)
        };
        ProblemThread::open(constructor, Parameters::new(given).unwrap())
    }

    #[test]
    fn products_with_the_jacobian_from_several_threads() {
        let problem = open(&[]).unwrap();
        assert_eq!((problem.start(), problem.outputs()[1].name.as_str()), (&[1.0, 2.0][..], "product"));
        std::thread::scope(|scope| {
            for k in 0..4 {
                let problem = &problem;
                scope.spawn(move || {
                    let m = vec![f64::from(k), 3.0];
                    assert_eq!(problem.value(m.clone()).unwrap(), [m[0] * m[0], 3.0 * m[0]]);
                    assert_eq!(problem.jacobian(m.clone()).unwrap(), [2.0 * m[0], 0.0, 3.0, m[0]]);
                    assert_eq!(
                        problem.jvp(m.clone(), vec![1.0, 2.0]).unwrap(),
                        [2.0 * m[0], 3.0 + 2.0 * m[0]]
                    );
                });
            }
        });
        let why = problem.jvp(vec![0.0; 2], vec![0.0; 3]).unwrap_err();
        assert_eq!(why.to_string(), "the direction has 3 values; the map has 2: `x` (2)");
    }

    #[test]
    fn failures_and_panics_stay_in_the_thread() {
        let opened = |given| open(given).unwrap_err();
        assert!(matches!(opened(&[("size", 0.5)]), Failure::Input(why) if why.contains("`size` is 0.5")));
        assert!(
            matches!(opened(&[("sise", 1.0)]), Failure::Input(why) if why.contains("no parameter `sise`"))
        );
        assert_eq!(opened(&[("size", 3.0)]), Failure::Problem("three is not to be had".into()));
        assert_eq!(opened(&[("size", 4.0)]), Failure::Panic("four".into()));

        let problem = open(&[]).unwrap();
        assert_eq!(problem.value(vec![-11.0, 0.0]), Err(Failure::Problem("too little".into())));
        assert_eq!(problem.value(vec![2.0, 0.0]), Ok(vec![4.0, 0.0]));
        let broken = Err(Failure::Panic("11 is too much".into()));
        assert_eq!(problem.value(vec![11.0, 0.0]), broken);
        assert_eq!(problem.value(vec![2.0, 0.0]), broken);
    }
}
