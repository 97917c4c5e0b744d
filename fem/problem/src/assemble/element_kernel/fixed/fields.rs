//! Fields at the points of a batch of cells: coefficients, loaded once, and the sums that slots read.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{FieldSlot, Order, Requirements};

use super::batch::{FixedBatch, PointMap, row};
use super::tables::{FieldBasis, FieldTables, FixedTables, MOST_NUMBERS};
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::lanes::{SimdLane, Starts};

/// Memory of a batch, kept from one run to the next: coefficients per slot, node × component. Only the first slot of a field has any.
pub(super) struct FieldBuffers<L>(Vec<Vec<L>>);

/// What a kernel reads of fields at a point, at the places of its slots. An array: where places are constants its numbers stay in registers.
pub(super) type Numbers<L> = [L; MOST_NUMBERS];

impl<L: SimdLane> FieldBuffers<L> {
    /// Memory for the coefficients that a kernel reads.
    pub fn new<S: Sizes, const D: usize>(requirements: &Requirements, tables: &FixedTables<S, D>) -> Self {
        let zero = L::splat(0.0);
        let coefficients = requirements.fields.iter().map(|slot| {
            let nodes = tables.fields[slot.field].as_ref().map_or(0, |field| field.tables.nodes);
            vec![zero; nodes * slot.components]
        });
        FieldBuffers(coefficients.collect())
    }

    /// The coefficients of some cells, loaded.
    #[inline(always)]
    pub fn load<S: Sizes, const D: usize>(
        &mut self,
        requirements: &Requirements,
        tables: &FixedTables<S, D>,
        coefficients: &[f64],
        starts: &Starts,
    ) {
        // One by one, so that each is compiled for its slot.
        macro_rules! load {
            ($($index:literal)*) => {
                $(if requirements.fields.len() > $index {
                    self.load_slot(requirements, $index, tables, coefficients, starts);
                })*
            };
        }
        load!(0 1 2 3);
        for index in 4..requirements.fields.len() {
            self.load_slot(requirements, index, tables, coefficients, starts);
        }
    }

    #[inline(always)]
    fn load_slot<S: Sizes, const D: usize>(
        &mut self,
        requirements: &Requirements,
        index: usize,
        tables: &FixedTables<S, D>,
        coefficients: &[f64],
        starts: &Starts,
    ) {
        let slot = &requirements.fields[index];
        if first_slot(requirements, index) != index {
            return;
        }
        let Some(field) = &tables.fields[slot.field] else { return };
        let target = &mut self.0[index];
        match slot.components {
            1 => gather_field::<L, 1>(coefficients, starts, &field.offsets, target),
            2 => gather_field::<L, 2>(coefficients, starts, &field.offsets, target),
            _ => gather_field::<L, 3>(coefficients, starts, &field.offsets, target),
        }
    }
}

impl<L: SimdLane, S: Sizes, const D: usize> FixedBatch<'_, L, S, D> {
    /// The value that one slot reads at the q-th point.
    #[inline(always)]
    pub fn evaluate_slot(
        &self,
        requirements: &Requirements,
        index: usize,
        q: usize,
        map: &PointMap<L, D>,
        buffers: &FieldBuffers<L>,
        numbers: &mut Numbers<L>,
    ) {
        let slot = &requirements.fields[index];
        let Some(field) = &self.tables.fields[slot.field] else { return };
        let coefficients = &buffers.0[first_slot(requirements, index)][..];
        let target = &mut numbers[slot.offset..];
        match slot.components {
            1 => self.interpolate::<1>(slot, field, q, map, coefficients, target),
            2 => self.interpolate::<2>(slot, field, q, map, coefficients, target),
            _ => self.interpolate::<3>(slot, field, q, map, coefficients, target),
        }
    }

    #[inline(always)]
    fn interpolate<const C: usize>(
        &self,
        slot: &FieldSlot,
        field: &FieldTables<D>,
        q: usize,
        map: &PointMap<L, D>,
        coefficients: &[L],
        target: &mut [L],
    ) {
        let FixedTables { arguments, geometry, .. } = self.tables;
        let is_value = matches!(slot.order, Order::Value);
        match field.basis {
            FieldBasis::Arguments if is_value => {
                value::<L, C>(arguments.values.entries()[q].entries(), coefficients, target);
            }
            FieldBasis::Arguments => {
                let slopes = arguments.slopes.entries()[q].entries();
                gradient::<L, C, D>(slopes, &map.inverse, coefficients, target);
            }
            FieldBasis::Geometry if is_value => {
                value::<L, C>(geometry.values.entries()[q].entries(), coefficients, target);
            }
            _ if is_value => {
                let nodes = field.tables.nodes;
                value::<L, C>(&field.tables.value[q * nodes..][..nodes], coefficients, target);
            }
            _ => gradient::<L, C, D>(row(&field.tables, q), &map.inverse, coefficients, target),
        }
    }
}

/// Σ over nodes of coefficient × basis function.
#[inline(always)]
fn value<L: SimdLane, const C: usize>(values: &[f64], coefficients: &[L], target: &mut [L]) {
    let coefficients = &coefficients[..values.len() * C];
    let mut sums = [L::splat(0.0); C];
    for node in 0..values.len() {
        for component in 0..C {
            sums[component] =
                coefficients[node * C + component].multiply_add(L::splat(values[node]), sums[component]);
        }
    }
    let target = &mut target[..C];
    for component in 0..C {
        target[component] = sums[component];
    }
}

/// The gradient in reference coordinates, then in physical ones.
#[inline(always)]
fn gradient<L: SimdLane, const C: usize, const D: usize>(
    slopes: &[[f64; D]],
    inverse: &[[L; D]; D],
    coefficients: &[L],
    target: &mut [L],
) {
    let coefficients = &coefficients[..slopes.len() * C];
    let mut sums = [[L::splat(0.0); D]; C];
    for node in 0..slopes.len() {
        for component in 0..C {
            for j in 0..D {
                sums[component][j] = coefficients[node * C + component]
                    .multiply_add(L::splat(slopes[node][j]), sums[component][j]);
            }
        }
    }
    let target = &mut target[..C * D];
    for component in 0..C {
        for i in 0..D {
            let mut sum = inverse[i][0] * sums[component][0];
            for j in 1..D {
                sum = inverse[i][j].multiply_add(sums[component][j], sum);
            }
            target[component * D + i] = sum;
        }
    }
}

/// The first slot that reads the field of a slot: coefficients are loaded once.
#[inline(always)]
fn first_slot(requirements: &Requirements, index: usize) -> usize {
    let mut first = 0;
    while requirements.fields[first].field != requirements.fields[index].field {
        first += 1;
    }
    first
}

#[inline(always)]
fn gather_field<L: SimdLane, const C: usize>(
    values: &[f64],
    starts: &Starts,
    offsets: &[usize],
    target: &mut [L],
) {
    let (target, _) = target.as_chunks_mut::<C>();
    let target = &mut target[..offsets.len()];
    for node in 0..offsets.len() {
        target[node] = L::gather_from(values, starts, offsets[node]);
    }
}
