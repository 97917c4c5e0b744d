//! Residuals field by field, and the iterates at which it is worth while to ask whether they are the solution.
//!
//! Nothing here decides that an iterate is the solution: that is said in `judgement.rs`, row by row.

use std::ops::Range;

use super::Iterates;
use crate::linear_algebra::vector::{largest, norm};
use crate::solve::divided::Together;
use crate::solve::elimination::Elimination;

/// An iterate is judged once the residual of each field has dropped to this part of the largest that it had, or to a larger tolerance, or stays.
const WORTH_JUDGING: f64 = 1e-6;

/// A step below this part of a field leaves it as it is, so that a residual that stays is not a matter of u.
pub(super) const SMALL_STEP: f64 = 1e-6;

/// Number of unknowns of one field, and of components at each of its nodes, whose unknowns follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldUnknowns {
    /// Unknowns of the field, one field after the other.
    pub unknowns: usize,
    /// Components at each node. Each is judged by its own size.
    pub components: usize,
}

/// One component of a field among all unknowns.
#[derive(Clone, Debug)]
pub(in crate::solve) struct Component {
    first: usize,
    /// The unknowns of its field.
    field: Range<usize>,
    stride: usize,
    together: Together,
}

impl Component {
    /// This process's unknowns of the component among all.
    pub fn unknowns(&self) -> impl Iterator<Item = usize> + use<> {
        (self.first..self.field.end).step_by(self.stride)
    }

    /// The first of its unknowns.
    pub fn first(&self) -> usize {
        self.first
    }

    /// The largest amount in it.
    pub fn largest(&self, full: &[f64]) -> f64 {
        self.together.largest(self.largest_here(full))
    }

    /// The largest amount on this process.
    fn largest_here(&self, full: &[f64]) -> f64 {
        self.unknowns().fold(0.0, |largest, unknown| largest.max(full[unknown].abs()))
    }

    /// The negative of the smallest value, and the largest one, on this process.
    fn ends_here(&self, full: &[f64]) -> [f64; 2] {
        let ends = self.unknowns().fold(None, |ends: Option<(f64, f64)>, unknown| {
            let value = full[unknown];
            Some(ends.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
        });
        let (low, high) = ends.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        [-low, high]
    }
}

/// Sizes of a component of all processes.
#[derive(Clone, Copy, Debug)]
pub(in crate::solve) struct Sizes {
    /// The largest amount in a change of the unknowns.
    pub change: f64,
    /// The largest amount in the unknowns.
    pub most: f64,
    /// The difference of the largest and the smallest of the unknowns, which an offset does not change.
    pub range: f64,
    /// The largest amount in all components of its field, which have one unit.
    pub in_field: f64,
}

/// The fields of a problem as ranges of its free unknowns.
#[derive(Clone, Debug)]
pub(in crate::solve) struct Fields {
    /// The components of all fields.
    pub components: Vec<Component>,
    /// Among the free unknowns.
    free: Vec<Range<usize>>,
    pub together: Together,
}

impl Fields {
    /// Fields that follow each other; the remaining entries are one more.
    pub fn new(layouts: &[FieldUnknowns], elimination: &Elimination, together: &Together) -> Self {
        let (mut all, mut components, mut end) = (Vec::new(), Vec::new(), 0_usize);
        let rest = FieldUnknowns { unknowns: elimination.size(), components: 1 };
        for FieldUnknowns { unknowns, components: count } in layouts.iter().copied().chain([rest]) {
            let begin = end;
            end = elimination.size().min(begin.saturating_add(unknowns));
            if begin < end {
                all.push(begin..end);
                let stride = count.max(1);
                let of = |place| {
                    let (first, field, together) = (begin + place, begin..end, together.clone());
                    Component { first, field, stride, together }
                };
                components.extend((0..stride.min(end - begin)).map(of));
            }
        }
        let place = |unknown: usize| elimination.free().partition_point(|free| *free < unknown);
        let free = all.iter().map(|range| place(range.start)..place(range.end)).collect();
        Fields { components, free, together: together.clone() }
    }

    /// The sizes of each component in a change and in the unknowns, by one exchange.
    pub fn sizes(&self, change: &[f64], u: &[f64]) -> Vec<Sizes> {
        let of = |component: &Component| {
            let [low, high] = component.ends_here(u);
            let in_field = largest(&u[component.field.clone()]);
            [component.largest_here(change), component.largest_here(u), low, high, in_field]
        };
        let found = self.together.largest_of_each(self.components.iter().flat_map(of).collect());
        let sizes = found.as_chunks().0.iter().map(|[change, most, low, high, in_field]| {
            let range = if -low > *high { 0.0 } else { high + low };
            Sizes { change: *change, most: *most, range, in_field: *in_field }
        });
        sizes.collect()
    }

    /// Norm of each field's part of a vector of free unknowns.
    pub fn norms(&self, reduced: &[f64]) -> Vec<f64> {
        self.together.norms_and_sum(&self.parts(reduced), None)
    }

    fn parts<'v>(&self, reduced: &'v [f64]) -> Vec<(&'v [f64], Range<usize>)> {
        self.free.iter().map(|range| (reduced, range.clone())).collect()
    }

    /// Norm of a vector of free unknowns, and of each field's part of it, by one exchange.
    pub fn norm_and_norms(&self, reduced: &[f64]) -> (f64, Vec<f64>) {
        let mut asked = self.parts(reduced);
        asked.push((reduced, 0..reduced.len()));
        let mut norms = self.together.norms_and_sum(&asked, None);
        (norms.pop().unwrap_or(f64::NAN), norms)
    }

    /// The norm of a residual, and norms of it and of the free unknowns by fields, by one exchange.
    pub fn norms_at(&self, residual: &[f64], free: &[f64]) -> (f64, Norms) {
        let mut asked = self.parts(residual);
        asked.extend(self.parts(free));
        asked.push((residual, 0..residual.len()));
        // With weights that follow no pattern of a mesh.
        let mark = |place: usize| weight(place) * free[place];
        let mut found = self.together.norms_and_sum(&asked, Some((free.len(), &mark)));
        let (mark, size) = (found.pop().unwrap_or(f64::NAN), found.pop().unwrap_or(f64::NAN));
        let u = found.split_off(self.free.len());
        (size, Norms { residual: found, u, step: None, mark })
    }

    /// Norm of a vector of free unknowns.
    pub fn norm(&self, reduced: &[f64]) -> f64 {
        self.together.norm(reduced, 0..reduced.len())
    }

    /// Norms over only some free unknowns, given by their reduced numbers in ascending order.
    pub fn norms_over(&self, places: &[u32], value: impl Fn(usize) -> f64) -> Vec<f64> {
        let within = |range: &Range<usize>| {
            let place = |end: usize| places.partition_point(|place| (*place as usize) < end);
            let values: Vec<f64> =
                places[place(range.start)..place(range.end)].iter().map(|p| value(*p as usize)).collect();
            norm(&values)
        };
        self.free.iter().map(within).collect()
    }
}

/// Norms per field at an iterate, over free unknowns.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Norms {
    pub residual: Vec<f64>,
    pub u: Vec<f64>,
    /// Of the whole Newton step that led here, before it was shortened; none at the start.
    pub step: Option<Vec<f64>>,
    /// A sum of u with weights that tell iterates apart whose norms are equal, as those of mirror images are.
    pub mark: f64,
}

/// Σ w_i u_i with the weights of [`Fields::mark`].
pub(in crate::solve) fn mark(u: &[f64]) -> f64 {
    u.iter().enumerate().map(|(i, u)| weight(i) * u).sum()
}

fn weight(place: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    0.5 + (GOLDEN * place as f64).fract()
}

impl Iterates<'_> {
    /// The residual of each field to which linear systems need to be solved.
    pub fn targets(&self) -> impl Iterator<Item = f64> {
        let count = self.norms.first().map_or(0, |start| start.residual.len());
        (0..count).map(|field| self.options.relative_tolerance * self.largest_residual(field))
    }

    /// The largest residual that a field had.
    pub fn largest_residual(&self, field: usize) -> f64 {
        self.norms.iter().map(|norms| norms.residual[field]).fold(0.0, f64::max)
    }

    /// Whether it is worth while to judge the last iterate. It decides nothing: it spares work at iterates that are far off.
    pub fn is_worth_judging(&self) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let worth = WORTH_JUDGING.max(self.options.relative_tolerance);
        let is_higher =
            |steps: &[Norms], field: usize| steps[1].residual[field] > 0.5 * steps[0].residual[field];
        (0..last.residual.len()).all(|field| {
            let steps = self.norms[self.norms.len().saturating_sub(3)..].windows(2);
            last.residual[field] <= worth * self.largest_residual(field)
                || before.residual[field] == 0.0
                // While contact is searched for, residuals go up and down.
                || (steps.len() == 2 && steps.into_iter().all(|steps| is_higher(steps, field)))
        })
    }

    /// Whether the residual of each field is this part of the largest that it had, or stays as it is.
    pub fn has_dropped_to(&self, part: f64) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        (0..last.residual.len()).all(|field| {
            last.residual[field] <= part * self.largest_residual(field)
                || before.residual[field] == 0.0
                || self.has_stalled(field)
        })
    }

    /// Whether the last step changed neither a field nor its residual by much. Next to others a field may be zero, and its
    /// steps and its residual the rounding of theirs.
    pub fn has_stalled(&self, field: usize) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let small = last.step.as_ref().is_some_and(|step| step[field] <= SMALL_STEP * last.u[field]);
        (small || last.u.len() > 1) && last.residual[field] > 0.5 * before.residual[field]
    }

    /// Whether the last step changed neither the fields nor their residuals by much.
    pub fn stays(&self) -> bool {
        let [.., before, last] = &self.norms[..] else { return false };
        let Some(step) = &last.step else { return false };
        (0..step.len()).all(|field| {
            step[field] <= SMALL_STEP * last.u[field]
                && (last.residual[field] > 0.5 * before.residual[field] || last.residual[field] == 0.0)
        })
    }

    /// Whether the residual of a field stays as it is.
    pub fn some_field_stays(&self) -> bool {
        let count = self.norms.last().map_or(0, |last| last.residual.len());
        (0..count).any(|field| self.has_stalled(field))
    }
}
