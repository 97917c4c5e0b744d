//! A system in space by our multigrid and by PETSc's CG with GAMG, the same matrix in one run; a line of a table for each.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use forms_fem::linear_algebra::{CsrMatrix, MultigridOptions};
use forms_fem::output::{StandardOutput, tell};
use forms_fem::prelude::*;

/// Relative residual that every program is to reach.
pub const TOLERANCE: f64 = 1e-8;

/// The head of the table.
pub const HEADER: [&str; 2] = [
    "program | set-up s | solution s | together s | iterations | relative residual | peak memory",
    "--- | --- | --- | --- | --- | --- | ---",
];

/// Who else solves the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    /// PETSc, by `peers/solve_petsc.py`, in one process and in two.
    Petsc,
    /// Nobody.
    Nobody,
}

/// Our solver's options on some threads.
pub fn options(threads: Threads) -> MultigridSolverOptions {
    MultigridSolverOptions {
        tolerance: TOLERANCE,
        multigrid: MultigridOptions { threads, ..MultigridOptions::default() },
        threads,
        ..MultigridSolverOptions::default()
    }
}

/// Solves a symmetric system over free nodes of three components, at these positions: by us on one thread and on two, and by the
/// other program, with the system's Python.
///
/// # Errors
/// Errors of our solver, or of writing the system for PETSc. PETSc's errors are in its line.
pub fn compare(
    out: &mut StandardOutput,
    constraints: &Constraints<3>,
    (matrix, load): (CsrMatrix, Vec<f64>),
    free: impl Iterator<Item = [f64; 3]>,
    beside: Beside,
) -> Result<(), Box<dyn Error>> {
    for threads in [1, 2].map(Threads::new) {
        let start = Instant::now();
        let mut solver = MultigridSolver::new(constraints, options(threads))?;
        solver.set_matrix(matrix.clone())?;
        let set_up = start.elapsed().as_secs_f64();
        let found = solver.solve(&load, 0.0)?;
        let seconds = start.elapsed().as_secs_f64();
        out.line(format!(
            "forms-fem, {} thread{} | {set_up:.2} | {:.2} | {seconds:.2} | {} | {:.1e} | {}",
            threads.count(),
            if threads.count() == 1 { "" } else { "s" },
            seconds - set_up,
            found.iterations,
            residual(&matrix, &found.solution, &load)?,
            peak_memory()
        ));
        if threads == Threads::new(2) {
            for level in &solver.report().levels {
                tell(format!("  level of {} unknowns, {} entries", level.unknowns, level.entries));
            }
        }
    }
    if beside == Beside::Petsc {
        let path = std::env::temp_dir().join(format!("system_{}.bin", std::process::id()));
        write_system(&path, &matrix, &load, free)?;
        drop(matrix);
        for processes in [1, 2] {
            match run_petsc(&path, processes) {
                Ok(line) => out.line(&line),
                Err(error) => out.line(format!("PETSc in {processes} processes: {error}")),
            }
        }
        std::fs::remove_file(&path)?;
    }
    Ok(())
}

/// ‖b − A x‖ / ‖b‖, computed here and not by the solver.
fn residual(matrix: &CsrMatrix, x: &[f64], b: &[f64]) -> Result<f64, Box<dyn Error>> {
    let product = matrix.multiply(x)?;
    let square: f64 = b.iter().zip(&product).map(|(b, product)| (b - product).powi(2)).sum();
    Ok((square / b.iter().map(|b| b * b).sum::<f64>()).sqrt())
}

/// Peak memory of this process so far, if the system reports it.
pub fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kibibytes.map_or("unknown".to_owned(), |kibibytes| format!("{:.2} GiB", kibibytes / f64::from(1 << 20)))
}

/// Writes what `peers/solve_petsc.py` reads, little-endian: nodes and blocks (u64), where each row's blocks start (u64),
/// their columns (u32), their values (f64, 3 × 3, row-major), the right-hand side and the nodes' positions (f64).
fn write_system(
    path: &Path,
    matrix: &CsrMatrix,
    load: &[f64],
    positions: impl Iterator<Item = [f64; 3]>,
) -> Result<(), Box<dyn Error>> {
    let mut file = BufWriter::with_capacity(1 << 20, File::create(path)?);
    let nodes = matrix.rows() / 3;
    let mut integers = vec![nodes as u64, matrix.values().len() as u64 / 9];
    integers.extend(matrix.row_pointers().iter().step_by(3).map(|start| *start as u64 / 9));
    for value in integers {
        file.write_all(&value.to_le_bytes())?;
    }
    for node in 0..nodes {
        for column in matrix.row(3 * node).0.iter().step_by(3) {
            file.write_all(&(column / 3).to_le_bytes())?;
        }
    }
    for node in 0..nodes {
        let rows: [&[f64]; 3] = std::array::from_fn(|k| matrix.row(3 * node + k).1);
        for place in (0..rows[0].len()).step_by(3) {
            for value in rows.iter().flat_map(|row| &row[place..place + 3]) {
                file.write_all(&value.to_le_bytes())?;
            }
        }
    }
    for value in load.iter().copied().chain(positions.flatten()) {
        file.write_all(&value.to_le_bytes())?;
    }
    Ok(file.flush()?)
}

/// Runs PETSc on a written system; gives its line of the table.
fn run_petsc(path: &Path, processes: usize) -> Result<String, Box<dyn Error>> {
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers/solve_petsc.py");
    let python = if Path::new("/usr/bin/python3").exists() { "/usr/bin/python3" } else { "python3" };
    let mut command = if processes == 1 {
        Command::new(python)
    } else {
        let mut command = Command::new("mpirun");
        command.args(["--allow-run-as-root", "-n", &processes.to_string(), python]);
        command
    };
    command.arg(script).arg(path).arg(TOLERANCE.to_string()).env("OMP_NUM_THREADS", "1");
    let output = command.output()?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(said.lines().last().unwrap_or("it failed").to_owned().into());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
