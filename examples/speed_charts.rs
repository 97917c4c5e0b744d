//! The bar charts of docs/speed.md from its measurements, docs/speed_kernels.csv and docs/speed_assembly.csv.
//!
//! `cargo run --release --bin speed_charts` writes `out/speed_kernels.png` and `out/speed_assembly.png`.
//! `cargo run --release --bin compare_with_peers` measures.

use std::error::Error;
use std::process::ExitCode;

use forms_fem::output::picture::{BarChart, Picture};
use forms_fem::output::{StandardOutput, program};

const KERNELS: &str = include_str!("../docs/speed_kernels.csv");
const ASSEMBLY: &str = include_str!("../docs/speed_assembly.csv");
/// The name of this library in the table of assembly.
const THIS_LIBRARY: &str = "this library";

/// The rows of a table below its head. Only the first cell may be in quotes, with commas inside.
fn rows(table: &str) -> Vec<Vec<&str>> {
    table.lines().skip(1).map(row).collect()
}

fn row(line: &str) -> Vec<&str> {
    match line.strip_prefix('"').and_then(|rest| rest.split_once("\",")) {
        Some((first, rest)) => std::iter::once(first).chain(rest.split(',')).collect(),
        None => line.split(',').collect(),
    }
}

/// Ratios of the times of element kernels, with AVX-512, and their geometric mean.
fn kernels() -> Result<BarChart, Box<dyn Error>> {
    let mut ratios = Vec::new();
    for row in rows(KERNELS) {
        let [form, here, ffcx, ..] = row[..] else { return Err("a row of kernels is too short".into()) };
        ratios.push((form, ffcx.parse::<f64>()? / here.parse::<f64>()?));
    }
    let mean = (ratios.iter().map(|(_, ratio)| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
    let chart = BarChart::new("times as fast as FFCx's fastest variant, AVX-512")
        .title("Element kernels")
        .line(mean, &format!("mean {mean:.2}"));
    Ok(ratios.iter().fold(chart, |chart, (form, ratio)| chart.bar(form, *ratio)))
}

/// Ratios of the times of an assembly with a known pattern, on one thread.
fn assembly() -> Result<BarChart, Box<dyn Error>> {
    let mut chart =
        BarChart::new("times as fast, one thread, pattern known").title("Assembly of elasticity, degree 2");
    let mut here = f64::NAN;
    for row in rows(ASSEMBLY) {
        let [mesh, name, seconds, ..] = row[..] else { return Err("a row of assembly is too short".into()) };
        let seconds: f64 = seconds.parse()?;
        if name == THIS_LIBRARY {
            here = seconds;
        } else {
            chart = chart.bar(&format!("{mesh}: {name}"), seconds / here);
        }
    }
    Ok(chart)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all("out")?;
    for (chart, path) in [(kernels()?, "out/speed_kernels.png"), (assembly()?, "out/speed_assembly.png")] {
        chart.write_png(path)?;
        out.line(path);
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
