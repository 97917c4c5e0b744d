//! P2 elasticity on a cube of n³ × 6 tetrahedra, clamped on one face: our multigrid beside PETSc's CG with GAMG on the
//! same matrix.
//!
//! `cargo run --release -p forms-bench --example elasticity_in_space -- [DIVISIONS] [--alone]` (default 32: 811,200
//! unknowns). PETSc is run by `peers/solve_petsc.py` with the system's Python, in one process and in two; `--alone`
//! leaves it out. Debian: python3-petsc4py, openmpi-bin.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

use forms_fem::linear_algebra::{CsrMatrix, MultigridOptions};
use forms_fem::output::{StandardOutput, program, tell};
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, NonlinearProblem};

/// Isotropic elasticity under a body force.
#[forms(dimension = 3)]
mod elastic {
    /// Moduli and load.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
        /// Body force.
        pub f: Given<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * div(w) * I
    }

    /// ∫ σ(u):ε(v) − f·v.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(f, v))
    }
}

/// Relative residual that every program is to reach.
const TOLERANCE: f64 = 1e-8;

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let alone = arguments.iter().any(|argument| argument == "--alone");
    let divisions = arguments.iter().find(|argument| !argument.starts_with('-'));
    let n: usize = divisions.map_or(Ok(32), |n| n.parse())?;

    let start = Instant::now();
    let mesh = Arc::new(cuboid([0.0; 3], [1.0; 3], [n; 3], CellShape::Tetrahedron, 1)?);
    let space = Space::vector(&mesh, 2)?;
    let f = Given::function(|x: &[f64; 3]| [0.3 * x[1], 0.1, -1.0]);
    let form = elastic::balance(&elastic::Data { lambda: 1.2, mu: 0.8, f }, &elastic::Omega::on("all"));
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_: &[f64; 3]| [0.0; 3])?;
    let assembler = Assembler::new(&mesh);
    let mut problem = Problem::new(&form, &space).assembler(&assembler);
    let mut elimination = Elimination::new(space.unknowns(), constraints.prescribed())?;
    let zero = vec![0.0; space.unknowns()];
    let load: Vec<f64> = elimination.reduce(&problem.residual(&zero)?)?.iter().map(|value| -value).collect();
    let matrix = elimination.reduce_matrix(&problem.tangent(&zero)?.matrix)?;
    drop(problem);
    out.line(format!(
        "{n}³ × 6 tetrahedra, P2: {} unknowns, {} entries; mesh, space and matrix in {:.1} s\n",
        matrix.rows(),
        matrix.values().len(),
        start.elapsed().as_secs_f64()
    ));
    out.line("program | set-up s | solution s | together s | iterations | relative residual | peak memory");
    out.line("--- | --- | --- | --- | --- | --- | ---");
    for threads in [1, 2] {
        let threads = Threads::new(threads);
        let options = MultigridSolverOptions {
            tolerance: TOLERANCE,
            multigrid: MultigridOptions { threads, ..MultigridOptions::default() },
            threads,
            ..MultigridSolverOptions::default()
        };
        let start = Instant::now();
        let mut solver = MultigridSolver::new(&constraints, options)?;
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
    if !alone {
        let path = std::env::temp_dir().join(format!("elasticity_{n}_{}.bin", std::process::id()));
        let free = elimination.free().iter().step_by(3).map(|unknown| space.positions()[unknown / 3]);
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

/// Largest memory of this process so far, where the system says it.
fn peak_memory() -> String {
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

fn main() -> ExitCode {
    program(run)
}
