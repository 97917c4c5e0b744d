//! Account of a run: the table, columns over time, pictures.

use std::error::Error;

use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, TimeSeries, TimeSeriesError};
use forms_fem::time::State;

use super::ring::{FALL, GRAVITY, INSIDE, OUTSIDE, Record, SPEED, Thrown, model};

/// The times of the frames that are drawn.
const FRAMES_SHOWN: [f64; 6] = [0.0, 6.0, 8.0, 11.0, 20.0, 40.0];
/// The last part of the time, over which means are taken.
const MEAN: f64 = 0.25;

/// The table, the times at which the ring touches and leaves, and the numbers of the end.
pub fn table(
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
    let sum = |axis: usize| {
        records.windows(2).map(|pair| (pair[1].time - pair[0].time) * pair[1].force[axis]).sum::<f64>()
    };
    out.line(format!("impulses of the flat {:.5} and {:.5}", sum(0), sum(1)));
    let most = records.iter().map(|record| record.iterations).max().unwrap_or(0);
    let of = |count: fn(&Record) -> usize| records.iter().map(count).sum::<usize>();
    out.line(format!(
        "{} steps in time, {} of Newton's method, at most {most} in one, of which {} were shortened",
        records.len() - 1,
        of(|record| record.iterations),
        of(|record| record.shortened)
    ));
    // The means over a last part of the time, in which a ring that rolls goes by v for each −ω b.
    let last = records[records.len() - 1];
    let Some(first) = records.iter().find(|record| record.time >= (1.0 - MEAN) * last.time) else {
        return Ok(());
    };
    let (time, mut turned, mut height) = (last.time - first.time, 0.0, 0.0);
    for pair in records.windows(2).filter(|pair| pair[0].time >= first.time) {
        let part = (pair[1].time - pair[0].time) / 2.0;
        turned -= part * (pair[0].spin + pair[1].spin);
        height += part * (pair[0].height + pair[1].height) / time;
    }
    let way = last.along - first.along;
    let rigid = SPEED / (1.0 + (INSIDE * INSIDE + OUTSIDE * OUTSIDE) / (2.0 * OUTSIDE * OUTSIDE));
    out.line(format!(
        "means from {:.2} on: v = {:.5}, −ω b = {:.5}, of which v is {:.4}; height {height:.4}, friction takes {:.5}; a rigid ring rolls \
         with {rigid:.5}",
        first.time,
        way / time,
        turned * OUTSIDE / time,
        way / (turned * OUTSIDE),
        (last.lost - first.lost) / scale
    ));
    Ok(())
}

/// Names of the numbers over time.
const COLUMNS: [&str; 10] = [
    "energy",
    "kinetic",
    "friction",
    "momentum_x",
    "momentum_y",
    "force_x",
    "force_y",
    "along",
    "height",
    "spin",
];

/// The numbers over time.
pub fn series(records: &[Record]) -> Result<TimeSeries, TimeSeriesError> {
    let mut series = TimeSeries::new(COLUMNS);
    for record in records {
        let Record { time, energy, kinetic, lost, along, height, spin, .. } = *record;
        let ([px, py], [fx, fy]) = (record.momentum, record.force);
        series.push(time, &[energy, kinetic, lost, px, py, fx, fy, along, height, spin])?;
    }
    Ok(series)
}

/// Speeds, energies, height and forces over time.
pub fn draw(records: &[Record]) -> Result<(), Box<dyn Error>> {
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
    let curve =
        |name: &str, value: &dyn Fn(&Record) -> f64| Curve::new(name, &times, &of(value)).without_markers();
    let scale = records[0].kinetic;
    let zero = records[0].energy - scale;
    let energies = plot("Energies", "beside the kinetic energy of the throw")
        .curve(curve("kinetic", &|r| r.kinetic / scale))
        .curve(curve("elastic and height", &|r| (r.energy - zero - r.kinetic) / scale))
        .curve(curve("taken by friction", &|r| r.lost / scale))
        .curve(curve("sum", &|r| (r.energy - zero + r.lost) / scale).colour(Colour::BLACK).dashed());
    let mass = records[0].momentum[0] / SPEED;
    let rigid = SPEED / (1.0 + (INSIDE * INSIDE + OUTSIDE * OUTSIDE) / (2.0 * OUTSIDE * OUTSIDE));
    let speeds = plot("Speed of the centre, and of the rim by the spin", "speed")
        .curve(curve("v", &|r| r.momentum[0] / mass))
        .curve(curve("−ω b", &|r| -r.spin * OUTSIDE))
        .horizontal_line(rigid, "a rigid ring that rolls");
    let weight = mass * GRAVITY;
    let heights = plot("Height of the centre", "height").curve(curve("height", &|r| r.height));
    let forces = plot("Forces of the flat", "beside the weight")
        .curve(curve("pressing", &|r| r.force[1] / weight))
        .curve(curve("along", &|r| r.force[0] / weight));
    Panel::new(2)
        .letters()
        .picture(&speeds)?
        .picture(&energies)?
        .picture(&heights)?
        .picture(&forces)?
        .write_png("out/rolling_ring_course.png")?;
    Ok(())
}

/// The ring at some times, with a line of points that lay one below the other.
pub fn draw_frames(thrown: &Thrown, shown: &[State<2>]) -> Result<(), Box<dyn Error>> {
    let floor = -OUTSIDE - FALL;
    let mut panel = Panel::new(3);
    for time in FRAMES_SHOWN {
        let nearest = shown.iter().min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs()));
        let Some(state) = nearest else { continue };
        let u = &state.value;
        let of = model(None, [1.0, 0.0], [0.0; 2]);
        let at = thrown.assembler.functional(&of.momentum(u))? / thrown.mass;
        let spoke = (0..=10).map(|part| -> Result<[f64; 2], Box<dyn Error>> {
            let radius = INSIDE + (OUTSIDE - INSIDE) * (0.02 + 0.096 * f64::from(part));
            let moved = u.evaluate(&[0.0, -radius])?;
            Ok([moved[0], moved[1] - radius])
        });
        let spoke: Vec<[f64; 2]> = spoke.collect::<Result<_, _>>()?;
        let frame = FieldMap::of(&state.rate, Shown::Magnitude, "speed")
            .deformed(u, 1.0)
            .line(&[[at - 1.25, floor], [at + 1.25, floor]], "", Colour::BLACK)
            .line(&spoke, "", Colour::BLACK)
            .window([at - 1.25, at + 1.25], [floor - 0.05, floor + 2.3])
            .range(0.0, 2.0 * SPEED)
            .title(&format!("t = {:.2}", state.time))
            .levels(12)
            .size(180.0, 180.0);
        panel = panel.picture(&frame)?;
    }
    panel.write_png("out/rolling_ring.png")?;
    Ok(())
}
