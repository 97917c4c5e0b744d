//! The innermost loop: a small table of numbers times lane values along one axis.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use crate::lanes::SimdLane;

/// target\[o\]\[r\]\[k\] = Σ_c table\[r\]\[c\] source\[o\]\[c\]\[k\] for k < `inner`; added to what is there if `add`.
#[inline(always)]
pub(super) fn contract<L: SimdLane>(
    table: &[f64],
    columns: usize,
    inner: usize,
    source: &[L],
    target: &mut [L],
    add: bool,
) {
    match columns {
        2 => contract_fixed::<L, 2>(table, inner, source, target, add),
        3 => contract_fixed::<L, 3>(table, inner, source, target, add),
        4 => contract_fixed::<L, 4>(table, inner, source, target, add),
        5 => contract_fixed::<L, 5>(table, inner, source, target, add),
        6 => contract_fixed::<L, 6>(table, inner, source, target, add),
        _ => contract_any(table, columns, inner, source, target, add),
    }
}

#[inline(always)]
fn contract_fixed<L: SimdLane, const COLUMNS: usize>(
    table: &[f64],
    inner: usize,
    source: &[L],
    target: &mut [L],
    add: bool,
) {
    let rows = table.len() / COLUMNS;
    let zero = L::splat(0.0);
    let sources = source.chunks_exact(COLUMNS * inner);
    for (source, target) in sources.zip(target.chunks_exact_mut(rows * inner)) {
        if inner == 1 {
            let mut values = [zero; COLUMNS];
            for c in 0..COLUMNS {
                values[c] = source[c];
            }
            for (factors, target) in table.chunks_exact(COLUMNS).zip(target.iter_mut()) {
                let mut sum = if add { *target } else { zero };
                for c in 0..COLUMNS {
                    sum = values[c].multiply_add(L::splat(factors[c]), sum);
                }
                *target = sum;
            }
            continue;
        }
        let mut columns = [&source[..0]; COLUMNS];
        for c in 0..COLUMNS {
            columns[c] = &source[c * inner..][..inner];
        }
        for (factors, target) in table.chunks_exact(COLUMNS).zip(target.chunks_exact_mut(inner)) {
            let mut lanes = [zero; COLUMNS];
            for c in 0..COLUMNS {
                lanes[c] = L::splat(factors[c]);
            }
            // Of a known length, and decided before the loop, not in it.
            let target = &mut target[..inner];
            if add {
                along::<L, COLUMNS, true>(&columns, &lanes, target);
            } else {
                along::<L, COLUMNS, false>(&columns, &lanes, target);
            }
        }
    }
}

#[inline(always)]
fn along<L: SimdLane, const COLUMNS: usize, const ADD: bool>(
    columns: &[&[L]; COLUMNS],
    factors: &[L; COLUMNS],
    target: &mut [L],
) {
    for k in 0..target.len() {
        let mut sum = if ADD { target[k] } else { L::splat(0.0) };
        for c in 0..COLUMNS {
            sum = columns[c][k].multiply_add(factors[c], sum);
        }
        target[k] = sum;
    }
}

#[inline(always)]
fn contract_any<L: SimdLane>(
    table: &[f64],
    columns: usize,
    inner: usize,
    source: &[L],
    target: &mut [L],
    add: bool,
) {
    let rows = table.len() / columns;
    let sources = source.chunks_exact(columns * inner);
    for (source, target) in sources.zip(target.chunks_exact_mut(rows * inner)) {
        for (factors, target) in table.chunks_exact(columns).zip(target.chunks_exact_mut(inner)) {
            for k in 0..inner {
                let mut sum = if add { target[k] } else { L::splat(0.0) };
                for c in 0..columns {
                    sum = source[c * inner + k].multiply_add(L::splat(factors[c]), sum);
                }
                target[k] = sum;
            }
        }
    }
}
