//! Solves with the triangles of a factor over units of the elimination tree, which threads share.
//!
//! What a unit takes from unknowns above it is summed in the unit, and the unit above adds the sums of those below it in their order:
//! the bits do not depend on the number of threads.

use std::sync::{Mutex, OnceLock, PoisonError};

use super::SymmetricFactor;
use crate::analysis::Analysis;
use crate::elimination::Unit;
use crate::threads::Threads;

/// One of the lower triangles that a factor stores: L, or L and Uᵀ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle<'a> {
    pub(super) analysis: &'a Analysis,
    /// Of all triangles.
    pub(super) values: &'a [f64],
    /// Number of triangles, and which of them this one is.
    pub(super) count: usize,
    pub(super) number: usize,
    pub(super) threads: Threads,
}

/// Values of all unknowns in elimination order for each right-hand side, cut into those of units. A task changes those of its unit, and
/// publishes them then.
struct Parts<'x> {
    free: Vec<Mutex<Vec<&'x mut [f64]>>>,
    known: Vec<OnceLock<Vec<&'x [f64]>>>,
    /// Places of the units' first unknowns, and the number of unknowns.
    starts: Vec<usize>,
}

impl<'x> Parts<'x> {
    fn new(starts: Vec<usize>, sides: &'x mut [&mut [f64]]) -> Self {
        let count = starts.len() - 1;
        let mut free: Vec<Vec<&mut [f64]>> = vec![];
        free.resize_with(count, Vec::new);
        for side in sides {
            let mut rest = &mut **side;
            for (ends, free) in starts.windows(2).zip(&mut free) {
                let (own, others) = rest.split_at_mut(ends[1] - ends[0]);
                free.push(own);
                rest = others;
            }
        }
        let mut known = vec![];
        known.resize_with(count, OnceLock::new);
        Parts { free: free.into_iter().map(Mutex::new).collect(), known, starts }
    }

    fn take(&self, unit: usize) -> Vec<&'x mut [f64]> {
        std::mem::take(&mut *self.free[unit].lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Memory of a thread for a right-hand side: numbers for rows outside of a unit, zero between tasks, and those below a supernode.
#[derive(Default)]
pub(super) struct Outside {
    pub(super) values: Vec<f64>,
    pub(super) below: Vec<f64>,
    /// Whether the right-hand side is zero at a supernode.
    pub(super) rests: bool,
}

/// Memory of a thread for all right-hand sides.
fn begin(memory: &mut Vec<Outside>, count: usize, size: usize) {
    if memory.is_empty() {
        // Memory that is zero from the start costs nothing where it is not touched.
        memory.resize_with(count, || Outside { values: vec![0.0; size], ..Outside::default() });
    }
}

impl SymmetricFactor {
    fn triangle(&self) -> Triangle<'_> {
        let (analysis, values, threads) = (&*self.analysis, &self.values[..], self.threads);
        Triangle { analysis, values, count: 1, number: 0, threads }
    }

    /// Replaces each x, in elimination order, by L⁻¹ x: with the bits that it has by itself.
    pub(crate) fn solve_with_lower(&self, sides: &mut [&mut [f64]]) {
        self.triangle().solve_with_lower(sides);
    }

    /// Replaces each y, in elimination order, by L⁻ᵀ y: with the bits that it has by itself.
    pub(crate) fn solve_with_upper(&self, sides: &mut [&mut [f64]]) {
        self.triangle().solve_with_upper(sides);
    }

    /// The part of [`SymmetricFactor::solve_with_upper`] in some supernodes, ascending, with all above them in the elimination tree. Nothing
    /// else is read or replaced.
    pub(crate) fn solve_with_upper_at(&self, supernodes: &[u32], sides: &mut [&mut [f64]]) {
        self.triangle().solve_with_upper_at(supernodes, sides);
    }
}

impl Triangle<'_> {
    /// Replaces each x, in elimination order, by the inverse of the triangle times x.
    pub(super) fn solve_with_lower(&self, sides: &mut [&mut [f64]]) {
        let (elimination, size, count) = (self.analysis.elimination(), self.analysis.size(), sides.len());
        if let [only] = &elimination.units[..] {
            let mut memory = vec![];
            memory.resize_with(count, Outside::default);
            return self.forward(only, (0, sides), &mut memory);
        }
        let parts = Parts::new(self.starts(&elimination.units, size), sides);
        let mut children = vec![vec![]; elimination.units.len()];
        for (number, unit) in elimination.units.iter().enumerate() {
            unit.parent.into_iter().for_each(|parent| children[parent as usize].push(number));
        }
        // Of each unit, for one right-hand side after the other.
        let sums: Vec<OnceLock<Vec<f64>>> = elimination.units.iter().map(|_| OnceLock::new()).collect();
        elimination.forward.run(self.threads, &mut vec![], |number, memory: &mut Vec<Outside>| {
            let (unit, start, mut own) =
                (&elimination.units[number], parts.starts[number], parts.take(number));
            begin(memory, count, size);
            let end = parts.starts[number + 1];
            for child in &children[number] {
                let mut changes = sums[*child].get().into_iter().flatten();
                for (own, Outside { values, .. }) in own.iter_mut().zip(&mut *memory) {
                    for (row, change) in elimination.units[*child].outer.iter().zip(&mut changes) {
                        let row = *row as usize;
                        let target = if row < end { &mut own[row - start] } else { &mut values[row] };
                        *target += change;
                    }
                }
            }
            self.forward(unit, (start, &mut own), memory);
            let mut taken = Vec::with_capacity(count * unit.outer.len());
            for Outside { values, .. } in memory {
                taken.extend(unit.outer.iter().map(|row| std::mem::take(&mut values[*row as usize])));
            }
            let _ = sums[number].set(taken);
        });
    }

    /// Replaces each y, in elimination order, by the inverse of the transposed triangle times y.
    pub(super) fn solve_with_upper(&self, sides: &mut [&mut [f64]]) {
        let all: Vec<u32> = (0..self.analysis.supernodes.n_supernodes() as u32).collect();
        self.solve_with_upper_at(&all, sides);
    }

    /// The part of [`Triangle::solve_with_upper`] in some supernodes, ascending, with all above them in the elimination tree.
    fn solve_with_upper_at(&self, supernodes: &[u32], sides: &mut [&mut [f64]]) {
        let (elimination, size, sides_count) =
            (self.analysis.elimination(), self.analysis.size(), sides.len());
        let count = elimination.units.len();
        if count < 2 {
            let mut memory = vec![];
            memory.resize_with(sides_count, Outside::default);
            return self.backward(supernodes, (0, sides), &mut memory);
        }
        let parts = Parts::new(self.starts(&elimination.units, size), sides);
        elimination.backward.run(self.threads, &mut vec![], |number, memory: &mut Vec<Outside>| {
            let number = count - 1 - number;
            let unit = &elimination.units[number];
            let place = |supernode: usize| supernodes.partition_point(|known| (*known as usize) < supernode);
            let asked = &supernodes[place(unit.supernodes.start)..place(unit.supernodes.end)];
            if asked.is_empty() {
                return;
            }
            let (start, mut own) = (parts.starts[number], parts.take(number));
            begin(memory, sides_count, size);
            let mut rest = &unit.outer[..];
            while let Some(first) = rest.first() {
                // Neighbours are in one unit.
                let holder = parts.starts.partition_point(|start| *start <= *first as usize) - 1;
                let (start, end) = (parts.starts[holder], parts.starts[holder + 1]);
                let held = rest.partition_point(|row| (*row as usize) < end);
                let known = parts.known[holder].get().into_iter().flatten();
                for (known, Outside { values, .. }) in known.zip(&mut *memory) {
                    for row in &rest[..held] {
                        values[*row as usize] = known[*row as usize - start];
                    }
                }
                rest = &rest[held..];
            }
            self.backward(asked, (start, &mut own), memory);
            let _ = parts.known[number].set(own.into_iter().map(|own| &*own).collect());
        });
    }

    fn starts(&self, units: &[Unit], size: usize) -> Vec<usize> {
        let begins = self.analysis.supernodes.supernode_begin();
        units.iter().map(|unit| begins[unit.supernodes.start] as usize).chain([size]).collect()
    }
}
