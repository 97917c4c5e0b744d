//! New nodes on an outline, as far apart as the sizes ask for.

use super::outline::{Arc, is_corner};
use super::sizes::SizeField;

/// Steps of the integrals over an arc.
const STEPS: usize = 16;
/// The turn of an outline along one edge, at most \[rad\].
const TURN: f64 = 0.45;
/// Edges of a loop without corners, at least.
const LEAST_OF_A_LOOP: usize = 6;

/// An edge of the new outline: its start and the node in its middle; it ends where the next begins.
pub(super) type NewEdge = [[f64; 2]; 2];

/// The edges of a closed loop. Corners stay.
pub(super) fn of_loop(arcs: &[Arc], sizes: &SizeField) -> Vec<NewEdge> {
    let count = arcs.len();
    let corners: Vec<usize> =
        (0..count).filter(|&k| is_corner(&arcs[(k + count - 1) % count], &arcs[k])).collect();
    if corners.is_empty() {
        return of_chain(arcs, sizes, LEAST_OF_A_LOOP);
    }
    let mut edges = vec![];
    for (place, &start) in corners.iter().enumerate() {
        let end = corners.get(place + 1).copied().unwrap_or(count + corners[0]);
        let chain: Vec<Arc> = (start..end).map(|k| arcs[k % count]).collect();
        edges.extend(of_chain(&chain, sizes, 1));
    }
    edges
}

/// The edges of arcs that follow each other and do not close. Corners stay.
pub(super) fn of_open_chain(arcs: &[Arc], sizes: &SizeField) -> Vec<NewEdge> {
    let mut edges = vec![];
    let mut start = 0;
    for end in 1..=arcs.len() {
        if end == arcs.len() || is_corner(&arcs[end - 1], &arcs[end]) {
            edges.extend(of_chain(&arcs[start..end], sizes, 1));
            start = end;
        }
    }
    edges
}

/// The edges of arcs that follow each other: the integral of 1/size is the same over each, and the middle node halves it.
pub(super) fn of_chain(arcs: &[Arc], sizes: &SizeField, least: usize) -> Vec<NewEdge> {
    let mut sums = vec![0.0];
    for arc in arcs {
        for step in 0..STEPS {
            let [a, b] = [step, step + 1].map(|k| k as f64 / STEPS as f64);
            let (from, to) = (arc.point(a), arc.point(b));
            let (before, after) = (arc.direction(a), arc.direction(b));
            let turn = (before[0] * after[1] - before[1] * after[0]).abs();
            let middle = arc.point(0.5 * (a + b));
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let last = sums.last().copied().unwrap_or(0.0);
            sums.push(last + (length / sizes.at(&middle)).max(turn / TURN));
        }
    }
    let total = sums.last().copied().unwrap_or(0.0);
    let count = ((total - 0.25).ceil().max(1.0) as usize).max(least);
    let place = |half: usize| -> [f64; 2] {
        let wanted = total * half as f64 / (2 * count) as f64;
        let step = sums.partition_point(|sum| *sum <= wanted).clamp(1, sums.len() - 1) - 1;
        let share = ((wanted - sums[step]) / (sums[step + 1] - sums[step])).clamp(0.0, 1.0);
        let arc = &arcs[step / STEPS];
        // Ends stay to the last bit.
        if half == 0 { arc.nodes[0] } else { arc.point(((step % STEPS) as f64 + share) / STEPS as f64) }
    };
    (0..count).map(|edge| [place(2 * edge), place(2 * edge + 1)]).collect()
}
