//! Reads of a basis function, and the functions that replace it at a point.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, FieldSlot, Order, Requirements};

use crate::lanes::SimdLane;

/// Reads of a basis function: its value, its derivatives along the axes of the reference cell. By number, 0 is the
/// value and 1 + axis the derivative along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::assemble) struct Derivatives {
    pub value: bool,
    pub gradient: bool,
}

impl Derivatives {
    /// Reads of a kernel's test and trial functions, besides second derivatives.
    pub fn of_arguments(requirements: &Requirements) -> Self {
        Derivatives { value: requirements.basis_value, gradient: requirements.basis_gradient }
    }

    /// Reads of a field.
    pub fn of_slot(slot: &FieldSlot) -> Self {
        Derivatives { value: slot.order == Order::Value, gradient: slot.order == Order::Gradient }
    }

    /// Count of the numbers that are read in D dimensions.
    #[inline(always)]
    pub fn count<const D: usize>(&self) -> usize {
        usize::from(self.value) + if self.gradient { D } else { 0 }
    }

    /// The k-th of the numbers that are read.
    #[inline(always)]
    pub fn kind(&self, k: usize) -> usize {
        if self.value { k } else { k + 1 }
    }

    /// The place of one of them among those that are read.
    #[inline(always)]
    pub fn place(&self, kind: usize) -> usize {
        if self.value || kind == 0 { kind } else { kind - 1 }
    }
}

/// The function whose value, or whose derivative along an axis of the reference cell, is one and the others zero;
/// `inverse` is J⁻ᵀ.
#[inline(always)]
pub(in crate::assemble) fn unit<L: SimdLane, const D: usize>(
    inverse: &[[L; D]; D],
    kind: usize,
) -> Basis<L, D> {
    let mut unit = Basis { value: L::splat(if kind == 0 { 1.0 } else { 0.0 }), gradient: [L::splat(0.0); D] };
    if kind > 0 {
        for i in 0..D {
            unit.gradient[i] = inverse[i][kind - 1];
        }
    }
    unit
}
