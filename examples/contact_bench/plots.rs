//! Plots of each problem: the error over the unknowns, Newton steps, the pressure along the contact.

use std::path::{Path, PathBuf};

use forms_fem::output::Failure;
use forms_fem::output::picture::{Colour, Curve, LinePlot, Panel, Picture, Scale};

use crate::rows::Row;

/// Curves of one picture at most: colours and markers repeat beyond.
const CURVES: usize = 24;

/// Width and height of the plots of curves \[pt\]: three columns of names fit below.
const SIZE: [f64; 2] = [560.0, 480.0];

/// A formulation's name in a legend.
fn short(name: &str) -> String {
    let mut short = name.replace("nitsche", "Nitsche");
    for (long, abbreviation) in [
        ("points of whole facets", "whole facets"),
        ("augmented Lagrangian", "augm. Lagrangian"),
        ("proximal Galerkin", "proximal"),
        ("mean gaps, Nitsche θ = 0", "mean gaps"),
        (", one step each", ", 1 each"),
        ("dual multipliers (bounds at nodes)", "dual multipliers"),
        ("log barrier, ĝ/d", "barrier ĝ/d"),
    ] {
        short = short.replace(long, abbreviation);
    }
    short
}

/// Writes the plots of all problems, for the largest degree that was run. The paths.
///
/// # Errors
/// A file that cannot be written.
pub fn write(rows: &[Row], directory: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut paths = vec![];
    let mut problems: Vec<&str> = rows.iter().map(|row| row.problem.as_str()).collect();
    problems.dedup();
    for problem in problems {
        let of: Vec<&Row> =
            rows.iter().filter(|row| row.problem == problem && row.measured().is_some()).collect();
        let Some(degree) = of.iter().map(|row| row.degree).max() else { continue };
        let of: Vec<&Row> = of.into_iter().filter(|row| row.degree == degree).collect();
        let mut names: Vec<&str> = of.iter().map(|row| row.formulation.as_str()).collect();
        names.dedup();
        names.truncate(CURVES);
        let curves: Vec<(&str, Vec<&Row>)> = names
            .iter()
            .map(|name| (*name, of.iter().copied().filter(|row| row.formulation == *name).collect()))
            .collect();
        let path = |what: &str| directory.join(format!("{problem}_{what}.png"));
        for (plot, what) in [(errors(&curves), "errors"), (newton(&curves), "newton")] {
            if let Some(plot) = plot {
                plot.write_png(path(what))?;
                paths.push(path(what));
            }
        }
        if let Some(panel) = pressures(&curves)? {
            panel.write_png_at(path("pressures"), 100.0)?;
            paths.push(path("pressures"));
        }
    }
    Ok(paths)
}

fn errors(curves: &[(&str, Vec<&Row>)]) -> Option<LinePlot> {
    let mut plot = LinePlot::new()
        .size(SIZE[0], SIZE[1])
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis("relative error of the pressure", Scale::Logarithmic);
    let mut any = false;
    for (name, rows) in curves {
        let points: Vec<(f64, f64)> = rows
            .iter()
            .filter_map(|row| Some((row.unknowns as f64, row.measured()?.pressure_error?)))
            .filter(|(_, error)| *error > 1e-16)
            .collect();
        if points.len() > 1 {
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            plot = plot.curve(Curve::new(&short(name), &x, &y));
            any = true;
        }
    }
    any.then_some(plot)
}

fn newton(curves: &[(&str, Vec<&Row>)]) -> Option<LinePlot> {
    let mut plot = LinePlot::new()
        .size(SIZE[0], SIZE[1])
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis("Newton steps", Scale::Logarithmic);
    let mut any = false;
    for (name, rows) in curves {
        let steps = |row: &&&Row| row.measured().map_or(0, |measured| measured.newton);
        let rows: Vec<&&Row> = rows.iter().filter(|row| steps(row) > 0).collect();
        if rows.len() > 1 {
            let x: Vec<f64> = rows.iter().map(|row| row.unknowns as f64).collect();
            let y: Vec<f64> = rows.iter().map(|row| steps(row) as f64).collect();
            plot = plot.curve(Curve::new(&short(name), &x, &y));
            any = true;
        }
    }
    any.then_some(plot)
}

fn finest<'a>(rows: &[&'a Row]) -> Option<&'a Row> {
    rows.iter().copied().max_by_key(|row| row.level)
}

/// A small plot per formulation, with the known pressure.
fn pressures(curves: &[(&str, Vec<&Row>)]) -> Result<Option<Panel>, Failure> {
    let mut panel = Panel::new(4);
    let mut any = false;
    for (name, rows) in curves {
        let Some(measured) = finest(rows).and_then(Row::measured) else { continue };
        let split =
            |points: &[[f64; 2]]| -> (Vec<f64>, Vec<f64>) { points.iter().map(|[x, y]| (*x, *y)).unzip() };
        let ((x, y), (places, known)) = (split(&measured.pressures), split(&measured.known));
        let most = |y: &[f64]| y.iter().copied().fold(0.0, f64::max);
        // A method may be far off, and a known pressure infinite.
        let top = if known.is_empty() { most(&y) } else { most(&known).min(3.0 * known[0].abs()) };
        if top <= 0.0 {
            continue;
        }
        let mut plot = LinePlot::new()
            .title(&short(name))
            .size(190.0, 150.0)
            .x_axis("", Scale::Linear)
            .y_axis("", Scale::Linear)
            .y_range(-0.15 * top, 1.35 * top)
            .curve(Curve::new("", &x, &y).without_markers());
        if !known.is_empty() {
            plot =
                plot.curve(Curve::new("", &places, &known).colour(Colour::BLACK).without_markers().dashed());
        }
        panel = panel.picture(&plot)?;
        any = true;
    }
    Ok(any.then_some(panel))
}
