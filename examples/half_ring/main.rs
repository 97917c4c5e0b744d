//! Half a ring of rubber, ν = 0.4995, pressed by a rigid flat to half of its thickness: elements for nearly incompressible bodies compared, with
//! the forces, the Newton steps of each increment, and δ and ∫ (J − 1) under F = 5 N/mm.
//!
//! Radii 20 and 40 mm, y ≤ 0, the inner arc fixed, the cut faces free, W = μ/2 (J^(−2/3) tr C − 3) + K/2 (J − 1)², E = 1.4 MPa, plane
//! strain; the flat comes from below in steps of 1 mm, without friction. By symmetry the right half is computed.
//!
//! Run it with `cargo run --release --bin half_ring -- [CELLS ALONG] [MESHES] [LAST WAY]`; each mesh has twice the cells along of the one before.

mod forms;
mod ring;

use std::error::Error;
use std::process::ExitCode;

use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};

use ring::{Formulation, OUTSIDE, Run, Setting};

/// F \[N/mm\].
const FORCE: f64 = 5.0;
/// Ways whose forces are compared \[mm\].
const WAYS: [f64; 3] = [2.0, 5.0, 10.0];

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
}

fn row(run: &Run, along: usize) -> String {
    let force = |way: f64| run.steps.iter().find(|step| step.way == way).map(|step| step.force);
    let forces = WAYS.map(|way| number(force(way), 4)).join(" | ");
    let (way, growth) = (run.at_force.map(|(way, _)| way), run.at_force.map(|(_, growth)| growth));
    let name = run.formulation.name();
    format!("| {name} | {along} | {} | {forces} | {} | {} |", run.unknowns, number(way, 5), number(growth, 4))
}

fn draw(runs: &[Run], out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let mut forces =
        LinePlot::new().x_axis("way of the flat [mm]", Scale::Linear).y_axis("force [N/mm]", Scale::Linear);
    let mut newton = LinePlot::new()
        .x_axis("way of the flat [mm]", Scale::Linear)
        .y_axis("Newton steps of the increment", Scale::Linear);
    for run in runs {
        let ways: Vec<f64> = run.steps.iter().map(|step| step.way).collect();
        let [of_force, of_steps] =
            [|step: &ring::Pressed| step.force, |step: &ring::Pressed| step.iterations as f64]
                .map(|value| run.steps.iter().map(value).collect::<Vec<f64>>());
        if ways.is_empty() {
            continue;
        }
        forces = forces.curve(Curve::new(run.formulation.name(), &ways, &of_force));
        if run.formulation != Formulation::Displacement {
            newton = newton.curve(Curve::new(run.formulation.name(), &ways, &of_steps));
        }
    }
    forces.write_png("out/half_ring_forces.png")?;
    newton.write_png("out/half_ring_newton.png")?;
    let Some(run) = runs.iter().find(|run| run.formulation == Formulation::TaylorHood) else { return Ok(()) };
    if let (Some(p), Some(last)) = (&run.pressure, run.steps.last()) {
        let height = last.way - OUTSIDE;
        FieldMap::of(p, Shown::Component(0), "mean stress p [MPa]")
            .length_unit("mm")
            .without_mesh_lines()
            .levels(20)
            .deformed(&run.displacement, 1.0)
            .undeformed_outline("undeformed")
            .line(&[[0.0, height], [OUTSIDE, height]], "flat", Colour::BLACK)
            .write_png("out/half_ring.png")?;
        out.line("out/half_ring.png, out/half_ring_forces.png, out/half_ring_newton.png");
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [along, meshes, end] = [given(0, 16), given(1, 2), given(2, 10)];
    let mut finest = vec![];
    out.line("| element | cells along | unknowns | F(2) N/mm | F(5) | F(10) | δ mm at F = 5 | ∫(J − 1) mm² there |");
    out.line("| --- | --: | --: | --: | --: | --: | --: | --: |");
    for formulation in Formulation::ALL {
        let meshes = if formulation.on_one_mesh() { 1 } else { meshes };
        for level in 0..meshes {
            let setting = Setting { along: along << level, end, force: FORCE };
            let run = setting.run(formulation)?;
            out.line(row(&run, setting.along));
            if level + 1 == meshes {
                finest.push(run);
            }
        }
    }
    out.line("");
    out.line("Newton steps of each increment:");
    for run in &finest {
        let steps: Vec<String> = run.steps.iter().map(|step| step.iterations.to_string()).collect();
        let local = run.local_unknowns.as_ref().map_or_else(String::new, |counts| format!(" | {counts}"));
        out.line(format!("| {} | {} |{local}", run.formulation.name(), steps.join(" | ")));
        if let Some(why) = &run.failure {
            out.line(format!("  {why}"));
        }
    }
    draw(&finest, out)
}

fn main() -> ExitCode {
    program(run)
}
