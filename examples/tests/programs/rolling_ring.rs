//! The program `rolling_ring` as a user runs it, with few cells: a ring of rubber that friction brings to roll.

use std::process::{Command, Output};

use crate::printed::after;

fn run(arguments: &[&str], directory: &std::path::Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rolling_ring"));
    command.args(arguments).current_dir(directory).output().expect("the program starts")
}

/// Until it rolls: v is what its spin and a radius between that of its inner side and its own give, near the speed of a rigid ring, and
/// friction takes no more. While it slides the flat's forces are in the ratio κ = ½, so that the columns give the impulses alone.
#[test]
fn a_ring_that_slides_comes_to_roll() {
    let directory = tempfile::tempdir().expect("a directory");
    let output = run(&["12", "40", "16"], directory.path());
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (v, spin) = (after(&printed, "v = "), after(&printed, "−ω b = "));
    assert!((0.9..1.0).contains(&after(&printed, "of which v is ")), "{printed}");
    assert!((v / 0.18462 - 1.0).abs() < 0.1 && (spin / 0.18462 - 1.0).abs() < 0.1, "{printed}");
    assert!(after(&printed, "friction takes ") < 1e-3, "{printed}");

    let csv = std::fs::read_to_string(directory.path().join("out/rolling_ring.csv")).expect("the columns");
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let place = |name: &str| names.iter().position(|own| *own == name).expect("the column");
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|number| number.parse().expect("a number")).collect()).collect();
    let column = |name: &str| rows.iter().map(|row| row[place(name)]).collect::<Vec<f64>>();
    let (t, energy, friction) = (column("t"), column("energy"), column("friction"));
    let scale = column("kinetic")[0];
    for (energy_at, friction_at) in energy.iter().zip(&friction) {
        assert!((energy_at + friction_at - energy[0]).abs() < 1e-9 * scale);
    }
    // It falls freely by 0.2 under a weight of 0.02 per mass.
    let touching = column("force_y").iter().zip(&t).find(|(force, _)| **force > 0.0).map(|(_, t)| *t);
    assert!(touching.is_some_and(|t| (t - 20.0_f64.sqrt()).abs() < 0.03), "{touching:?}");
    let sliding = |t: f64| (4.6..8.0).contains(&t);
    let [along, pressing] = ["force_x", "force_y"].map(|name| {
        column(name).iter().zip(&t).filter(|(_, t)| sliding(**t)).map(|(force, _)| force).sum::<f64>()
    });
    assert!((along / pressing + 0.5).abs() < 1e-6, "{along} {pressing}");
    for picture in ["rolling_ring.png", "rolling_ring_course.png"] {
        let bytes = std::fs::read(directory.path().join("out").join(picture)).expect("a picture");
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000, "{picture}");
    }
}
