//! The numbers: a summary as Markdown, and a CSV file with each figure.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use forms_fem::output::picture::Curve;
use forms_fem::output::write_whole;

use crate::Outcome;
use crate::study::{Relative, Series, Study, ZoneErrors, envelope};

/// The slope of log y over log x by least squares.
pub fn order(x: &[f64], y: &[f64]) -> Option<f64> {
    Curve::new("", x, y).order(x.len())
}

/// ω: the slope of an upper envelope of a length over many meshes; none where the length is zero on most of them.
pub fn omega(zones: &[ZoneErrors], length: impl Fn(&ZoneErrors) -> f64) -> Option<f64> {
    let positive = zones.iter().filter(|zone| length(zone) > 0.0).count();
    let (h, lengths): (Vec<f64>, Vec<f64>) = envelope(zones, length).into_iter().unzip();
    (2 * positive > zones.len()).then(|| order(&h, &lengths)).flatten()
}

/// A column's name, and the length it shows.
pub type LengthColumn = (&'static str, fn(&ZoneErrors) -> f64);

/// A column's name, and the error it shows.
type ErrorColumn = (&'static str, fn(Relative) -> f64);

/// The three lengths of the contact zone, with their names.
pub const LENGTHS: [LengthColumn; 3] = [
    ("|Γ^h_C,a ∩ Γ_C,i|", |zone| zone.gained),
    ("|Γ_C,a ∩ Γ^h_C,i|", |zone| zone.lost),
    ("sum", |zone| zone.gained + zone.lost),
];

/// The tables: errors by mesh with their fitted orders, and the contact zone.
pub fn summary(study: &Study) -> String {
    let mut text = format!("## θ = {}, reference n_r = {}\n\n", signed(study.theta), study.reference);
    let quantities = study.quantities();
    let names: Vec<&str> = quantities.iter().map(|(name, _)| name.as_str()).collect();
    let _ = writeln!(text, "| n_r | h (cm) | {} |", names.join(" | "));
    let _ = writeln!(text, "|{}", " --: |".repeat(2 + names.len()));
    for (k, row) in study.whole.errors.iter().enumerate() {
        let cells: Vec<String> =
            quantities.iter().map(|(_, errors)| format!("{:.3e}", errors[k].h1)).collect();
        let _ = writeln!(text, "| {} | {:.4} | {} |", row.radial, row.h, cells.join(" | "));
    }
    let kinds: [ErrorColumn; 3] = [
        ("order", |error| error.h1),
        ("order, semi-norm", |error| error.seminorm),
        ("order, squared ratio as printed", Relative::printed),
    ];
    for (name, value) in kinds {
        let orders = quantities.iter().map(|(_, errors)| {
            let values: Vec<f64> = errors.iter().map(|error| value(*error)).collect();
            order(&study.widths(), &values).map_or("-".to_owned(), |order| format!("{order:.2}"))
        });
        let _ = writeln!(text, "| {name} | | {} |", orders.collect::<Vec<_>>().join(" | "));
    }
    let _ = writeln!(text, "\nContact zone of the reference: {:.4} cm.", study.reference_zone.length());
    text.push_str(&zone_lines(&study.whole));
    if let Some(split) = &study.split {
        text.push_str("\nWith contact facets split at the zeros of β_h:\n\n");
        text.push_str(&beside(&study.whole, split));
        text.push('\n');
        text.push_str(&zone_lines(split));
    }
    text
}

/// The lengths of the contact zone.
fn zone_lines(series: &Series) -> String {
    let mut text = String::new();
    for (name, length) in LENGTHS {
        let zero = series.zones.iter().filter(|zone| length(zone) == 0.0).count();
        let largest = series.zones.iter().map(length).fold(0.0, f64::max);
        let slope = omega(&series.zones, length)
            .map_or("no slope can be fitted".to_owned(), |omega| format!("slope of its envelope {omega:.2}"));
        let count = series.zones.len();
        let _ =
            writeln!(text, "- {name}: zero on {zero} of {count} meshes, at most {largest:.2e} cm, {slope}");
    }
    text
}

/// Whole and split facets side by side, mesh by mesh.
fn beside(whole: &Series, split: &Series) -> String {
    let mut text =
        "| n_r | Newton steps | u_h (14) | p_h (22) | p̃_h (21) | contact zone off by (cm) |\n".to_owned();
    text.push_str("| --: | --: | --: | --: | --: | --: |\n");
    for (a, b) in whole.errors.iter().zip(&split.errors) {
        let zone = |series: &Series| {
            let mut zones = series.zones.iter().filter(|zone| zone.radial == a.radial);
            zones.next().map_or((0, 0.0), |zone| (zone.steps, zone.gained + zone.lost))
        };
        let ((steps, off), (split_steps, split_off)) = (zone(whole), zone(split));
        let pair = |a: Relative, b: Relative| format!("{:.4e} → {:.4e}", a.h1, b.h1);
        let _ = writeln!(
            text,
            "| {} | {steps} → {split_steps} | {} | {} | {} | {off:.3e} → {split_off:.3e} |",
            a.radial,
            pair(a.direct, b.direct),
            pair(a.consistent, b.consistent),
            pair(a.discrete, b.discrete)
        );
    }
    text
}

/// Writes a CSV file for each figure and returns their paths.
pub fn write_all(study: &Study, directory: &Path) -> Outcome<Vec<PathBuf>> {
    let quantities = study.quantities();
    let named =
        |kept: &dyn Fn(&str) -> bool| quantities.iter().filter(|(name, _)| kept(name)).collect::<Vec<_>>();
    let mut files = vec![
        ("figure_3_left", errors(study, &named(&|name| name == "u_h (14)" || name == "p_h (22)"))),
        ("figure_3_right", zones(&study.whole)),
        ("figure_4_right", errors(study, &named(&|name| name == "p_h (22)" || name.contains("(41)")))),
        ("figure_5", errors(study, &named(&|name| !name.contains("(41)")))),
    ];
    files.push(("figure_4_left", error_map(study)?));
    if let Some(split) = &study.split {
        files.push(("split_facets", zones(split)));
    }
    let mut paths = Vec::new();
    for (name, text) in files {
        let path = directory.join(file_name(name, study.theta, "csv"));
        write_whole(&path, |file| file.write_all(text.as_bytes()))?;
        paths.push(path);
    }
    Ok(paths)
}

/// A number with a minus sign instead of a hyphen.
pub fn signed(number: f64) -> String {
    number.to_string().replace('-', "−")
}

/// The name of a figure's file.
pub fn file_name(figure: &str, theta: f64, ending: &str) -> String {
    format!("{figure}_theta_{theta}.{ending}")
}

/// Errors by mesh, one line each: full norm, semi-norm and the squared ratio of each quantity.
fn errors(study: &Study, quantities: &[&(String, Vec<Relative>)]) -> String {
    let mut text = "n_r,h [cm]".to_owned();
    for (name, _) in quantities {
        let _ = write!(text, ",\"{name}: H1\",\"{name}: H1 semi-norm\",\"{name}: H1 squared, as printed\"");
    }
    text.push('\n');
    for (k, row) in study.whole.errors.iter().enumerate() {
        let _ = write!(text, "{},{}", row.radial, row.h);
        for (_, errors) in quantities {
            let error = errors[k];
            let _ = write!(text, ",{:e},{:e},{:e}", error.h1, error.seminorm, error.printed());
        }
        text.push('\n');
    }
    text
}

/// |p_h − p_ref| at the nodes of the finest of the meshes.
fn error_map(study: &Study) -> Outcome<String> {
    let finest = study.finest()?;
    let mut text = "x [cm],y [cm],|p_h - p_ref| [N cm^2/MPa]\n".to_owned();
    for (node, position) in finest.adjoint.space().positions().iter().enumerate() {
        let here = finest.adjoint.at_node(node);
        let difference = study.adjoint_difference(finest, position, here);
        let _ = writeln!(text, "{},{},{difference:e}", position[0], position[1]);
    }
    Ok(text)
}

/// Lengths and Newton steps by mesh.
fn zones(series: &Series) -> String {
    let names: Vec<String> = LENGTHS.iter().map(|(name, _)| format!("\"{name} [cm]\"")).collect();
    let mut text = format!("n_r,h [cm],{},Newton steps\n", names.join(","));
    for zone in &series.zones {
        let lengths: Vec<String> = LENGTHS.iter().map(|(_, length)| format!("{:e}", length(zone))).collect();
        let _ = writeln!(text, "{},{},{},{}", zone.radial, zone.h, lengths.join(","), zone.steps);
    }
    text
}
