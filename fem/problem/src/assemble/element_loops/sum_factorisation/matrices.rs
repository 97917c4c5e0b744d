//! Element matrices of scalar forms: coefficients of all pairs of derivatives at the points, then sums over the points
//! for all pairs of nodes, one axis after the other.

use super::contraction::contract;
use super::{Derivatives, ProductTables};
use crate::instantiate::instantiate;
use crate::lanes::{SharedWork, SimdLane};

/// Sums on their way; the list at `s * (D + 1) + t` belongs to derivative s of the test function and t of the trial
/// function, 0 the value, 1 + axis the derivative along an axis that is not yet summed over.
pub(in crate::assemble) struct MatrixStages<L> {
    from: Vec<Vec<L>>,
    to: Vec<Vec<L>>,
    /// Places among the last sums of the pairs (i, j) of nodes, row after row; of symmetric matrices those with i ≤ j.
    places: Vec<u32>,
}

impl<L> Default for MatrixStages<L> {
    fn default() -> Self {
        MatrixStages { from: vec![], to: vec![], places: vec![] }
    }
}

/// Multiply-adds after the coefficients at the points are known.
pub(in crate::assemble) fn matrix_operations<const D: usize>(
    tables: &ProductTables,
    derivatives: Derivatives,
    symmetric: bool,
) -> usize {
    let (n, m) = (tables.nodes, tables.points);
    let per_axis = (0..D).map(|axis| {
        let kinds = match derivatives.gradient {
            true => axis + 1 + usize::from(derivatives.value || axis + 1 < D),
            false => 1,
        };
        let pairs = n.pow(2 * (D - axis) as u32);
        let kept = if symmetric && axis == 0 { pairs * (n + 1) / (2 * n) } else { pairs };
        kinds * kinds * kept * m.pow(axis as u32 + 1)
    });
    per_axis.sum()
}

/// The sums of all pairs of nodes.
pub(in crate::assemble) struct PairSums<'a, L, const D: usize> {
    pub tables: &'a ProductTables,
    pub derivatives: Derivatives,
    pub symmetric: bool,
    pub stages: &'a mut MatrixStages<L>,
    /// Pairs (i, j), row after row; of symmetric matrices those with i ≤ j.
    pub blocks: &'a mut [L],
}

impl<L: SimdLane> MatrixStages<L> {
    /// Memory for the sums.
    #[inline(never)]
    pub fn prepare<const D: usize>(&mut self, tables: &ProductTables, symmetric: bool) {
        let (n, m) = (tables.nodes, tables.points);
        let length = (n * n).max(m).pow(D as u32);
        if self.from.len() == (D + 1) * (D + 1) && self.from[0].len() == length {
            return;
        }
        for stage in [&mut self.from, &mut self.to] {
            stage.clear();
            stage.resize(if D == 0 { 0 } else { (D + 1) * (D + 1) }, vec![L::splat(0.0); length]);
        }
        let mut place_of = vec![0; tables.node_at.len()];
        for (place, node) in tables.node_at.iter().enumerate() {
            place_of[*node as usize] = place;
        }
        self.places.clear();
        for i in 0..place_of.len() {
            for j in if symmetric { i } else { 0 }..place_of.len() {
                self.places.push(pair_place::<D>(n, [place_of[i], place_of[j]], symmetric));
            }
        }
    }

    /// Coefficients of a pair of derivatives, at all places of the grid of points.
    #[inline(always)]
    pub fn coefficients<const D: usize>(&mut self, [test, trial]: [usize; 2]) -> &mut [L] {
        &mut self.from[test * (D + 1) + trial]
    }
}

/// The place of a pair of two places among the last sums: indices of pairs along the axes, the last axis fastest. Of
/// symmetric matrices those along the first axis are ordered.
fn pair_place<const D: usize>(n: usize, [mut i, mut j]: [usize; 2], symmetric: bool) -> u32 {
    let along = |place: usize, axis: usize| place / n.pow((D - 1 - axis) as u32) % n;
    if symmetric && along(i, 0) > along(j, 0) {
        (i, j) = (j, i);
    }
    let (a, b) = (along(i, 0), along(j, 0));
    let first = if symmetric { a * n - a * (a + 1) / 2 + b } else { a * n + b };
    (1..D).fold(first, |place, axis| place * n * n + along(i, axis) * n + along(j, axis)) as u32
}

impl<L: SimdLane, const D: usize> SharedWork<L> for PairSums<'_, L, D> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let PairSums { tables, derivatives, symmetric, stages, blocks } = self;
        let (n, m) = (tables.nodes, tables.points);
        for axis in (0..D).rev() {
            let (before, inner) = (m.pow(axis as u32), (n * n).pow((D - 1 - axis) as u32));
            let ordered = symmetric && axis == 0;
            let rows = if ordered { n * (n + 1) / 2 } else { n * n };
            let (from, to) = (before * m * inner, before * rows * inner);
            // Which kinds of derivatives there are before this axis is summed over.
            let has_value = derivatives.value || axis + 1 < D;
            let exists = |kind: usize| match kind {
                0 => has_value || !derivatives.gradient,
                _ => derivatives.gradient && kind <= axis + 1,
            };
            let mut begun = [[false; 4]; 4];
            for test in 0..=D {
                for trial in 0..=D {
                    if !exists(test) || !exists(trial) {
                        continue;
                    }
                    let (slope, other_slope) = (test == axis + 1, trial == axis + 1);
                    let left = [if slope { 0 } else { test }, if other_slope { 0 } else { trial }];
                    let tables = if ordered { &tables.ordered_pairs } else { &tables.pairs };
                    let table = &tables[usize::from(slope)][usize::from(other_slope)];
                    let source = &stages.from[test * (D + 1) + trial][..from];
                    let target = &mut stages.to[left[0] * (D + 1) + left[1]][..to];
                    contract(table, m, inner, source, target, begun[left[0]][left[1]]);
                    begun[left[0]][left[1]] = true;
                }
            }
            std::mem::swap(&mut stages.from, &mut stages.to);
        }
        let (last, places) = (&stages.from[0][..], &stages.places[..]);
        let blocks = &mut blocks[..places.len()];
        for pair in 0..places.len() {
            blocks[pair] = last[places[pair] as usize];
        }
    }
}

instantiate!(matrices in lanes: MatrixStages::<L>::prepare::<D>);
