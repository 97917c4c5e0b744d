//! Time of bisection: all of a million triangles and of a million tetrahedra, some cells of the result, and back.
//!
//! `cargo run --release -p forms-bench --example bisection [-- CELLS]` prints the least time of five.

use std::error::Error;
use std::io::Write as _;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use forms_fem::mesh::{BisectedMesh, MeshError, Nesting, cuboid, rectangle};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// One cell in this number is marked where some are.
const ONE_IN: usize = 200;

fn main() -> ExitCode {
    program(run)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let cells: usize = std::env::args().nth(1).map_or(Ok(1_000_000), |count| count.parse())?;
    let side = ((cells / 2) as f64).sqrt().round().max(1.0) as usize;
    measure(out, "triangles", rectangle([0.0; 2], [1.0; 2], [side; 2], CellShape::Triangle, 1)?)?;
    let side = ((cells / 6) as f64).cbrt().round().max(1.0) as usize;
    measure(out, "tetrahedra", cuboid([0.0; 3], [1.0; 3], [side; 3], CellShape::Tetrahedron, 1)?)
}

fn measure<const D: usize>(
    out: &mut StandardOutput,
    shape: &str,
    mesh: Mesh<D>,
) -> Result<(), Box<dyn Error>> {
    let coarse = BisectedMesh::new(mesh)?;
    let all = every(&coarse, 1);
    let fine = least_of_five(out, &format!("{shape}, all bisected"), || coarse.refined(&all))?;
    let some = every(&fine, ONE_IN);
    least_of_five(out, &format!("{shape}, one in {ONE_IN} bisected"), || fine.refined(&some))?;
    let all = every(&fine, 1);
    least_of_five(out, &format!("{shape}, coarsened"), || fine.coarsened(&all))?;
    Ok(())
}

fn every<const D: usize>(mesh: &BisectedMesh<D>, step: usize) -> Vec<u32> {
    (0..mesh.mesh().cell_count() as u32).step_by(step).collect()
}

/// Least time of five runs, and the mesh.
fn least_of_five<const D: usize>(
    out: &mut StandardOutput,
    what: &str,
    divide: impl Fn() -> Result<(BisectedMesh<D>, Nesting<D>), MeshError>,
) -> Result<BisectedMesh<D>, Box<dyn Error>> {
    let mut least = Duration::MAX;
    for _ in 0..4 {
        let start = Instant::now();
        divide()?;
        least = least.min(start.elapsed());
    }
    let start = Instant::now();
    let (mesh, _) = divide()?;
    least = least.min(start.elapsed());
    writeln!(out, "{what}: {} cells in {:.2} s", mesh.mesh().cell_count(), least.as_secs_f64())?;
    Ok(mesh)
}
