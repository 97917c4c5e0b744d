//! Events of a motion: numbers of its state that pass zero in a step, and steps that end there.

use std::fmt;

use super::adaptive_steps::AdaptiveSteps;
use super::checkpoint::Checkpoint;
use super::error::{StepError, StepFailure};
use super::step::{State, Taken};
use super::time_loop::TimeLoop;
use crate::instantiate::instantiate;
use crate::output::Crossing;

/// Numbers of a state, as a gap, or a force above a threshold, that are watched while steps are taken. A number passes zero in a step
/// where it is positive at one end and zero or less at the other; what passes and comes back within a step is not seen.
///
/// Passages are found on the straight line between the two ends, and the step stays whole. With [`Events::located`] the step is taken
/// again, shorter, until it ends just behind its first passage.
///
/// ```
/// # use forms_fem::prelude::*;
/// # use forms_fem::time::operators::scalar;
/// use forms_fem::time::{Events, GeneralisedAlpha, State, Step, TimeLoop};
///
/// #[forms(dimension = 2)]
/// mod fall {
///     use forms_fem::time::operators::scalar::second_rate;
///
///     #[includes(forms_fem::time::operators::scalar::Data)]
///     pub struct Data {}
///     #[cells]
///     pub struct Omega;
///
///     pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         integral(Omega, (second_rate(u) + 2) * v)
///     }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?;
/// # let space = Space::scalar(&mesh, 1)?;
/// let height = Field::interpolate(&space, |_| 9.0)?;
/// let form = |step: &Step<2>| fall::Model::new(fall::data_from(step)).motion();
/// let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), State::at_rest(0.0, height));
/// let mut events = Events::new().of("height", |state: &State<2>| Ok(state.value.values()[0])).located(1e-10)?;
/// loop {
///     let step = events.take(&mut motion, 0.7)?;
///     if let Some(event) = step.events.first() {
///         assert!(event.name == "height" && !event.passage.rises && (step.taken.to - 3.0).abs() < 1e-10);
///         break;
///     }
/// }
/// # Ok(())
/// # }
/// ```
pub struct Events<'a, const D: usize> {
    watched: Vec<(String, NumberOf<'a, D>)>,
    within: Option<f64>,
}

type NumberOf<'a, const D: usize> = Box<dyn Fn(&[State<D>]) -> Result<f64, NumberError> + 'a>;

/// Reason why a state has no such number.
pub type NumberError = Box<dyn std::error::Error + Send + Sync>;

impl<const D: usize> fmt::Debug for Events<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.watched.iter().map(|(name, _)| &**name).collect();
        f.debug_struct("Events").field("watched", &names).field("within", &self.within).finish()
    }
}

/// A number that has passed zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The name of the number.
    pub name: String,
    /// Time and direction. The time lies on the straight line between the ends of the step in which it passes, and of a located
    /// event between the last two tries.
    pub passage: Crossing,
}

/// A step with the events in it.
#[derive(Clone, Debug)]
pub struct EventFunction<const D: usize> {
    /// The step.
    pub taken: Taken<D>,
    /// Its events, in the order of time.
    pub events: Vec<Event>,
    /// Steps that were tried and taken back on the way to the event.
    pub tries: usize,
}

/// Values of the numbers at a time.
type Values = (f64, Vec<f64>);

/// Secants in a row; then the interval is halved, so that it shrinks whatever the numbers do between its ends.
const SECANTS: usize = 2;

impl<'a, const D: usize> Events<'a, D> {
    /// An empty list of events.
    pub fn new() -> Self {
        Events { watched: vec![], within: None }
    }

    /// A further number of the state of the first unknown, which passes zero.
    pub fn of(self, name: &str, number: impl Fn(&State<D>) -> Result<f64, NumberError> + 'a) -> Self {
        self.of_states(name, move |states| number(&states[0]))
    }

    /// A further number of the states of all unknowns.
    pub fn of_states(
        mut self,
        name: &str,
        number: impl Fn(&[State<D>]) -> Result<f64, NumberError> + 'a,
    ) -> Self {
        self.watched.push((name.to_owned(), Box::new(number)));
        self
    }

    /// Steps end at their first event: behind it, by at most this \[time\]. Each try is a step of its own size, with its own matrix.
    ///
    /// # Errors
    /// [`StepFailure::Tolerance`] for what is no positive number.
    pub fn located(mut self, within: f64) -> Result<Self, StepFailure> {
        if !(within > 0.0 && within.is_finite()) {
            return Err(StepFailure::Tolerance(within));
        }
        self.within = Some(within);
        Ok(self)
    }

    /// A step of a size, or a shorter one to its first event.
    ///
    /// # Errors
    /// [`StepError`]; the last state is then what it was.
    pub fn take(&mut self, motion: &mut TimeLoop<'_, D>, size: f64) -> Result<EventFunction<D>, StepError> {
        self.take_by(motion, &mut |motion| motion.take(size))
    }

    /// A step whose size adapts itself and which ends at `until` at the latest, or a shorter one to its first event.
    ///
    /// # Errors
    /// As [`AdaptiveSteps::take`]; the last state is then what it was.
    pub fn take_adaptive(
        &mut self,
        motion: &mut TimeLoop<'_, D>,
        steps: &mut AdaptiveSteps,
        until: f64,
    ) -> Result<EventFunction<D>, StepError> {
        self.take_by(motion, &mut |motion| steps.take(motion, until))
    }

    #[inline(never)]
    fn take_by(
        &mut self,
        motion: &mut TimeLoop<'_, D>,
        take: &mut dyn FnMut(&mut TimeLoop<'_, D>) -> Result<Taken<D>, StepError>,
    ) -> Result<EventFunction<D>, StepError> {
        let start = motion.checkpoint();
        let watched = self.try_take(motion, &start, take);
        if watched.is_err() {
            motion.go_back(start);
        }
        watched
    }

    fn try_take(
        &self,
        motion: &mut TimeLoop<'_, D>,
        start: &Checkpoint<D>,
        take: &mut dyn FnMut(&mut TimeLoop<'_, D>) -> Result<Taken<D>, StepError>,
    ) -> Result<EventFunction<D>, StepError> {
        let mut low = self.values(motion)?;
        let mut taken = take(motion)?;
        let (mut high, mut end, mut tries) = (self.values(motion)?, motion.checkpoint(), 0);
        let Some(within) = self.within else {
            return Ok(EventFunction { taken, events: self.between(&low, &high), tries });
        };
        while let Some(first) = first_passage(&low, &high).filter(|_| high.0 - low.0 > within) {
            let to = match tries % (SECANTS + 1) {
                SECANTS => 0.5 * (low.0 + high.0),
                // So far from the ends that the interval may come to an end from one side.
                _ => first.clamp(low.0 + 0.5 * within, high.0 - 0.5 * within),
            };
            if to <= low.0 || to >= high.0 {
                // Neighbouring numbers.
                break;
            }
            motion.go_back(start.clone());
            tries += 1;
            let shorter = motion.take_to(to)?;
            let values = self.values(motion)?;
            match first_passage(&low, &values) {
                Some(_) => (taken, high, end) = (shorter, values, motion.checkpoint()),
                None => low = values,
            }
        }
        motion.go_back(end);
        Ok(EventFunction { taken, events: self.between(&low, &high), tries })
    }

    /// The events between two times.
    fn between(&self, low: &Values, high: &Values) -> Vec<Event> {
        let passed = self.watched.iter().zip(low.1.iter().zip(&high.1));
        let mut events: Vec<Event> = passed
            .filter_map(|((name, _), (before, after))| {
                let passage = Crossing::of_zero([low.0, high.0], [*before, *after])?;
                Some(Event { name: name.clone(), passage })
            })
            .collect();
        events.sort_by(|one, other| one.passage.time.total_cmp(&other.passage.time));
        events
    }

    fn values(&self, motion: &TimeLoop<'_, D>) -> Result<Values, StepError> {
        let (state, states) = (motion.state(), motion.states());
        let number = |(name, number): &(String, NumberOf<'a, D>)| {
            let found = number(states).and_then(|value| match value.is_finite() {
                true => Ok(value),
                false => Err(format!("it is {value}").into()),
            });
            found.map_err(|why| StepError {
                from: state.time,
                to: state.time,
                why: StepFailure::Event { name: name.clone(), why },
            })
        };
        Ok((state.time, self.watched.iter().map(number).collect::<Result<_, _>>()?))
    }
}

/// The first time at which one of the numbers passes zero between two times, by straight lines.
fn first_passage(low: &Values, high: &Values) -> Option<f64> {
    let values = low.1.iter().zip(&high.1);
    let passages = values.filter_map(|(before, after)| Crossing::of_zero([low.0, high.0], [*before, *after]));
    passages.map(|passage| passage.time).reduce(f64::min)
}

impl<const D: usize> Default for Events<'_, D> {
    fn default() -> Self {
        Events::new()
    }
}

instantiate!(events: Events::<D>::take_by);
