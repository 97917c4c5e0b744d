//! Descent where the best shape is known: of all polygons with n corners and the same area the regular one has the shortest
//! perimeter, P² = 4 n tan(π/n) A.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::*;
use crate::constraints::Constraints;
use crate::element::CellShape;
use crate::mesh::{Mesh, annulus};
use crate::space::Space;

const CORNERS: usize = 12;

/// The perimeter of a plate with a fixed hole, whose area is given; or ill: with a derivative of the wrong sign, without a
/// solution once a node comes too far to the right.
struct Isoperimetric {
    area: Volume,
    sign: f64,
    no_farther_than: f64,
}

impl ShapeProblem<2> for Isoperimetric {
    type State = ();

    fn solve(&self, mesh: &Mesh<2>) -> Result<Values<()>, Failure> {
        if mesh.nodes().iter().any(|x| x[0] > self.no_farther_than) {
            return Err("too far to the right".into());
        }
        let criterion = perimeter(mesh, "outer")?;
        Ok(Values { criterion, constraint: Some(self.area.value(mesh)?), state: () })
    }

    fn derivatives(&self, movements: &Arc<Space<2>>, _: &mut ()) -> Result<Derivatives, Failure> {
        let values = perimeter_derivative(movements, "outer")?;
        let criterion = values.into_iter().map(|value| self.sign * value).collect();
        Ok(Derivatives { criterion, constraint: Some(self.area.derivative(movements)?) })
    }

    fn fix(&self, movements: &mut Constraints<2>) -> Result<(), Failure> {
        Ok(movements.fix("inner", |_| [0.0; 2])?)
    }
}

/// An oblong plate with unequal edges, with a twelve-cornered hole.
fn plate() -> Mesh<2> {
    let mesh = annulus(1.0, 2.0, 3, CORNERS, CellShape::Quadrilateral, 1).unwrap();
    let nodes = mesh.nodes().iter().map(|[x, y]| {
        let outwards = x.hypot(*y) - 1.0;
        [x * (1.0 + 0.3 * outwards) + 0.1 * outwards * y, y * (1.0 - 0.15 * outwards)]
    });
    mesh.with_nodes(nodes.collect()).unwrap()
}

fn problem(mesh: &Mesh<2>) -> Isoperimetric {
    let area = Volume { target: measured_volume(mesh).unwrap() };
    Isoperimetric { area, sign: 1.0, no_farther_than: f64::INFINITY }
}

fn options() -> DescentOptions {
    DescentOptions {
        iterations: 400,
        gradient_tolerance: 1e-7,
        decrease_tolerance: 0.0,
        constraint_tolerance: 1e-10,
        ..DescentOptions::new(0.1)
    }
}

#[test]
fn the_shortest_perimeter_is_the_regular_polygon() {
    let initial = plate();
    let problem = problem(&initial);
    let descent = Descent {
        problem: &problem,
        initial: initial.clone(),
        options: options(),
        pattern: None,
        wall: None,
        remesh: None,
    };
    let mut reports = 0;
    let best = descent
        .run(None, &mut |_| {
            reports += 1;
            Ok(())
        })
        .unwrap();
    let n = CORNERS as f64;
    let hole = 0.5 * n * (TAU / n).sin();
    let shortest = (4.0 * n * (PI / n).tan() * (problem.area.target + hole)).sqrt();
    let (start, end) = (best.state.history[0].criterion, best.values.criterion);
    println!("{start} to {end}, shortest {shortest}, in {} steps", best.state.iterations());
    assert_eq!(best.state.finish, Some(StopReason::Converged), "{:?}", best.state.history.last());
    assert!(start > 1.02 * shortest);
    assert!((end / shortest - 1.0).abs() < 1e-10, "{end} and {shortest}");
    assert!(best.values.constraint.unwrap().abs() < 1e-10);
    assert_eq!(reports, best.state.history.len() + 1, "the start, each step and the end are told");
    // All edges equally long.
    let corners: Vec<[f64; 2]> = (0..CORNERS)
        .map(|k| {
            let facet = best.mesh.facet_region("outer").unwrap()[k];
            let [a, b] = [0, 1].map(|end| {
                let local = best.mesh.cell_element(facet.cell as usize).facet_nodes(facet.local.into())[end];
                best.mesh.nodes()[best.mesh.cell(facet.cell as usize)[local] as usize]
            });
            [a[0] - b[0], a[1] - b[1]]
        })
        .collect();
    for edge in corners {
        assert!((edge[0].hypot(edge[1]) * n / shortest - 1.0).abs() < 1e-5);
    }
}

#[test]
fn every_step_keeps_armijos_promise() {
    let initial = plate();
    let problem = problem(&initial);
    let options = DescentOptions { iterations: 15, ..options() };
    let descent = Descent { problem: &problem, initial, options, pattern: None, wall: None, remesh: None };
    let best = descent.run(None, &mut |_| Ok(())).unwrap();
    assert_eq!(best.state.finish, Some(StopReason::Iterations));
    let history = &best.state.history;
    let penalty = 10.0 * history[0].criterion;
    for pair in history.windows(2) {
        let step = pair[1].step.as_ref().unwrap();
        let lagrangian = |row: &Row| {
            let c = row.constraint.unwrap();
            row.criterion + step.multiplier * c + 0.5 * penalty * c * c
        };
        let promised = step.factor * step.gradient_norm.powi(2);
        let decrease = lagrangian(&pair[0]) - lagrangian(&pair[1]);
        assert!(decrease >= 1e-4 * promised && promised > 0.0, "{decrease:e} of {promised:e}");
        assert!(step.longest_move <= 0.2 + 1e-12 && pair[1].quality > 0.1);
    }
    let csv = best.state.csv();
    assert_eq!(csv.lines().count(), 17);
    assert!(csv.lines().all(|line| line.split(',').count() == 12), "{csv}");
}

#[test]
fn a_descent_that_goes_on_is_the_one_that_was_not_interrupted() {
    let initial = plate();
    let problem = problem(&initial);
    let options = DescentOptions { iterations: 12, ..options() };
    let descent = Descent { problem: &problem, initial, options, pattern: None, wall: None, remesh: None };
    let mut written = Vec::new();
    let whole = descent
        .run(None, &mut |report| {
            let nothing = || serde_json::json!({});
            let checkpoint = Checkpoint::new(nothing(), nothing(), vec![], report.state.clone());
            written.push(serde_json::to_string(&checkpoint)?);
            Ok(())
        })
        .unwrap();
    for text in written {
        let checkpoint: Checkpoint = serde_json::from_str(&text).unwrap();
        let resumed = descent.run(Some(checkpoint.state), &mut |_| Ok(())).unwrap();
        assert_eq!(resumed.state, whole.state);
        assert!(resumed.mesh.nodes() == whole.mesh.nodes());
    }
    // More steps than before: it goes on.
    let options = DescentOptions { iterations: 14, ..descent.options.clone() };
    let longer = Descent { options, ..descent };
    let more = longer.run(Some(whole.state.clone()), &mut |_| Ok(())).unwrap();
    assert_eq!(more.state.iterations(), 14);
    assert_eq!(more.state.history[..13], whole.state.history[..]);
}

#[test]
fn what_goes_wrong_is_told() {
    let initial = plate();
    let run = |problem: &Isoperimetric, options: DescentOptions, from| {
        Descent { problem, initial: initial.clone(), options, pattern: None, wall: None, remesh: None }
            .run(from, &mut |_| Ok(()))
    };
    // A derivative of the wrong sign: no step decreases.
    let wrong = Isoperimetric { sign: -1.0, ..problem(&initial) };
    let finish = run(&wrong, options(), None).unwrap().state.finish;
    assert!(matches!(&finish, Some(StopReason::NoStep(why)) if why.contains("Lagrangian")), "{finish:?}");
    // Cells that must not get worse than they are.
    let quality = initial.quality().scaled_jacobian()[0];
    let strict = DescentOptions { least_quality: 2.0 * quality, ..options() };
    assert_eq!(run(&problem(&initial), strict, None).unwrap().state.finish, Some(StopReason::MeshQuality));
    // No solution at the start; options without meaning; a state of another mesh.
    let nowhere = Isoperimetric { no_farther_than: 0.0, ..problem(&initial) };
    let message =
        |result: Result<Optimised<(), 2>, ShapeOptimisationError>| result.err().unwrap().to_string();
    assert_eq!(message(run(&nowhere, options(), None)), "iteration 0: too far to the right");
    let meaningless = DescentOptions { penalty: 0.0, ..options() };
    assert_eq!(
        message(run(&problem(&initial), meaningless, None)),
        "penalty = 0 is not possible: it must be positive"
    );
    let other = DescentState { nodes: vec![0.0; 4], mesh: None, step: None, history: vec![], finish: None };
    let text = message(run(&problem(&initial), options(), Some(other)));
    assert!(text.starts_with("the state to go on from has 4 coordinates"), "{text}");
}

#[test]
fn cells_are_laid_out_anew_inside_the_same_boundary() {
    let initial = plate();
    // Inner nodes are shaken, the boundary moves.
    let shaken = initial.nodes().iter().enumerate().map(|(node, x)| {
        let radius = x[0].hypot(x[1]);
        let by = if (1.1..1.6).contains(&radius) { 0.06 * (7.0 * node as f64).sin() } else { 0.0 };
        [x[0] * 1.05 + by, x[1] * 0.97 - by]
    });
    let shaken = initial.with_nodes(shaken.collect()).unwrap();
    let laid = smoothed(&initial, &shaken, &InnerProduct::elasticity(0.0)).unwrap();
    assert!(laid.quality().scaled_jacobian()[0] > shaken.quality().scaled_jacobian()[0]);
    // An affine movement of the boundary takes the inside along.
    for (start, end) in initial.nodes().iter().zip(laid.nodes()) {
        assert!((end[0] - 1.05 * start[0]).abs() < 1e-12 && (end[1] - 0.97 * start[1]).abs() < 1e-12);
    }
    assert!((measured_volume(&laid).unwrap() / measured_volume(&shaken).unwrap() - 1.0).abs() < 1e-14);
}

/// Below a wall that it would cross at its place, the plate goes down until it is as round as without.
#[test]
fn nodes_slide_along_a_wall() {
    let initial = plate();
    let problem = problem(&initial);
    let height = 1.75;
    let clearance = |x: &[f64; 2]| Clearance { distance: height - x[1], away: [0.0, -1.0] };
    let wall = Wall { region: "outer".into(), clearance: &clearance };
    let options = DescentOptions { gradient_tolerance: 1e-4, ..options() };
    let free = Descent {
        problem: &problem,
        initial: initial.clone(),
        options,
        pattern: None,
        wall: None,
        remesh: None,
    };
    let highest = |mesh: &Mesh<2>| mesh.nodes().iter().map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max);
    assert!(highest(&initial) < height);
    let without = free.run(None, &mut |_| Ok(())).unwrap();
    assert!(highest(&without.mesh) > height + 0.1, "{}", highest(&without.mesh));
    let walled = Descent { wall: Some(wall), ..free };
    let mut most = f64::NEG_INFINITY;
    let best = walled
        .run(None, &mut |report| {
            most = most.max(highest(report.mesh));
            Ok(())
        })
        .unwrap();
    println!("{} with the wall, {} without", best.values.criterion, without.values.criterion);
    assert!(most < height + 1e-9 && highest(&best.mesh) > height - 1e-3, "{most}");
    assert!((best.values.criterion / without.values.criterion - 1.0).abs() < 1e-4);
    assert!(best.values.constraint.unwrap().abs() < 1e-6);
}
