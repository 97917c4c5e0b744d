//! Tangent less the linear part, reduced to the free unknowns, in either form in which a problem may give it.

use crate::linear_algebra::{CsrMatrix, Entry};
use crate::solve::condensed_solver::additions;
use crate::solve::elimination::Elimination;
use crate::solve::newton::{NewtonFailure, PartlyLinear};

/// The tangent at some u less the linear part, reduced.
pub(super) struct Changes {
    pub additions: Vec<Entry>,
    /// The unknowns that the nonlinearity reads.
    pub watched: Vec<u32>,
    /// Unknowns at which coming tangents may add.
    pub near: Vec<u32>,
}

/// The entries of the tangent at u, reduced, at the places where it may differ from the linear part.
pub(super) fn changed_entries(
    problem: &mut dyn PartlyLinear,
    elimination: &mut Elimination,
    u: &[f64],
) -> Result<Vec<Entry>, NewtonFailure> {
    let tangent = problem.tangent(u)?;
    let places = tangent.changed.unwrap_or_default();
    Ok(elimination.reduce_places(&tangent.matrix, places)?)
}

/// The tangent of the nonlinear part, reduced, where the problem has it by itself.
pub(super) fn nonlinear_changes(
    problem: &mut dyn PartlyLinear,
    elimination: &Elimination,
    u: &[f64],
) -> Result<Option<Changes>, NewtonFailure> {
    let Some(tangent) = problem.nonlinear_tangent(u)? else { return Ok(None) };
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

/// The tangent at u less the linear part, in either form in which a problem may give it.
pub(super) fn changes(
    problem: &mut dyn PartlyLinear,
    elimination: &mut Elimination,
    linear_part: &CsrMatrix,
    u: &[f64],
) -> Result<Changes, NewtonFailure> {
    if let Some(changes) = nonlinear_changes(problem, elimination, u)? {
        return Ok(changes);
    }
    let entries = changed_entries(problem, elimination, u)?;
    // Marks are quicker than a sorted list: each unknown is met in many entries.
    let mut is_watched = vec![false; linear_part.rows()];
    for unknown in entries.iter().flat_map(|entry| [entry.row, entry.column]) {
        is_watched[unknown as usize] = true;
    }
    let watched = (0..).zip(is_watched).filter_map(|(unknown, is_watched)| is_watched.then_some(unknown));
    let watched = watched.collect();
    Ok(Changes { additions: additions(linear_part, &entries)?, watched, near: vec![] })
}
