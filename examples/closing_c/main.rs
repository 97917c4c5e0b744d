//! A C that closes, and the lower part that holds its arm best: topology optimisation through contact with a third medium (Bluhm, Sigmund
//! and Poulios 2021, Comput. Mech. 67; the term of second gradients is that of `forms_contact::laws::third_medium`).
//!
//! The arm's end is moved down until the arm lies on a body whose densities are wanted: those that push back most, with at most 40 % of the
//! area below the gap. Densities are smoothed by a form and projected. Without contact the arm would not feel them. At last the whole cells
//! of the body and the arm are solved again with contact pairs.
//!
//! Run it with `cargo run --release --bin closing_c -- [CELLS ACROSS] [ITERATIONS]`. Pictures are in `out/closing_c.png` and
//! `out/closing_c_force.png`, frames for ParaView in `out/closing_c.pvd`.

mod design;
mod pairs;

use std::error::Error;
use std::process::ExitCode;

use forms_examples::density_filter::Filtered;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::inverse::{
    Bounds, ConstrainedMinimum, HistoryError, Inequality, MovingAsymptotes, ReducedProblem,
};
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Panel, Picture, Scale};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

use crate::design::{Closing, LOWER};

/// The part of the design's area that may be used.
const PART: f64 = 0.4;
/// β, one value after the other, each with its part of the iterations.
const SHARPNESS: [f64; 2] = [2.0, 8.0];

/// Prints the derivative of the criterion along a wave and its differences.
fn check_gradient(
    problem: &mut Filtered<'_>,
    cells: &Arc<Space<2>>,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    let m = problem.start();
    let wave = Field::interpolate(cells, |x| (7.0 * x[0] + 3.0 * x[1]).sin())?;
    let (_, gradient) = problem.value_and_gradient(&m)?;
    let slope: f64 = gradient.iter().zip(wave.values()).map(|(slope, wave)| slope * wave).sum();
    let mut at = |t: f64| -> Result<f64, HistoryError> {
        problem.value(&m.iter().zip(wave.values()).map(|(m, wave)| m + t * wave).collect::<Vec<_>>())
    };
    let step = 1e-3;
    let difference = (8.0 * (at(step)? - at(-step)?) - (at(2.0 * step)? - at(-2.0 * step)?)) / (12.0 * step);
    let order = taylor_test(problem, &m, wave.values(), 0.02)?.second_order()?;
    out.line(format!(
        "dJ along sin(7x + 3y): {slope:.9e}, by differences {difference:.9e}, order of the Taylor test {order:.3}"
    ));
    Ok(())
}

fn optimise(
    c: &Closing,
    density: &Field<2>,
    iterations: usize,
    out: &mut StandardOutput,
) -> Result<ConstrainedMinimum, Box<dyn Error>> {
    let mut problem = c.filtered(density)?;
    let mut area = c.area(density);
    let most = PART * LOWER;
    let limit: Box<Inequality<'_, HistoryError>> = Box::new(move |m| {
        let (value, slope) = area.value_and_gradient(m)?;
        Ok((value / most - 1.0, slope.iter().map(|slope| slope / most).collect()))
    });
    let method = MovingAsymptotes {
        max_iterations: iterations,
        move_limit: 0.2,
        tolerance: 1e-3,
        ..Default::default()
    };
    let bounds = Bounds::between(c.cells.unknowns(), 0.0, 1.0);
    Ok(method.run(&mut problem, &bounds, &mut [limit], |step| {
        if step.iteration % 5 == 0 {
            out.line(format!(
                "| {} | {} | {:.4} | {:+.1e} |",
                c.sharpness, step.iteration, -step.value, step.constraints[0]
            ));
        }
    })?)
}

/// ρ at the points of a picture: the arm and the body are 1.
fn density<'a>(c: &'a Closing, smooth: &'a Field<2>) -> impl Fn(usize, &[f64; 2]) -> f64 + Sync + 'a {
    move |cell, reference| match c.mesh().cell_centre(cell)[1] {
        y if y < LOWER => c.projected(smooth.evaluate_in(cell, reference)[0]),
        y => f64::from(y > design::UPPER),
    }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let across = counts.first().copied().unwrap_or(16);
    let iterations = counts.get(1).copied().unwrap_or(40);
    let steps = counts.get(2).copied().unwrap_or(3);
    let mut c = Closing::new(across, steps)?;
    let even = |c: &Closing, density: f64| Field::interpolate(&c.cells, |_| density);
    out.line(format!("{} unknowns, {} densities", c.displacements.unknowns(), c.cells.unknowns()));

    // The arm's force without anything below is the unit.
    let nothing = even(&c, 0.0)?;
    let force = -c.filtered(&nothing)?.value(nothing.values())?;
    c.unit = force;
    out.line(format!("force on the arm with nothing below: {:.6e}", c.unit));
    let mut found = even(&c, PART)?;
    check_gradient(&mut c.filtered(&found)?, &c.cells, out)?;
    out.line("| β | iteration | force | area beside its bound |\n| --: | --: | --: | --: |");
    let first = found.clone();
    let mut history = vec![];
    for sharpness in SHARPNESS {
        c.sharpness = sharpness;
        let minimum = optimise(&c, &found, iterations / SHARPNESS.len(), out)?;
        history.extend(minimum.history.iter().map(|step| -step.value));
        found = Field::from_values(&c.cells, minimum.controls)?;
    }
    check_gradient(&mut c.filtered(&found)?, &c.cells, out)?;
    out.line(format!("{history:?}"));
    draw(&c, &first, &found, &history)?;
    compare(&c, &found, out)
}

fn draw(c: &Closing, first: &Field<2>, last: &Field<2>, history: &[f64]) -> Result<(), Box<dyn Error>> {
    let mut panel = Panel::new(2);
    for (densities, title) in [(first, "first"), (last, "last")] {
        let mut problem = c.filtered(densities)?;
        let smooth = problem.smoothed(densities.values())?;
        let states = problem.states(densities.values())?;
        let map = FieldMap::cell_by_cell(c.mesh(), density(c, &smooth), "ρ")
            .deformed(&states[c.steps - 1], 1.0)
            .range(0.0, 1.0)
            .without_mesh_lines()
            .size(240.0, 160.0)
            .title(title);
        panel = panel.picture(&map)?;
    }
    panel.draw()?.write_png("out/closing_c.png")?;
    let iterations: Vec<f64> = (0..history.len()).map(|iteration| iteration as f64).collect();
    LinePlot::new()
        .title("Force on the arm over iterations")
        .x_axis("iteration", Scale::Linear)
        .y_axis("force / that of the arm alone", Scale::Linear)
        .grid()
        .curve(Curve::new("moving asymptotes", &iterations, history).without_markers())
        .write_png("out/closing_c_force.png")?;
    Ok(())
}

fn compare(c: &Closing, found: &Field<2>, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let smooth = c.filtered(found)?.smoothed(found.values())?;
    // A point outside of the design is in no cell of ρ̃'s.
    let solid = |x: &[f64; 2]| smooth.evaluate(x).is_ok_and(|value| value[0] > 0.5);
    let whole = Field::interpolate(&c.cells, |x| f64::from(solid(x)))?;
    let mut history = c.history(&whole);
    let force = -history.value(whole.values())?;
    out.line(format!("whole cells, third medium: {force:.5}"));
    let with_pairs = pairs::solve(c, &solid, 2 * c.steps)?;
    out.line(format!("whole cells, pairs: {:.5}", with_pairs.force / c.unit));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
