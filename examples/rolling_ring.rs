//! A ring of rubber that is thrown along a flat: it falls, touches, and is spun by friction. Large displacements and strains, contact by
//! Nitsche's method in mid-point schemes that know the energy ([`finite_impact`]).
//!
//! Checks, of which each ends the program if it fails: energy and work of friction stay together what they were (`conserving`) or never grow
//! (`hybrid`), and momentum changes by the impulses of weight and flat. Beside it stands the closed form of a rigid ring: friction on the
//! flat has no moment about it, so that from the speed v it comes to roll with v/(1 + (a² + b²)/2b²), radii a and b.
//!
//! Run it with `cargo run --release --bin rolling_ring -- [CELLS AROUND] [STEPS PER UNIT OF TIME] [UNITS OF TIME] [hybrid]`. It writes
//! `out/rolling_ring.csv`, frames for ParaView in `out/rolling_ring.pvd`, and pictures.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::finite_impact::finite_impact;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, TimeSeries, TimeSeriesError, VtuFile, VtuSeries, program};
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};

/// Radii, λ and μ, density, weight per mass, κ.
const INSIDE: f64 = 0.5;
const OUTSIDE: f64 = 1.0;
const LAMBDA: f64 = 4.0;
const MU: f64 = 1.0;
const DENSITY: f64 = 1.0;
const GRAVITY: f64 = 0.02;
const FRICTION: f64 = 0.5;
/// The speed along the flat, and the height of the fall.
const SPEED: f64 = 0.3;
const FALL: f64 = 0.2;
/// γ₀: quadratic cells need some 30 (λ + 2μ), or E₁ has no lower bound and the motion explodes in flight.
const GAMMA: f64 = 400.0 * MU;
const DEGREE: usize = 4;
/// Pictures per unit of time.
const FRAMES: f64 = 4.0;

/// The scheme of a run.
#[derive(Clone, Copy, PartialEq)]
enum Pressure {
    Conserving,
    Hybrid,
}

/// The numbers of a step that are written.
#[derive(Clone, Copy)]
struct Record {
    time: f64,
    energy: f64,
    kinetic: f64,
    /// Work of friction so far.
    lost: f64,
    /// Momentum along the flat and off it.
    momentum: [f64; 2],
    /// The flat's mean force in the step.
    force: [f64; 2],
    /// The centre's height, and the angular velocity by the moment of inertia.
    height: f64,
    spin: f64,
}

/// The body, its start, and what is measured of it.
struct Thrown {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    mass: f64,
}

impl Thrown {
    fn new(around: usize) -> Result<Self, Box<dyn Error>> {
        let mesh = annulus(INSIDE, OUTSIDE, (around / 12).max(1), around, CellShape::Quadrilateral, 2)?;
        let mesh = Arc::new(mesh);
        let space = Space::vector(&mesh, 2)?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(DEGREE));
        let one = Field::interpolate(&space, |_| [1.0, 0.0])?;
        let mass = assembler.functional(&model(None, [1.0, 0.0], [0.0; 2]).momentum(&one))?;
        Ok(Thrown { space, assembler, mass })
    }

    fn start(&self) -> Result<State<2>, Box<dyn Error>> {
        let velocity = Field::interpolate(&self.space, |_| [SPEED, 0.0])?;
        Ok(State::new(0.0, Field::zero(&self.space), velocity)?)
    }

    fn measured(
        &self,
        before: Option<(&State<2>, &Record, Pressure)>,
        after: &State<2>,
    ) -> Result<Record, Box<dyn Error>> {
        let (u, velocity) = (&after.value, &after.rate);
        let axes = [[1.0, 0.0], [0.0, 1.0]];
        let along = |axis: [f64; 2]| model(None, axis, [0.0; 2]);
        let total = |axis: [f64; 2], w: &Field<2>| self.assembler.functional(&along(axis).momentum(w));
        let momentum = [total(axes[0], velocity)?, total(axes[1], velocity)?];
        let way = [total(axes[0], u)? / self.mass, total(axes[1], u)? / self.mass];
        let about = model(None, axes[0], way);
        let spin = self.assembler.functional(&about.spin(u, velocity))?
            / self.assembler.functional(&about.inertia(u))?;
        let mut record = Record {
            time: after.time,
            energy: self.assembler.functional(&along(axes[0]).energy(u, velocity))?,
            kinetic: kinetic(&self.assembler, velocity)?,
            lost: 0.0,
            momentum,
            force: [0.0; 2],
            height: OUTSIDE + FALL + way[1],
            spin,
        };
        if let Some((before, earlier, pressure)) = before {
            let start = &before.value;
            for (force, axis) in record.force.iter_mut().zip(axes) {
                *force = match pressure {
                    Pressure::Conserving => {
                        self.assembler.functional(&along(axis).conserving_force(u, start))?
                    }
                    Pressure::Hybrid => self.assembler.functional(&along(axis).hybrid_force(u, start))?,
                };
            }
            record.lost = earlier.lost
                + match pressure {
                    Pressure::Conserving => {
                        self.assembler.functional(&along(axes[0]).conserving_loss(u, start))?
                    }
                    Pressure::Hybrid => self.assembler.functional(&along(axes[0]).hybrid_loss(u, start))?,
                };
        }
        Ok(record)
    }
}

fn kinetic(assembler: &Assembler<2>, velocity: &Field<2>) -> Result<f64, Box<dyn Error>> {
    let zero = Field::zero(velocity.space());
    let energy = model(None, [0.0; 2], [0.0; 2]);
    Ok(assembler.functional(&energy.energy(&zero, velocity))?
        - assembler.functional(&energy.energy(&zero, &zero))?)
}

fn model(step: Option<&Step<2>>, direction: [f64; 2], centre: [f64; 2]) -> finite_impact::Model<2> {
    let required = finite_impact::Required {
        base: step.map(Into::into).unwrap_or_default(),
        lambda: LAMBDA,
        mu: MU,
        rho: DENSITY,
        gamma0: GAMMA,
        obstacle_normal: Given::constant([0.0, -1.0]),
        gap: Given::function(|x: &[f64; 2]| x[1] + OUTSIDE + FALL),
    };
    let data = finite_impact::Data {
        friction: FRICTION,
        body_force: Given::constant([0.0, -DENSITY * GRAVITY]),
        direction: Given::constant(direction),
        centre: Given::constant(centre),
        ..required.into()
    };
    finite_impact::Model { data, regions: finite_impact::Regions::default().gamma_c("outer") }
}

/// Steps of a run, the frames' states among them.
fn follow(
    thrown: &Thrown,
    pressure: Pressure,
    size: f64,
    end: f64,
    mut frame: impl FnMut(&State<2>) -> Result<(), Box<dyn Error>>,
) -> Result<Vec<Record>, Box<dyn Error>> {
    let start = thrown.start()?;
    let mut records = vec![thrown.measured(None, &start)?];
    let mid_point = GeneralisedAlpha::mid_point();
    let base = |step: &Step<2>| model(Some(step), [0.0; 2], [0.0; 2]);
    let conserving = move |step: &Step<2>| base(step).conserving(&step.before.value);
    let hybrid = move |step: &Step<2>| base(step).hybrid(&step.before.value);
    let options = NewtonOptions { absolute_tolerance: 1e-13, ..NewtonOptions::default() };
    let motion = match pressure {
        Pressure::Conserving => TimeLoop::new(conserving, mid_point, start),
        Pressure::Hybrid => TimeLoop::new(hybrid, mid_point, start),
    };
    let mut motion = motion.assembler(&thrown.assembler).options(options);
    frame(motion.state())?;
    while motion.state().time < end - 0.5 * size {
        let before = motion.state().clone();
        motion.take(size)?;
        let (after, earlier) = (motion.state(), records[records.len() - 1]);
        let record = thrown.measured(Some((&before, &earlier, pressure)), after)?;
        check(&earlier, &record, pressure, thrown.mass)?;
        records.push(record);
        if (after.time * FRAMES + 1e-9).floor() > (before.time * FRAMES + 1e-9).floor() {
            frame(after)?;
        }
    }
    Ok(records)
}

/// Balances of a step: energy beside the kinetic energy of the throw, momentum beside its own.
fn check(before: &Record, after: &Record, pressure: Pressure, mass: f64) -> Result<(), Box<dyn Error>> {
    let scale = mass * SPEED * SPEED / 2.0;
    let gain = (after.energy + after.lost - before.energy - before.lost) / scale;
    let wrong = match pressure {
        Pressure::Conserving => gain.abs() > 1e-9,
        Pressure::Hybrid => gain > 1e-9,
    };
    if wrong || after.lost < before.lost {
        return Err(format!("at {} the energy has changed by {gain:.1e}", after.time).into());
    }
    let size = after.time - before.time;
    for (axis, weight) in [0.0, -mass * GRAVITY].into_iter().enumerate() {
        let impulse = size * (after.force[axis] + weight);
        let off = (after.momentum[axis] - before.momentum[axis] - impulse) / (mass * SPEED);
        if off.abs() > 1e-9 {
            return Err(format!("at {} the momentum is off by {off:.1e}", after.time).into());
        }
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all("out")?;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given =
        |place: usize, otherwise: usize| arguments.get(place).map_or(Ok(otherwise), |text| text.parse());
    let (around, per_unit, end) = (given(0, 24)?, given(1, 40)?, given(2, 7)?);
    let pressure = match arguments.get(3).map(String::as_str) {
        None => Pressure::Conserving,
        Some("hybrid") => Pressure::Hybrid,
        Some(other) => return Err(format!("`{other}` is no scheme: it takes `hybrid`, or nothing").into()),
    };
    let thrown = Thrown::new(around.max(3))?;
    out.line(format!("{} unknowns", thrown.space.unknowns()));
    let mut film = VtuSeries::new("out/rolling_ring.pvd")?;
    let mut shown: Vec<State<2>> = vec![];
    let frame = |state: &State<2>| -> Result<(), Box<dyn Error>> {
        let file = VtuFile::new(thrown.space.mesh()).point_data("displacement", &state.value)?;
        film.write(state.time, &file.point_data("velocity", &state.rate)?)?;
        shown.push(state.clone());
        Ok(())
    };
    let records = follow(&thrown, pressure, 1.0 / per_unit.max(1) as f64, end as f64, frame)?;
    let series = series(&records)?;
    tell(&thrown, &records, &series, out)?;
    series.write("out/rolling_ring.csv")?;
    draw(&records, &shown)
}

/// The table, and the times at which the ring touches and leaves.
fn tell(
    thrown: &Thrown,
    records: &[Record],
    series: &TimeSeries,
    out: &mut StandardOutput,
) -> Result<(), TimeSeriesError> {
    let scale = thrown.mass * SPEED * SPEED / 2.0;
    out.line("| t | height | v | −ω b | kinetic | energy | friction | sum − 1 |\n| --: | --: | --: | --: | --: | --: | --: | --: |");
    let zero = records[0].energy;
    for record in records.iter().step_by((records.len() / 20).max(1)) {
        out.line(format!(
            "| {:.2} | {:.4} | {:.5} | {:.5} | {:.4} | {:.5} | {:.5} | {:+.1e} |",
            record.time,
            record.height,
            record.momentum[0] / thrown.mass,
            -record.spin * OUTSIDE,
            record.kinetic / scale,
            1.0 + (record.energy - zero) / scale,
            record.lost / scale,
            (record.energy - zero + record.lost) / scale
        ));
    }
    // A hundredth of the weight.
    for passage in series.passages("force_y", 0.01 * thrown.mass * GRAVITY)? {
        out.line(format!("{} at {:.2}", if passage.rises { "touches" } else { "leaves" }, passage.time));
    }
    let last = records[records.len() - 1];
    let rigid = SPEED / (1.0 + (INSIDE * INSIDE + OUTSIDE * OUTSIDE) / (2.0 * OUTSIDE * OUTSIDE));
    let sum = |axis: usize| {
        records.windows(2).map(|pair| (pair[1].time - pair[0].time) * pair[1].force[axis]).sum::<f64>()
    };
    out.line(format!(
        "at the end v = {:.5}, −ω b = {:.5}; a rigid ring rolls with {rigid:.5}. Impulses of the flat {:.5} and {:.5}",
        last.momentum[0] / thrown.mass,
        -last.spin * OUTSIDE,
        sum(0),
        sum(1)
    ));
    Ok(())
}

/// Names of the numbers over time.
const COLUMNS: [&str; 9] =
    ["energy", "kinetic", "friction", "momentum_x", "momentum_y", "force_x", "force_y", "height", "spin"];

fn series(records: &[Record]) -> Result<TimeSeries, TimeSeriesError> {
    let mut series = TimeSeries::new(COLUMNS);
    for record in records {
        let Record { time, energy, kinetic, lost, height, spin, .. } = *record;
        let ([px, py], [fx, fy]) = (record.momentum, record.force);
        series.push(time, &[energy, kinetic, lost, px, py, fx, fy, height, spin])?;
    }
    Ok(series)
}

fn draw(records: &[Record], shown: &[State<2>]) -> Result<(), Box<dyn Error>> {
    let times: Vec<f64> = records.iter().map(|record| record.time).collect();
    let of = |value: &dyn Fn(&Record) -> f64| records.iter().map(value).collect::<Vec<f64>>();
    let plot = |title: &str, label: &str| {
        LinePlot::new()
            .title(title)
            .x_axis("t", Scale::Linear)
            .y_axis(label, Scale::Linear)
            .grid()
            .size(480.0, 320.0)
    };
    let zero = records[0].energy - records[0].kinetic;
    plot("A ring that is thrown along a flat", "energy")
        .curve(Curve::new("kinetic", &times, &of(&|r| r.kinetic)).without_markers())
        .curve(
            Curve::new("elastic and height", &times, &of(&|r| r.energy - zero - r.kinetic)).without_markers(),
        )
        .curve(Curve::new("taken by friction", &times, &of(&|r| r.lost)).without_markers())
        .curve(Curve::new("sum", &times, &of(&|r| r.energy - zero + r.lost)).without_markers())
        .write_png("out/rolling_ring_energy.png")?;
    let mass = records[0].momentum[0] / SPEED;
    plot("Speed of the centre, and of the rim beside it", "speed")
        .curve(Curve::new("v", &times, &of(&|r| r.momentum[0] / mass)).without_markers())
        .curve(Curve::new("−ω b", &times, &of(&|r| -r.spin * OUTSIDE)).without_markers())
        .write_png("out/rolling_ring_speed.png")?;
    // The frame in which the ring stands lowest.
    let lowest = |state: &State<2>| state.value.values().iter().skip(1).step_by(2).sum::<f64>();
    let pressed = shown.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b)));
    if let Some(state) = pressed {
        let floor = -OUTSIDE - FALL;
        let at =
            state.value.values().iter().step_by(2).sum::<f64>() / (state.value.values().len() / 2) as f64;
        FieldMap::of(&state.rate, Shown::Magnitude, "speed")
            .deformed(&state.value, 1.0)
            .line(&[[at - 1.3, floor], [at + 1.3, floor]], "flat", Colour::BLACK)
            .write_png("out/rolling_ring.png")?;
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
