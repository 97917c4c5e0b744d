//! The pictures: Figures 3, 4 and 5 of the paper.

use std::path::{Path, PathBuf};

use forms_contact::hollow_cylinder::OUTER_RADIUS;
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Marker, Panel, Picture, Scale};

use crate::Outcome;
use crate::study::{Relative, Study, envelope};
use crate::tables::{LENGTHS, file_name, omega, signed};

/// Half of the width of the window about an end of the contact zone, in cells of the mesh that is shown.
const WINDOW: f64 = 6.0;

/// Writes each figure as PNG and SVG and returns their paths.
pub fn write_all(study: &Study, directory: &Path) -> Outcome<Vec<PathBuf>> {
    let figures = [
        ("figure_3_left", displacement_and_adjoint(study).draw()?),
        ("figure_3_right", contact_zone(study).draw()?),
        ("figure_4_left", error_map(study)?.draw()?),
        ("figure_4_right", extended_neumann(study).draw()?),
        ("figure_5", discrete_adjoint(study).draw()?),
    ];
    let mut paths = Vec::new();
    for (name, figure) in figures {
        let path = directory.join(file_name(name, study.theta, "png"));
        figure.write_png(&path)?;
        paths.push(path);
        let path = directory.join(file_name(name, study.theta, "svg"));
        figure.write_svg(&path)?;
        paths.push(path);
    }
    Ok(paths)
}

/// Axes for errors over h.
fn error_plot(study: &Study, title: &str) -> LinePlot {
    LinePlot::new()
        .title(&format!("{title}, θ = {}", signed(study.theta)))
        .x_axis("h [cm]", Scale::Logarithmic)
        .y_axis("relative H^{1} error (ratio of norms)", Scale::Logarithmic)
        .grid()
        .size(360.0, 280.0)
}

/// A curve of errors with its fitted order.
fn curve(study: &Study, name: &str, errors: &[Relative], value: impl Fn(&Relative) -> f64) -> Curve {
    let values: Vec<f64> = errors.iter().map(value).collect();
    Curve::new(name, &study.widths(), &values).fitted_order(values.len())
}

/// One of [`Study::quantities`] in the full norm, under a name for the legend.
fn full(study: &Study, quantity: usize, name: &str) -> Curve {
    curve(study, name, &study.quantities()[quantity].1, |error| error.h1)
}

fn displacement_and_adjoint(study: &Study) -> LinePlot {
    let quantities = study.quantities();
    let seminorm = |k: usize, name: &str| {
        curve(study, name, &quantities[k].1, |error| error.seminorm).dashed().without_markers()
    };
    error_plot(study, "Displacement and adjoint state")
        .curve(full(study, 0, "u_{h} (14)").slope_triangle(1.5))
        .curve(full(study, 1, "p_{h} (22)").slope_triangle(0.5))
        .curve(seminorm(0, "u_{h}, semi-norm"))
        .curve(seminorm(1, "p_{h}, semi-norm"))
}

fn extended_neumann(study: &Study) -> LinePlot {
    let mut plot =
        error_plot(study, "Extended Neumann zone").curve(full(study, 1, "p_{h} (22)").slope_triangle(0.5));
    for (k, extension) in study.extensions.iter().enumerate() {
        let name = format!("(41), C = {extension}");
        plot = plot.curve(full(study, 3 + k, &name).dashed());
    }
    plot
}

fn discrete_adjoint(study: &Study) -> LinePlot {
    error_plot(study, "Discrete adjoint state")
        .curve(full(study, 0, "u_{h} (14)").slope_triangle(1.5))
        .curve(full(study, 1, "p_{h} (22)").slope_triangle(0.5))
        .curve(full(study, 2, "p̃_{h} (21)"))
}

/// Both lengths over h, their zeros at the foot of the plot, and the envelope of their sum.
fn contact_zone(study: &Study) -> LinePlot {
    let positive = |k: usize| study.whole.zones.iter().map(LENGTHS[k].1).filter(|length| *length > 0.0);
    let smallest = positive(0).chain(positive(1)).fold(f64::INFINITY, f64::min);
    // Logarithmic axes have no zero: it gets a line below everything else.
    let foot = if smallest.is_finite() { smallest / 4.0 } else { 1.0 };
    let mut plot = LinePlot::new()
        .title(&format!("Contact zone against n_{{r}} = {}, θ = {}", study.reference, signed(study.theta)))
        .x_axis("h [cm]", Scale::Logarithmic)
        .y_axis("length [cm]", Scale::Logarithmic)
        .grid()
        .size(360.0, 300.0)
        .horizontal_line(foot, "zero");
    let names = ["|Γ^{h}_{C,a} ∩ Γ_{C,i}|", "|Γ_{C,a} ∩ Γ^{h}_{C,i}|"];
    for (k, marker) in [Marker::Circle, Marker::Square].into_iter().enumerate() {
        let (h, lengths): (Vec<f64>, Vec<f64>) = study
            .whole
            .zones
            .iter()
            .map(|zone| match LENGTHS[k].1(zone) {
                0.0 => (zone.h, foot),
                length => (zone.h, length),
            })
            .unzip();
        plot = plot.curve(Curve::new(names[k], &h, &lengths).marker(marker).without_line());
    }
    let (h, lengths): (Vec<f64>, Vec<f64>) = envelope(&study.whole.zones, LENGTHS[2].1).into_iter().unzip();
    if omega(&study.whole.zones, LENGTHS[2].1).is_some() {
        let name = "envelope of their sum";
        plot = plot.curve(Curve::new(name, &h, &lengths).fitted_order(h.len()).without_markers());
    }
    plot
}

/// |p_h − p_ref| on the finest of the meshes: the whole body, and about the right end of the contact zone.
fn error_map(study: &Study) -> Outcome<Panel> {
    let finest = study.finest()?;
    let p = &finest.adjoint;
    let mesh = p.space().mesh();
    let difference = |cell: usize, point: &[f64; 2]| {
        let (position, _) = mesh.map(cell, point);
        study.adjoint_difference(finest, &position, &p.evaluate_in(cell, point))
    };
    let map = |title: &str| {
        FieldMap::cell_by_cell(mesh, difference, "|p_{h} − p_{ref}| [N cm^{2}/MPa]")
            .without_mesh_lines()
            .length_unit("cm")
            .title(title)
    };
    let end = study.reference_zone.parts.last().map_or(0.0, |part| part[1]) / OUTER_RADIUS;
    let [x, y] = [OUTER_RADIUS * end.sin(), -OUTER_RADIUS * end.cos()];
    let half = WINDOW * finest.h;
    // More of the body than of what lies below it.
    let zoom = map("About an end of the contact zone")
        .window([x - half, x + half], [y - 0.5 * half, y + 1.5 * half]);
    let whole =
        map(&format!("n_{{r}} = {} against {}, θ = {}", finest.radial, study.reference, signed(study.theta)));
    Ok(Panel::new(2).picture(&whole)?.picture(&zoom)?)
}
