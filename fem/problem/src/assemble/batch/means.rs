//! Means over the cells of a batch: of basis functions, and of the fields that a kernel reads by their means.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{FieldSlot, Further, Order, Requirements};

use super::cell_map::inverse_transposed;
use super::fields::side_index;
use super::side::SideBuffers;
use super::{Batch, BatchBuffers, Reads};
use crate::assemble::binding::Values;
use crate::assemble::groups::means::MeanTables;
use crate::lanes::SimdLane;

impl<L: SimdLane, const D: usize> Batch<'_, L, D> {
    /// The means that the kernel reads, the same at all points: of basis functions on both sides, and of fields.
    #[inline(always)]
    pub(super) fn load_means(&mut self, requirements: &Requirements) {
        let group = self.group;
        for side in 0..group.sides.len() {
            let Some(tables) = &group.sides[side].means else { return };
            let BatchBuffers { sides, reads, .. } = &mut *self.buffers;
            let least = sides[side].evaluate_means(tables, &reads[side]);
            self.least = self.least.minimum(least);
        }
        for index in 0..requirements.fields.len() {
            let slot = &requirements.fields[index];
            if !slot.order.is_mean() {
                continue;
            }
            let (Values::Discrete { element, .. } | Values::Given { element, .. }) =
                &self.binding.values[slot.field]
            else {
                continue;
            };
            let BatchBuffers { sides, coefficients, fields, .. } = &mut *self.buffers;
            interpolate(slot, &sides[side_index(slot.side)].further[*element], &coefficients[index], fields);
        }
    }
}

impl<L: SimdLane, const D: usize> SideBuffers<L, D> {
    /// (∫ φ, ∫ ∇φ) / |T| of the functions of all elements whose means are read; gives the least Jacobian determinant.
    #[inline(always)]
    fn evaluate_means(&mut self, tables: &MeanTables<D>, reads: &[Reads]) -> L {
        let zero = L::splat(0.0);
        for index in 0..reads.len() {
            if reads[index].mean {
                for further in &mut self.further[index] {
                    further.mean = Further::none().mean;
                }
            }
        }
        let (mut volume, mut least) = (zero, L::splat(f64::INFINITY));
        for q in 0..tables.weights.len() {
            let (determinant, inverse) = inverse_transposed(&self.jacobian_at(&tables.geometry, q));
            least = least.minimum(determinant);
            let weight = determinant * L::splat(tables.weights[q]);
            volume += weight;
            for index in 0..reads.len() {
                if !reads[index].mean {
                    continue;
                }
                let table = &tables.elements[index];
                let (values, slopes) = (&table.value[q * table.nodes..], &table.gradient[q * table.nodes..]);
                let further = &mut self.further[index][..table.nodes];
                for node in 0..table.nodes {
                    let mean = &mut further[node].mean;
                    mean.value = weight.multiply_add(L::splat(values[node]), mean.value);
                    for i in 0..D {
                        let mut slope = inverse[i][0] * L::splat(slopes[node][0]);
                        for j in 1..D {
                            slope = inverse[i][j].multiply_add(L::splat(slopes[node][j]), slope);
                        }
                        mean.gradient[i] = weight.multiply_add(slope, mean.gradient[i]);
                    }
                }
            }
        }
        let scale = L::splat(1.0) / volume;
        for index in 0..reads.len() {
            if !reads[index].mean {
                continue;
            }
            for further in &mut self.further[index] {
                let mean = &mut further.mean;
                mean.value = mean.value * scale;
                for axis in 0..D {
                    mean.gradient[axis] = mean.gradient[axis] * scale;
                }
            }
        }
        least
    }
}

/// Σ over the nodes of coefficient × mean of the basis function, or of its gradient.
#[inline(always)]
fn interpolate<L: SimdLane, const D: usize>(
    slot: &FieldSlot,
    further: &[Further<L, D>],
    coefficients: &[L],
    fields: &mut [L],
) {
    let components = slot.components;
    for component in 0..components {
        if slot.order == Order::MeanValue {
            let mut sum = L::splat(0.0);
            for node in 0..further.len() {
                let mean = further[node].mean.value;
                sum = mean.multiply_add(coefficients[node * components + component], sum);
            }
            fields[slot.offset + component] = sum;
            continue;
        }
        let mut sums = [L::splat(0.0); D];
        for node in 0..further.len() {
            let coefficient = coefficients[node * components + component];
            for axis in 0..D {
                sums[axis] = further[node].mean.gradient[axis].multiply_add(coefficient, sums[axis]);
            }
        }
        for axis in 0..D {
            fields[slot.offset + component * D + axis] = sums[axis];
        }
    }
}
