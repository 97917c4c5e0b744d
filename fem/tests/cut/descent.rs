//! Descents on level set functions: bodies that merge, the shortest boundary of an area, Taylor tests.

use std::f64::consts::PI;

use forms_fem::cut::Cut;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{
    LevelSetControls, LevelSetDescent, LevelSetOptions, LevelSetProblem, LevelSetState, LevelSetVolume,
    interface_measure,
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

#[test]
fn interrupted_descents_end_with_the_same_bits() {
    let settings = json!({ "cells": 16 });
    let descent = two_discs(16);
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
    descent.options.iterations = 0;
    assert_eq!(descent.run(None, &mut |_| Ok(())).unwrap().state.finish, Some(StopReason::Iterations));
}
