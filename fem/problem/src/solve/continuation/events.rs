//! Limit points and bifurcations between two points of a branch: what happened, and where.

use super::family::{Direction, Place, Reached};
use super::points::Points;

/// The kind of an event on a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The parameter has a maximum or a minimum along the branch.
    LimitPoint,
    /// Eigenvalues of the tangent pass zero while the parameter does not turn: another branch crosses or touches.
    Bifurcation {
        /// Their number. It is known of symmetric tangents; of others it is one.
        eigenvalues: usize,
    },
}

/// An event in vectors.
#[derive(Clone, Debug)]
pub(super) struct Located {
    pub kind: EventKind,
    pub at: Place,
    /// On the parameter.
    pub uncertainty: f64,
    pub arc_length: f64,
    /// Null vectors of a bifurcation on all unknowns.
    pub modes: Vec<Vec<f64>>,
    /// The branch's direction.
    pub direction: Direction,
}

/// Changes of the direction of the parameter, and numbers of eigenvalues that change their sign besides.
pub(super) fn kinds_between(a: &Reached, b: &Reached) -> Vec<EventKind> {
    let turns = a.direction.parameter * b.direction.parameter < 0.0;
    let changes = a.inertia.changes(b.inertia);
    let eigenvalues = changes.abs_diff(usize::from(turns));
    let mut kinds = vec![];
    if turns {
        kinds.push(EventKind::LimitPoint);
    }
    if eigenvalues > 0 {
        kinds.push(EventKind::Bifurcation { eigenvalues });
    }
    kinds
}

/// Most points that are computed for one event.
const EVALUATIONS: usize = 40;
/// A bracket of this part of the step is an event's place.
const WIDTH: f64 = 1e-10;
/// A function below this part of its values at the ends of the step is zero.
const ZERO: f64 = 1e-9;

/// One end of the bracket.
struct End {
    /// From the first point, along its direction.
    distance: f64,
    /// The function that vanishes at the event, and the same as regula falsi reads it.
    value: f64,
    weight: f64,
    at: Reached,
}

/// The function that vanishes at an event, with the vectors that it was computed with.
struct Watch<'a> {
    kind: EventKind,
    first: &'a Reached,
    vectors: Vec<Vec<f64>>,
}

impl Watch<'_> {
    /// dλ/ds, or the eigenvalue nearest to zero with a sign that changes at the bifurcation. The tangent is the solver's.
    fn value(&mut self, points: &mut Points<'_>, at: &Reached) -> Option<f64> {
        let EventKind::Bifurcation { eigenvalues } = self.kind else {
            return Some(at.direction.parameter);
        };
        let (amount, vectors) = points.nearest_to_zero(eigenvalues, &self.vectors).ok()?;
        self.vectors = vectors;
        let is_before = match eigenvalues % 2 {
            1 => at.orientation()? == self.first.orientation()?,
            _ => at.inertia == self.first.inertia,
        };
        Some(if is_before { amount } else { -amount })
    }
}

/// The place of an event between two points, by regula falsi with halvings. Where points next to it cannot be computed, the
/// uncertainty says how near they were.
pub(super) fn locate(
    points: &mut Points<'_>,
    kind: EventKind,
    (a, b): (&Reached, &Reached),
    distance: f64,
) -> Located {
    let mut watch = Watch { kind, first: a, vectors: vec![] };
    // The tangent at b is the last one.
    let at_b = watch.value(points, b);
    let solution = super::points::Solution { at: a.at.clone(), residual: vec![], iterations: 0 };
    let again = points.analyse(solution, &a.direction, a.arc_length).ok();
    let at_a = again.and_then(|again| watch.value(points, &again));
    let end =
        |distance: f64, value: f64, at: &Reached| End { distance, value, weight: value, at: at.clone() };
    let (at_a, at_b) = (at_a.unwrap_or(1.0), at_b.unwrap_or(-1.0));
    let scale = at_a.abs().max(at_b.abs());
    let (mut low, mut high) = (end(0.0, at_a, a), end(distance, at_b, b));
    let mut last_was_low = None;
    let mut best = (f64::INFINITY, watch.vectors.clone());
    let mut samples = vec![(low.distance, low.value), (high.distance, high.value)];
    for evaluation in 0..EVALUATIONS {
        let width = high.distance - low.distance;
        if width <= WIDTH * distance || low.value * high.value >= 0.0 {
            break;
        }
        let secant = low.distance + width * low.weight / (low.weight - high.weight);
        let inside = secant > low.distance && secant < high.distance;
        let middle = 0.5 * (low.distance + high.distance);
        let next = if inside && evaluation % 4 != 3 { secant } else { middle };
        let Ok(found) = points.beyond(a, next) else { break };
        let Some(value) = watch.value(points, &found.reached) else { break };
        if value.abs() < best.0 {
            best = (value.abs(), watch.vectors.clone());
        }
        samples.push((next, value));
        let is_low = value * low.value > 0.0;
        let found = end(next, value, &found.reached);
        // An end that stays twice weighs half (Illinois).
        let stays = last_was_low == Some(is_low);
        if is_low {
            low = found;
            high.weight *= if stays { 0.5 } else { 1.0 };
        } else {
            high = found;
            low.weight *= if stays { 0.5 } else { 1.0 };
        }
        last_was_low = Some(is_low);
        if value.abs() <= ZERO * scale {
            break;
        }
    }
    let modes = best.1.iter().filter_map(|vector| points.mode(vector).ok()).collect();
    let mut found = place(kind, &low, &high, modes, zero_of(samples));
    // Next to a bifurcation the direction of a point has a part of the null vector, that of the step has none.
    if let Some(chord) = points.metric.unit(b.at.since(&a.at)) {
        found.direction = chord;
    }
    found.uncertainty = found.uncertainty.max(points.accuracy());
    found
}

/// The zero of the parabola through the three samples with the smallest values, and how far it is from that of the line through two.
fn zero_of(mut samples: Vec<(f64, f64)>) -> (f64, f64) {
    samples.sort_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let line = |a: (f64, f64), b: (f64, f64)| (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
    match samples[..] {
        // Neville's scheme for the distance as a function of the value, at zero.
        [a, b, c, ..] => {
            let (near, far) = (line(a, b), line(b, c));
            let zero = line((near, a.1), (far, c.1));
            if zero.is_finite() { (zero, (zero - near).abs()) } else { (near, f64::INFINITY) }
        }
        [a, b] => (line(a, b), f64::INFINITY),
        _ => (f64::NAN, f64::INFINITY),
    }
}

/// The event between the ends of a bracket.
fn place(
    kind: EventKind,
    low: &End,
    high: &End,
    modes: Vec<Vec<f64>>,
    (zero, spread): (f64, f64),
) -> Located {
    let width = high.distance - low.distance;
    let inside = zero.clamp(low.distance, high.distance);
    let part = if inside.is_nan() { 0.5 } else { (inside - low.distance) / width };
    let nearest = if low.value.abs() <= high.value.abs() { low } else { high };
    let direction = nearest.at.direction.clone();
    let slope = low.at.direction.parameter.abs().max(high.at.direction.parameter.abs());
    match kind {
        // The parameter is stationary there: the nearest point has it to the second order.
        EventKind::LimitPoint => Located {
            kind,
            at: nearest.at.at.clone(),
            uncertainty: slope.min(nearest.value.abs()) * width,
            arc_length: nearest.at.arc_length,
            modes: vec![],
            direction,
        },
        EventKind::Bifurcation { .. } => {
            let way = high.at.at.since(&low.at.at);
            Located {
                kind,
                at: low.at.at.moved(&way, part),
                // The zero is between both ends, and near to that of a simpler rule.
                uncertainty: slope * spread.max(f64::EPSILON * high.distance).min(width),
                arc_length: low.at.arc_length + part * (high.at.arc_length - low.at.arc_length),
                modes,
                direction,
            }
        }
    }
}
