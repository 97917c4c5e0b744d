//! The paper's cylinder, the direct problem (14), compared with GetFEM with MUMPS: one run, the same mesh, elements and
//! quadrature; time, Newton steps and the criterion J of both.
//!
//! `cargo run --release -p forms-bench --example beside_getfem [-- RADIAL [THETA]]` (default 64: 528,384 unknowns,
//! and −1). GetFEM is run by `bench/peers/cylinder_getfem.py` with the system's Python. Debian: python3-getfem.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use forms_contact::forms;
use forms_contact::hollow_cylinder::{Settings, hollow_cylinder};
use forms_fem::output::{StandardOutput, program, tell};
use forms_fem::prelude::*;

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let radial = arguments.next().map_or(Ok(64), |text| text.parse())?;
    let theta = arguments.next().map_or(Ok(-1.0), |text| text.parse())?;

    let start = Instant::now();
    let problem = hollow_cylinder(&Settings { radial, theta, threads: Threads::ONE, ..Settings::default() })?;
    let set_up = start.elapsed().as_secs_f64();
    let options = TangentSolverOptions { threads: Threads::ONE, ..TangentSolverOptions::default() };
    let mut solver = CondensedSolver::new(options);
    let cpu_before = cpu_seconds();
    let direct = problem
        .direct()?
        .solver(&mut solver)
        .each_step(|step| {
            tell(format!("Newton {}: relative residual {:.2e}", step.iteration, step.relative_residual));
        })
        .solve()?;
    let cpu = cpu_seconds().zip(cpu_before).map_or(f64::NAN, |(after, before)| after - before);
    let report = solver.report();
    let u = direct.field();
    let criterion =
        forms::criterion(&problem.law.data, &problem.law.regions.omega, &problem.law.regions.boundary, u);
    let j = problem.assembler.functional(&criterion)?;
    let steps = direct.history.len() - 1;

    out.line(format!("n_r = {radial}, θ = {theta}, {} unknowns, one thread\n", problem.space.unknowns()));
    out.line("| program | mesh, space, pattern (s) | direct problem (s) | the same, CPU (s) | Newton steps | relative residual | J |");
    out.line("| --- | --: | --: | --: | --: | --: | --: |");
    let residual = direct.history[steps].relative_residual;
    out.line(format!(
        "| forms-contact | {set_up:.2} | {:.2} | {cpu:.2} | {steps} | {residual:.1e} | {j:.12} |",
        direct.seconds
    ));
    let way = report.path.map_or_else(String::new, |path| path.to_string());
    let condensed = report.condensed_unknowns.map_or_else(String::new, |count| format!(", {count} of them"));
    let parts = format!(
        "assembly {:.2} s, ordering and analysis {:.2} s, {} factorisation(s) {:.2} s, solves {:.2} s; {way}{condensed}",
        direct.assembly_seconds,
        report.analysis_seconds,
        report.factorisations,
        report.factorisation_seconds,
        report.solve_seconds
    );
    match run_getfem(radial, theta) {
        Ok(theirs) => {
            let (seconds, their_j) = (number(&theirs, "seconds")?, number(&theirs, "J")?);
            let their_cpu = number(&theirs, "cpu_seconds")?;
            out.line(format!(
                "| GetFEM {} with MUMPS | not counted | {seconds:.2} | {their_cpu:.2} | {} | {:.1e} | {their_j:.12} |",
                text(&theirs, "version")?,
                number(&theirs, "steps")?,
                number(&theirs, "relative_residual")?
            ));
            out.line(format!("\nOurs: {parts}."));
            out.line(format!(
                "GetFEM takes {:.1} times as long ({:.1} times in CPU time, {:.1} times with our mesh, space and pattern); \
                 J differs by {:.1e}, relatively.",
                seconds / direct.seconds,
                their_cpu / cpu,
                seconds / (direct.seconds + set_up),
                ((j - their_j) / their_j).abs()
            ));
        }
        Err(why) => out.line(format!("\nOurs: {parts}.\nGetFEM did not run: {why}")),
    }
    Ok(())
}

/// The line of JSON that GetFEM's script prints.
fn run_getfem(radial: usize, theta: f64) -> Result<String, Box<dyn Error>> {
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers/cylinder_getfem.py");
    let python = if Path::new("/usr/bin/python3").exists() { "/usr/bin/python3" } else { "python3" };
    let mut command = Command::new(python);
    command.arg(script).arg(radial.to_string()).arg(theta.to_string());
    // Its progress is shown; one thread, as ours.
    let output = command.env("OMP_NUM_THREADS", "1").env("OPENBLAS_NUM_THREADS", "1");
    let output = output.stderr(Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err("it failed, with the message above".into());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Seconds of all cores that this process has had, where the system says it.
fn cpu_seconds() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in brackets: the 12th and 13th field, in hundredths of a second.
    let fields: Vec<&str> = status.rsplit(')').next()?.split_whitespace().collect();
    let ticks = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

/// A value of flat JSON, as it is written.
fn text<'a>(json: &'a str, name: &str) -> Result<&'a str, Box<dyn Error>> {
    let (_, rest) = json.split_once(&format!("\"{name}\": ")).ok_or(format!("no {name} in {json}"))?;
    Ok(rest.split([',', '}']).next().unwrap_or(rest).trim_matches('"'))
}

fn number(json: &str, name: &str) -> Result<f64, Box<dyn Error>> {
    Ok(text(json, name)?.parse()?)
}

fn main() -> ExitCode {
    program(run)
}
