//! Descents on level set functions: bodies that merge, the shortest boundary of an area, Taylor tests.

use std::f64::consts::PI;

use forms_fem::cut::Cut;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{
    HoleOptions, LevelSetControls, LevelSetDescent, LevelSetOptions, LevelSetProblem, LevelSetRow,
    LevelSetState, LevelSetVolume, SmoothPerimeter, interface_measure,
};
use forms_fem::shape_optimisation::{Checkpoint, Derivatives, Failure, StopReason, Values};
use serde_json::json;

use crate::{level, square};

#[forms(level_set_derivatives)]
mod wells {
    pub struct Data {
        pub depth: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn depth_inside(t: Test<Scalar>) -> Form {
        integral(Omega, depth * t)
    }
}

/// min(|x ∓ (0.33, 0)| − 0.42): negative in two discs that overlap.
fn depth(x: &[f64; 2]) -> f64 {
    (x[0].abs() - 0.33).hypot(x[1]) - 0.42
}

fn depth_gradient(x: &[f64; 2]) -> [f64; 2] {
    let across = x[0].abs() - 0.33;
    let size = across.hypot(x[1]).max(f64::MIN_POSITIVE);
    [across * x[0].signum() / size, x[1] / size]
}

/// ∫ of the depth over the body: least where it is the two discs.
struct Wells;

impl Wells {
    fn values(&self, body: &Arc<Cut<2>>) -> Result<(f64, Vec<f64>), Failure> {
        let data = wells::data().depth(Given::function_with_gradient(depth, depth_gradient));
        let form = wells::depth_inside(&data, &wells::Omega::on("all"));
        let assembler = Assembler::new(body.mesh()).with_cut(body)?;
        let one = Field::interpolate(&Space::discontinuous_scalar(body.mesh(), 0)?, |_| 1.0)?;
        let value = assembler.linear_form(&form, one.space())?.iter().sum();
        Ok((value, assembler.derivative_by_level_set(&form, &[], &[&one])?))
    }
}

impl LevelSetProblem<2> for Wells {
    type State = Vec<f64>;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Vec<f64>>, Failure> {
        let (criterion, state) = self.values(body)?;
        Ok(Values { criterion, constraint: None, state })
    }
    fn derivatives(&self, _: &Arc<Cut<2>>, state: &mut Vec<f64>) -> Result<Derivatives, Failure> {
        Ok(Derivatives { criterion: state.clone(), constraint: None })
    }
    fn topological_derivatives(&self, body: &Arc<Cut<2>>, _: &mut Vec<f64>) -> Result<Derivatives, Failure> {
        let space = Space::scalar(body.mesh(), 1)?;
        let criterion = space.positions().iter().map(|x| -PI * depth(x)).collect();
        Ok(Derivatives { criterion, constraint: None })
    }
}

/// The descent on the depth from the full square: all of the material around the discs is too much.
fn full_square(cells: usize) -> LevelSetDescent<'static, Wells, 2> {
    let size = 2.0 / cells as f64;
    let initial = level(&square(cells, CellShape::Triangle), |_| -1.0);
    let holes = HoleOptions { every: 4, ..HoleOptions::new(size) };
    let options = LevelSetOptions { iterations: 24, holes: Some(holes), ..LevelSetOptions::new(size) };
    LevelSetDescent { problem: &Wells, initial, options }
}

#[test]
fn holes_appear_in_a_full_square() {
    let cells = 32;
    let run = full_square(cells).run(None, &mut |_| Ok(())).unwrap();
    let (rows, radius) = (&run.state.history, 4.0 / cells as f64);
    let made: Vec<_> = rows.iter().filter_map(|row| row.holes.as_ref()).collect();
    println!("{made:?}, {} {}, {:?}", rows[0].criterion, run.values.criterion, run.state.finish);
    let first = made[0];
    // ∫ of the depth over (−1, 1)², by the mid-point rule with 2000² cells.
    assert!((first.before - 0.775_972).abs() < 3e-3, "{}", first.before);
    // Twelve-sided holes of two cells are a little smaller than circles.
    let ratio = (first.after - first.before) / first.promised;
    assert!(first.count > 5 && (0.85..1.0).contains(&ratio), "{ratio}");
    assert!(made.iter().all(|holes| holes.after < holes.before && holes.promised < 0.0));
    assert!(first.promised >= -PI * radius * radius * first.count as f64);
    assert!(run.values.criterion < 0.0 && rows[0].criterion > 0.2);
    assert!(run.state.csv().contains(&format!(",{},{},{}\n", first.count, first.before, first.after)));
}

/// The depth inside with a given area.
struct WellsOfArea(LevelSetVolume);

impl LevelSetProblem<2> for WellsOfArea {
    type State = Derivatives;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Derivatives>, Failure> {
        let ((criterion, of_depth), (area, of_area)) = (Wells.values(body)?, self.0.value(body)?);
        let state = Derivatives { criterion: of_depth, constraint: Some(of_area) };
        Ok(Values { criterion, constraint: Some(area), state })
    }
    fn derivatives(&self, _: &Arc<Cut<2>>, state: &mut Derivatives) -> Result<Derivatives, Failure> {
        Ok(state.clone())
    }
    fn topological_derivatives(
        &self,
        body: &Arc<Cut<2>>,
        _: &mut Derivatives,
    ) -> Result<Derivatives, Failure> {
        let of_depth = Wells.topological_derivatives(body, &mut vec![])?;
        let constraint = Some(vec![self.0.by_hole::<2>(); of_depth.criterion.len()]);
        Ok(Derivatives { constraint, ..of_depth })
    }
}

#[test]
fn holes_bring_an_area_to_its_target() {
    let LevelSetDescent { initial, options, .. } = full_square(32);
    let problem = WellsOfArea(LevelSetVolume { target: 1.0 });
    let options = LevelSetOptions { iterations: 80, ..options };
    let run = LevelSetDescent { problem: &problem, initial, options }.run(None, &mut |_| Ok(())).unwrap();
    let made: Vec<_> = run.state.history.iter().filter_map(|row| row.holes.as_ref()).collect();
    println!("{made:?}, {:?} {:?}, {:?}", run.values.criterion, run.values.constraint, run.state.finish);
    let parts: Vec<usize> = run.state.history.iter().map(|row| row.parts).collect();
    println!("parts of the body {parts:?}");
    // Four corners come off, and are gone at last.
    assert!(parts[0] == 1 && parts.contains(&5) && parts.last() == Some(&1), "{parts:?}");
    // At first nothing but the area's price promises a gain: λ + r c = 3 · 10 J₀.
    assert!(made[0].promised < 10.0 * (made[0].after - made[0].before), "{made:?}");
    assert!(run.values.constraint.unwrap().abs() < 1e-3);
    // The least value, where the depth is below −0.0108, by the mid-point rule with 3000² cells.
    assert!((run.values.criterion + 0.152_686).abs() < 2e-5, "{}", run.values.criterion);
}

#[test]
fn holes_that_are_not_resolved_are_refused() {
    let refused = |change: fn(&mut HoleOptions), words: &str| {
        let mut descent = full_square(8);
        descent.options.holes.iter_mut().for_each(change);
        let error = descent.run(None, &mut |_| Ok(())).err().unwrap().to_string();
        assert!(error.starts_with(words), "{error}");
    };
    refused(
        |holes| holes.radius = 0.25,
        "holes.radius = 0.25 is not possible: it must be finite, and no less",
    );
    refused(|holes| holes.distance = f64::NAN, "holes.distance = NaN is not possible");
    refused(|holes| holes.every = 0, "holes.every = 0 is not possible");
    refused(|holes| holes.most = 0, "holes.most = 0 is not possible");
    let LevelSetDescent { initial, options, .. } = full_square(8);
    let problem = Bubble { area: LevelSetVolume { target: 1.0 } };
    let error = LevelSetDescent { problem: &problem, initial, options }.run(None, &mut |_| Ok(()));
    assert!(error.err().unwrap().to_string().contains("which this problem does not state"));
}

fn two_discs(cells: usize) -> LevelSetDescent<'static, Wells, 2> {
    let apart = |x: &[f64; 2]| (x[0].abs() - 0.45).hypot(x[1]) - 0.2;
    let initial = level(&square(cells, CellShape::Triangle), apart);
    let options = LevelSetOptions { iterations: 40, ..LevelSetOptions::new(2.0 / cells as f64) };
    LevelSetDescent { problem: &Wells, initial, options }
}

#[test]
fn two_discs_merge() {
    let descent = two_discs(32);
    let run = descent.run(None, &mut |_| Ok(())).unwrap();
    let rows = &run.state.history;
    let joined = rows.iter().position(|row| row.parts == 1).unwrap();
    let last = rows[rows.len() - 1].criterion;
    println!("{last:.6} after {} steps, joined at step {joined}, {:?}", rows.len() - 1, run.state.finish);
    assert_eq!(rows[0].parts, 2);
    assert!(joined > 1 && rows[joined..].iter().all(|row| row.parts == 1), "{joined}");
    assert!(
        rows.windows(2).all(|pair| pair[1].criterion < pair[0].before_distance.unwrap_or(pair[0].criterion))
    );
    // The least value is −0.15292532, by integration over the exact discs.
    assert!((last + 0.152_925_32).abs() < 5e-6, "{last}");
}

/// With φ of degree 2 on quadrilaterals, whose boundaries are curved within cells.
#[test]
fn two_discs_merge_with_degree_2() {
    let cells = 16;
    let space = Space::scalar(&square(cells, CellShape::Quadrilateral), 2).unwrap();
    let apart = |x: &[f64; 2]| (x[0].abs() - 0.45).hypot(x[1]) - 0.2;
    let initial = Field::interpolate(&space, apart).unwrap();
    let options = LevelSetOptions { iterations: 40, ..LevelSetOptions::new(2.0 / cells as f64) };
    let run = LevelSetDescent { problem: &Wells, initial, options }.run(None, &mut |_| Ok(())).unwrap();
    let rows = &run.state.history;
    let last = rows[rows.len() - 1].criterion;
    println!("{last:.6} after {} steps, {:?}", rows.len() - 1, run.state.finish);
    assert_eq!((rows[0].parts, rows[rows.len() - 1].parts), (2, 1));
    assert!((last + 0.152_925_32).abs() < 2e-5, "{last}");
}

#[test]
fn interrupted_descents_end_with_the_same_bits() {
    for descent in [two_discs(16), full_square(16)] {
        check_interrupted(&descent);
    }
}

/// The run that is interrupted after seven steps ends as one that is not.
fn check_interrupted(descent: &LevelSetDescent<Wells, 2>) {
    let settings = json!({ "cells": 16 });
    let whole = descent.run(None, &mut |_| Ok(())).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint.json");
    let stopped = descent.run(None, &mut |report| {
        Checkpoint::new(settings.clone(), json!({}), vec![], report.state.clone()).write(&path)?;
        match report.state.iterations() {
            7 => Err("the power is gone".into()),
            _ => Ok(()),
        }
    });
    assert!(stopped.err().unwrap().to_string().contains("the power is gone"));
    let read = Checkpoint::<LevelSetState>::read(&path).unwrap().unwrap().state_for(&settings).unwrap();
    assert_eq!(read.iterations(), 7);
    let resumed = descent.run(Some(read), &mut |_| Ok(())).unwrap();
    assert_eq!(resumed.state, whole.state);
    let bits = |state: &LevelSetState| state.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&resumed.state), bits(&whole.state));
    let holes = |row: &LevelSetRow| row.holes.is_some();
    let later = whole.state.history[8..].iter().any(holes);
    assert!(later || descent.options.holes.is_none(), "no holes after the interruption");
    let other = two_discs(8).run(Some(whole.state), &mut |_| Ok(()));
    assert!(other.err().unwrap().to_string().contains("it is of another mesh"));
}

/// The length of the boundary, with a given area.
struct Bubble {
    area: LevelSetVolume,
}

impl LevelSetProblem<2> for Bubble {
    type State = Derivatives;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Derivatives>, Failure> {
        let ((criterion, of_length), (constraint, of_area)) =
            (interface_measure(body)?, self.area.value(body)?);
        let state = Derivatives { criterion: of_length, constraint: Some(of_area) };
        Ok(Values { criterion, constraint: Some(constraint), state })
    }
    fn derivatives(&self, _: &Arc<Cut<2>>, state: &mut Derivatives) -> Result<Derivatives, Failure> {
        Ok(state.clone())
    }
}

#[test]
fn a_disc_has_the_shortest_boundary() {
    let cells = 24;
    let mesh = square(cells, CellShape::Triangle);
    // A square of area 1 with a level set function that is far from a distance.
    let initial = level(&mesh, |x| 3.0 * (x[0].abs().max(x[1].abs()) - 0.5013));
    let problem = Bubble { area: LevelSetVolume { target: 1.0 } };
    let options = LevelSetOptions { iterations: 60, ..LevelSetOptions::new(2.0 / cells as f64) };
    let run = LevelSetDescent { problem: &problem, initial, options }.run(None, &mut |_| Ok(())).unwrap();
    let (length, shortest) = (run.values.criterion, 2.0 * PI.sqrt());
    println!("{length} {shortest} {:?} {:?}", run.values.constraint, run.state.finish);
    assert!(run.state.history.iter().any(|row| row.before_distance.is_some()));
    assert!(run.values.constraint.unwrap().abs() < 2e-3, "{:?}", run.values.constraint);
    assert!((length / shortest - 1.0).abs() < 4e-3, "{length} {shortest}");
    assert!(run.state.csv().lines().count() == run.state.history.len() + 1);
}

/// The second derivative of a perimeter is that of the product along Γ: with it a wavy circle becomes round in fewer steps.
#[test]
fn smoothing_along_the_interface_makes_a_boundary_even_sooner() {
    let cells = 32;
    let size = 2.0 / cells as f64;
    let mesh = square(cells, CellShape::Triangle);
    let wavy = |x: &[f64; 2]| x[0].hypot(x[1]) - 0.56 - 0.06 * (5.0 * x[1].atan2(x[0])).cos();
    let problem = Bubble { area: LevelSetVolume { target: 1.0 } };
    let steps_to_round = |interface_smoothing: f64| {
        let (iterations, largest_change) = (60, 0.25 * size);
        let own = LevelSetOptions::new(size);
        let options = LevelSetOptions { iterations, interface_smoothing, largest_change, ..own };
        let descent = LevelSetDescent { problem: &problem, initial: level(&mesh, wavy), options };
        let run = descent.run(None, &mut |_| Ok(())).unwrap();
        let is_round = |row: &LevelSetRow| {
            row.criterion < 1.001 * 2.0 * PI.sqrt() && row.constraint.is_some_and(|off| off.abs() < 1e-3)
        };
        run.state.history.iter().position(is_round).unwrap()
    };
    let [without, with] = [0.0, 0.5].map(steps_to_round);
    assert!(with < without, "{with} {without}");
}

/// The perimeter of a circle by the variation of densities, and a derivative that goes on where nodes change sides.
#[test]
fn smooth_perimeters_have_no_kinks() {
    let cells = 32;
    let mesh = square(cells, CellShape::Triangle);
    let phi = |radius: f64| level(&mesh, |x| (x[0] - 0.01).hypot(x[1] + 0.02) - radius);
    let space = phi(0.6).space().clone();
    let smooth = SmoothPerimeter::new(&space, vec![false; space.unknowns()]).unwrap();
    let value = |radius: f64| smooth.value(&Cut::by(&phi(radius)).unwrap()).unwrap();
    let (found, slopes) = value(0.6);
    assert!((found / (1.2 * PI) - 1.0).abs() < 0.02, "{found}");
    // φ + t has the radius 0.6 − t.
    let slope = -slopes.iter().sum::<f64>();
    let step = 1e-6;
    let difference = (value(0.6 + step).0 - value(0.6 - step).0) / (2.0 * step);
    assert!((slope / difference - 1.0).abs() < 1e-7, "{slope} {difference}");
    // A rough φ whose value at a node changes its sign: the slope of the length by it jumps, that of the variation goes on.
    let rough =
        level(&mesh, |x| x[0].hypot(x[1]) - 0.6 + 0.02 * (40.0 * x[0] + 1.0).sin() * (33.0 * x[1]).cos());
    let sizes: Vec<f64> = rough.values().iter().map(|value| value.abs()).collect();
    let node = (0..sizes.len()).min_by(|a, b| sizes[*a].total_cmp(&sizes[*b])).unwrap();
    let bodies = [1e-7, -1e-7].map(|value| {
        let mut values = rough.values().to_vec();
        values[node] = value;
        Cut::by(&Field::from_values(&space, values).unwrap()).unwrap()
    });
    let of_smooth = bodies.each_ref().map(|body| smooth.value(body).unwrap().1[node]);
    let of_length = bodies.each_ref().map(|body| interface_measure(body).unwrap().1[node]);
    println!("{found} {of_smooth:?} {of_length:?}");
    let jump = |slopes: [f64; 2]| (slopes[0] - slopes[1]).abs() / slopes[0].abs().max(slopes[1].abs());
    assert!(jump(of_smooth) < 1e-4 && jump(of_length) > 0.1);
    assert!(SmoothPerimeter::new(&space, vec![]).is_err());
}

#[test]
fn values_of_phi_are_controls_of_a_reduced_problem() {
    let mesh = square(12, CellShape::Triangle);
    let start = level(&mesh, |x| (x[0] - 0.1).hypot(1.3 * x[1]) - 0.611);
    let direction: Vec<f64> =
        start.space().positions().iter().map(|x| 1.0 + (3.0 * x[0]).sin() * x[1]).collect();
    let values = start.values().to_vec();
    let mut wells = LevelSetControls { problem: &Wells, start: start.clone() };
    let order = taylor_test(&mut wells, &values, &direction, 1e-2).unwrap().second_order().unwrap();
    assert!((order - 2.0).abs() < 0.05, "{order}");
    let problem = Bubble { area: LevelSetVolume { target: 1.0 } };
    let mut bubble = LevelSetControls { problem: &problem, start };
    let order = taylor_test(&mut bubble, &values, &direction, 1e-2).unwrap().second_order().unwrap();
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

#[test]
fn options_without_meaning_are_refused() {
    let mut descent = two_discs(8);
    descent.options.smoothing = -1.0;
    let error = descent.run(None, &mut |_| Ok(())).err().unwrap().to_string();
    assert_eq!(error, "smoothing = -1 is not possible: it must be positive");
    let mut descent = two_discs(8);
    descent.options.interface_smoothing = -1.0;
    let error = descent.run(None, &mut |_| Ok(())).err().unwrap().to_string();
    assert_eq!(error, "interface_smoothing = -1 is not possible: it must not be negative");
    let mut descent = two_discs(8);
    descent.options.iterations = 0;
    assert_eq!(descent.run(None, &mut |_| Ok(())).unwrap().state.finish, Some(StopReason::Iterations));
}
