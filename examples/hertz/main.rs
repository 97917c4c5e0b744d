//! Contact in space: a ball is pressed onto a rigid flat, or a block onto a rigid ball. The block's obstacle is its signed
//! distance: the gap g and the direction n_y into the obstacle follow x.
//!
//! Hertz (1882): the radius of contact a with a³ = 3PR/4E′, E′ = E/(1−ν²), the pressure p0 √(1 − r²/a²) with
//! p0 = 3P/(2πa²). The ball's mesh has curved hexahedra whose lower faces lie on it.
//!
//! Run it with `cargo run --release --bin hertz -- ball` or `-- block`.

mod bodies;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use forms_contact::forms;
use forms_contact::hertz::{CONTACT, CONTACT_CELLS, Hertz, in_space, quarter_place};
use forms_contact::threshold::threshold;
use forms_examples::command_line::program_with_options;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, tell};
use forms_fem::prelude::*;

use bodies::Contact;

/// Presses an elastic body onto a rigid obstacle and compares the pressure with Hertz's.
#[derive(Parser)]
#[command(version, name = "hertz")]
struct Options {
    /// The pair of bodies
    body: Contact,
    /// Cells in each direction; a multiple of four, since those of equal size are three quarters
    #[arg(long, default_value_t = 12)]
    divisions: usize,
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let contact = options.body;
    let body = contact.body();
    let problem = in_space(body, options.divisions)?;
    let (mesh, space) = (problem.space.mesh(), &problem.space);
    // θ = −1 is stable for every γ₀; other variants would be warned about here.
    if let Some(warning) = threshold(&problem, CONTACT_CELLS)?.warning() {
        tell(format!("warning: {warning}"));
    }
    let mut solver = CondensedSolver::default();
    let solved = problem
        .direct()?
        .solver(&mut solver)
        .each_step(|step| {
            let active = step.active_points.unwrap_or(0);
            out.line(format!(
                "Newton {}: residual {:.2e}, {active} active points",
                step.iteration, step.residual
            ));
        })
        .solve()?;
    let u = solved.into_field();
    let report = solver.report();
    if let (Some(path), Some(count)) = (report.path, report.condensed_unknowns) {
        out.line(format!("{} unknowns, {path}, {count} of them", space.unknowns()));
    }

    let (data, gamma_c, assembler) = (&problem.law.data, &problem.law.regions.gamma_c, &problem.assembler);
    let force = 4.0 * assembler.functional(&forms::contact_force(data, gamma_c, &u))?;
    let hertz = Hertz::of_point(force);
    let Hertz { reach: a, peak: p0 } = hertz;
    let error = hertz.profile_error(&problem, &u)?;
    out.line(format!(
        "force {force:.4} N, Hertz: radius of contact {a:.4} mm, pressure {p0:.3} MPa in the middle"
    ));
    out.line(format!("pressure profile: {:.2} % from Hertz in the L² norm", 100.0 * error));

    let pressure = forms::contact_pressure(data, &u);
    let picture = |part: &str| format!("out/{}{part}.png", contact.name());
    // Along the x axis, at the nodes.
    let scalars = Space::scalar(mesh, 2)?;
    let on_body = assembler.at_facet_nodes(&pressure, CONTACT, &scalars)?;
    let along = scalars
        .positions()
        .iter()
        .enumerate()
        .filter(|(_, [x, y, z])| *y == 0.0 && (z - body.surface(*x, 0.0)).abs() < 1e-9 && *x < 1.2 * a);
    let mut samples: Vec<[f64; 2]> = along.map(|(node, x)| [x[0], on_body.at_node(node)[0]]).collect();
    samples.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let [radii, values] = [0, 1].map(|k| samples.iter().map(|sample| sample[k]).collect::<Vec<_>>());
    let line: Vec<f64> = (0..=200).map(|k| 1.2 * a * f64::from(k) / 200.0).collect();
    LinePlot::new()
        .title(contact.title())
        .x_axis("distance from the axis [mm]", Scale::Linear)
        .y_axis("contact pressure [MPa]", Scale::Linear)
        .curve(Curve::new("Hertz", &line, &line.iter().map(|r| hertz.pressure(*r)).collect::<Vec<_>>()))
        .curve(Curve::new("computed, at nodes", &radii, &values).dashed())
        .write_png(picture(""))?;

    // Seen from below: the pressure on the deformed surface's plan.
    let flat = |[s, t]: [f64; 2]| [quarter_place(s), quarter_place(t)];
    let plan = forms_fem::mesh::structured([options.divisions; 2], CellShape::Quadrilateral, 2, flat)?;
    let plan_space = Space::scalar(&plan, 2)?;
    let below =
        plan_space.positions().iter().map(|x| on_body.evaluate(&[x[0], x[1], body.surface(x[0], x[1])]));
    let below = below.collect::<Result<Vec<_>, _>>()?.concat();
    let below = Field::from_values(&plan_space, below)?;
    FieldMap::of(&below, Shown::Component(0), "contact pressure [MPa]")
        .length_unit("mm")
        .title("Contact pressure from below, a quarter")
        .window([0.0, 0.9], [0.0, 0.9])
        .write_png(picture("_surface"))?;

    // The plane of symmetry y = 0, deformed, each displacement as large as it is.
    let section = |[s, w]: [f64; 2]| {
        let [x, _, z] = body.place([s, 0.0, w]);
        [x, z]
    };
    let section = forms_fem::mesh::structured([options.divisions; 2], CellShape::Quadrilateral, 2, section)?;
    let section_space = Space::vector(&section, 2)?;
    let cut = section_space.positions().iter().map(|x| u.evaluate(&[x[0], 0.0, x[1]]).map(|u| [u[0], u[2]]));
    let cut = Field::from_values(&section_space, cut.collect::<Result<Vec<_>, _>>()?.concat())?;
    let (outline, obstacle) = contact.outline();
    FieldMap::of(&cut, Shown::Component(1), "u_{z} [mm]")
        .length_unit("mm")
        .axes("x", "z")
        .title("The plane y = 0")
        .deformed(&cut, 1.0)
        .undeformed_outline("before")
        .line(&outline, obstacle, Colour::BLACK)
        .write_png(picture("_section"))?;

    assert!(options.divisions < 12 || error < 0.02, "the pressure profile is {error} from Hertz");
    Ok(())
}

fn main() -> ExitCode {
    program_with_options(run)
}
