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
            let (table, _) = table.as_chunks::<COLUMNS>();
            if add {
                down::<L, COLUMNS, true>(table, &values, &mut target[..table.len()]);
            } else {
                down::<L, COLUMNS, false>(table, &values, &mut target[..table.len()]);
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

/// Entries that are computed side by side: what a loop takes for itself is shared.
const SIDE_BY_SIDE: usize = 3;

/// Σ over columns, for each row of the table.
#[inline(always)]
fn down<L: SimdLane, const COLUMNS: usize, const ADD: bool>(
    table: &[[f64; COLUMNS]],
    values: &[L; COLUMNS],
    target: &mut [L],
) {
    let (rows, others) = table.as_chunks::<SIDE_BY_SIDE>();
    let (targets, rest) = target.as_chunks_mut::<SIDE_BY_SIDE>();
    let targets = &mut targets[..rows.len()];
    for k in 0..rows.len() {
        for r in 0..SIDE_BY_SIDE {
            let start = if ADD { targets[k][r] } else { L::splat(0.0) };
            targets[k][r] = combined(values, &rows[k][r], start);
        }
    }
    let rest = &mut rest[..others.len()];
    for r in 0..others.len() {
        let start = if ADD { rest[r] } else { L::splat(0.0) };
        rest[r] = combined(values, &others[r], start);
    }
}

#[inline(always)]
fn combined<L: SimdLane, const COLUMNS: usize>(
    values: &[L; COLUMNS],
    factors: &[f64; COLUMNS],
    start: L,
) -> L {
    let mut sum = start;
    for c in 0..COLUMNS {
        sum = values[c].multiply_add(L::splat(factors[c]), sum);
    }
    sum
}

#[inline(always)]
fn along<L: SimdLane, const COLUMNS: usize, const ADD: bool>(
    columns: &[&[L]; COLUMNS],
    factors: &[L; COLUMNS],
    target: &mut [L],
) {
    // Of known lengths: nothing is checked per entry.
    let (targets, rest) = target.as_chunks_mut::<SIDE_BY_SIDE>();
    let whole = targets.len();
    let mut chunks = [columns[0].as_chunks::<SIDE_BY_SIDE>().0; COLUMNS];
    let mut ends = [&columns[0][..0]; COLUMNS];
    for c in 0..COLUMNS {
        let (own, end) = columns[c].as_chunks::<SIDE_BY_SIDE>();
        (chunks[c], ends[c]) = (&own[..whole], &end[..rest.len()]);
    }
    for k in 0..whole {
        for entry in 0..SIDE_BY_SIDE {
            let mut sum = if ADD { targets[k][entry] } else { L::splat(0.0) };
            for c in 0..COLUMNS {
                sum = chunks[c][k][entry].multiply_add(factors[c], sum);
            }
            targets[k][entry] = sum;
        }
    }
    for k in 0..rest.len() {
        let mut sum = if ADD { rest[k] } else { L::splat(0.0) };
        for c in 0..COLUMNS {
            sum = ends[c][k].multiply_add(factors[c], sum);
        }
        rest[k] = sum;
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
