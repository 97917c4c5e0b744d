//! Quadrature on parts of the unit square and cube in which a polynomial is negative, and on its zeros, with positive weights
//! (R. I. Saye, SIAM J. Sci. Comput. 37 (2015) A993).
//!
//! Where a slope is nowhere zero, zeros are a graph over the other axes: its height. Lines along this axis are cut at the zero and have Gauss points
//! between. The lines start at points of a rule for the face across, which is parted where the graph leaves the box: one axis fewer, down
//! to zeros on a segment. A box where no slope is large enough is divided.
//!
//! ```text
//! bernstein   polynomials by their coefficients: bounds, parts, faces, zeros
//! cell        a level set function on a cell, the points of rules there and on facets
//! simplices   the same cut along straight lines, for pictures and distances
//! ```

mod bernstein;
mod cell;
mod simplices;
#[cfg(test)]
mod tests;

use std::cell::Cell;

use self::bernstein::{Line, Zeros, bending, bounds, dimension, divided, face, gradient, line, slope_bounds};
pub(crate) use self::cell::{CellPolynomial, FacetPart, LineRules};
pub(super) use self::simplices::kuhn;
use crate::cut::number::Number;

/// The square of a gradient over that of its component along the height, at most: Gauss points follow no steeper graphs.
const STEEPEST: f64 = 20.0;

/// Divisions of a box. Parts around a single point, as a saddle has, come to 10⁻⁶ of a square and 10⁻⁴ of a cube.
const DEEPEST: usize = 40;

/// The place at which a box is divided: off its middle, so that a zero that is there by design is inside a part.
const DIVIDED_AT: f64 = 0.483_127;

/// Boxes that are divided at a time. More of them lie along a line, as two zeros do that are nearly one; their lines are cut all the
/// same, only their bases are not parted.
const MOST: usize = 64;

/// The part of a box that is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// Negative values.
    Inside,
    /// Positive values.
    Outside,
    /// Zeros.
    Interface,
}

/// Places on the unit segment with their weights.
type LineRule = [(f64, f64)];

/// Rules on the unit segment, and a number that tells which boxes and axes were chosen.
pub(super) struct Walk<'a> {
    /// Those on lines along heights, on lines across, on which these begin, and in space on a line on which those do.
    rules: [&'a LineRule; 3],
    structure: Cell<u32>,
}

impl<'a> Walk<'a> {
    pub fn new(rules: [&'a LineRule; 3]) -> Self {
        Walk { rules, structure: Cell::new(0x811c_9dc5) }
    }

    /// Two functions with the same number are cut in the same way.
    pub fn structure(&self) -> u32 {
        self.structure.get()
    }

    fn note(&self, choice: usize) {
        // Fowler, Noll and Vo's hash.
        self.structure.set((self.structure.get() ^ choice as u32).wrapping_mul(0x0100_0193));
    }

    /// Gauss points between the ends of the unit segment and the zeros of some functions on it.
    fn between<R: Number>(&self, rule: usize, functions: &[Line<R>], visit: &mut dyn FnMut(R, R)) {
        let zeros = Zeros::of(functions);
        self.note(zeros.list().len());
        self.on_intervals((rule, zeros.list()), &mut |_| true, visit);
    }

    /// Gauss points on the intervals between some zeros, those of a number that is wanted.
    fn on_intervals<R: Number>(
        &self,
        (rule, zeros): (usize, &[R]),
        is_wanted: &mut dyn FnMut(usize) -> bool,
        visit: &mut dyn FnMut(R, R),
    ) {
        let mut start = R::zero();
        for number in 0..=zeros.len() {
            let end = zeros.get(number).copied().unwrap_or(R::one());
            let length = end - start;
            if is_wanted(number) && length.value() > 0.0 {
                self.rules[rule].iter().for_each(|(x, w)| visit(start + length * *x, length * *w));
            }
            start = end;
        }
    }
}

/// The first of some axes with nearly the largest number: of equal ones, as a sphere has, rounding must not choose.
fn best(numbers: &[f64]) -> usize {
    (1..numbers.len()).fold(0, |best, axis| if numbers[axis] > 1.1 * numbers[best] { axis } else { best })
}

/// A part of a box, with the functions that have zeros there.
#[derive(Clone, Copy)]
struct Part<R, const N: usize> {
    functions: [[R; N]; 2],
    count: usize,
    origin: [f64; 3],
    size: [f64; 3],
}

/// The way to go on in a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// No function has a zero.
    Whole,
    /// All functions have heights along an axis.
    Along(usize),
}

impl<R: Number, const N: usize> Part<R, N> {
    fn new(functions: [[R; N]; 2], count: usize) -> Self {
        Part { functions, count, origin: [0.0; 3], size: [1.0; 3] }
    }

    /// Leaves out the functions without zeros.
    fn reduce(&mut self) {
        let mut kept = 0;
        for k in 0..self.count {
            let [least, most] = bounds(&self.functions[k]);
            if least < 0.0 && most > 0.0 {
                self.functions[kept] = self.functions[k];
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// The best axis for heights, and the least part of a squared gradient that is along it.
    fn height(&self) -> (usize, f64) {
        let axes = dimension(N);
        let (mut parts, mut largest) = ([f64::MAX; 3], [0.0_f64; 3]);
        for function in &self.functions[..self.count] {
            let slopes: [[f64; 2]; 3] =
                std::array::from_fn(|axis| if axis < axes { slope_bounds(function, axis) } else { [0.0; 2] });
            let sizes = slopes.map(|[least, most]| most.max(-least));
            let square: f64 = sizes.iter().map(|size| size * size).sum();
            for axis in 0..axes {
                let [least, most] = slopes[axis];
                let own = least.max(-most).max(0.0);
                parts[axis] = parts[axis].min(own * own / square);
                largest[axis] = largest[axis].max(sizes[axis]);
            }
        }
        // Where nothing bounds a slope, the one that may be the largest.
        let first = if parts[..axes].iter().all(|part| *part == 0.0) { &largest } else { &parts };
        let best = best(&first[..axes]);
        (best, parts[best])
    }

    /// Both parts along the axis along which slopes change most.
    fn parts(&self) -> [Self; 2] {
        let change = |axis: usize| -> f64 {
            let own = self.functions[..self.count].iter();
            own.map(|function| bending(function, axis)).fold(0.0, f64::max) * self.size[axis]
        };
        let changes: [f64; 3] =
            std::array::from_fn(|axis| if axis < dimension(N) { change(axis) } else { 0.0 });
        let axis = best(&changes);
        let mut parts = [*self; 2];
        for k in 0..self.count {
            let [low, high] = divided(&self.functions[k], axis, DIVIDED_AT);
            (parts[0].functions[k], parts[1].functions[k]) = (low, high);
        }
        parts[0].size[axis] *= DIVIDED_AT;
        parts[1].size[axis] -= parts[0].size[axis];
        parts[1].origin[axis] += parts[0].size[axis];
        parts
    }

    /// Visits this part, unless functions have zeros in it and no height: such a part is returned with its best axis.
    fn visit(mut self, walk: &Walk, visit: &mut dyn FnMut(&Self, Step)) -> Option<(Self, usize)> {
        self.reduce();
        if self.count == 0 {
            walk.note(7);
            visit(&self, Step::Whole);
            return None;
        }
        let (axis, along) = self.height();
        walk.note(8 + axis);
        if along * STEEPEST < 1.0 {
            return Some((self, axis));
        }
        visit(&self, Step::Along(axis));
        None
    }

    /// Divides this part as long as functions have zeros in it and no height.
    fn divide(self, walk: &Walk, visit: &mut dyn FnMut(&Self, Step)) {
        let Some(first) = self.visit(walk, visit) else { return };
        let mut level = vec![first];
        for _ in 0..DEEPEST {
            let parts = level.iter().flat_map(|(part, _)| part.parts());
            level = parts.filter_map(|part| part.visit(walk, visit)).collect();
            walk.note(level.len());
            if level.is_empty() {
                return;
            }
            if level.len() > MOST {
                break;
            }
        }
        level.iter().for_each(|(part, axis)| visit(part, Step::Along(*axis)));
    }

    /// A point with coordinates on this part.
    fn place(&self, at: &[R; 3]) -> [R; 3] {
        std::array::from_fn(|k| at[k] * self.size[k] + self.origin[k])
    }

    /// Its size without that along an axis.
    fn across(&self, axis: usize) -> f64 {
        (0..dimension(N)).filter(|k| *k != axis).map(|k| self.size[k]).product()
    }
}

/// The points of a rule on the unit square, parted at the zeros of two functions that do not meet.
fn on_square<R: Number>(functions: [[R; 9]; 2], walk: &Walk, visit: &mut dyn FnMut([R; 2], R)) {
    Part::new(functions, 2).divide(walk, &mut |part, step| {
        let axis = if let Step::Along(axis) = step { axis } else { 0 };
        let own = &part.functions[..part.count];
        let (mut ends, mut heights) = ([[R::zero(); 3]; 4], [[R::zero(); 3]; 2]);
        for (k, function) in own.iter().enumerate() {
            (ends[2 * k], ends[2 * k + 1]) = (face(function, axis, 0), face(function, axis, 1));
        }
        let area = part.size[0] * part.size[1];
        walk.between(2, &ends[..2 * own.len()], &mut |s, outer| {
            for (height, function) in heights.iter_mut().zip(own) {
                *height = line(function, axis, &[s, s]);
            }
            walk.between(1, &heights[..own.len()], &mut |t, inner| {
                let at = if axis == 0 { [t, s] } else { [s, t] };
                let [x, y, _] = part.place(&[at[0], at[1], R::zero()]);
                visit([x, y], outer * inner * area);
            });
        });
    });
}

/// The points of a rule on what is wanted of the unit square or cube: places, weights and on the interface unit normals towards positive values.
///
/// A zero counts as positive. With n points on lines across heights errors are of order 2n in the size of the box, and weights are positive.
pub(super) fn points<R: Number, const N: usize>(
    polynomial: &[R; N],
    wanted: Wanted,
    walk: &Walk,
    visit: &mut dyn FnMut([R; 3], R, [R; 3]),
) {
    Part::new([*polynomial; 2], 1).divide(walk, &mut |part, step| {
        let function = &part.functions[0];
        let axis = match step {
            Step::Along(axis) => axis,
            Step::Whole => {
                let is_inside = bounds(function)[0] < 0.0;
                if wanted != if is_inside { Wanted::Inside } else { Wanted::Outside } {
                    return;
                }
                0
            }
        };
        let mut on_line = |s: [R; 2], weight: R| {
            let values = line(function, axis, &s);
            let zeros = Zeros::of(&[values]);
            let place = |t: R| -> [R; 3] {
                let mut others = s.into_iter();
                std::array::from_fn(|k| if k == axis { t } else { others.next().unwrap_or(R::zero()) })
            };
            if wanted == Wanted::Interface {
                for zero in zeros.list() {
                    let place = place(*zero);
                    let local = gradient(function, &place);
                    let slope: [R; 3] = std::array::from_fn(|k| local[k] * part.size[k].recip());
                    let size = slope.iter().map(|entry| *entry * *entry).sum::<R>().sqrt();
                    let along = slope[axis].abs();
                    if along.value() > 0.0 {
                        let area = weight * part.across(axis) * (size / along);
                        visit(part.place(&place), area, slope.map(|entry| entry / size));
                    }
                }
                return;
            }
            // Signs alternate from the line's start.
            let first = usize::from((values[0].value() < 0.0) != (wanted == Wanted::Inside));
            let volume = part.across(axis) * part.size[axis];
            walk.on_intervals((0, zeros.list()), &mut |number| number % 2 == first, &mut |t, own| {
                visit(part.place(&place(t)), weight * own * volume, [R::zero(); 3]);
            });
        };
        let on_face = |s: [R; 2], weight: R| on_line(s, weight);
        base(function, axis, walk, on_face);
    });
}

/// The points of a rule on the face across an axis, parted where zeros leave the box at its ends.
fn base<R: Number, const N: usize>(
    function: &[R; N],
    axis: usize,
    walk: &Walk,
    mut visit: impl FnMut([R; 2], R),
) {
    if N == 9 {
        let ends = [0, 1].map(|end| face(function, axis, end));
        walk.between(1, &ends, &mut |s, weight| visit([s, R::zero()], weight));
    } else {
        let ends = [0, 1].map(|end| face(function, axis, end));
        on_square(ends, walk, &mut visit);
    }
}
