//! The program `rolling_wheel` as a user runs it, with few cells, and its problem: derivatives by φ, one position, threads.

use std::process::Command;

use forms_contact::Adjoint;
use forms_contact::rolling::RollingCriterion;
use forms_examples::level_set::wheel::{Rolling, Wheel, round_holes, sector_wave};
use forms_fem::cut::Cut;
use forms_fem::inverse::reduced_problem::taylor_test;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{LevelSetControls, LevelSetProblem};

const CELLS: usize = 8;

/// All terms of the criterion, over three positions.
fn with_all_terms() -> Rolling {
    let criterion = RollingCriterion { exponent: 3.0, unevenness: 40.0, length: 7.85, variance: 5.0 };
    Rolling { criterion, ..Rolling::over_sector(3) }
}

/// Every term of J over three positions, with one factor for states and adjoint states.
#[test]
fn the_derivative_of_several_positions_is_exact() {
    let wheel = Wheel::rolling(CELLS, &with_all_terms()).unwrap().with_length();
    let phi = Field::interpolate(&wheel.scalars, round_holes).unwrap();
    let body = Cut::by(&phi).unwrap();
    let mut values = wheel.solve(&body).unwrap();
    let gradient = wheel.derivatives(&body, &mut values.state).unwrap().criterion;
    assert_eq!(values.state.solver.report().factorisations, 1);
    let direction: Vec<f64> = phi.space().positions().iter().map(sector_wave).collect();
    let slope: f64 = gradient.iter().zip(&direction).map(|(by, along)| by * along).sum();
    let at = |step: f64| {
        let moved = phi.values().iter().zip(&direction).map(|(phi, along)| phi + step * along).collect();
        let body = Cut::by(&Field::from_values(phi.space(), moved).unwrap()).unwrap();
        wheel.solve(&body).unwrap().criterion
    };
    let difference = |step: f64| (at(step) - at(-step)) / (2.0 * step);
    let extrapolated = (4.0 * difference(1e-5) - difference(2e-5)) / 3.0;
    assert!((slope / extrapolated - 1.0).abs() < 1e-8, "{slope} {extrapolated}");
    let mut controls = LevelSetControls { problem: &wheel, start: phi.clone() };
    let report = taylor_test(&mut controls, phi.values(), &direction, 1e-4).unwrap();
    assert!((report.second_order().unwrap() - 2.0).abs() < 0.05, "{report:?}");
}

/// One position with θ = −1 is the wheel of Figure 6, and a sector of the way leads to the same J. Results have the same digits on one
/// thread and on two.
#[test]
fn positions_agree_with_what_is_known() {
    let solve = |wheel: &Wheel| {
        let phi = Field::interpolate(&wheel.scalars, round_holes).unwrap();
        let body = Cut::by(&phi).unwrap();
        let mut values = wheel.solve(&body).unwrap();
        let by_phi = wheel.derivatives(&body, &mut values.state).unwrap().criterion;
        (values.criterion, by_phi)
    };
    let one = Rolling { theta: -1.0, contact_degree: None, ..Rolling::over_sector(1) };
    let known = solve(&Wheel::new(CELLS, Adjoint::Discrete).unwrap());
    assert_eq!(solve(&Wheel::rolling(CELLS, &one).unwrap()), known);

    let all = with_all_terms();
    let threads = |count| solve(&Wheel::rolling(CELLS, &all).unwrap().with_threads(Threads::new(count)));
    let (before, by_phi) = threads(1);
    assert_eq!((before, by_phi), threads(2));

    let mut turned = all.clone();
    turned.positions.iter_mut().for_each(|ground| ground.angle += std::f64::consts::TAU / 24.0);
    let (after, _) = solve(&Wheel::rolling(CELLS, &turned).unwrap());
    assert!((after / before - 1.0).abs() < 1e-10, "{before} {after}");
}

/// The number after some words.
fn after(printed: &str, words: &str) -> f64 {
    let rest = printed.split(words).nth(1).unwrap_or_else(|| panic!("`{words}`: {printed}"));
    let number: String = rest.chars().take_while(|c| c.is_ascii_digit() || "+-.e".contains(*c)).collect();
    number.parse().unwrap_or_else(|error| panic!("`{words}` {number}: {error}"))
}

#[test]
fn holes_of_a_coarse_wheel_roll_more_evenly() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut command = Command::new(env!("CARGO_BIN_EXE_rolling_wheel"));
    command.args([
        "--cells",
        "8",
        "--positions",
        "3",
        "--compared",
        "6",
        "--steps",
        "6",
        "--last-steps",
        "2",
    ]);
    let output = command.arg("--out").arg(directory.path()).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");
    let (slope, difference) = (after(&printed, "dJ along a wave "), after(&printed, "by differences "));
    assert!((slope / difference - 1.0).abs() < 1e-6, "{printed}");
    assert!(after(&printed, "turned by a sector ").abs() < 1e-10, "{printed}");
    assert!(after(&printed, "one solver: ") == 1.0 && after(&printed, "one by one: ") >= 3.0, "{printed}");
    let row = |name: &str| -> Vec<f64> {
        let start = format!("| {name} |");
        let row = printed.lines().find(|line| line.starts_with(&start)).expect("its row");
        row.split('|').filter_map(|cell| cell.trim().parse().ok()).collect()
    };
    let (one, rolling) = (row("one position"), row("rolling"));
    // J, the range of W and that of the reaction.
    assert!(rolling[0] < one[0] && rolling[2] < one[2] && rolling[4] < one[4], "{printed}");
    for picture in ["rolling_wheel.png", "rolling_wheel_animation.png"] {
        let bytes = std::fs::read(directory.path().join(picture)).expect("a picture");
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000, "{picture}");
    }
}
