//! Tables of contact of two bodies.

use std::fmt::Write;

use super::rows::BodiesRow;
use crate::bodies::MeasuredBodies;

/// The tables.
pub fn write(rows: &[BodiesRow], text: &mut String) {
    let (solves, terms): (Vec<&BodiesRow>, Vec<&BodiesRow>) = rows.iter().partition(|row| row.is_solve());
    // Writing to a string does not fail.
    let _ = write!(
        text,
        "## Contact of two bodies\n\nThe contact term of a block on a slab, quadratic displacements on simplices that do not match, points that \
         slide along rays, µs of a processor per own facet (means), search and insertion included. Both programs have the same meshes, rule, law \
         and iterate; the last column is the largest relative difference of the norms of residual and tangent.\n\n\
         | case | unknowns | own facets | search | residual | GetFEM | ratio | tangent | GetFEM | ratio | difference |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n"
    );
    let none = || "-".to_owned();
    for row in terms {
        let each = |seconds: &[f64]| 1e6 * mean(seconds) / row.ours.facets as f64;
        let ours = |seconds: &[f64]| format!("{:.2}", each(seconds));
        let theirs = |own: &[f64], of: fn(&MeasuredBodies) -> &[f64]| match &row.getfem {
            Some(getfem) => {
                (format!("{:.0}", each(of(getfem))), format!("{:.1}", mean(of(getfem)) / mean(own)))
            }
            None => (none(), none()),
        };
        let (residual, residual_ratio) = theirs(&row.ours.residual, |getfem| &getfem.residual);
        let (tangent, tangent_ratio) = theirs(&row.ours.tangent, |getfem| &getfem.tangent);
        let _ = writeln!(
            text,
            "| {}, {} | {} | {} | {} | {} | {residual} | {residual_ratio} | {} | {tangent} | {tangent_ratio} | {} |",
            row.case.name(),
            row.law.name(),
            row.ours.unknowns,
            row.ours.facets,
            ours(&row.ours.search),
            ours(&row.ours.residual),
            ours(&row.ours.tangent),
            row.difference().map_or_else(none, |difference| format!("{difference:.0e}")),
        );
    }
    let _ = write!(
        text,
        "\nA whole solve: the block pressed onto the slab and drawn along, in seconds of a processor, from the constraints on. The last column is the relative \
         difference of the displacement's norm.\n\n\
         | case | unknowns | own facets | ours | Newton steps | GetFEM | Newton steps | ratio | difference |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
    );
    for row in solves {
        let seconds = mean(&row.ours.solve);
        let theirs = row.getfem.as_ref().map(|getfem| (mean(&getfem.solve), getfem.steps));
        let _ = writeln!(
            text,
            "| {}, {} | {} | {} | {seconds:.2} | {} | {} | {} | {} | {} |",
            row.case.name(),
            row.law.name(),
            row.ours.unknowns,
            row.ours.facets,
            row.ours.steps,
            theirs.map_or_else(none, |(seconds, _)| format!("{seconds:.1}")),
            theirs.map_or_else(none, |(_, steps)| steps.to_string()),
            theirs.map_or_else(none, |(theirs, _)| format!("{:.1}", theirs / seconds)),
            row.difference().map_or_else(none, |difference| format!("{difference:.0e}")),
        );
    }
    text.push('\n');
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
