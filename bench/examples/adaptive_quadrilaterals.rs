//! Contact on quadrilaterals with hanging nodes: Newton's method on the few unknowns that change, and on all of them.
//!
//! `cargo run --release -p forms-bench --example adaptive_quadrilaterals [-- CELLS [LEVELS]]`
//!
//! A block is pressed onto a rigid parabola, with Nitsche's method. The mesh is refined around the contact, level by level. Both solvers give the same
//! displacements, and the time is that of a whole solve, with the factorisation of the tangents.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::mesh::OctreeMesh;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// Nitsche contact with θ = 0 of a linear elastic body, E = 1 and ν = 0.3.
#[forms(dimension = 2)]
mod contact {
    /// The gap below the body.
    pub struct Data {
        pub distance: Given<Scalar>,
    }
    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_C.
    #[facets]
    pub struct Bottom;

    fn stress(u: Vector) -> Tensor {
        eps(u) / 1.3 + 0.3 / (1.3 * 0.4) * div(u) * I
    }
    /// The direct problem.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            - integral(Bottom, pos_part(-dot(stress(u) * n, n) - 10 / h * (u[1] + distance)) * v[1])
    }
}

/// A block on [−1, 1] × [0, 1], with smaller cells where it touches.
fn mesh(cells: usize, levels: usize) -> Result<Mesh<2>, Box<dyn Error>> {
    let coarse = rectangle([-1.0, 0.0], [1.0, 1.0], [2 * cells, cells], CellShape::Quadrilateral, 1)?;
    let mut mesh = OctreeMesh::new(coarse)?;
    for level in 0..levels {
        let (wide, high) = (0.4 / f64::from(1_u32 << level), 0.4 / f64::from(1_u32 << level));
        let is_near = |cell: &u32| {
            let corners =
                mesh.mesh().cell(*cell as usize).iter().map(|node| mesh.mesh().nodes()[*node as usize]);
            let least = corners.fold([f64::MAX; 2], |[a, b], x| [a.min(x[0].abs()), b.min(x[1])]);
            least[0] < wide && least[1] < high
        };
        let near: Vec<u32> = (0..mesh.mesh().cell_count() as u32).filter(is_near).collect();
        mesh = mesh.refined(&near)?.0;
    }
    Ok(mesh.mesh().clone())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number =
        |place: usize, otherwise: usize| arguments.get(place).map_or(Ok(otherwise), |word| word.parse());
    let mesh = mesh(number(0, 32)?, number(1, 3)?)?;
    let space = Space::vector(&mesh, 2)?;
    let mut held = Constraints::new(&space);
    held.join_hanging_nodes()?;
    held.fix("top", |_| [0.0, -0.05])?;
    let form = contact::Model::new(contact::data().distance(|x: &[f64; 2]| x[0] * x[0])).direct();
    out.line(format!(
        "{} cells, {} hanging facets, {} unknowns, one thread",
        mesh.cell_count(),
        mesh.hanging_facets()?.len(),
        space.unknowns()
    ));
    out.line("| solver | Newton steps | unknowns of a step | seconds |");
    out.line("| --- | --: | --: | --: |");
    let mut found: Vec<Field<2>> = vec![];
    for name in ["on few unknowns", "on all unknowns"] {
        let (mut few, mut all) = (CondensedSolver::default(), TangentSolver::default());
        let is_few = name == "on few unknowns";
        let solver: &mut dyn LinearSolver = if is_few { &mut few } else { &mut all };
        let start = Instant::now();
        let mut problem =
            Problem::new(&form, &space).threads(Threads::ONE).constrained(&held).solver(&mut *solver);
        let solved = problem.solve()?;
        drop(problem);
        let seconds = start.elapsed().as_secs_f64();
        let steps = solved.iterations();
        found.push(solved.into_field());
        let unknowns =
            solver.report().and_then(|report| report.condensed_unknowns).unwrap_or(space.unknowns());
        out.line(format!("| {name} | {steps} | {unknowns} | {seconds:.3} |"));
    }
    let largest = found[0].values().iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let apart =
        found[0].values().iter().zip(found[1].values()).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    out.line(format!("displacements differ by {:.0e} of the largest", apart / largest));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
