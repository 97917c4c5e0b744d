//! A bar that flies onto a rigid obstacle and bounces (Doyen, Ern & Piperno 2011), by one scheme after the other, compared with d'Alembert's
//! waves: it prints the table of examples/results.md, draws energies and forces over time, and writes them to `out/bar_impact.csv`, and the
//! conserving scheme's film to `out/bar_impact.pvd`.
//!
//! Run it with `cargo run --release --bin bar_impact -- [CELLS ALONG THE BAR] [STEPS PER UNIT OF TIME]`.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::ExitCode;

use forms_contact::impact::impact;
use forms_fem::output::picture::{Colour, Curve, LinePlot, Panel, Picture, Scale};
use forms_fem::output::{StandardOutput, VtuFile, VtuSeries, program, write_whole};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, Events, GeneralisedAlpha, Mass, State, Step, TimeLoop,
    operators, redistributed_mass,
};

/// E, ρ, L, v, the gap at the start, and the time that is followed.
const YOUNGS_MODULUS: f64 = 900.0;
const DENSITY: f64 = 1.0;
const LENGTH: f64 = 10.0;
const VELOCITY: f64 = 10.0;
const GAP: f64 = 5.0;
const END: f64 = 1.5;
/// Between these times forces are reported separately: after the first blow, and before waves come back from the free end.
const SETTLED: f64 = 0.52;
const MIDDLE: f64 = 0.8;
/// Pictures of the film per unit of time.
const FRAMES: f64 = 30.0;

/// Contact begins at gap/v, lasts while a wave goes to the free end and back, with the force E v/c.
const TOUCH: f64 = GAP / VELOCITY;

fn wave_speed() -> f64 {
    (YOUNGS_MODULUS / DENSITY).sqrt()
}

fn release() -> f64 {
    TOUCH + 2.0 * LENGTH / wave_speed()
}

/// Contact's way into a step, and the scheme.
#[derive(Clone, Copy)]
enum Steps {
    /// At the time at which the scheme evaluates forces.
    Plain(GeneralisedAlpha),
    /// The same by the formulas of order 2.
    Backward,
    Hybrid,
    Conserving,
    /// Central differences with lumped masses, in a quarter of the step size.
    Explicit,
}

/// The distribution of the mass.
#[derive(Clone, Copy)]
enum Inertia {
    /// Everywhere.
    Even,
    /// Not at the nodes on the obstacle's side.
    Redistributed,
}

/// Energy and force of the obstacle over time, per height of the bar.
struct Course {
    name: &'static str,
    times: Vec<f64>,
    energies: Vec<f64>,
    forces: Vec<f64>,
    /// The times at which the gap closes first and opens last.
    contact: [f64; 2],
    velocity: f64,
}

fn model(step: Option<&Step<2>>, rho: &Field<2>) -> impact::Model<2> {
    let evaluated: operators::vector::Data<2> = step.map(Into::into).unwrap_or_default();
    let data = impact::data_from(evaluated)
        .lambda(0.0)
        .mu(YOUNGS_MODULUS / 2.0)
        .gamma0(4.0 * YOUNGS_MODULUS)
        .obstacle_normal([-1.0, 0.0])
        .gap(GAP)
        .theta(1.0)
        .rho(rho);
    impact::Model { data, regions: impact::Regions::default().gamma_c("left") }
}

fn follow(
    name: &'static str,
    (steps, inertia): (Steps, Inertia),
    space: &Arc<Space<2>>,
    size: f64,
) -> Result<Course, Box<dyn Error>> {
    let assembler = Assembler::new(space.mesh());
    let mut along = Constraints::new(space);
    along.fix_component("all", 1, |_| 0.0)?;
    let velocity = Field::interpolate(space, |_| [-VELOCITY, 0.0])?;
    let start = State::new(0.0, Field::zero(space), velocity)?;

    let even = Field::interpolate(&Space::discontinuous_scalar(space.mesh(), 0)?, |_| DENSITY)?;
    let rho = match inertia {
        Inertia::Even => even,
        Inertia::Redistributed => redistributed_mass(&even, "left", &assembler)?,
    };
    let plain = |step: &Step<2>| model(Some(step), &rho).motion();
    let mid_point = GeneralisedAlpha::mid_point();
    let motion = match steps {
        Steps::Plain(scheme) => TimeLoop::new(plain, scheme, start),
        Steps::Backward => TimeLoop::new(plain, BackwardDifferences::new(2)?, start),
        Steps::Explicit => TimeLoop::new(plain, CentralDifferences, start).mass(Mass::Lumped),
        Steps::Hybrid => {
            let hybrid = |step: &Step<2>| model(Some(step), &rho).hybrid(&step.before.value);
            TimeLoop::new(hybrid, mid_point, start)
        }
        Steps::Conserving => {
            let conserving = |step: &Step<2>| model(Some(step), &rho).conserving(&step.before.value);
            TimeLoop::new(conserving, mid_point, start)
        }
    };
    let mut motion = motion.assembler(&assembler).constrained(&along);
    let size = if matches!(steps, Steps::Explicit) { size / 4.0 } else { size };
    let functionals = model(None, &rho);
    let energy = |state: &State<2>| assembler.functional(&functionals.energy(&state.value, &state.rate));
    let mut course = Course {
        name,
        times: vec![0.0],
        energies: vec![energy(motion.state())?],
        forces: vec![0.0],
        contact: [f64::NAN; 2],
        velocity: 0.0,
    };
    let mut events = Events::new().of("gap", |state| Ok(GAP + state.value.evaluate(&[0.0, 0.0])?[0]));
    // One film is enough.
    let mut film = match (steps, inertia) {
        (Steps::Conserving, Inertia::Even) => Some(VtuSeries::new("out/bar_impact.pvd")?),
        _ => None,
    };
    while motion.state().time < END - 0.5 * size {
        let before = motion.state().clone();
        for event in events.take(&mut motion, size)?.events {
            match event.passage.rises {
                true => course.contact[1] = event.passage.time,
                false if course.contact[0].is_nan() => course.contact[0] = event.passage.time,
                false => {}
            }
        }
        let after = motion.state();
        course.times.push(after.time);
        course.energies.push(energy(after)?);
        course.forces.push(match steps {
            Steps::Hybrid => assembler.functional(&functionals.hybrid_force(&after.value, &before.value))?,
            Steps::Conserving => {
                assembler.functional(&functionals.conserving_force(&after.value, &before.value))?
            }
            _ => assembler.functional(&functionals.contact_force(&after.value))?,
        });
        if let Some(film) = &mut film
            && (after.time * FRAMES).floor() > (before.time * FRAMES).floor()
        {
            let file = VtuFile::new(space.mesh()).point_data("displacement", &after.value)?;
            film.write(after.time, &file.point_data("velocity", &after.rate)?)?;
        }
    }
    let height = assembler.mesh().nodes().iter().map(|x| x[1]).fold(0.0, f64::max);
    course.energies.iter_mut().chain(&mut course.forces).for_each(|total| *total /= height);
    // Where there is no inertia the rate is what the scheme makes of displacements.
    let inner =
        space.positions().iter().zip(motion.state().rate.values().chunks(2)).filter(|(x, _)| x[0] > 0.0);
    let along_x: Vec<f64> = inner.map(|(_, rate)| rate[0]).collect();
    course.velocity = along_x.iter().sum::<f64>() / along_x.len() as f64;
    Ok(course)
}

impl Course {
    fn impulse(&self) -> f64 {
        self.times.windows(2).zip(&self.forces[1..]).map(|(t, force)| (t[1] - t[0]) * force).sum()
    }

    /// The least and the largest force between two times.
    fn forces_between(&self, from: f64, to: f64) -> [f64; 2] {
        let inside = self.times.iter().zip(&self.forces).filter(|(t, _)| (from..to).contains(t));
        let ends = |[least, most]: [f64; 2], (_, force): (_, &f64)| [least.min(*force), most.max(*force)];
        inside.fold([f64::INFINITY, 0.0], ends)
    }

    fn row(&self) -> String {
        let ([touch, release], start) = (self.contact, self.energies[0]);
        let largest = self.energies.iter().copied().fold(f64::MIN, f64::max) / start - 1.0;
        let end = self.energies.last().copied().unwrap_or(start) / start - 1.0;
        let peak = self.forces.iter().copied().fold(0.0, f64::max);
        let ([_, first], [least, most]) =
            (self.forces_between(0.0, SETTLED), self.forces_between(SETTLED, MIDDLE));
        format!(
            "| {} | {touch:.3} | {release:.3} | {:.2} | {peak:.0} | {:.3} | {largest:+.1e} | {end:+.1e} | {first:.0} | {least:.0} to {most:.0} |",
            self.name,
            self.impulse(),
            self.velocity
        )
    }
}

fn draw<'c>(
    courses: impl Iterator<Item = &'c Course>,
    title: &str,
    label: &str,
    value: impl Fn(&Course) -> Vec<f64>,
) -> LinePlot {
    let plot = LinePlot::new().title(title).x_axis("t", Scale::Linear).y_axis(label, Scale::Linear).grid();
    courses.fold(plot.size(480.0, 320.0), |plot, course| {
        let curve = Curve::new(course.name, &course.times, &value(course)).without_markers();
        plot.curve(match course.name {
            // Curves that lie on those of other schemes.
            "hybrid" => curve.colour(Colour::BLACK).dashed(),
            "conserving" => curve.colour(Colour::grey(140)).dashed(),
            name if name.ends_with("redistributed") => curve.dashed(),
            _ => curve,
        })
    })
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let (cells, size) = (given(0, 60), 1.0 / given(1, 400) as f64);
    // Square cells, one over the height.
    let mesh = rectangle([0.0; 2], [LENGTH, LENGTH / cells as f64], [cells, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;

    let trapezoidal = Steps::Plain(GeneralisedAlpha::trapezoidal());
    let of_order_two = "backward differences, order 2";
    let all = [
        ("trapezoidal", trapezoidal, Inertia::Even),
        ("mid-point", Steps::Plain(GeneralisedAlpha::mid_point()), Inertia::Even),
        ("generalised-α, ρ = 0.5", Steps::Plain(GeneralisedAlpha::with_spectral_radius(0.5)?), Inertia::Even),
        ("HHT, α = 0.1", Steps::Plain(GeneralisedAlpha::hilber_hughes_taylor(0.1)?), Inertia::Even),
        (of_order_two, Steps::Backward, Inertia::Even),
        ("central differences", Steps::Explicit, Inertia::Even),
        ("hybrid", Steps::Hybrid, Inertia::Even),
        ("conserving", Steps::Conserving, Inertia::Even),
        ("trapezoidal, redistributed", trapezoidal, Inertia::Redistributed),
        ("mid-point, redistributed", Steps::Plain(GeneralisedAlpha::mid_point()), Inertia::Redistributed),
        ("backward differences, redistributed", Steps::Backward, Inertia::Redistributed),
        ("hybrid, redistributed", Steps::Hybrid, Inertia::Redistributed),
        ("conserving, redistributed", Steps::Conserving, Inertia::Redistributed),
    ];
    let mut courses = vec![];
    out.line(format!("| scheme | touches | leaves | impulse | largest force | velocity | largest gain of energy | energy at the end | largest force before t = {SETTLED} | force from there to {MIDDLE} |"));
    out.line("| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: |");
    let force = YOUNGS_MODULUS * VELOCITY / wave_speed();
    let impulse = force * (release() - TOUCH);
    out.line(format!(
        "| closed form | {TOUCH:.3} | {:.3} | {impulse:.2} | {force:.0} | {VELOCITY:.3} | 0 | 0 | {force:.0} | {force:.0} |",
        release()
    ));
    for (name, steps, inertia) in all {
        let course = follow(name, (steps, inertia), &space, size)?;
        out.line(course.row());
        courses.push(course);
    }

    let mut csv = "scheme,t,energy,force\n".to_owned();
    for course in &courses {
        for ((t, energy), force) in course.times.iter().zip(&course.energies).zip(&course.forces) {
            writeln!(csv, "\"{}\",{t:e},{energy:e},{force:e}", course.name)?;
        }
    }
    write_whole("out/bar_impact.csv", |file| file.write_all(csv.as_bytes()))?;
    let change = |course: &Course| -> Vec<f64> {
        course.energies.iter().map(|energy| energy / course.energies[0] - 1.0).collect()
    };
    let label = "change of energy / energy at the start";
    let all = draw(courses.iter(), "A bar that bounces, all schemes", label, change);
    let nearly_kept = |course: &&Course| change(course).iter().all(|change| change.abs() < 1e-3);
    let near =
        draw(courses.iter().filter(nearly_kept), "Those that change it by less than 10⁻³", label, change)
            .x_range(0.4, END);
    Panel::new(2).letters().picture(&all)?.picture(&near)?.write_png("out/bar_impact_energy.png")?;
    let shown =
        |course: &&Course| course.name.starts_with("conserving") || course.name.starts_with("generalised");
    draw(courses.iter().filter(shown), "Force of the obstacle", "force", |course| course.forces.clone())
        .horizontal_line(force, "E v / c")
        .vertical_line(TOUCH, "")
        .vertical_line(release(), "")
        .write_png("out/bar_impact_force.png")?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
