//! Contact of two elastic bodies compared with closed forms: cylinders and a ball (Hertz 1882), and a cylinder that is pressed and then
//! drawn along (Cattaneo 1938). It prints the table of docs/contact_between_bodies.md and draws its pictures.
//!
//! Run it with `cargo run --release --bin half_spaces -- [CELLS OVER THE CONTACT'S HALF WIDTH] [THE SAME IN SPACE]`.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::ContactProblem;
use forms_contact::half_spaces::{HalfSpaces, StickSlip, Traction, Tractions, balls, cylinders};
use forms_contact::hertz::{Hertz, RADIUS};
use forms_contact::laws::two_bodies as law;
use forms_fem::output::picture::{Curve, LinePlot, Marker, Picture, Scale};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// P \[N, in the plane N/mm\], κ and Q.
const FORCE: f64 = 10.0;
const FRICTION: f64 = 0.3;
const SHEAR: f64 = 1.5;

/// A row of the table.
fn row(out: &mut StandardOutput, case: &str, quantity: &str, exact: f64, found: f64) {
    let error = 100.0 * (found / exact - 1.0);
    out.line(format!("| {case} | {quantity} | {exact:.5} | {found:.5} | {error:+.2} % |"));
}

/// Presses the bodies, and compares.
fn press<const D: usize>(
    out: &mut StandardOutput,
    case: &str,
    bodies: &HalfSpaces<D>,
    problem: &ContactProblem<D, law::Model<D>>,
) -> Result<(Field<D>, Tractions<D>), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let mut solver = CondensedSolver::default();
    let u = problem.direct()?.solver(&mut solver).solve()?.into_field();
    let tractions = Tractions::of(problem, &u)?;
    let (fitted, force) = (tractions.fitted(), tractions.force() / bodies.part());
    row(out, case, "P", bodies.force, force);
    row(out, case, "a", bodies.hertz.reach, fitted.reach);
    row(out, case, "p0", bodies.hertz.peak, fitted.peak);
    let error = 100.0 * tractions.profile_error(&bodies.hertz);
    out.line(format!("| {case} | profile, L² | | | {error:.2} % |"));
    Ok((u, tractions))
}

/// The closed form of a profile over the distance from the middle, and what was computed as dots.
fn profile<const D: usize>(
    tractions: &Tractions<D>,
    hertz: &Hertz,
    sample: impl Fn(&Traction<D>) -> f64,
    exact: impl Fn(f64) -> f64,
) -> [Curve; 2] {
    let mut dots: Vec<[f64; 2]> =
        tractions.points.iter().map(|point| [point.distance(), sample(point)]).collect();
    dots.retain(|[r, _]| *r < 1.2 * hertz.reach);
    dots.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let [x, y] = [0, 1].map(|k| dots.iter().map(|dot| dot[k]).collect::<Vec<_>>());
    let line: Vec<f64> = (0..=480).map(|k| 1.2 * hertz.reach * f64::from(k) / 480.0).collect();
    let values: Vec<f64> = line.iter().map(|r| exact(*r)).collect();
    [
        Curve::new("closed form", &line, &values).without_markers(),
        Curve::new("computed, at quadrature points", &x, &y).marker(Marker::Circle).without_line(),
    ]
}

fn draw(title: &str, label: &str, [exact, found]: [Curve; 2], path: &str) -> Result<(), Box<dyn Error>> {
    LinePlot::new()
        .title(title)
        .x_axis("distance from the middle [mm]", Scale::Linear)
        .y_axis(label, Scale::Linear)
        .curve(exact)
        .curve(found)
        .write_png(path)?;
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise);
    let [in_plane, in_space] = [given(0, 16), given(1, 4)];

    out.line("| case | | closed form | computed | |");
    out.line("| --- | --- | --: | --: | --: |");
    let bodies = cylinders([RADIUS; 2], FORCE, in_plane)?;
    press(out, "two cylinders", &bodies, &bodies.pressed()?)?;

    let bodies = cylinders([f64::INFINITY, RADIUS], FORCE, in_plane)?;
    let (u, pressed) = press(out, "cylinder on half-space", &bodies, &bodies.pressed()?)?;
    let pressure = |r| bodies.hertz.pressure(r);
    let curves = profile(&pressed, &bodies.hertz, |point| point.pressure, pressure);
    draw("A cylinder on a half-space", "pressure [MPa]", curves, "out/half_spaces_pressure.png")?;

    let asked = StickSlip::of_line(bodies.hertz, FORCE, FRICTION, SHEAR);
    let problem = bodies.sheared(&asked, &u)?;
    let solved = problem.direct()?.start(&u).solve()?;
    let tractions = Tractions::of(&problem, solved.field())?;
    row(out, "drawn along", "Q", SHEAR, tractions.shear());
    // At the forces that come out.
    let exact = StickSlip::of_line(bodies.hertz, tractions.force(), FRICTION, tractions.shear());
    let middle = tractions.points.iter().min_by(|a, b| a.distance().total_cmp(&b.distance()));
    if let Some(point) = middle {
        row(out, "drawn along", "q(0)", exact.traction(0.0), point.shear);
    }
    let curves = profile(&tractions, &bodies.hertz, |point| point.shear, |r| exact.traction(r));
    draw("Pressed, then drawn along", "friction [MPa]", curves, "out/half_spaces_friction.png")?;

    let bodies = balls([f64::INFINITY, RADIUS], FORCE, in_space)?;
    let (_, tractions) = press(out, "ball on half-space", &bodies, &bodies.pressed()?)?;
    let way = bodies.approach() * (tractions.force() / bodies.part() / FORCE).powf(2.0 / 3.0);
    row(out, "ball on half-space", "approach", way, bodies.approach());
    let pressure = |r| bodies.hertz.pressure(r);
    let curves = profile(&tractions, &bodies.hertz, |point| point.pressure, pressure);
    draw("A ball on a half-space", "pressure [MPa]", curves, "out/half_spaces_ball.png")
}

fn main() -> ExitCode {
    program(run)
}
