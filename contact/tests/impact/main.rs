//! Elastic bars that hit an obstacle, compared with d'Alembert's waves: a free bar (Doyen, Ern & Piperno 2011) and one that is held at its
//! end, in which contact comes back with a known period; what their schemes do to the energy.

mod rubber;

use forms_contact::impact::impact;
use forms_fem::prelude::*;
use forms_fem::time::{
    CentralDifferences, Events, GeneralisedAlpha, Mass, NumberError, State, Step, Taken, TimeLoop,
    redistributed_mass,
};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// A bar along x on 0..length of square cells, one over its height, with Γ_C at x = 0 and the obstacle beyond −gap.
struct Bar {
    youngs_modulus: f64,
    length: f64,
    gap: f64,
    cells: usize,
}

/// c = 30, hits at t = 0.5 with v = −10, is in contact for 2L/c with the force E v/c = 300, and leaves undeformed with v = +10.
const FREE: Bar = Bar { youngs_modulus: 900.0, length: 10.0, gap: 5.0, cells: 60 };
/// c = 1; held at x = 1, released from u = (1 − x)/2: contact for t in 1..2 with the pressure ½, period 3, energy ⅛.
const HELD: Bar = Bar { youngs_modulus: 1.0, length: 1.0, gap: 0.0, cells: 60 };

impl Bar {
    fn height(&self) -> f64 {
        self.length / self.cells as f64
    }

    fn space(&self) -> Outcome<Arc<Space<2>>> {
        let mesh =
            rectangle([0.0; 2], [self.length, self.height()], [self.cells, 1], CellShape::Quadrilateral, 1)?;
        Ok(Space::vector(&mesh, 1)?)
    }

    fn model(&self, step: forms_fem::time::operators::vector::Data<2>) -> impact::Model<2> {
        let data = impact::data_from(step)
            .lambda(0.0)
            .mu(self.youngs_modulus / 2.0)
            .gamma0(4.0 * self.youngs_modulus)
            .obstacle_normal([-1.0, 0.0])
            .gap(self.gap)
            .theta(1.0)
            .rho(1.0);
        let regions = impact::Regions::default().gamma_c("left");
        impact::Model { data, regions }
    }

    fn start(&self, space: &Arc<Space<2>>) -> Outcome<State<2>> {
        let free = self.gap > 0.0;
        let value = Field::interpolate(space, |x| [if free { 0.0 } else { (1.0 - x[0]) / 2.0 }, 0.0])?;
        let rate = Field::interpolate(space, |_| [if free { -10.0 } else { 0.0 }, 0.0])?;
        Ok(State::new(0.0, value, rate)?)
    }

    fn constraints(&self, space: &Arc<Space<2>>) -> Outcome<Constraints<2>> {
        let mut constraints = Constraints::new(space);
        constraints.fix_component("all", 1, |_| 0.0)?;
        if self.gap == 0.0 {
            constraints.fix_component("right", 0, |_| 0.0)?;
        }
        Ok(constraints)
    }
}

/// A step's time at its end, energy there, and mean force of the obstacle over it, both per height.
#[derive(Clone, Copy, Debug)]
struct Record {
    time: f64,
    energy: f64,
    force: f64,
}

/// The pressure of a mid-point scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pressure {
    Hybrid,
    Conserving,
}

/// Follows a bar by a mid-point scheme; the records begin with the start, and the last state comes with them.
fn follow(bar: &Bar, pressure: Pressure, size: f64, steps: usize) -> Outcome<(Vec<Record>, State<2>)> {
    let space = bar.space()?;
    let assembler = Assembler::new(space.mesh());
    let plain = bar.model(Default::default());
    let constraints = bar.constraints(&space)?;
    let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
    let mut records = vec![];
    let mut record = |state: &State<2>, force: f64| -> Outcome {
        let energy = assembler.functional(&plain.energy(&state.value, &state.rate))?;
        let height = bar.height();
        records.push(Record { time: state.time, energy: energy / height, force: force / height });
        Ok(())
    };
    let start = bar.start(&space)?;
    record(&start, 0.0)?;
    let mid_point = GeneralisedAlpha::mid_point();
    let conserving = |step: &Step<2>| bar.model(step.into()).conserving(&step.before.value);
    let hybrid = |step: &Step<2>| bar.model(step.into()).hybrid(&step.before.value);
    let mut motion = match pressure {
        Pressure::Conserving => TimeLoop::new(conserving, mid_point, start),
        Pressure::Hybrid => TimeLoop::new(hybrid, mid_point, start),
    }
    .assembler(&assembler)
    .constrained(&constraints)
    .options(options);
    for _ in 0..steps {
        let before = motion.state().value.clone();
        let _: Taken<2> = motion.take(size)?;
        let after = &motion.state().value;
        let force = match pressure {
            Pressure::Conserving => assembler.functional(&plain.conserving_force(after, &before))?,
            Pressure::Hybrid => assembler.functional(&plain.hybrid_force(after, &before))?,
        };
        record(motion.state(), force)?;
    }
    let end = motion.state().clone();
    Ok((records, end))
}

#[test]
fn a_free_bar_bounces_as_waves_do() -> Outcome {
    let size = 1.0 / 400.0;
    for pressure in [Pressure::Hybrid, Pressure::Conserving] {
        let (records, end) = follow(&FREE, pressure, size, 600)?;
        let impulse: f64 = records.iter().map(|record| record.force * size).sum();
        assert!((impulse / 200.0 - 1.0).abs() < 0.02, "{pressure:?} {impulse}");
        let touched: Vec<_> = records.iter().filter(|record| record.force > 30.0).map(|r| r.time).collect();
        let [first, last] = [touched[0], touched[touched.len() - 1]];
        assert!((first - 0.5).abs() < 0.02 && (last - 7.0 / 6.0).abs() < 0.06, "{first} {last}");
        // The plateau E v/c.
        let plateau: Vec<_> =
            records.iter().filter(|r| (0.6..1.1).contains(&r.time)).map(|r| r.force).collect();
        let mean = plateau.iter().sum::<f64>() / plateau.len() as f64;
        assert!((mean / 300.0 - 1.0).abs() < 0.01, "{pressure:?} {mean}");
        let velocities: Vec<f64> = end.rate.values().iter().step_by(2).copied().collect();
        let mean = velocities.iter().sum::<f64>() / velocities.len() as f64;
        assert!((mean - 10.0).abs() < 0.3, "{pressure:?} {mean}");
    }
    Ok(())
}

/// A step that ends where the gap closes, at 0.5 after free flight, which the mid-point rule follows exactly; then whole steps until it
/// has opened, at about 0.5 + 2L/c, closer on a finer mesh.
#[test]
fn a_step_ends_where_a_bar_touches() -> Outcome {
    let mut off = vec![];
    for cells in [30, 120] {
        let bar = Bar { cells, ..FREE };
        let space = bar.space()?;
        let constraints = bar.constraints(&space)?;
        let form = |step: &Step<2>| bar.model(step.into()).conserving(&step.before.value);
        let mut motion =
            TimeLoop::new(form, GeneralisedAlpha::mid_point(), bar.start(&space)?).constrained(&constraints);
        let gap = |state: &State<2>| -> Result<f64, NumberError> {
            Ok(bar.gap + state.value.evaluate(&[0.0, 0.0])?[0])
        };
        let (size, mut located) = (0.3 / cells as f64, Events::new().of("gap", gap).located(1e-9)?);
        let touch = loop {
            let step = located.take(&mut motion, size)?;
            if let [touch] = &step.events[..] {
                assert!(motion.state().time == step.taken.to && step.taken.to - touch.passage.time <= 1e-9);
                break touch.passage;
            }
        };
        assert!(!touch.rises && (touch.time - 0.5).abs() < 2e-9, "{touch:?}");
        let left = gap(motion.state()).map_err(|why| why.to_string())?;
        assert!((-1e-7..=0.0).contains(&left), "{left:e}");
        let (mut events, mut last) = (Events::new().of("gap", gap), touch);
        while motion.state().time < 1.3 {
            last = events.take(&mut motion, size)?.events.last().map_or(last, |event| event.passage);
        }
        assert!(last.rises, "{last:?}");
        off.push((last.time - 7.0 / 6.0).abs());
    }
    println!("{off:?}");
    assert!(off[0] < 0.02 && off[1] < 0.5 * off[0], "{off:?}");
    Ok(())
}

#[test]
fn a_held_bar_comes_back_with_its_period() -> Outcome {
    let size = 1.0 / 150.0;
    let (records, end) = follow(&HELD, Pressure::Conserving, size, 450)?;
    let energy = records[0].energy;
    // −σ_n²/2γ of the start is Nitsche's, and goes with h.
    assert!((energy - 0.125).abs() < 0.002, "{energy}");
    let mean_of = |range: std::ops::Range<f64>| {
        let forces: Vec<_> =
            records.iter().filter(|record| range.contains(&record.time)).map(|r| r.force).collect();
        forces.iter().sum::<f64>() / forces.len() as f64
    };
    assert!((mean_of(1.1..1.9) - 0.5).abs() < 0.01);
    assert!(mean_of(0.1..0.9) < 1e-12 && mean_of(2.2..3.0) < 0.02);
    // After a period it is where it began, up to the dispersion of the waves' fronts.
    let off = end.value.minus(&HELD.start(end.value.space())?.value)?;
    let largest = off.values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    assert!(largest < 0.05, "{largest}");
    Ok(())
}

#[test]
fn the_hybrid_scheme_never_gains_and_the_conserving_one_keeps_energy() -> Outcome {
    let steps = if std::env::var_os("FORMS_SWEEPS").is_some() { 10_000 } else { 500 };
    let bar = Bar { cells: 20, ..HELD };
    let (records, _) = follow(&bar, Pressure::Conserving, 0.02, steps)?;
    assert!(records.iter().filter(|record| record.force > 0.1).count() > steps / 5, "it hits");
    let start = records[0].energy;
    let drift = records.iter().map(|record| (record.energy / start - 1.0).abs()).fold(0.0, f64::max);
    assert!(drift < 1e-12, "{drift:e} in {steps} steps");
    let (records, _) = follow(&bar, Pressure::Hybrid, 0.02, steps)?;
    let gain = records.windows(2).map(|pair| pair[1].energy - pair[0].energy).fold(f64::MIN, f64::max);
    assert!(gain < 1e-14, "{gain:e}");
    // Three impacts cost something, and little.
    let kept = records[500].energy / start;
    assert!((0.8..1.0).contains(&kept), "{kept}");
    Ok(())
}

/// Generalised-α damps what the impact excites; central differences with lumped masses bounce, too.
#[test]
fn other_schemes_bounce() -> Outcome {
    let space = FREE.space()?;
    let assembler = Assembler::new(space.mesh());
    let plain = FREE.model(Default::default());
    let form = |step: &Step<2>| FREE.model(step.into()).motion();
    let constraints = FREE.constraints(&space)?;
    let run = |motion: TimeLoop<'_, 2>, size: f64, steps: usize| -> Outcome<[f64; 2]> {
        let mut motion = motion.assembler(&assembler).constrained(&constraints);
        let mut impulse = 0.0;
        for _ in 0..steps {
            motion.take(size)?;
            impulse += size * assembler.functional(&plain.contact_force(&motion.state().value))?;
        }
        let State { value, rate, .. } = motion.state();
        let energy = assembler.functional(&plain.energy(value, rate))?;
        Ok([impulse, energy].map(|total| total / FREE.height()))
    };
    let damped = GeneralisedAlpha::with_spectral_radius(0.5)?;
    let [impulse, energy] = run(TimeLoop::new(form, damped, FREE.start(&space)?), 1.0 / 400.0, 600)?;
    assert!((impulse / 200.0 - 1.0).abs() < 0.03 && (450.0..500.0).contains(&energy), "{impulse} {energy}");
    let explicit = TimeLoop::new(form, CentralDifferences, FREE.start(&space)?).mass(Mass::Lumped);
    let [impulse, energy] = run(explicit, 1.0 / 1600.0, 2400)?;
    assert!(
        (impulse / 200.0 - 1.0).abs() < 0.03 && (energy / 500.0 - 1.0).abs() < 0.05,
        "{impulse} {energy}"
    );
    Ok(())
}

/// The free bar by the trapezoidal rule, with mass everywhere and without inertia at the nodes that hit. The force swings about E v/c in the one
/// motion, and in the other it is nearer by a factor; nothing else is worse, and both keep the energy about as well.
#[test]
fn without_inertia_at_the_obstacle_the_force_does_not_swing() -> Outcome {
    let space = FREE.space()?;
    let assembler = Assembler::new(space.mesh());
    let even = Field::interpolate(&Space::discontinuous_scalar(space.mesh(), 0)?, |_| 1.0)?;
    let redistributed = redistributed_mass(&even, "left", &assembler)?;
    let constraints = FREE.constraints(&space)?;
    let follow = |rho: &Field<2>| -> Outcome<[f64; 5]> {
        let model = |step| {
            let mut model = FREE.model(step);
            model.data.rho = Given::field(rho);
            model
        };
        let form = |step: &Step<2>| model(step.into()).motion();
        let plain = model(Default::default());
        let start = FREE.start(&space)?;
        let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start)
            .assembler(&assembler)
            .constrained(&constraints);
        let gap = |state: &State<2>| -> Result<f64, NumberError> {
            Ok(FREE.gap + state.value.evaluate(&[0.0, 0.0])?[0])
        };
        let (mut events, mut contact) = (Events::new().of("gap", gap), [f64::NAN; 2]);
        let (size, height) = (1.0 / 400.0, FREE.height());
        let [mut impulse, mut swing, mut drift] = [0.0, 0.0_f64, 0.0_f64];
        for _ in 0..600 {
            for event in events.take(&mut motion, size)?.events {
                let place = usize::from(event.passage.rises);
                if place == 1 || contact[0].is_nan() {
                    contact[place] = event.passage.time;
                }
            }
            let State { time, value, rate, .. } = motion.state();
            let force = assembler.functional(&plain.contact_force(value))? / height;
            let energy = assembler.functional(&plain.energy(value, rate))? / height;
            impulse += size * force;
            drift = drift.max((energy / 500.0 - 1.0).abs());
            if (0.6..1.1).contains(time) {
                swing = swing.max((force / 300.0 - 1.0).abs());
            }
        }
        println!("{contact:?} impulse {impulse}, force off by {swing:e}, energy by {drift:e}");
        Ok([contact[0], contact[1], impulse, swing, drift])
    };
    let [_, _, _, with_mass, _] = follow(&even)?;
    let [touch, release, impulse, swing, drift] = follow(&redistributed)?;
    assert!((touch - 0.5).abs() < 0.005 && (release - 7.0 / 6.0).abs() < 0.01, "{touch} {release}");
    assert!((impulse / 200.0 - 1.0).abs() < 0.01, "{impulse}");
    assert!(swing < 0.15 && with_mass > 4.0 * swing, "{swing} and {with_mass} with mass");
    assert!(drift < 1e-3, "{drift:e}");
    Ok(())
}
