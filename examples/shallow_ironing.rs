//! Shallow ironing, the problem of tutorial 12 on the benchmark's mesh, compared with GetFEM on the same mesh with the same energy, and with
//! what was published: forces over the way of the block.
//!
//! Run it with `cargo run --release --bin shallow_ironing -- [FINENESS] [STEPS OF PRESSING] [STEPS OF SLIDING]`; a step of sliding is a fifth of
//! a millimetre, half of the way are 25 of them. GetFEM's forces are those of `tests/getfem/shallow_ironing.json`.

// The tutorial's own program is not this one.
#[allow(dead_code)]
#[path = "12_two_bodies.rs"]
mod tutorial;

use std::process::ExitCode;

use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use serde::Deserialize;

/// Forces of the block on the foundation at a place on its way \[N/mm\].
#[derive(Clone, Copy, Deserialize)]
struct Forces {
    /// Up to 1 it goes down, then along, 10 mm for each unit.
    way: f64,
    down: f64,
    along: f64,
}

/// GetFEM's run.
#[derive(Deserialize)]
struct Run {
    curve: Vec<Forces>,
}

/// The least and the largest of five published pairs of forces, down and along, at the end of pressing and half way along \[N/mm\]:
/// Poulios and Renard, Fischer and Wriggers, Yastrebov, Hartmann and others, Code_Aster.
const PUBLISHED: [(f64, [f64; 2], [f64; 2]); 2] =
    [(1.0, [267.9, 332.0], [55.3, 71.0]), (1.5, [337.4, 421.0], [102.1, 188.8])];

fn run(out: &mut StandardOutput) -> Result<(), Failure> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [fineness, pressing, sliding] = [given(0, 4), given(1, 8), given(2, 25)];
    let space = Space::vector(&tutorial::mesh(fineness)?, 1)?;
    out.line(format!("{} unknowns", space.unknowns()));
    out.line("| way | down [N/mm] | along [N/mm] | Newton steps |");
    out.line("| --: | --: | --: | --: |");

    let mut ours = vec![Forces { way: 0.0, down: 0.0, along: 0.0 }];
    let solve = |step: &Increment<'_, Field<2>>| -> Result<Field<2>, Failure> {
        let problem = tutorial::problem(&space, step.before, step.factor)?;
        let mut steps = 0_usize;
        let count = |newton: &NewtonStep| steps += usize::from(newton.iteration > 0);
        let solved = problem.direct()?.increment(step).each_step(count).solve()?;
        let force = solved.reaction("foundation bottom")?;
        let now = Forces { way: step.factor, down: force[1], along: -force[0] };
        out.line(format!("| {:.4} | {:.3} | {:.3} | {steps} |", now.way, now.down, now.along));
        ours.push(now);
        Ok(solved.into_field())
    };
    let ways = (1..=pressing).map(|step| step as f64 / pressing as f64);
    let ways = ways.chain((1..=sliding).map(|step| 1.0 + 0.02 * step as f64));
    let path = LoadSteps::through(ways).advance(Field::zero(&space), solve)?;

    let getfem: Run = serde_json::from_str(include_str!("../tests/getfem/shallow_ironing.json"))?;
    out.line("| way | down | GetFEM | published, least | most | along | GetFEM | published, least | most |");
    out.line("| --: | --: | --: | --: | --: | --: | --: | --: | --: |");
    for (way, of_down, of_along) in PUBLISHED {
        let at = |curve: &[Forces]| curve.iter().copied().find(|forces| (forces.way - way).abs() < 1e-9);
        if let (Some(own), Some(theirs)) = (at(&ours), at(&getfem.curve)) {
            let cells = |own: f64, theirs: f64, [least, most]: [f64; 2]| {
                format!("{own:.2} | {theirs:.2} | {least} | {most}")
            };
            let down = cells(own.down, theirs.down, of_down);
            out.line(format!("| {way} | {down} | {} |", cells(own.along, theirs.along, of_along)));
        }
    }
    draw(&ours, &getfem.curve)?;
    FieldMap::of(&path.state, Shown::Component(0), "displacement along [mm]")
        .length_unit("mm")
        .deformed(&path.state, 1.0)
        .write_png("out/shallow_ironing.png")?;
    Ok(())
}

/// Both curves, and the published band as bars.
fn draw(ours: &[Forces], getfem: &[Forces]) -> Result<(), Failure> {
    let column = |curve: &[Forces], value: fn(&Forces) -> f64| curve.iter().map(value).collect::<Vec<_>>();
    let curve = |name: &str, forces: &[Forces], value| {
        Curve::new(name, &column(forces, |forces| forces.way), &column(forces, value)).without_markers()
    };
    let mut plot = LinePlot::new()
        .x_axis("way of the block: 1 mm down, then 10 mm along", Scale::Linear)
        .y_axis("force [N/mm]", Scale::Linear)
        .curve(curve("down", ours, |forces| forces.down))
        .curve(curve("down, GetFEM", getfem, |forces| forces.down).dashed())
        .curve(curve("along", ours, |forces| forces.along))
        .curve(curve("along, GetFEM", getfem, |forces| forces.along).dashed());
    for (way, down, along) in PUBLISHED {
        for (name, band) in [("", down), ("published", along)] {
            // One entry of the legend serves all four bars.
            let name = if way == 1.0 { name } else { "" };
            plot = plot.curve(Curve::new(name, &[way; 2], &band).colour(Colour::BLACK));
        }
    }
    plot.write_png("out/shallow_ironing_forces.png")?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
