//! Time and memory of the paper's cylinder over finer and finer meshes: the direct problem (14) and both adjoint states,
//! (22) and (21). Each mesh has a process of its own, so that the largest memory is its own.
//!
//! `cargo run --release -p forms-bench --example scaling [-- N_R ...]` (default 16 32 64 128 160; the last has 3.3
//! million unknowns and needs about 8 GiB) prints a table and writes `out/scaling.csv` and `out/scaling.png`.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use forms_contact::Adjoint;
use forms_contact::hollow_cylinder::{Settings, hollow_cylinder};
use forms_fem::linear_algebra::SharedWork;
use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
use forms_fem::output::{StandardOutput, program, tell, write_whole};
use forms_fem::prelude::*;

/// The first argument of a process that computes one mesh.
const ONE: &str = "--one";

/// The measurements, in the order of the columns.
const COLUMNS: [&str; 12] = [
    "n_r",
    "unknowns",
    "mesh, space, pattern (s)",
    "direct problem (s)",
    "of it analysis (s)",
    "factorisation (s)",
    "adjoint (22) (s)",
    "adjoint (21) (s)",
    "in all (s)",
    "in all, CPU (s)",
    "Newton steps",
    "peak memory (GiB)",
];
const UNKNOWNS: usize = 1;
const IN_ALL: usize = 8;
const CPU: usize = 9;
const MEMORY: usize = 11;

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, radial] = &arguments[..]
        && first == ONE
    {
        return one(radial.parse()?, out);
    }
    let meshes: Vec<usize> = match arguments.is_empty() {
        true => vec![16, 32, 64, 128, 160],
        false => arguments.iter().map(|text| text.parse()).collect::<Result<_, _>>()?,
    };
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for radial in &meshes {
        tell(format!("n_r = {radial}"));
        let mut command = Command::new(std::env::current_exe()?);
        let output = command.args([ONE, &radial.to_string()]).stderr(Stdio::inherit()).output()?;
        if !output.status.success() {
            return Err(format!("n_r = {radial} was not solved: {}", output.status).into());
        }
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        rows.push(printed.trim().split(',').map(str::parse).collect::<Result<_, _>>()?);
    }
    out.line(format!("| {} |\n|{}", COLUMNS.join(" | "), " --: |".repeat(COLUMNS.len())));
    for row in &rows {
        let cells: Vec<String> = row.iter().enumerate().map(|(k, value)| shown(k, *value)).collect();
        out.line(format!("| {} |", cells.join(" | ")));
    }
    let column = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let (unknowns, seconds, memory) = (column(UNKNOWNS), column(IN_ALL), column(MEMORY));
    if rows.len() > 1 {
        let [time, cpu, room] = [&seconds, &column(CPU), &memory].map(|values| exponent(&unknowns, values));
        out.line(format!(
            "\nTime grows like unknowns^{time:.2}, CPU time like unknowns^{cpu:.2}, memory like unknowns^{room:.2} \
             (least squares, all meshes)."
        ));
    }

    let mut csv = format!("{}\n", COLUMNS.map(|name| format!("\"{name}\"")).join(","));
    for row in &rows {
        let _ = writeln!(csv, "{}", row.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
    }
    write_whole("out/scaling.csv", |file| file.write_all(csv.as_bytes()))?;
    let count = rows.len();
    LinePlot::new()
        .title("The cylinder: direct problem and two adjoint states")
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis("time [s], memory [GiB]", Scale::Logarithmic)
        .curve(Curve::new("time in all [s]", &unknowns, &seconds).fitted_order(count))
        .curve(Curve::new("CPU time in all [s]", &unknowns, &column(CPU)).fitted_order(count))
        .curve(Curve::new("direct problem [s]", &unknowns, &column(3)).fitted_order(count))
        .curve(Curve::new("factorisation [s]", &unknowns, &column(5)).fitted_order(count))
        .curve(Curve::new("peak memory [GiB]", &unknowns, &memory).fitted_order(count))
        .grid()
        .write_png("out/scaling.png")?;
    out.line("Written: out/scaling.csv, out/scaling.png");
    Ok(())
}

/// Solves one mesh and prints its row.
fn one(radial: usize, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let problem = hollow_cylinder(&Settings { radial, ..Settings::default() })?;
    let set_up = start.elapsed().as_secs_f64();
    tell(format!("  {} unknowns; mesh, space and pattern in {set_up:.1} s", problem.space.unknowns()));
    let mut solver = CondensedSolver::default();
    let direct = problem
        .direct()?
        .solver(&mut solver)
        .each_step(|step| {
            let condensed =
                step.condensed_unknowns.map_or(String::new(), |count| format!(" by {count} unknowns"));
            let relative = step.relative_residual;
            tell(format!("  Newton {}{condensed}: relative residual {relative:.1e}", step.iteration));
        })
        .solve()?;
    let report = solver.report();
    tell(format!("  direct problem in {:.1} s; {} factorisation(s)", direct.seconds, report.factorisations));
    let orderings: Vec<_> = report.orderings.iter().map(|candidate| candidate.name).collect();
    tell(format!("  {} entries in the factor; orderings: {}", report.factor_entries, orderings.join(", ")));
    for (stage, work) in
        [("factorisation", &report.factorisation_work), ("triangular solve", &report.solve_work)]
    {
        let Some(work) = work else { continue };
        let bounds = SharedWork::THREADS
            .map(|threads| format!("{:.1} on {threads}", work.speed_up(threads).unwrap_or(f64::NAN)));
        tell(format!(
            "  {stage}: {:.3e} operations, {:.3e} on the critical path; speed-up at most {} threads",
            work.work,
            work.critical_path,
            bounds.join(", ")
        ));
    }
    let u = direct.field();
    let consistent = problem.solve_adjoint(Adjoint::Consistent, u, &mut solver)?.seconds;
    let discrete = problem.solve_adjoint(Adjoint::Discrete, u, &mut solver)?.seconds;
    let all = start.elapsed().as_secs_f64();
    tell(format!("  adjoint states in {consistent:.1} s and {discrete:.1} s, {all:.1} s in all"));
    let (unknowns, steps) = (problem.space.unknowns() as f64, (direct.history.len() - 1) as f64);
    let row = [
        radial as f64,
        unknowns,
        set_up,
        direct.seconds,
        report.analysis_seconds,
        report.factorisation_seconds,
        consistent,
        discrete,
        all,
        cpu_seconds().unwrap_or(f64::NAN),
        steps,
        peak_gibibytes().unwrap_or(f64::NAN),
    ];
    out.line(row.map(|value| value.to_string()).join(","));
    Ok(())
}

fn shown(column: usize, value: f64) -> String {
    match column {
        0 | UNKNOWNS | 10 => format!("{value}"),
        _ => format!("{value:.2}"),
    }
}

/// The slope of log y over log x by least squares.
fn exponent(x: &[f64], y: &[f64]) -> f64 {
    let logs: Vec<[f64; 2]> = x.iter().zip(y).map(|(x, y)| [x.ln(), y.ln()]).collect();
    let mean = |k: usize| logs.iter().map(|pair| pair[k]).sum::<f64>() / logs.len() as f64;
    let (mean_x, mean_y) = (mean(0), mean(1));
    let products: f64 = logs.iter().map(|[x, y]| (x - mean_x) * (y - mean_y)).sum();
    products / logs.iter().map(|[x, _]| (x - mean_x).powi(2)).sum::<f64>()
}

/// CPU seconds of this process on all cores, if the system reports them. On a machine with other work they say more
/// than the clock.
fn cpu_seconds() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in brackets: the 12th and 13th field, in hundredths of a second.
    let fields: Vec<&str> = status.rsplit(')').next()?.split_whitespace().collect();
    let ticks = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

/// Peak resident memory of this process; `None` where the system does not report it.
fn peak_gibibytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes / f64::from(1 << 20))
}

fn main() -> ExitCode {
    program(run)
}
