//! Senses of directions beyond kinks: the ways along the branch before and after one.
//!
//! Between a and b the branch goes by α along the direction at a, and by β along the direction at b. Both are positive, which says which of
//! its two senses the new direction has.

use super::family::{Direction, Reached};
use super::metric::Metric;

/// The way before a kink may be negative by this part of the step: its direction is that of a point near it.
const BEFORE: f64 = 0.1;

/// The way that is along neither direction is at most this part of the whole: more says that b is on another branch.
const ASIDE: f64 = 0.2;

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
    let mut aside = b.at.since(&a.at.moved(&a.direction, ways.before));
    aside.u.iter_mut().zip(&b.direction.u).for_each(|(value, d)| *value -= ways.after * d);
    aside.parameter -= ways.after * b.direction.parameter;
    if ways.after < 0.0 {
        b.direction.turn_round();
    }
    let length = ways.before.abs() + ways.after.abs();
    ways.before >= -BEFORE * ways.after.abs() && metric.length(&aside) <= ASIDE * length
}
