//! Fields at the points of a batch of cells: the sums over coefficients that slots read.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{FieldSlot, Order, Requirements};

use super::batch::{FixedBatch, PointMap, row};
use super::field_buffers::{FieldBuffers, Numbers, first_slot};
use super::tables::{FieldBasis, FieldTables, FixedTables};
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::lanes::SimdLane;

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
