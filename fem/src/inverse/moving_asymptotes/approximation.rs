//! Convex separable approximations between moving asymptotes, and the minimum of one by its dual.

use crate::inverse::bounds::Bounds;
use crate::inverse::control_vectors::ControlVectors;

/// A function of the controls at an iterate, from which its separable approximation is made.
pub(super) struct Separable {
    pub value: f64,
    pub gradient: Vec<f64>,
}

/// The asymptotes, and the iterates from which they move.
pub(super) struct Approximation {
    vectors: ControlVectors,
    lower: Vec<f64>,
    upper: Vec<f64>,
    move_limit: f64,
    first_distance: f64,
    /// Distance of both asymptotes from the last iterate.
    distances: Vec<f64>,
    /// The last two iterates, the later one first.
    earlier: Vec<Vec<f64>>,
}

/// Factors of the asymptotes' distances where a control swings, and where it goes on.
const CLOSER: f64 = 0.7;
const FARTHER: f64 = 1.2;
/// The least and the largest distance relative to that of the bounds.
const LEAST: f64 = 0.01;
const MOST: f64 = 10.0;
/// Part of the way to an asymptote that a control stays away from it.
const AWAY: f64 = 0.1;
/// Parts that make approximations strictly convex: of the gradient, and of the scale over the distance between bounds.
const CONVEX: f64 = 1e-3;
const FLAT: f64 = 1e-5;
/// The price of violating a constraint by one, relative to the scale of J: above all multipliers.
const PRICE: f64 = 1e3;
/// Sweeps over the multipliers, and halvings for each.
const SWEEPS: usize = 200;
const HALVINGS: usize = 100;

/// p/(U − x) + q/(x − L) for each control, and a constant.
struct Poles {
    p: Vec<f64>,
    q: Vec<f64>,
    rest: f64,
}

impl Approximation {
    pub fn new(vectors: &ControlVectors, bounds: &Bounds, move_limit: f64, first_distance: f64) -> Self {
        let (lower, upper) = bounds.both();
        let ranges = lower.iter().zip(upper).map(|(lower, upper)| first_distance * (upper - lower));
        Approximation {
            vectors: vectors.clone(),
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            move_limit,
            first_distance,
            distances: ranges.collect(),
            earlier: vec![],
        }
    }

    fn range(&self, control: usize) -> f64 {
        self.upper[control] - self.lower[control]
    }

    fn move_asymptotes(&mut self, m: &[f64]) {
        for (control, m) in m.iter().enumerate() {
            let range = self.range(control);
            let distance = &mut self.distances[control];
            match &self.earlier[..] {
                [last, before] => {
                    let swing = (m - last[control]) * (last[control] - before[control]);
                    *distance *= if swing < 0.0 {
                        CLOSER
                    } else if swing > 0.0 {
                        FARTHER
                    } else {
                        1.0
                    };
                    *distance = distance.clamp(LEAST * range, MOST * range);
                }
                _ => *distance = self.first_distance * range,
            }
        }
    }

    /// The minimum of the approximate problem, and the multiplier of each constraint.
    pub fn minimum(
        &mut self,
        m: &[f64],
        value: &Separable,
        constraints: &[Separable],
    ) -> (Vec<f64>, Vec<f64>) {
        self.move_asymptotes(m);
        let most = |gradient: &[f64]| {
            let changes =
                gradient.iter().enumerate().map(|(control, slope)| slope.abs() * self.range(control));
            self.vectors.largest(changes.fold(0.0, f64::max))
        };
        // J by its own size: multipliers and the price have none then.
        let scale = value.value.abs().max(most(&value.gradient));
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let of_value = self.poles(value, 1.0 / scale);
        let poles: Vec<Poles> = constraints.iter().map(|constraint| self.poles(constraint, 1.0)).collect();
        let mut multipliers = vec![0.0; poles.len()];
        for _ in 0..SWEEPS {
            let mut largest_change = 0.0_f64;
            for number in 0..poles.len() {
                let before = multipliers[number];
                self.maximise(m, &of_value, &poles, &mut multipliers, number);
                let after = multipliers[number];
                largest_change = largest_change.max((after - before).abs() / (1.0 + after));
            }
            if poles.len() <= 1 || largest_change < 1e-12 {
                break;
            }
        }
        let moved = self.controls(m, &of_value, &poles, &multipliers);
        self.earlier.insert(0, m.to_vec());
        self.earlier.truncate(2);
        multipliers.iter_mut().for_each(|multiplier| *multiplier *= scale);
        (moved, multipliers)
    }

    fn poles(&self, function: &Separable, factor: f64) -> Poles {
        let (mut p, mut q) = (vec![], vec![]);
        for (control, slope) in function.gradient.iter().enumerate() {
            let (distance, range) = (self.distances[control], self.range(control));
            let (up, down) = (factor * slope.max(0.0), factor * (-slope).max(0.0));
            // A control that its bounds hold has no range, and stays.
            let flat = if range > 0.0 { FLAT / range } else { 0.0 };
            p.push(distance.powi(2) * ((1.0 + CONVEX) * up + CONVEX * down + flat));
            q.push(distance.powi(2) * (CONVEX * up + (1.0 + CONVEX) * down + flat));
        }
        let term = |control: usize| match self.range(control) > 0.0 {
            true => (p[control] + q[control]) / self.distances[control],
            false => 0.0,
        };
        let rest = factor * function.value - self.vectors.sum(p.len(), term);
        Poles { p, q, rest }
    }

    /// The controls that minimise the Lagrangian.
    fn controls(&self, m: &[f64], value: &Poles, constraints: &[Poles], multipliers: &[f64]) -> Vec<f64> {
        let of = |(control, m): (usize, &f64)| {
            let (distance, range) = (self.distances[control], self.range(control));
            let sum = |of: fn(&Poles) -> &[f64]| {
                let terms = constraints.iter().zip(multipliers);
                terms.fold(of(value)[control], |sum, (poles, multiplier)| {
                    sum + multiplier * of(poles)[control]
                })
            };
            let (p, q) = (sum(|poles| &poles.p).sqrt(), sum(|poles| &poles.q).sqrt());
            let farthest = ((1.0 - AWAY) * distance).min(self.move_limit * range);
            let (low, high) =
                ((m - farthest).max(self.lower[control]), (m + farthest).min(self.upper[control]));
            if p + q > 0.0 { (m + distance * (q - p) / (p + q)).clamp(low, high) } else { *m }
        };
        m.iter().enumerate().map(of).collect()
    }

    /// The multiplier of one constraint for which it holds, or zero: the slope of the dual falls as it grows.
    fn maximise(&self, m: &[f64], value: &Poles, all: &[Poles], multipliers: &mut [f64], number: usize) {
        let mut excess = |multiplier: f64| {
            multipliers[number] = multiplier;
            let x = self.controls(m, value, all, multipliers);
            let violated = (multiplier - PRICE).max(0.0);
            self.at(m, &all[number], &x) - violated
        };
        if excess(0.0) <= 0.0 {
            multipliers[number] = 0.0;
            return;
        }
        let (mut low, mut high) = (0.0, 1.0);
        while excess(high) > 0.0 && high < 1e12 {
            (low, high) = (high, 4.0 * high);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if excess(middle) > 0.0 { low = middle } else { high = middle }
        }
        // On the side where the constraint holds.
        multipliers[number] = high;
    }

    fn at(&self, m: &[f64], poles: &Poles, x: &[f64]) -> f64 {
        let term = |control: usize| {
            let (x, m, distance) = (x[control], m[control], self.distances[control]);
            match self.range(control) > 0.0 {
                true => poles.p[control] / (m + distance - x) + poles.q[control] / (x - m + distance),
                false => 0.0,
            }
        };
        poles.rest + self.vectors.sum(x.len(), term)
    }
}
