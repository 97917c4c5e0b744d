//! Fields at the points from coefficients at the nodes, and the transposed: sums over the points for each node.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use super::contraction::contract;
use super::{Derivatives, ProductTables};
use crate::lanes::{SharedWork, SimdLane};

/// Sums on their way, axis by axis: those of the value first, then those of the derivative along each axis.
pub(in crate::assemble) struct Stages<L> {
    from: Vec<Vec<L>>,
    to: Vec<Vec<L>>,
}

impl<L> Default for Stages<L> {
    fn default() -> Self {
        Stages { from: vec![], to: vec![] }
    }
}

impl<L: SimdLane> Stages<L> {
    /// Makes room for D + 1 lists.
    fn prepare(&mut self, lists: usize, length: usize) {
        for stage in [&mut self.from, &mut self.to] {
            stage.resize_with(lists, Vec::new);
            for list in stage {
                if list.len() < length {
                    list.resize(length, L::splat(0.0));
                }
            }
        }
    }
}

/// Multiply-adds of one component of a field, or of one component of an element vector.
pub(in crate::assemble) fn axis_operations<const D: usize>(
    tables: &ProductTables,
    derivatives: Derivatives,
) -> usize {
    let (n, m) = (tables.nodes, tables.points);
    let per_axis = (0..D).map(|axis| {
        let size = n.pow(axis as u32 + 1) * m.pow((D - axis) as u32);
        let slopes = if derivatives.gradient { D - axis } else { 0 };
        let value = derivatives.value || (derivatives.gradient && axis > 0);
        size * (slopes + usize::from(value))
    });
    per_axis.sum()
}

/// Values and derivatives of a field at all points.
pub(in crate::assemble) struct Interpolation<'a, L, const D: usize> {
    pub tables: &'a ProductTables,
    pub derivatives: Derivatives,
    /// Node × component.
    pub coefficients: &'a [L],
    pub components: usize,
    pub stages: &'a mut Stages<L>,
    /// Of each component the value, if it is read, then the derivatives along the axes of the reference cell, if they
    /// are read; each at all places of the grid of points.
    pub target: &'a mut [L],
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Interpolation<'_, L, D> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Interpolation { tables, derivatives, coefficients, components, stages, target } = self;
        let (n, m) = (tables.nodes, tables.points);
        let points = m.pow(D as u32);
        stages.prepare(D + 1, n.max(m).pow(D as u32));
        let lists = derivatives.count::<D>();
        for component in 0..components {
            let own = &mut target[component * lists * points..][..lists * points];
            let first = &mut stages.from[0][..tables.node_at.len()];
            for place in 0..first.len() {
                first[place] = coefficients[tables.node_at[place] as usize * components + component];
            }
            for axis in (0..D).rev() {
                let (before, inner) = (n.pow(axis as u32), m.pow((D - 1 - axis) as u32));
                let (from, to) = (before * n * inner, before * m * inner);
                // The lists that exist: the value, and the derivatives along the axes that are done.
                for list in 0..=D {
                    let own_axis = list == 1 + axis;
                    let done = list > 1 + axis;
                    if list > 0 && !(derivatives.gradient && (own_axis || done)) {
                        continue;
                    }
                    if list == 0 && axis == 0 && !derivatives.value {
                        continue;
                    }
                    let source = if done { &stages.from[list] } else { &stages.from[0] };
                    let table = &tables.to_points[usize::from(own_axis)];
                    let target = if axis == 0 {
                        &mut own[derivatives.place(list) * points..][..points]
                    } else {
                        &mut stages.to[list][..to]
                    };
                    contract(table, n, inner, &source[..from], target, false);
                }
                std::mem::swap(&mut stages.from, &mut stages.to);
            }
        }
    }
}

/// Sums over all points of what is tested with each basis function.
pub(in crate::assemble) struct Integration<'a, L, const D: usize> {
    pub tables: &'a ProductTables,
    pub derivatives: Derivatives,
    /// Factors of the value, if any, of each component, then those of the derivatives along the axes of the
    /// reference cell, if anything; each at all places of the grid of points.
    pub source: &'a [L],
    pub components: usize,
    pub stages: &'a mut Stages<L>,
    /// Node × component.
    pub sums: &'a mut [L],
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Integration<'_, L, D> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Integration { tables, derivatives, source, components, stages, sums } = self;
        let (n, m) = (tables.nodes, tables.points);
        let points = m.pow(D as u32);
        stages.prepare(D + 1, n.max(m).pow(D as u32));
        for component in 0..components {
            for axis in 0..D {
                let (before, inner) = (n.pow(axis as u32), m.pow((D - 1 - axis) as u32));
                let (from, to) = (before * m * inner, before * n * inner);
                let has_value = derivatives.value || axis > 0;
                for list in 0..=D {
                    let (own_axis, left) = (list == 1 + axis, list > 1 + axis);
                    if list == 0 && !has_value {
                        continue;
                    }
                    if list > 0 && !(derivatives.gradient && (own_axis || left)) {
                        continue;
                    }
                    let source = if axis == 0 {
                        &source[(derivatives.place(list) * components + component) * points..][..points]
                    } else {
                        &stages.from[list][..from]
                    };
                    let table = &tables.to_nodes[usize::from(own_axis)];
                    let target = &mut stages.to[if left { list } else { 0 }][..to];
                    contract(table, m, inner, source, target, own_axis && has_value);
                }
                std::mem::swap(&mut stages.from, &mut stages.to);
            }
            let last = &stages.from[0][..tables.node_at.len()];
            for place in 0..last.len() {
                sums[tables.node_at[place] as usize * components + component] = last[place];
            }
        }
    }
}
