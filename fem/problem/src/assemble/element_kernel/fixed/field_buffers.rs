//! Coefficients of fields on a batch of cells, loaded once, and the numbers that kernels read of them.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::Requirements;

use super::tables::{FixedTables, MOST_NUMBERS};
use crate::assemble::element_kernel::sizes::Sizes;
use crate::lanes::{SimdLane, Starts};

/// Memory of a batch, kept from one run to the next: coefficients per slot, node × component. Only the first slot of a field has any.
pub(super) struct FieldBuffers<L>(pub Vec<Vec<L>>);

/// Numbers that a kernel reads of fields at a point, at the places of its slots. An array: where places are constants its numbers stay in registers.
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

/// The first slot that reads the field of a slot: coefficients are loaded once.
#[inline(always)]
pub(super) fn first_slot(requirements: &Requirements, index: usize) -> usize {
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
