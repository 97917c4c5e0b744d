//! Kinks of a branch, as where contact begins: the direction beyond, and steps that no plane across the old direction reaches.
//!
//! Between a and b the branch goes by α along the direction at a, and by β along the direction at b. Both are positive, which says which of
//! its two senses the new direction has. Where contact stiffens a falling branch, the new direction points back across the old one's plane, so
//! that the next point is found on a plane across the new direction.

use super::arc::Plane;
use super::events::{EventKind, Located};
use super::family::{Direction, Reached};
use super::metric::Metric;
use super::points::{Beyond, Points, Solution, TURN};
use crate::solve::{NewtonError, NewtonFailure};

/// The way before a kink may be negative by this part of the step: its direction is that of a point near it.
const BEFORE: f64 = 0.1;

/// Multiples of the distance at which the tangent beyond a kink is looked for.
const REACHES: [f64; 3] = [1.0, 4.0, 16.0];

/// Ways along both directions to and from a kink between two points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    pub before: f64,
    pub after: f64,
}

impl Ways {
    /// The ways of b − a along the directions of both; none where they are parallel.
    pub fn between(metric: &Metric, a: &Reached, b: &Reached) -> Option<Ways> {
        let way = b.at.since(&a.at);
        let cosine = metric.inner(&a.direction, &b.direction);
        let (along, along_new) = (metric.inner(&way, &a.direction), metric.inner(&way, &b.direction));
        let rest = 1.0 - cosine * cosine;
        let ways =
            Ways { before: (along - cosine * along_new) / rest, after: (along_new - cosine * along) / rest };
        (ways.before.is_finite() && ways.after.is_finite()).then_some(ways)
    }
}

impl Direction {
    fn turn_round(&mut self) {
        self.u.iter_mut().for_each(|value| *value = -*value);
        self.parameter = -self.parameter;
    }
}

/// Gives the direction at b the sense in which the branch leaves a kink between a and b. The kink is between them if the answer is true.
pub(super) fn orient(metric: &Metric, a: &Reached, b: &mut Reached) -> bool {
    let Some(ways) = Ways::between(metric, a, b) else { return false };
    if ways.after < 0.0 {
        b.direction.turn_round();
    }
    ways.before >= -BEFORE * ways.after.abs()
}

impl Points<'_> {
    /// A point beyond a kink that is within about a distance: on a plane across the direction that the tangent has there.
    ///
    /// # Errors
    /// [`NewtonError`], also where both senses of that direction lead back.
    pub fn beyond_kink(&mut self, from: &Reached, distance: f64) -> Result<Beyond, NewtonError> {
        for (reach, sense) in REACHES.into_iter().flat_map(|reach| [(reach, 1.0), (reach, -1.0)]) {
            // Points are in contact there, so that the tangent is that beyond the kink.
            let distance = reach * distance;
            let at = from.at.moved(&from.direction, distance);
            let guess = Solution { at: at.clone(), residual: vec![], iterations: 0 };
            let there = self.analyse(guess, &from.direction, 0.0)?.direction;
            let plane = Plane { normal: there.clone(), base: from.at.clone(), distance: sense * distance };
            // The start is on that plane, and keeps the points in contact.
            let along = self.metric.inner(&there, &at.since(&from.at));
            let guess = at.moved(&there, sense * distance - along);
            // Whole steps go back and forth between sets of points in contact.
            let found = self.with_line_search(|points| points.on_plane(&plane, &guess));
            let Ok(solution) = found else { continue };
            let way = self.metric.length(&solution.at.since(&from.at));
            let Ok(mut reached) = self.analyse(solution, &there, from.arc_length + way) else { continue };
            let is_beyond = orient(&self.metric, from, &mut reached);
            let cosine = self.metric.inner(&from.direction, &reached.direction);
            if is_beyond && cosine < TURN && way < 10.0 * distance {
                return Ok(Beyond { reached, cosine, off: 0.0 });
            }
        }
        Err(NewtonFailure::NoDescent.into())
    }
}

/// What happens at a kink between two points.
pub(super) fn events_at_kink(metric: &Metric, kinds: &[EventKind], a: &Reached, b: &Reached) -> Vec<Located> {
    let Some(ways) = Ways::between(metric, a, b) else { return vec![] };
    let at = a.at.moved(&a.direction, ways.before);
    let from_b = b.at.moved(&b.direction, -ways.after);
    let located = |kind: &EventKind| Located {
        kind: *kind,
        at: at.clone(),
        uncertainty: (at.parameter - from_b.parameter).abs(),
        arc_length: a.arc_length + ways.before.max(0.0),
        modes: vec![],
        direction: a.direction.clone(),
    };
    kinds.iter().map(located).collect()
}
