//! Element matrices of any form by the moments of its coefficients, where a grid has as many points along an axis as nodes: two or
//! three.
//!
//! In a coordinate u along an axis that is −1 and 1 (and 0 between) at the points, products of 1, u and u² are such functions again
//! there: u² = 1 at two points, u³ = u and u⁴ = u² at three. So the entry of a matrix for two products of such powers is a moment of the
//! coefficients, a sum over the points with a power of u along each axis. There are as many moments as points, and additions make them.
//! The matrix of powers becomes that of the basis functions axis by axis, along rows and columns, with four operations for three numbers.

mod sums;

use self::sums::Sums;
use super::{Derivatives, ProductTables};
use crate::lanes::{Order, SimdLane};

/// The plan of the sums of an integral's matrices.
pub(in crate::assemble) struct Moments {
    /// Nodes along an axis, and points.
    nodes: usize,
    /// Whether values of functions are read besides their derivatives.
    values: bool,
    /// The derivative of u on the reference cell.
    pub slope: f64,
    symmetric: bool,
    components: [usize; 2],
    /// The factors that take powers of u to basis functions: [`to_nodes`].
    factors: [f64; 2],
    planes: Vec<Plane>,
    /// Of planes that are no symmetric matrices, and of those that are: the moments for each pair of powers along the first of three axes.
    squares: [Vec<Squares>; 2],
    /// Pairs of indices along all axes but the first, and the pairs with the indices exchanged, those that are not before the others.
    mirrored: Vec<[u32; 2]>,
}

/// The matrix of one component of the test function and one of the trial function, of all pairs of nodes.
struct Plane {
    /// Of each pair of derivatives (s, t), at `s * kinds + t`: which list of numbers at the points; `None` where another pair has them.
    sources: Vec<Option<usize>>,
    /// Place of the first sum.
    start: usize,
    /// Symmetric: of the pairs along the first axis only those in order are computed.
    symmetric: bool,
}

/// Squares of moments along the last two axes, of all pairs of what is done to test and trial function there: nothing (0), the
/// derivative along the one (1) or the other (2), at `3 * test + trial`.
struct Squares {
    /// Their places: behind the moments one of zeros, and those that are made.
    places: [usize; 9],
    /// Those that are sums or multiples of others because of what is done along the first of three axes.
    made: Vec<Made>,
}

/// A sum of squares that is stored elsewhere, each with a factor.
struct Made {
    place: usize,
    terms: Vec<(usize, f64)>,
}

/// Squares that are made, at most: all but those of pairs of derivatives.
const MOST_MADE: usize = 5;

/// The power of u that is u^k at two or three points, k at most twice a power.
#[inline(always)]
const fn power(k: usize, points: usize) -> usize {
    if k < points { k } else { k - 2 }
}

/// The place of a pair m ≤ n among those in order.
#[inline(always)]
const fn in_order(nodes: usize, m: usize, n: usize) -> usize {
    m * nodes - m * (m + 1) / 2 + n
}

impl Moments {
    /// The plan, if the element and the grid of points allow for it. Forms that read only values have none.
    pub fn new<const D: usize>(
        tables: &ProductTables,
        derivatives: Derivatives,
        components: [usize; 2],
        symmetric: bool,
    ) -> Option<Self> {
        let (nodes, reach) = (tables.nodes, tables.reach?);
        if !derivatives.gradient || !matches!(D, 2 | 3) {
            return None;
        }
        // With s = a u on (−1, 1): (1 ± s)/2 of two nodes, (s² ± s)/2 and 1 − s² of three.
        let factors = [if nodes == 2 { 0.5 } else { reach * reach / 2.0 }, reach / 2.0];
        let kinds = derivatives.count::<D>();
        let inner = nodes.pow(2 * (D as u32 - 1));
        let image = |place: usize| {
            (0..D as u32 - 1).fold(0, |image, axis| {
                let scale = nodes.pow(2 * axis);
                let pair = place / scale % (nodes * nodes);
                image + scale * (pair % nodes * nodes + pair / nodes)
            })
        };
        let mirrored = (0..inner)
            .filter(|place| image(*place) >= *place)
            .map(|place| [place as u32, image(place) as u32]);
        let (mut planes, mut start, entries): (Vec<Plane>, _, _) = (vec![], 0, components[0] * components[1]);
        let number_of = |s: usize, t: usize| if symmetric { in_order(kinds, s, t) } else { s * kinds + t };
        for a in 0..components[0] {
            for b in if symmetric { a } else { 0 }..components[1] {
                let of_itself = symmetric && a == b;
                let source = |place: usize| {
                    let (s, t) = (place / kinds, place % kinds);
                    match (symmetric && s > t, of_itself) {
                        (true, true) => None,
                        (true, false) => Some(number_of(t, s) * entries + b * components[1] + a),
                        _ => Some(number_of(s, t) * entries + a * components[1] + b),
                    }
                };
                let sources = (0..kinds * kinds).map(source).collect();
                planes.push(Plane { sources, start, symmetric: of_itself });
                start += inner * first_pairs(nodes, of_itself);
            }
        }
        Some(Moments {
            nodes,
            values: derivatives.value,
            slope: 2.0 / reach,
            symmetric,
            components,
            factors,
            planes,
            squares: [false, true].map(|symmetric| squares::<D>(nodes, derivatives, symmetric)),
            mirrored: mirrored.collect(),
        })
    }

    /// Length of the list of all sums.
    pub fn length<const D: usize>(&self) -> usize {
        let inner = self.nodes.pow(2 * (D as u32 - 1));
        self.planes.iter().map(|plane| inner * first_pairs(self.nodes, plane.symmetric)).sum()
    }

    /// An order of the entries of computed blocks as one of the sums.
    pub fn order<const D: usize>(&self, tables: &ProductTables, order: &Order, lanes: usize) -> Order {
        let n = self.nodes;
        let mut place_of = vec![0; tables.node_at.len()];
        for (place, node) in tables.node_at.iter().enumerate() {
            place_of[*node as usize] = place;
        }
        let along = |place: usize, axis: usize| place / n.pow((D - 1 - axis) as u32) % n;
        let pair = |i: usize, j: usize, axis: usize| along(i, axis) * n + along(j, axis);
        let inner = n.pow(2 * (D as u32 - 1));
        let [rows, columns] = self.components;
        let mut places = vec![];
        for i in 0..place_of.len() {
            for j in if self.symmetric { i } else { 0 }..place_of.len() {
                for entry in 0..rows * columns {
                    let ([mut i, mut j], [mut a, mut b]) =
                        ([place_of[i], place_of[j]], [entry / columns, entry % columns]);
                    if self.symmetric && a > b {
                        ([i, j], [a, b]) = ([j, i], [b, a]);
                    }
                    let number = if self.symmetric { in_order(columns, a, b) } else { a * columns + b };
                    let plane = &self.planes[number];
                    let others = |i, j| (1..D).fold(0, |place, axis| place * n * n + pair(i, j, axis));
                    if plane.symmetric && (along(i, 0), others(i, j)) > (along(j, 0), others(j, i)) {
                        (i, j) = (j, i);
                    }
                    let first =
                        if plane.symmetric { in_order(n, along(i, 0), along(j, 0)) } else { pair(i, j, 0) };
                    places.push((plane.start + first * inner + others(i, j)) as u32);
                }
            }
        }
        Order::new(order.places().map(|place| places[place as usize]).collect(), lanes)
    }

    /// The sums of all pairs of nodes. `numbers`: the entries of the block of each pair of functions whose value, or whose derivative in u
    /// along an axis, is one (of symmetric forms of the pairs in order), each entry at all places of the grid of points. `room` is memory
    /// that is kept.
    #[inline(never)]
    pub fn sum<L: SimdLane, const D: usize>(&self, numbers: &[L], room: &mut Vec<L>, sums: &mut [L]) {
        L::call(Sums::<L, D> { moments: self, numbers, room, sums });
    }
}

/// Number of pairs along the first axis that are computed.
#[inline(always)]
const fn first_pairs(nodes: usize, symmetric: bool) -> usize {
    if symmetric { nodes * (nodes + 1) / 2 } else { nodes * nodes }
}

/// The squares for each pair of powers along the first of three axes; in 2D, where all axes are the last two, there is one.
fn squares<const D: usize>(nodes: usize, derivatives: Derivatives, symmetric: bool) -> Vec<Squares> {
    let (kinds, of_pair) = (derivatives.count::<D>(), nodes.pow(D as u32 - 2));
    let zeros = kinds * kinds * of_pair;
    let value = derivatives.value.then_some(derivatives.place(0));
    let along = |axis: usize| Some(derivatives.place(1 + axis));
    let moments =
        |s: usize, t: usize| of_pair * if symmetric { s.min(t) * kinds + s.max(t) } else { s * kinds + t };
    let mut all = vec![];
    for pair in 0..if D == 3 { nodes * nodes } else { 1 } {
        let powers = [pair / nodes, pair % nodes];
        if symmetric && powers[0] > powers[1] {
            continue;
        }
        let (mut places, mut made) = ([0; 9], vec![]);
        for (k, place) in places.iter_mut().enumerate() {
            // Along the first axis what is not differentiated there is taken as it is, or differentiated.
            let choices = [k / 3, k % 3].map(|done| match (done, D) {
                (0, 2) => vec![(value, 0)],
                (0, _) => vec![(value, 0), (along(0), 1)],
                _ => vec![(along(D + done - 3), 0)],
            });
            let mut terms = vec![];
            for (s, order) in &choices[0] {
                for (t, trial_order) in &choices[1] {
                    let (Some(s), Some(t)) = (*s, *t) else { continue };
                    let orders = [*order, *trial_order];
                    if D == 2 {
                        terms.push((moments(s, t), 1.0));
                    } else if (0..2).all(|k| powers[k] >= orders[k]) {
                        let sum = powers[0] + powers[1] - orders[0] - orders[1];
                        let factor: usize = (0..2).map(|k| powers[k].pow(orders[k] as u32)).product();
                        terms.push((moments(s, t) + power(sum, nodes), factor as f64));
                    }
                }
            }
            *place = match &terms[..] {
                [] => zeros,
                [(place, factor)] if *factor == 1.0 => *place,
                _ => {
                    let place = zeros + 1 + made.len();
                    made.push(Made { place, terms });
                    place
                }
            };
        }
        all.push(Squares { places, made });
    }
    all
}

#[cfg(test)]
mod tests;
