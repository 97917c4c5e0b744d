//! The sweep over a history, forward and back, with as many stored states as are allowed: where they are fewer than the steps, the
//! others are computed again, by the binomial schedule that needs the fewest steps (Griewank & Walther 2000, Algorithm 799: revolve,
//! ACM Trans. Math. Softw. 26).

use std::io;
use std::path::Path;

use thiserror::Error;

use super::checkpoint_store::{CheckpointStore, InMemory, OnDisk, Storage};
use super::error::{HistoryError, HistoryFailure};
use super::evolution::Evolution;
use crate::verification::Sample;

/// The value of a history's criterion with its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// J.
    pub value: f64,
    /// dJ/dm, an entry per control value.
    pub gradient: Vec<f64>,
    /// Work of the sweep.
    pub work: Work,
}

/// Account of a sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Steps solved, including repeated ones.
    pub steps_solved: usize,
    /// Adjoint steps solved.
    pub steps_reversed: usize,
    /// The most states that were stored at once, that before the first step among them; in addition to them there are the two ends of the
    /// step at hand.
    pub most_stored: usize,
}

/// J, and which switches were on in all steps.
///
/// # Errors
/// Those of the steps.
pub fn value_of<V: Evolution + ?Sized>(evolution: &mut V) -> Result<Sample, V::Error> {
    let mut before = evolution.start()?;
    let (mut value, mut switches) = (0.0, None::<Vec<u32>>);
    for step in 0..evolution.steps() {
        let after = evolution.advance(step, &before)?;
        value += evolution.cost(step, &before, &after)?;
        if let Some(more) = evolution.switches(step, &before, &after)? {
            switches.get_or_insert_default().extend(more);
        }
        before = after;
    }
    Ok(Sample { value: vec![value], active_set: switches })
}

/// J and its gradient, with at most `stored` states in memory (at least one, that before the first step).
///
/// # Errors
/// Those of the steps.
pub fn gradient_of<V: Evolution + ?Sized>(evolution: &mut V, stored: usize) -> Result<Gradient, V::Error> {
    sweep(evolution, stored, InMemory::default()).map_err(|failure| match failure {
        SweepFailure::Step(error) => error,
        SweepFailure::CheckpointStore(never) => match never {},
    })
}

/// The gradient with the states on disk, except for the last one, and as many as are allowed.
///
/// # Errors
/// [`SweepFailure`]: those of the steps, and of the files.
pub fn gradient_on_disk<V: Evolution + ?Sized>(
    evolution: &mut V,
    stored: usize,
    directory: &Path,
) -> Result<Gradient, SweepFailure<V::Error, io::Error>> {
    sweep(evolution, stored, OnDisk::new(directory))
}

/// The same, of histories.
pub(super) fn gradient_stored<V: Evolution<Error = HistoryError> + ?Sized>(
    evolution: &mut V,
    storage: &Storage,
) -> Result<Gradient, HistoryError> {
    let Some(directory) = &storage.directory else { return gradient_of(evolution, storage.most) };
    gradient_on_disk(evolution, storage.most, directory).map_err(|failure| match failure {
        SweepFailure::Step(error) => error,
        SweepFailure::CheckpointStore(why) => HistoryFailure::Storage(why).at(0),
    })
}

/// A sweep that failed in a step, or where its states are kept.
#[derive(Debug, Error)]
pub enum SweepFailure<E, S> {
    /// A step was not solved.
    #[error("{0}")]
    Step(E),
    /// A state was not kept or fetched.
    #[error("{0}")]
    CheckpointStore(S),
}

/// Failures of steps of one evolution with states on one store.
type FailureOf<V, S> = SweepFailure<<V as Evolution>::Error, <S as CheckpointStore>::Error>;

fn sweep<V: Evolution + ?Sized, S: CheckpointStore>(
    evolution: &mut V,
    stored: usize,
    store: S,
) -> Result<Gradient, FailureOf<V, S>> {
    let start = evolution.start().map_err(SweepFailure::Step)?;
    let steps = evolution.steps();
    let mut sweep = Sweep {
        slope: vec![0.0; start.len()],
        gradient: vec![0.0; evolution.control_count()],
        evolution,
        value: 0.0,
        reached: 0,
        work: Work { most_stored: 1, ..Work::default() },
    };
    let start = match steps {
        0 => start,
        _ => sweep.reverse(start, steps, stored.clamp(1, steps), store)?,
    };
    let Sweep { evolution, slope, mut gradient, value, work, .. } = sweep;
    evolution.reverse_start(&start, &slope, &mut gradient).map_err(SweepFailure::Step)?;
    Ok(Gradient { value, gradient, work })
}

/// A sweep on its way.
struct Sweep<'a, V: ?Sized> {
    evolution: &'a mut V,
    /// dJ/d of the state after the next step to be reversed.
    slope: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
    /// Steps whose part of J is in the value.
    reached: usize,
    work: Work,
}

impl<V: Evolution + ?Sized> Sweep<'_, V> {
    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, V::Error> {
        let after = self.evolution.advance(step, before)?;
        self.work.steps_solved += 1;
        if step == self.reached {
            self.value += self.evolution.cost(step, before, &after)?;
            self.reached += 1;
        }
        Ok(after)
    }

    /// The state after some steps from another.
    fn advance_to(&mut self, from: usize, to: usize, first: &[f64]) -> Result<Vec<f64>, V::Error> {
        let mut state = self.advance(from, first)?;
        for step in from + 1..to {
            state = self.advance(step, &state)?;
        }
        Ok(state)
    }

    /// Reverses all steps, with at most the given number of states on the store of those from which steps are computed again, and gives the
    /// first state back.
    fn reverse<S: CheckpointStore>(
        &mut self,
        start: Vec<f64>,
        steps: usize,
        stored: usize,
        mut states: S,
    ) -> Result<Vec<f64>, FailureOf<V, S>> {
        states.push(0, start).map_err(SweepFailure::CheckpointStore)?;
        let (mut to, mut last) = (steps, None);
        while let Some((from, first)) = states.top() {
            if to - from > 1 {
                let middle =
                    from + before_the_next_state(to - from, stored.saturating_sub(states.count() - 1).max(1));
                let state = self.advance_to(from, middle, first).map_err(SweepFailure::Step)?;
                states.push(middle, state).map_err(SweepFailure::CheckpointStore)?;
                // A state at the near end of the one step that is reversed next is not stored: that step is at hand.
                let stored = states.count() - usize::from(to - middle == 1);
                self.work.most_stored = self.work.most_stored.max(stored);
                continue;
            }
            let after = match last.take() {
                Some(last) => last,
                None => self.advance(from, first).map_err(SweepFailure::Step)?,
            };
            let slope = std::mem::take(&mut self.slope);
            let reversed = self.evolution.reverse(from, first, &after, slope, &mut self.gradient);
            self.slope = reversed.map_err(SweepFailure::Step)?;
            self.work.steps_reversed += 1;
            // Where this step began is where the one before it ends.
            to = from;
            last = states.pop().map_err(SweepFailure::CheckpointStore)?;
        }
        Ok(last.unwrap_or_default())
    }
}

/// The number of steps without a stored state before the next one with it: of `steps` that are to be reversed with `slots`
/// states; the first is where they begin.
fn before_the_next_state(steps: usize, slots: usize) -> usize {
    let repeated = largest_repetition(steps, slots);
    let fewest = if repeated >= 2 { reversible(slots, repeated - 2) } else { 1 };
    let most_after = if slots > 1 { reversible(slots - 1, repeated) } else { 1 };
    fewest.max(steps.saturating_sub(most_after)).clamp(1, steps - 1)
}

/// Smallest r with steps ≤ (slots + r)!/(slots! r!): no step needs to be solved more often than r times.
pub fn largest_repetition(steps: usize, slots: usize) -> usize {
    (1..).find(|&repeated| reversible(slots.max(1), repeated) >= steps).unwrap_or(steps)
}

/// (slots + repeated)!/(slots! repeated!), the most steps that can be reversed.
fn reversible(slots: usize, repeated: usize) -> usize {
    (1..=repeated).fold(1_usize, |product, k| product.saturating_mul(slots.saturating_add(k)) / k)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// xⁿ⁺¹ = m xⁿ + (xⁿ)²/10 from 1, J = Σ (n + 1) xⁿ⁺¹.
    struct Growth {
        steps: usize,
        m: f64,
        order: Vec<usize>,
    }

    impl Evolution for Growth {
        type Error = Infallible;

        fn steps(&self) -> usize {
            self.steps
        }

        fn control_count(&self) -> usize {
            2
        }

        fn start(&mut self) -> Result<Vec<f64>, Infallible> {
            Ok(vec![1.0])
        }

        fn advance(&mut self, _: usize, x: &[f64]) -> Result<Vec<f64>, Infallible> {
            Ok(vec![self.m * x[0] + x[0] * x[0] / 10.0])
        }

        fn cost(&mut self, step: usize, _: &[f64], after: &[f64]) -> Result<f64, Infallible> {
            Ok((step + 1) as f64 * after[0])
        }

        fn reverse(
            &mut self,
            step: usize,
            x: &[f64],
            after: &[f64],
            slope: Vec<f64>,
            gradient: &mut [f64],
        ) -> Result<Vec<f64>, Infallible> {
            assert_eq!(self.advance(step, x)?[0], after[0]);
            self.order.push(step);
            let slope = slope[0] + (step + 1) as f64;
            gradient[0] += slope * x[0];
            Ok(vec![slope * (self.m + x[0] / 5.0)])
        }

        fn reverse_start(
            &mut self,
            start: &[f64],
            slope: &[f64],
            gradient: &mut [f64],
        ) -> Result<(), Infallible> {
            assert_eq!(start, [1.0]);
            gradient[1] += slope[0];
            Ok(())
        }
    }

    fn swept(steps: usize, stored: usize) -> Gradient {
        let mut growth = Growth { steps, m: 0.8, order: vec![] };
        let Ok(found) = gradient_of(&mut growth, stored);
        assert_eq!(growth.order, (0..steps).rev().collect::<Vec<_>>());
        found
    }

    /// Griewank and Walther's count of steps: r l − (s + r)!/((s + 1)! (r − 1)!), and the last step, whose end is needed here.
    #[test]
    fn few_states_cost_the_least_number_of_steps() {
        for steps in 1..60 {
            let whole = swept(steps, steps);
            assert_eq!(whole.work.steps_solved, steps);
            for stored in 1..=steps {
                let Gradient { value, gradient, work } = swept(steps, stored);
                assert_eq!((value, &gradient), (whole.value, &whole.gradient), "{steps}, {stored}");
                assert!(work.most_stored <= stored && work.steps_reversed == steps, "{work:?}");
                let repeated = largest_repetition(steps, stored);
                let least = repeated * steps - reversible(stored + 1, repeated - 1) + 1;
                assert_eq!(work.steps_solved, least, "{steps} steps, {stored} stored");
            }
        }
        let work = swept(200, 12).work;
        assert_eq!((work.steps_solved, work.most_stored), (496, 12));
    }

    #[test]
    fn the_gradient_is_that_of_the_value() {
        let value = |m: f64| {
            let Ok(sample) = value_of(&mut Growth { steps: 20, m, order: vec![] });
            sample.value[0]
        };
        let found = swept(20, 4);
        let step = 1e-5;
        let difference = (value(0.8 + step) - value(0.8 - step)) / (2.0 * step);
        assert!((found.gradient[0] - difference).abs() < 1e-8 * difference.abs());
        assert_eq!(found.value, value(0.8));
        assert_eq!(swept(0, 3).gradient, [0.0, 0.0]);
    }
}
