//! Account of wheels over their positions: a table, columns over the angle, and what one factor saves.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use forms_contact::rolling::Ground;
use forms_examples::level_set::wheel::{HOLES, Pressed, Rolling, Wheel, round_holes};
use forms_fem::cut::Cut;
use forms_fem::output::{StandardOutput, write_whole};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use forms_fem::shape_optimisation::level_set::LevelSetProblem;

/// A wheel in all positions in which wheels are compared.
pub struct Rolled {
    pub name: String,
    /// The angles of the positions, in sectors.
    pub angles: Vec<f64>,
    pub work: Vec<f64>,
    pub reaction: Vec<f64>,
    pub unevenness: Vec<f64>,
    /// J of these positions with the price of the length of Γ.
    pub priced: f64,
    pub body: Arc<Cut<2>>,
    pub pressed: Pressed,
}

impl Rolled {
    /// The wheel of φ, whose values are those of the same nodes.
    pub fn new(name: &str, judge: &Wheel, rolling: &Rolling, phi: &Field<2>) -> Result<Self, Failure> {
        let body = Cut::by(&Field::from_values(&judge.scalars, phi.values().to_vec())?)?;
        let pressed = judge.solve(&body)?.state;
        let of = |value: &dyn Fn(usize) -> f64| (0..pressed.positions.len()).map(value).collect();
        let numbers = |place: usize| pressed.positions[place].numbers;
        let sector = std::f64::consts::TAU / HOLES as f64;
        Ok(Rolled {
            name: name.to_owned(),
            angles: rolling.positions.iter().map(|ground| ground.angle / sector).collect(),
            work: of(&|place| numbers(place).work),
            reaction: of(&|place| numbers(place).reaction),
            unevenness: of(&|place| numbers(place).unevenness(rolling.criterion.length)),
            priced: judge.priced(&pressed),
            body,
            pressed,
        })
    }
}

/// Mean, and largest less least value.
fn mean_and_range(values: &[f64]) -> [f64; 2] {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let end = |choose: fn(f64, f64) -> f64| values.iter().copied().reduce(choose).unwrap_or(f64::NAN);
    [mean, end(f64::max) - end(f64::min)]
}

/// The table of all wheels.
pub fn table(rolled: &[Rolled], out: &mut StandardOutput) {
    out.line("| wheel | J + price | W, mean | range | reaction, mean | range | unevenness |");
    out.line("| --- | --: | --: | --: | --: | --: | --: |");
    for wheel in rolled {
        let [work, of_work] = mean_and_range(&wheel.work);
        let [reaction, of_reaction] = mean_and_range(&wheel.reaction);
        let [unevenness, _] = mean_and_range(&wheel.unevenness);
        out.line(format!(
            "| {} | {:.4} | {work:.4} | {of_work:.4} | {reaction:.4} | {of_reaction:.4} | {unevenness:.4} |",
            wheel.name, wheel.priced
        ));
    }
}

/// Columns over the angle.
pub fn write_csv(rolled: &[Rolled], path: &Path) -> Result<(), Failure> {
    let mut text = "wheel,sectors,work,reaction,unevenness\n".to_owned();
    for wheel in rolled {
        for place in 0..wheel.angles.len() {
            let columns = [&wheel.angles, &wheel.work, &wheel.reaction, &wheel.unevenness];
            text.push_str(&wheel.name);
            for column in columns {
                write!(text, ",{}", column[place])?;
            }
            text.push('\n');
        }
    }
    write_whole(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    Ok(())
}

/// J before and after all grounds have turned by a sector.
pub fn turned_by_a_sector(cells: usize, rolling: &Rolling, out: &mut StandardOutput) -> Result<(), Failure> {
    let mut turned = rolling.clone();
    let sector = std::f64::consts::TAU / HOLES as f64;
    turned.positions.iter_mut().for_each(|Ground { angle, .. }| *angle += sector);
    let of = |rolling: &Rolling| -> Result<f64, Failure> {
        let wheel = Wheel::rolling(cells, rolling)?;
        let phi = Field::interpolate(&wheel.scalars, round_holes)?;
        Ok(wheel.solve(&Cut::by(&phi)?)?.state.unpriced)
    };
    let (before, after) = (of(rolling)?, of(&turned)?);
    out.line(format!("J of round holes {before:.9}, turned by a sector {:+.1e} of it", after / before - 1.0));
    Ok(())
}

/// Seconds and factorisations of all positions with one solver, and of each as a problem of its own, adjoint states included.
pub fn cost(cells: usize, rolling: &Rolling, out: &mut StandardOutput) -> Result<(), Failure> {
    let of = |rolling: &Rolling| -> Result<(f64, usize, f64), Failure> {
        let wheel = Wheel::rolling(cells, rolling)?.with_length();
        let phi = Field::interpolate(&wheel.scalars, round_holes)?;
        let body = Cut::by(&phi)?;
        let begun = Instant::now();
        let mut state = wheel.solve(&body)?.state;
        wheel.derivatives(&body, &mut state)?;
        let seconds = begun.elapsed().as_secs_f64();
        let report = state.solver.report();
        Ok((seconds, report.factorisations, report.analysis_seconds + report.factorisation_seconds))
    };
    let together = of(rolling)?;
    let mut single = (0.0, 0, 0.0);
    for ground in &rolling.positions {
        let one = of(&Rolling { positions: vec![*ground], ..rolling.clone() })?;
        single = (single.0 + one.0, single.1 + one.1, single.2 + one.2);
    }
    for (name, (seconds, factorisations, factoring)) in [("one solver", together), ("one by one", single)] {
        out.line(format!(
            "{name}: {factorisations} factorisations, {seconds:.2} s with adjoints, {factoring:.2} s of them in factors"
        ));
    }
    Ok(())
}
