//! A record of the points whose switches change, from which a failure of Newton's method is explained.
//!
//! Each iterate adds the points that differ from those of the iterate before. Positions, regions and observed values are found only if Newton's
//! method fails.

use std::collections::BTreeMap;

use super::Problem;
use crate::contract::Functional;
use crate::field::Field;
use crate::solve::{NewtonError, NewtonFailure, Oscillation, Remedy, SwitchingPoint};

/// Iterations before a failure in which points have to switch at least `CHANGES` times, unless the period of a cycle is known.
const WINDOW: usize = 8;

/// Points may switch and switch back on a way that leads to a solution.
const CHANGES: usize = 3;

/// Changes that are kept at most; the older half is forgotten.
const KEPT: usize = 1 << 20;

/// Points that get observed values.
const OBSERVED: usize = 200;

/// Values of an observed functional at its points.
type PointsWithValues<const D: usize> = Vec<(f64, [f64; D])>;

/// A change of a point's switches.
#[derive(Clone, Copy, Debug)]
struct Switched {
    iteration: u32,
    point: u32,
    /// The switches that changed, as bits.
    switches: u32,
}

/// The switches of all points at the last iterate, their changes up to it, and what is listed of points that oscillate.
#[derive(Clone, Debug)]
pub(in crate::solve) struct SwitchRecord<const D: usize> {
    observed: Vec<Functional<D>>,
    iterates: usize,
    last: Vec<u32>,
    changes: Vec<Switched>,
}

impl<const D: usize> Default for SwitchRecord<D> {
    fn default() -> Self {
        SwitchRecord { observed: vec![], iterates: 0, last: vec![], changes: vec![] }
    }
}

impl<const D: usize> SwitchRecord<D> {
    /// A record without iterates, from here on.
    pub fn begin(&mut self) {
        (self.iterates, self.last) = (0, vec![]);
        self.changes.clear();
    }

    /// The switches of all points at a new iterate.
    pub fn record(&mut self, switches: Vec<u32>) {
        if self.last.len() == switches.len() {
            let iteration = self.iterates as u32;
            let pairs = self.last.iter().zip(&switches).enumerate();
            let changed = pairs.filter(|(_, (before, now))| before != now);
            self.changes.extend(changed.map(|(point, (before, now))| Switched {
                iteration,
                point: point as u32,
                switches: before ^ now,
            }));
            if self.changes.len() > KEPT {
                self.changes.drain(..KEPT / 2);
            }
        }
        self.last = switches;
        self.iterates += 1;
    }

    /// The points that oscillated at the end: number, iterations of their changes, switches.
    fn oscillating(&self, why: &NewtonFailure) -> Vec<(usize, Vec<usize>, u32)> {
        let (window, least) = match why {
            NewtonFailure::Cycling { period, .. } if *period > 1 => (*period, 1),
            NewtonFailure::Cycling { .. }
            | NewtonFailure::NotConverged { .. }
            | NewtonFailure::BoundsCycle { .. }
            | NewtonFailure::Stagnated
            | NewtonFailure::NoDescent => (WINDOW, CHANGES),
            _ => return vec![],
        };
        let mut of_points: BTreeMap<usize, (Vec<usize>, u32)> = BTreeMap::new();
        let recent = |iteration: &usize| iteration + window >= self.iterates;
        for Switched { iteration, point, switches } in &self.changes {
            let (iterations, lately) = of_points.entry(*point as usize).or_default();
            iterations.push(*iteration as usize);
            *lately |= if recent(&(*iteration as usize)) { *switches } else { 0 };
        }
        let run = |iterations: Vec<usize>| -> Vec<usize> {
            // The changes at the end that follow each other within the window.
            let breaks = iterations.windows(2).rposition(|pair| pair[1] - pair[0] > window);
            iterations[breaks.map_or(0, |place| place + 1)..].to_vec()
        };
        let oscillates = |iterations: &Vec<usize>| {
            iterations.iter().filter(|iteration| recent(iteration)).count() >= least
        };
        let found = of_points.into_iter().filter(|(_, (iterations, _))| oscillates(iterations));
        let mut found: Vec<(usize, Vec<usize>, u32)> =
            found.map(|(point, (iterations, switches))| (point, run(iterations), switches)).collect();
        found.sort_by_key(|(_, iterations, _)| std::cmp::Reverse(iterations.len()));
        found
    }
}

fn bits(set: u32) -> Vec<usize> {
    (0..32).filter(|bit| set >> bit & 1 == 1).collect()
}

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// A functional of the problem's unknowns whose integrand is listed at points that oscillate when Newton's method fails, as a gap, a pressure
    /// or a slip: under its name, at the point of its quadrature that is nearest. The value of the integral is not used.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?;
    /// let space = Space::scalar(&mesh, 1)?;
    /// // u + 1 where u is positive, else u − 1: Newton's method goes from 1 to −1 and back.
    /// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), (u + 2.0 * heaviside(u) - 1.0) * v));
    /// let value = form!(|u: Unknown<Scalar>| -> Functional { integral(cells("all"), u) });
    /// let start = Field::interpolate(&space, |_| 1.0)?;
    /// let Err(error) = Problem::new(&form, &space).start(&start).observe(&value).solve() else {
    ///     panic!("it goes back and forth");
    /// };
    /// let oscillation = error.oscillation.expect("points that switch");
    /// assert_eq!(oscillation.points.len(), oscillation.point_count);
    /// assert_eq!(oscillation.points[0].since, 1);
    /// assert!((oscillation.points[0].values[0].1 - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn observe(mut self, functional: &Functional<D>) -> Self {
        self.switches.observed.push(functional.clone());
        self
    }

    /// The points that oscillated before a failure, where there are any.
    pub(super) fn oscillation(&self, error: &NewtonError) -> Option<Oscillation> {
        let found = self.switches.oscillating(&error.why);
        if found.is_empty() || error.u.iter().any(|u| !u.is_finite()) {
            return None;
        }
        // What cannot be said is left out: the failure is reported in any case.
        let places = self.system.switch_places(&error.u).ok()?;
        if places.len() != self.switches.last.len() {
            return None;
        }
        let fields = self.system.fields(&error.u);
        let fields: Vec<&Field<D>> = fields.iter().collect();
        let observed: Vec<(&'static str, PointsWithValues<D>)> = self
            .switches
            .observed
            .iter()
            .filter_map(|one| Some((one.name(), self.system.assembler.values_of(one, &fields).ok()?)))
            .collect();
        let values_at = |x: &[f64; D]| {
            let nearest = |values: &[(f64, [f64; D])]| {
                let distance = |y: &[f64; D]| x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
                let by_distance =
                    |a: &&(f64, [f64; D]), b: &&(f64, [f64; D])| distance(&a.1).total_cmp(&distance(&b.1));
                values.iter().min_by(by_distance).map(|(value, _)| *value)
            };
            observed.iter().filter_map(|(name, values)| Some((*name, nearest(values)?))).collect()
        };
        let regions = &self.system.form.inputs().regions;
        let points = found.iter().enumerate().map(|(number, (point, iterations, switches))| {
            let (region, position) = &places[*point];
            SwitchingPoint {
                position: position.to_vec(),
                region: regions[*region].name.clone(),
                switches: bits(*switches),
                on: bits(self.switches.last[*point]),
                since: iterations.first().copied().unwrap_or_default(),
                changes: iterations.len(),
                values: if number < OBSERVED { values_at(position) } else { vec![] },
            }
        });
        let points: Vec<SwitchingPoint> = points.collect();
        let counts = [points.len(), places.len()];
        let remedy = Remedy::of(counts, &error.why, &error.history, &self.options);
        Some(Oscillation { points, point_count: places.len(), remedy })
    }
}
