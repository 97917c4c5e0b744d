//! Plots of each problem: the error over the unknowns, Newton steps, the pressure along the contact.

use std::path::{Path, PathBuf};

use forms_fem::output::Failure;
use forms_fem::output::picture::{Colour, Curve, LinePlot, Picture, Scale};

use crate::rows::Row;

/// Curves of one picture at most.
const CURVES: usize = 12;

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
        let mut save = |plot: Option<LinePlot>, what: &str| -> Result<(), Failure> {
            if let Some(plot) = plot {
                let path = directory.join(format!("{problem}_{what}.png"));
                plot.write_png(&path)?;
                paths.push(path);
            }
            Ok(())
        };
        save(errors(&curves), "errors")?;
        save(newton(&curves), "newton")?;
        save(pressures(&curves), "pressures")?;
    }
    Ok(paths)
}

fn errors(curves: &[(&str, Vec<&Row>)]) -> Option<LinePlot> {
    let mut plot = LinePlot::new()
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
            plot = plot.curve(Curve::new(name, &x, &y));
            any = true;
        }
    }
    any.then_some(plot)
}

fn newton(curves: &[(&str, Vec<&Row>)]) -> Option<LinePlot> {
    let mut plot =
        LinePlot::new().x_axis("unknowns", Scale::Logarithmic).y_axis("Newton steps", Scale::Logarithmic);
    let mut any = false;
    for (name, rows) in curves {
        let steps = |row: &&&Row| row.measured().map_or(0, |measured| measured.newton);
        let rows: Vec<&&Row> = rows.iter().filter(|row| steps(row) > 0).collect();
        if rows.len() > 1 {
            let x: Vec<f64> = rows.iter().map(|row| row.unknowns as f64).collect();
            let y: Vec<f64> = rows.iter().map(|row| steps(row) as f64).collect();
            plot = plot.curve(Curve::new(name, &x, &y));
            any = true;
        }
    }
    any.then_some(plot)
}

fn finest<'a>(rows: &[&'a Row]) -> Option<&'a Row> {
    rows.iter().copied().max_by_key(|row| row.level)
}

fn pressures(curves: &[(&str, Vec<&Row>)]) -> Option<LinePlot> {
    let mut plot =
        LinePlot::new().x_axis("along the contact", Scale::Linear).y_axis("pressure", Scale::Linear);
    let known = curves
        .iter()
        .find_map(|(_, rows)| Some(&finest(rows)?.measured()?.known).filter(|known| !known.is_empty()));
    let mut ends: Option<[f64; 2]> = None;
    let mut draw = |plot: LinePlot, curve: Curve, y: &[f64]| {
        for &y in y {
            let [low, high] = ends.unwrap_or([y; 2]);
            ends = Some([low.min(y), high.max(y)]);
        }
        plot.curve(curve.without_markers())
    };
    for (name, rows) in curves {
        let Some(measured) = finest(rows).and_then(Row::measured) else { continue };
        let (x, y): (Vec<f64>, Vec<f64>) = measured.pressures.iter().map(|[x, y]| (*x, *y)).unzip();
        plot = draw(plot, Curve::new(name, &x, &y), &y);
    }
    if let Some(known) = known {
        let (x, y): (Vec<f64>, Vec<f64>) = known.iter().map(|[x, y]| (*x, *y)).unzip();
        plot = draw(plot, Curve::new("exact", &x, &y).colour(Colour::BLACK).dashed(), &y);
    }
    let [low, high] = ends?;
    // Pressures that are uniform have an axis of their own.
    let is_uniform = high - low < 1e-3 * high.abs();
    Some(if is_uniform { plot.y_range(0.0, 1.5 * high.abs().max(f64::MIN_POSITIVE)) } else { plot })
}
