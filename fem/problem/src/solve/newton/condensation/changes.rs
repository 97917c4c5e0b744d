//! Tangent less the linear part, reduced to the free unknowns, in either form in which a problem may give it.

use std::ops::Range;
use std::sync::Arc;

use crate::linear_algebra::{BlockMatrix, CsrMatrix, Entry};
use crate::solve::condensed_solver::additions;
use crate::solve::elimination::Elimination;
use crate::solve::newton::{NewtonFailure, NonlinearTangent, PartlyLinear};

/// The tangent at some u less the linear part, reduced.
pub(super) struct Changes {
    pub additions: Vec<Entry>,
    /// The unknowns that the nonlinearity reads.
    pub watched: Vec<u32>,
    /// Unknowns at which coming tangents may add.
    pub near: Vec<u32>,
}

/// The linear part on the free unknowns.
pub(in crate::solve::newton) struct Reduced {
    pub matrix: Arc<CsrMatrix>,
    /// All rows and columns, where free unknowns give others: entries of tangents are then sums over several places.
    pub full: Option<BlockMatrix>,
}

/// Entries that a tangent adds to the linear part at some places, reduced.
pub(super) fn differences(
    elimination: &mut Elimination,
    linear_part: &Reduced,
    tangent: &BlockMatrix,
    places: &[Range<usize>],
) -> Result<Vec<Entry>, NewtonFailure> {
    Ok(match &linear_part.full {
        Some(base) => without_zeros(elimination.reduce_differences(tangent, base, places)?),
        None => additions(&linear_part.matrix, &elimination.reduce_places(tangent, places)?)?,
    })
}

fn without_zeros(mut entries: Vec<Entry>) -> Vec<Entry> {
    entries.retain(|entry| entry.value != 0.0);
    entries
}

/// The tangent of the nonlinear part, reduced, where the problem has it by itself.
pub(super) fn nonlinear_changes(
    problem: &mut dyn PartlyLinear,
    elimination: &Elimination,
    u: &[f64],
) -> Result<Option<Changes>, NewtonFailure> {
    let Some(tangent) = problem.nonlinear_tangent(u)? else { return Ok(None) };
    if !elimination.only_prescribes() {
        return Ok(Some(related_changes(&tangent, elimination)));
    }
    let mut places = vec![u32::MAX; elimination.size()];
    elimination.free().iter().enumerate().for_each(|(place, unknown)| places[*unknown] = place as u32);
    let is_free = |place: &u32| *place != u32::MAX;
    let (mut additions, mut near) = (Vec::new(), Vec::new());
    for &row in tangent.rows.iter().filter(|row| is_free(&places[**row])) {
        let first = additions.len();
        for (column, value) in tangent.matrix.row(row).filter(|(_, value)| *value != 0.0) {
            if is_free(&places[column]) {
                additions.push(Entry { row: places[row], column: places[column], value });
            }
        }
        // What is stored beyond is where pairs may come to soon.
        if additions.len() > first {
            near.extend(tangent.matrix.row(row).map(|(column, _)| places[column]).filter(is_free));
        }
    }
    near.sort_unstable();
    near.dedup();
    let watched = tangent.reads.iter().map(|unknown| places[*unknown]).filter(is_free).collect();
    Ok(Some(Changes { additions, watched, near }))
}

/// The tangent of the nonlinear part where free unknowns give others.
fn related_changes(tangent: &NonlinearTangent<'_>, elimination: &Elimination) -> Changes {
    let weights = elimination.weights();
    let reduced = |unknown: usize| weights.of(unknown).iter().map(|(number, _)| *number);
    let (mut entries, mut near) = (Vec::new(), Vec::new());
    for &row in tangent.rows.iter().filter(|row| !weights.of(**row).is_empty()) {
        let first = entries.len();
        for (column, value) in tangent.matrix.row(row).filter(|(_, value)| *value != 0.0) {
            entries.push(Entry { row: row as u32, column: column as u32, value });
        }
        // What is stored beyond is where pairs may come to soon.
        if entries.len() > first {
            near.extend(reduced(row));
            near.extend(tangent.matrix.row(row).flat_map(|(column, _)| reduced(column)));
        }
    }
    near.sort_unstable();
    near.dedup();
    let mut watched: Vec<u32> = tangent.reads.iter().flat_map(|unknown| reduced(*unknown)).collect();
    watched.sort_unstable();
    watched.dedup();
    Changes { additions: weights.reduce(entries), watched, near }
}

/// The tangent at u less the linear part, in either form in which a problem may give it.
pub(super) fn changes(
    problem: &mut dyn PartlyLinear,
    elimination: &mut Elimination,
    linear_part: &Reduced,
    u: &[f64],
) -> Result<Changes, NewtonFailure> {
    if let Some(changes) = nonlinear_changes(problem, elimination, u)? {
        return Ok(changes);
    }
    let tangent = problem.tangent(u)?;
    let places = tangent.changed.unwrap_or_default();
    let (additions, entries) = match &linear_part.full {
        Some(base) => {
            let additions = elimination.reduce_differences(&tangent.matrix, base, places)?;
            (without_zeros(additions.clone()), additions)
        }
        None => {
            let entries = elimination.reduce_places(&tangent.matrix, places)?;
            (additions(&linear_part.matrix, &entries)?, entries)
        }
    };
    // Marks are quicker than a sorted list: each unknown is met in many entries.
    let mut is_watched = vec![false; linear_part.matrix.rows()];
    for unknown in entries.iter().flat_map(|entry| [entry.row, entry.column]) {
        is_watched[unknown as usize] = true;
    }
    let watched = (0..).zip(is_watched).filter_map(|(unknown, is_watched)| is_watched.then_some(unknown));
    let watched = watched.collect();
    Ok(Changes { additions, watched, near: vec![] })
}
