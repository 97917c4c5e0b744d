//! The lower part of a C that closes: topology optimisation through contact with a third medium (Bluhm, Sigmund and Poulios 2021, Comput.
//! Mech. 67; the second gradients are those of `forms_contact::laws::third_medium`).
//!
//! A pad presses the upper arm down until it meets a body whose densities are wanted: those with the largest force on the pad, in 40 % of
//! the area below the gap. Densities are smoothed by a form and projected. At last the arm and the body are solved again with contact
//! pairs: in whole cells, and on triangles that fit the level ½ of the densities.
//!
//! Run it with `cargo run --release --bin closing_c -- [CELLS ACROSS, a multiple of 8] [ITERATIONS]`. Pictures are
//! `out/closing_c.png` and `out/closing_c_animation.png`.

mod animation;
mod design;
mod fitted;
mod pairs;

use std::cell::RefCell;
use std::error::Error;
use std::process::ExitCode;

use forms_examples::density_filter::Filtered;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::inverse::{Bounds, HistoryError, Inequality, MovingAsymptotes, ReducedProblem};
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

use crate::animation::Frame;
use crate::design::{Closing, LOWER};
use crate::fitted::fitted;
use crate::pairs::{Pressed, whole_cells, with_pairs};

/// The part of the design's area that may be used.
const PART: f64 = 0.4;
/// β of the projection, in the first and in the second half of the iterations.
const SHARPNESS: [f64; 2] = [2.0, 8.0];
/// Frames of the animation that show iterates after the first: many early ones, which change most.
const FRAMES: usize = 8;

/// The densities of an iterate, with the β of its projection.
struct Iterate {
    sharpness: f64,
    densities: Vec<f64>,
    force: f64,
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let mut c = Closing::new(counts.first().copied().unwrap_or(16))?;
    let iterations = counts.get(1).copied().unwrap_or(50);
    out.line(format!("{} unknowns, {} densities", c.displacements.unknowns(), c.cells.unknowns()));

    // The force with nothing below the arm is the unit.
    let nothing = Field::zero(&c.cells);
    let alone = -c.history(&nothing).value(nothing.values())?;
    c.unit = alone;
    out.line(format!("force with nothing below the arm: {alone:.6e}"));
    let first = Field::interpolate(&c.cells, |_| PART)?;
    check_gradient(&mut c.filtered(&first)?, &c.cells, out)?;
    let at_first = shown(&c, &first)?;

    out.line("\n| β | iteration | force | area over its limit |\n| --: | --: | --: | --: |");
    let (mut found, mut iterates) = (first, vec![]);
    for sharpness in SHARPNESS {
        c.sharpness = sharpness;
        found = optimise(&c, &found, iterations / SHARPNESS.len(), &mut iterates, out)?;
    }
    check_gradient(&mut c.filtered(&found)?, &c.cells, out)?;
    let at_last = shown(&c, &found)?;

    out.line("\n| below the arm | force: medium | pairs | difference | sinks by: medium | pairs |\n| --- | --: | --: | --: | --: | --: |");
    let bar = |x: &[f64; 2]| x[1] > (1.0 - PART) * LOWER;
    let solid = |x: &[f64; 2]| at_last.0.evaluate(x).is_ok_and(|density| density[0] > 0.5);
    compare_in_whole_cells(&c, "a bar of the same area", &bar, out)?;
    compare_in_whole_cells(&c, "what was found, in whole cells", &solid, out)?;
    // The level ½ is that of the densities before their projection, too.
    let mesh = fitted(&c, &c.filtered(&found)?.smoothed(found.values())?, 1.0)?;
    let pressed = with_pairs(&c, &mesh)?;
    let in_medium = (-c.filtered(&found)?.value(found.values())?, &at_last.1);
    compare("what was found, on triangles that fit", in_medium, &pressed, out)?;
    let area = form!(|| -> Functional { integral(cells("lower body"), 1) });
    let area = Assembler::new(&mesh).functional(&area)?;
    out.line(format!("\narea on triangles over its limit: {:+.1e}", area / (PART * LOWER) - 1.0));
    let forces: Vec<f64> = iterates.iter().map(|iterate| iterate.force).collect();
    draw(&c, [at_first, at_last], &pressed, &forces)?;
    let frames = frames(&mut c, &iterates)?;
    animation::write(&c, &frames, &pressed)?;
    out.line("\npictures: out/closing_c.png, out/closing_c_animation.png");
    Ok(())
}

/// Prints the derivative of the criterion along a wave, and by differences of fourth order.
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
    let h = 1e-3;
    let difference = (8.0 * (at(h)? - at(-h)?) - (at(2.0 * h)? - at(-2.0 * h)?)) / (12.0 * h);
    let order = taylor_test(problem, &m, wave.values(), 0.02)?.second_order()?;
    out.line(format!(
        "slope along sin(7x + 3y): {slope:.9e}, by differences {difference:.9e}, order of the Taylor test {order:.3}"
    ));
    Ok(())
}

/// Densities of the largest force, from others.
fn optimise(
    c: &Closing,
    density: &Field<2>,
    iterations: usize,
    iterates: &mut Vec<Iterate>,
    out: &mut StandardOutput,
) -> Result<Field<2>, Box<dyn Error>> {
    let (mut area, most) = (c.area(density), PART * LOWER);
    // The method evaluates the limit once at each iterate.
    let visited = RefCell::new(vec![]);
    let limit: Box<Inequality<'_, HistoryError>> = Box::new(|m| {
        visited.borrow_mut().push(m.to_vec());
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
    let found = method.run(&mut c.filtered(density)?, &bounds, &mut [limit], |step| {
        if step.iteration.is_multiple_of(5) {
            let (iteration, over) = (step.iteration, step.constraints[0]);
            out.line(format!("| {} | {iteration} | {:.4} | {over:+.1e} |", c.sharpness, -step.value));
        }
    })?;
    let visited = found.history.iter().zip(visited.into_inner());
    iterates.extend(visited.map(|(step, densities)| Iterate {
        sharpness: c.sharpness,
        densities,
        force: -step.value,
    }));
    Ok(Field::from_values(&c.cells, found.controls)?)
}

/// ρ as the form reads it, and the displacements.
fn shown(c: &Closing, density: &Field<2>) -> Result<(Field<2>, Field<2>), Box<dyn Error>> {
    let mut problem = c.filtered(density)?;
    let smooth = problem.smoothed(density.values())?;
    let projected = smooth.values().iter().map(|smooth| c.projected(*smooth)).collect();
    let mut states = problem.states(density.values())?;
    let last = states.pop().ok_or("a history without steps")?;
    Ok((Field::from_values(&c.smooth, projected)?, last))
}

/// Some iterates with their numbers, as [`shown`].
fn frames(c: &mut Closing, iterates: &[Iterate]) -> Result<Vec<Frame>, Box<dyn Error>> {
    let last = iterates.len() - 1;
    let mut chosen: Vec<usize> = (0..=FRAMES).map(|k| last * k * k / (FRAMES * FRAMES)).collect();
    chosen.dedup();
    chosen
        .into_iter()
        .map(|number| {
            let Iterate { sharpness, densities, .. } = &iterates[number];
            c.sharpness = *sharpness;
            let (density, u) = shown(c, &Field::from_values(&c.cells, densities.clone())?)?;
            Ok(Frame { number, density, u })
        })
        .collect()
}

/// A body of whole cells in the third medium and with pairs, as [`compare`] prints it.
fn compare_in_whole_cells(
    c: &Closing,
    name: &str,
    solid: &dyn Fn(&[f64; 2]) -> bool,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    let whole = Field::interpolate(&c.cells, |x| f64::from(solid(x)))?;
    let mut history = c.history(&whole);
    let force = -history.value(whole.values())?;
    let states = history.states(whole.values())?;
    let u = states.last().ok_or("a history without steps")?;
    compare(name, (force, u), &with_pairs(c, &whole_cells(c, solid)?)?, out)
}

/// Prints the force, and how far the top of the lower body sinks, in the third medium and with pairs.
fn compare(
    name: &str,
    (force, u): (f64, &Field<2>),
    pressed: &Pressed,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    let (_, with_pairs) = pressed.states.last().ok_or("no step of the pad")?;
    let top = with_pairs.space().positions().iter().zip(with_pairs.values().chunks(2));
    let top = top.filter(|(x, _)| (x[1] - LOWER).abs() < 1e-9);
    let (place, sinks) = top.map(|(x, u)| (x, -u[1])).max_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no body")?;
    out.line(format!(
        "| {name} | {force:.4} | {:.4} | {:+.1} % | {:.5} | {sinks:.5} |",
        pressed.force,
        100.0 * (force / pressed.force - 1.0),
        -u.evaluate(place)?[1]
    ));
    Ok(())
}

/// Densities at first and at last, the bodies with pairs, and the force over the iterations.
fn draw(
    c: &Closing,
    shapes: [(Field<2>, Field<2>); 2],
    pressed: &Pressed,
    forces: &[f64],
) -> Result<(), Box<dyn Error>> {
    let mut panel = Panel::new(2);
    for ((density, u), title) in shapes.iter().zip(["at first", "at last"]) {
        panel = panel.picture(&animation::densities(c, density, u).size(200.0, 130.0).title(title))?;
    }
    let (_, u) = pressed.states.last().ok_or("no step of the pad")?;
    let map = FieldMap::of(u, Shown::Magnitude, "|u|").deformed(u, 1.0);
    panel = panel.picture(&map.size(200.0, 130.0).levels(8).title("on triangles, with contact pairs"))?;
    let iterations: Vec<f64> = (0..forces.len()).map(|iteration| iteration as f64).collect();
    let plot = LinePlot::new()
        .x_axis("iteration", Scale::Linear)
        .y_axis("force", Scale::Linear)
        .title("force, over that of the arm alone")
        .size(200.0, 140.0)
        .grid()
        .curve(Curve::new("", &iterations, forces).without_markers());
    Ok(panel.picture(&plot)?.draw()?.write_png("out/closing_c.png")?)
}

fn main() -> ExitCode {
    program(run)
}
