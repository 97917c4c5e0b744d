//! A block that is pressed and drawn on a slab with friction by multipliers: hats, dual ones with the displacements, and dual ones eliminated.
//!
//! `cargo run --release -p forms-bench --example dual_multipliers -- [FINENESS]` prints the numbers of factorisations, their seconds, and those of solves, with
//! the GMRES iterations that were made before LU was taken.

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as law;
use forms_contact::laws::mortar_bodies::{data, frictional_mortar_problem};
use forms_fem::contract::PairQuadrature;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::{LinearSolver, LocalUnknowns};

fn main() -> ExitCode {
    program(run)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let fineness: usize = std::env::args().nth(1).map_or(Ok(12), |word| word.parse())?;
    let body = |from: [f64; 2], to: [f64; 2], cells: [usize; 2]| {
        rectangle(from, to, cells.map(|count| count * fineness), CellShape::Quadrilateral, 1)
    };
    let (slab, block) = (body([0.0, -1.0], [4.0, 0.0], [11, 3])?, body([0.3, 0.0], [1.3, 1.0], [4, 3])?);
    let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)])?;
    let (space, own) = (Space::vector(&mesh, 1)?, "block bottom");
    let mut held = Constraints::new(&space);
    held.fix("slab bottom", |_| [0.0; 2])?;
    held.fix("block top", |_| [0.02, -0.05])?;
    let none = Field::zero(&space);
    let data = data().lambda(115.0).mu(77.0).gamma0(1000.0).friction(0.3);
    let touch = Pairing::onto(own, "slab top").at(PairQuadrature::Pieces);
    let regions = law::Regions::default().touch(touch).own(own).gamma_n("block right");
    let model = law::Model { data: data.displacement_before(Given::field(&none)), regions };
    writeln!(
        out,
        "| multipliers | unknowns | eliminated | factorisations | their seconds | those of solves | GMRES iterations |"
    )?;
    writeln!(out, "| --- | --: | --: | --: | --: | --: | --: |")?;
    for (elements, eliminates) in
        [(Elements::Bernstein(1), false), (Elements::Dual, false), (Elements::Dual, true)]
    {
        let traces = Space::of(&mesh, elements.clone(), Scope::Facets(own.to_owned()), &[2])?;
        let pressed = (0..traces.node_count()).flat_map(|_| [10.0, 0.0]).collect();
        let pressed = Field::from_values(&traces, pressed)?;
        let mut whole = TangentSolver::default();
        let mut local = LocalUnknowns::<TangentSolver>::default();
        let solver: &mut dyn LinearSolver = if eliminates { &mut local } else { &mut whole };
        let problem = frictional_mortar_problem(&model, [&space, &traces], &held)?;
        let solved = problem.start([&none, &pressed, &Field::zero(&traces)]).solver(solver).solve()?;
        let Some(report) = &solved.report else { continue };
        writeln!(
            out,
            "| {elements} | {} | {} | {} | {:.2} | {:.2} | {} |",
            space.unknowns() + 2 * traces.unknowns(),
            report.local_unknowns.map_or(0, |counts| counts.eliminated),
            report.factorisations + report.lu_factorisations,
            report.factorisation_seconds,
            report.solve_seconds,
            report.iterations.iter().sum::<usize>(),
        )?;
    }
    Ok(())
}
