//! Solves with the triangles of a factor over units of the elimination tree, which threads share.
//!
//! What a unit takes from unknowns above it is summed in the unit, and the unit above adds the sums of those below it in their order:
//! the bits do not depend on the number of threads.

use std::sync::{Mutex, OnceLock, PoisonError};

use super::SymmetricFactor;
use crate::elimination::Unit;

/// Values of all unknowns in elimination order, cut into those of units. A task changes those of its unit, and publishes them then.
struct Parts<'x> {
    free: Vec<Mutex<Option<&'x mut [f64]>>>,
    known: Vec<OnceLock<&'x [f64]>>,
    /// Places of the units' first unknowns, and the number of unknowns.
    starts: Vec<usize>,
}

impl<'x> Parts<'x> {
    fn new(starts: Vec<usize>, x: &'x mut [f64]) -> Self {
        let (mut free, mut rest) = (Vec::with_capacity(starts.len()), x);
        for ends in starts.windows(2) {
            let (own, others) = rest.split_at_mut(ends[1] - ends[0]);
            free.push(Mutex::new(Some(own)));
            rest = others;
        }
        let mut known = vec![];
        known.resize_with(free.len(), OnceLock::new);
        Parts { free, known, starts }
    }

    fn take(&self, unit: usize) -> Option<&'x mut [f64]> {
        self.free[unit].lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Memory of a thread: numbers for rows outside of a unit, zero between tasks, and those below a supernode.
#[derive(Default)]
struct Outside {
    values: Vec<f64>,
    below: Vec<f64>,
}

impl Outside {
    fn begin(&mut self, size: usize) {
        if self.values.is_empty() {
            // Memory that is zero from the start costs nothing where it is not touched.
            self.values = vec![0.0; size];
        }
    }
}

impl SymmetricFactor {
    /// Replaces x, in elimination order, by L⁻¹ x.
    pub(crate) fn solve_with_lower(&self, x: &mut [f64]) {
        let (elimination, size) = (self.analysis.elimination(), x.len());
        if let [only] = &elimination.units[..] {
            let (mut below, mut none) = (vec![], vec![]);
            return self.forward(only, (0, x), &mut none, &mut below);
        }
        let parts = Parts::new(self.starts(&elimination.units, size), x);
        let mut children = vec![vec![]; elimination.units.len()];
        for (number, unit) in elimination.units.iter().enumerate() {
            unit.parent.into_iter().for_each(|parent| children[parent as usize].push(number));
        }
        let sums: Vec<OnceLock<Vec<f64>>> = elimination.units.iter().map(|_| OnceLock::new()).collect();
        elimination.forward.run(self.threads, &mut Outside::default(), |number, outside| {
            let (unit, start) = (&elimination.units[number], parts.starts[number]);
            let Some(own) = parts.take(number) else { return };
            outside.begin(size);
            let end = start + own.len();
            for child in &children[number] {
                let changes = sums[*child].get().into_iter().flatten();
                for (row, change) in elimination.units[*child].outer.iter().zip(changes) {
                    let row = *row as usize;
                    let target = if row < end { &mut own[row - start] } else { &mut outside.values[row] };
                    *target += change;
                }
            }
            self.forward(unit, (start, own), &mut outside.values, &mut outside.below);
            let taken = unit.outer.iter().map(|row| std::mem::take(&mut outside.values[*row as usize]));
            let _ = sums[number].set(taken.collect());
        });
    }

    /// Replaces y, in elimination order, by L⁻ᵀ y.
    pub(crate) fn solve_with_upper(&self, y: &mut [f64]) {
        let (elimination, size) = (self.analysis.elimination(), y.len());
        let count = elimination.units.len();
        if count < 2 {
            return self.substitute_back(0..self.analysis.supernodes.n_supernodes() as u32, y);
        }
        let parts = Parts::new(self.starts(&elimination.units, size), y);
        elimination.backward.run(self.threads, &mut Outside::default(), |number, outside| {
            let number = count - 1 - number;
            let (unit, start) = (&elimination.units[number], parts.starts[number]);
            let Some(own) = parts.take(number) else { return };
            outside.begin(size);
            let mut rest = &unit.outer[..];
            while let Some(first) = rest.first() {
                // Neighbours are in one unit.
                let holder = parts.starts.partition_point(|start| *start <= *first as usize) - 1;
                let (start, end) = (parts.starts[holder], parts.starts[holder + 1]);
                let held = rest.partition_point(|row| (*row as usize) < end);
                let known = parts.known[holder].get().copied().unwrap_or_default();
                for row in &rest[..held] {
                    outside.values[*row as usize] = known[*row as usize - start];
                }
                rest = &rest[held..];
            }
            let supernodes = unit.supernodes.start as u32..unit.supernodes.end as u32;
            self.backward(supernodes, (start, &mut *own), &outside.values, &mut outside.below);
            let _ = parts.known[number].set(own);
        });
    }

    fn starts(&self, units: &[Unit], size: usize) -> Vec<usize> {
        let begins = self.analysis.supernodes.supernode_begin();
        units.iter().map(|unit| begins[unit.supernodes.start] as usize).chain([size]).collect()
    }
}
