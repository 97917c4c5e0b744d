//! P2 elasticity on a cube of n³ × 6 tetrahedra, clamped on one face: our multigrid and PETSc's CG with GAMG on the
//! same matrix.
//!
//! `cargo run --release -p forms-bench --example elasticity_in_space -- [DIVISIONS] [--alone]` (default 32: 811,200
//! unknowns). PETSc is run by `peers/solve_petsc.py` with the system's Python, in one process and in two; `--alone`
//! leaves it out. Debian: python3-petsc4py, openmpi-bin.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_bench::beside_petsc::{Beside, HEADER, compare};
use forms_fem::output::{StandardOutput, program};
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

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let alone = arguments.iter().any(|argument| argument == "--alone");
    let beside = if alone { Beside::Nobody } else { Beside::Petsc };
    let divisions = arguments.iter().find(|argument| !argument.starts_with('-'));
    let n: usize = divisions.map_or(Ok(32), |n| n.parse())?;

    let start = Instant::now();
    let mesh = cuboid([0.0; 3], [1.0; 3], [n; 3], CellShape::Tetrahedron, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let f = Given::function(|x: &[f64; 3]| [0.3 * x[1], 0.1, -1.0]);
    let form = elastic::balance(&elastic::data().lambda(1.2).mu(0.8).f(f), &elastic::Omega::on("all"));
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_: &[f64; 3]| [0.0; 3])?;
    let mut problem = Problem::new(&form, &space);
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
    HEADER.iter().for_each(|line| out.line(line));
    let free = elimination.free().iter().step_by(3).map(|unknown| space.positions()[unknown / 3]);
    compare(out, &constraints, (matrix, load), free, beside)?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
