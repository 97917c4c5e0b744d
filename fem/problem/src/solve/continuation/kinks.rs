//! Kinks of a branch, as where contact begins: steps that no plane across the old direction reaches, and events.
//!
//! Kinks of a branch. Where contact stiffens a falling branch, the new direction points back across the old one's plane, so that the next point is found on a
//! plane across the new direction.

use super::arc::Plane;
use super::events::{EventKind, Located};
use super::family::Reached;
use super::metric::Metric;
use super::points::{Beyond, Points, Solution, TURN};
use super::turns::{Ways, orient};
use crate::solve::{NewtonError, NewtonFailure};

/// Multiples of the distance at which the tangent beyond a kink is looked for.
const REACHES: [f64; 3] = [1.0, 4.0, 16.0];

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

/// The event at a kink between two points.
pub(super) fn events_at_kink(metric: &Metric, kinds: &[EventKind], a: &Reached, b: &Reached) -> Vec<Located> {
    let Some(ways) = Ways::between(metric, a, b) else { return vec![] };
    let at = a.at.moved(&a.direction, ways.before);
    let from_b = b.at.moved(&b.direction, -ways.after);
    let away = |end: &Reached| (at.parameter - end.at.parameter).abs();
    let located = |kind: &EventKind| Located {
        kind: *kind,
        at: at.clone(),
        // The kink is between both points, and the branch may be curved.
        uncertainty: away(a).max(away(b)).max((at.parameter - from_b.parameter).abs()),
        arc_length: a.arc_length + ways.before.max(0.0),
        modes: vec![],
        direction: a.direction.clone(),
    };
    kinds.iter().map(located).collect()
}
