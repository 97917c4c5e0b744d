//! An incompressible body with P2/P1 elements: the Cholesky factor with signs and LU, their times and memory.
//!
//! `cargo run --release -p forms-bench --example saddle_points -- SOLVER [CELLS] [DIMENSION]` solves with the solver `signs` or `lu`, by
//! default on 105 × 105 × 2 triangles (100,278 unknowns). A process measures one solver, for its memory.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_bench::beside_petsc::peak_memory;
use forms_fem::linear_algebra::Transpose;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::Elimination;

/// Solves with each factor.
const REPETITIONS: usize = 3;

/// An incompressible elastic body.
#[forms]
mod incompressible {
    /// Ω.
    #[cells]
    pub struct Omega;

    /// ∫ 2 ε(u):ε(v) − p div v − q div u − v₀.
    pub fn body(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - v[0])
    }
}

fn main() -> ExitCode {
    program(run)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let by_lu = arguments.first().is_some_and(|solver| solver == "lu");
    let cells: usize = arguments.get(1).map_or(Ok(105), |cells| cells.parse())?;
    if arguments.get(2).is_some_and(|dimension| dimension == "3") {
        measure(out, cuboid([0.0; 3], [1.0; 3], [cells; 3], CellShape::Tetrahedron, 1)?, by_lu)
    } else {
        measure(out, rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Triangle, 1)?, by_lu)
    }
}

fn measure<const D: usize>(out: &mut StandardOutput, mesh: Mesh<D>, by_lu: bool) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let (bodies, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
    let mut held = Constraints::new(&bodies);
    held.fix("left", |_| [0.0; D])?;
    let form = incompressible::body(&incompressible::Omega::on("all"));
    let assembler = Assembler::new(&mesh);
    let spaces = [&bodies, &pressures];
    let zero = spaces.map(Field::zero);
    let matrix = assembler.tangent(&form, &zero.each_ref(), &spaces)?;
    let constraints = [&held, &Constraints::new(&pressures)];
    let matrix = Elimination::of(&constraints)?.reduce_matrix(&matrix.into())?;
    let exact: Vec<f64> = (0..matrix.rows()).map(|k| (0.37 * k as f64).sin()).collect();
    let b = matrix.multiply(&exact)?;
    out.line("solver | unknowns | factor s, least | solve s, least | relative error | peak memory");
    let mut least = [f64::INFINITY; 2];
    let mut error = 0.0_f64;
    for _ in 0..REPETITIONS {
        let mut solver: Box<dyn LinearSolver> = match by_lu {
            true => Box::new(LuSolver::default()),
            false => Box::new(TangentSolver::default()),
        };
        let start = Instant::now();
        solver.set_matrix(matrix.clone())?;
        least[0] = least[0].min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let found = solver.solve_with(&b, 0.0, Transpose::No)?.solution;
        least[1] = least[1].min(start.elapsed().as_secs_f64());
        error = found.iter().zip(&exact).fold(error, |most, (a, b)| most.max((a - b).abs()));
    }
    let name = if by_lu { "LU" } else { "Cholesky with signs" };
    let [factor, solve] = least;
    let size = matrix.rows();
    out.line(format!("{name} | {size} | {factor:.2} | {solve:.3} | {error:.1e} | {}", peak_memory()));
    Ok(())
}
