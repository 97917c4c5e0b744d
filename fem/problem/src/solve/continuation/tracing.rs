//! The way along a branch: steps that are halved where they fail and doubled where they succeed, and the events in them.

use std::ops::RangeInclusive;

use super::branch::{BranchEnd, ContinuationFailure};
use super::events::{EventKind, Located, kinds_between, locate};
use super::family::{Next, Reached};
use super::kinks::events_at_kink;
use super::points::{BEND, Beyond, OFF, Points, TURN, is_judged};
use super::turns::Ways;
use crate::solve::NewtonError;

/// Length and number of steps.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    /// Smallest and largest steps, as parts of the first one.
    pub smallest: f64,
    pub largest: f64,
    /// Most points.
    pub points: usize,
    /// The parameters between which the branch is followed.
    pub range: RangeInclusive<f64>,
}

/// Steps that turn more are accepted only below this multiple of the smallest one: there they pass a kink.
const KINK: f64 = 16.0;

/// A point with the events between it and the point before.
struct Step {
    reached: Reached,
    events: Vec<Located>,
}

/// The branch so far.
#[derive(Default)]
pub(super) struct Traced {
    pub points: Vec<Reached>,
    /// With the number of the point before.
    pub events: Vec<(usize, Located)>,
}

impl Traced {
    fn enter(&mut self, points: &mut Points<'_>, reached: Reached) -> Result<Next, ContinuationFailure> {
        let next = points.family.reached(&reached).map_err(ContinuationFailure::Measurement)?;
        // Earlier unknowns are the caller's to keep.
        if let Some(before) = self.points.last_mut() {
            (before.at.u, before.direction.u, before.residual) = (vec![], vec![], vec![]);
        }
        self.points.push(reached);
        Ok(next)
    }

    /// The end of a branch that is followed from its first point, with a first step of a length.
    ///
    /// # Errors
    /// [`ContinuationFailure`]: the smallest step fails, or a measurement.
    pub fn follow(
        &mut self,
        points: &mut Points<'_>,
        first: Reached,
        length: f64,
        steps: &Steps,
    ) -> Result<BranchEnd, ContinuationFailure> {
        if self.enter(points, first)? == Next::Stop {
            return Ok(BranchEnd::Stopped);
        }
        let (mut factor, mut successes) = (1.0_f64, 0);
        while let Some(from) = self.points.last().filter(|_| self.points.len() < steps.points) {
            let from = from.clone();
            let may_halve = factor > steps.smallest;
            match step(points, &from, factor * length, factor > KINK * steps.smallest) {
                Ok(Step { mut reached, events }) => {
                    let number = self.points.len() - 1;
                    let parameter = reached.at.parameter;
                    let is_outside = parameter > *steps.range.end() && reached.direction.parameter > 0.0
                        || parameter < *steps.range.start() && reached.direction.parameter < 0.0;
                    if is_outside {
                        reached = at_end(points, &from, reached, &steps.range);
                    }
                    let within = events.into_iter().filter(|event| event.arc_length <= reached.arc_length);
                    self.events.extend(within.map(|event| (number, event)));
                    if self.enter(points, reached)? == Next::Stop {
                        return Ok(BranchEnd::Stopped);
                    }
                    if is_outside {
                        return Ok(BranchEnd::Range);
                    }
                    successes += 1;
                    if successes == 2 {
                        (factor, successes) = ((2.0 * factor).min(steps.largest), 0);
                    }
                }
                Err(_) if may_halve => (factor, successes) = (0.5 * factor, 0),
                Err(why) => return Err(why.of(from.at.parameter)),
            }
        }
        Ok(BranchEnd::Points)
    }
}

/// A reason to halve a step.
enum Failed {
    Newton(Box<NewtonError>),
    Turns,
    Singular,
    Together,
}

impl Failed {
    fn of(self, parameter: f64) -> ContinuationFailure {
        match self {
            Failed::Newton(why) => ContinuationFailure::Step { parameter, why },
            Failed::Turns => ContinuationFailure::Kink { parameter },
            Failed::Singular | Failed::Together => ContinuationFailure::Singular { parameter },
        }
    }
}

/// One step of a length. One that turns much, or has several kinds of events, is refused unless it is short already.
fn step(points: &mut Points<'_>, from: &Reached, length: f64, is_long: bool) -> Result<Step, Failed> {
    let Beyond { reached, cosine, .. } = match points.beyond(from, length) {
        Ok(Beyond { cosine, off, .. }) if is_long && (cosine < BEND || off > OFF) => {
            return Err(Failed::Turns);
        }
        Ok(beyond) => beyond,
        Err(error) if is_long => return Err(Failed::Newton(Box::new(error))),
        // The new direction may point back across the plane.
        Err(error) => points.beyond_kink(from, length).map_err(|_| Failed::Newton(Box::new(error)))?,
    };
    if !is_judged(reached.inertia) {
        return Err(Failed::Singular);
    }
    let kinds = kinds_between(from, &reached);
    if cosine < TURN {
        let is_between = Ways::between(&points.metric, from, &reached).is_some_and(|ways| ways.after > 0.0);
        let events = events_at_kink(&points.metric, &kinds, from, &reached);
        return if is_between { Ok(Step { reached, events }) } else { Err(Failed::Turns) };
    }
    if kinds.len() > 1 && is_long {
        return Err(Failed::Together);
    }
    let located = |kind: &EventKind| locate(points, *kind, (from, &reached), length);
    let mut events: Vec<Located> = kinds.iter().map(located).collect();
    events.sort_by(|a, b| a.arc_length.total_cmp(&b.arc_length));
    Ok(Step { reached, events })
}

/// The point at the end of the range; where it is not found, the one beyond it.
fn at_end(points: &mut Points<'_>, from: &Reached, beyond: Reached, range: &RangeInclusive<f64>) -> Reached {
    let end = if beyond.at.parameter > *range.end() { *range.end() } else { *range.start() };
    let part = (end - from.at.parameter) / (beyond.at.parameter - from.at.parameter);
    let guess = from.at.moved(&beyond.at.since(&from.at), part);
    let Ok(solution) = points.at_parameter(guess.u, end) else { return beyond };
    let way = points.metric.length(&solution.at.since(&from.at));
    let near = way <= points.metric.length(&beyond.at.since(&from.at)) * 1.1;
    match points.analyse(solution, &from.direction, from.arc_length + way) {
        Ok(found) if near => found,
        _ => beyond,
    }
}
