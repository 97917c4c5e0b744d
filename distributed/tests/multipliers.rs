//! Multipliers on own facets and means over them, on moving segments, on 1, 2 and 3 processes: the results of one process with the
//! solvers of `forms_fem`.

use forms_distributed::cases::mortar_block::MortarBlock;
use forms_distributed::cases::report::read;
use forms_fem::inverse::ReducedProblem;

mod programs;

use programs::mpirun;

const SAME: f64 = 1e-9;
const PROGRAM: &str = env!("CARGO_BIN_EXE_mortar_block");

fn told(processes: usize, arguments: &[&str]) -> String {
    let output = mpirun(processes, PROGRAM, arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?} on {processes}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

/// ‖a − b‖∞ / ‖b‖∞.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
}

/// The last states are the same. Where a path ends in the rounding of a line search it may take a step more.
fn check(name: &str, own: &str, method: &str) {
    let block = MortarBlock::of(name, 4, own == "slab").unwrap();
    let serial = block.drawn(name, None).unwrap();
    let force = serial.force;
    // κ p over a pressed block, whose tangential force is nearly κ times the normal one.
    assert!(force.abs() > 0.1, "friction holds the block back: {force}");
    for processes in [1, 2, 3] {
        let told = told(processes, &[name, own, method]);
        let found = read(&told);
        let more = difference(&found["steps"], &serial.steps);
        assert!(more < 0.2, "{name} on {own}, {processes}: {:?} for {:?}", found["steps"], serial.steps);
        let pairs = serial.fields.iter().zip(["u", "multipliers", "means"]);
        let mut compared: Vec<(&str, f64)> =
            pairs.map(|(field, of)| (of, difference(&found[of], field.values()))).collect();
        compared.push(("force", (found["force"][0] / force - 1.0).abs()));
        let most = found["iterations"].iter().copied().fold(0.0, f64::max);
        println!("{name} on {own} by {method}, {processes} processes: {compared:?}, {most} iterations");
        assert!(
            compared.iter().all(|(_, apart)| *apart < SAME),
            "{name} on {own}, {processes}: {compared:?}"
        );
    }
}

#[test]
fn means_on_segments_are_the_same() {
    check("means", "block", "direct");
    check("means", "slab", "gmres");
}

/// Facets of the slab are covered in part.
#[test]
fn multipliers_are_the_same_by_a_direct_solver() {
    for name in ["hats", "bernstein", "dual", "dual_of_bernstein"] {
        check(name, "block", "direct");
    }
    for name in ["hats", "dual"] {
        check(name, "slab", "direct");
    }
}

/// Over surfaces that are covered whole. Where a function comes to be faced by a sliver while its node sticks, stiffnesses are indefinite at an
/// iterate, and GMRES does not get through them.
#[test]
fn multipliers_are_the_same_by_gmres() {
    for name in ["hats", "bernstein", "dual"] {
        check(name, "block", "gmres");
    }
}

/// Adjoint states are solutions of transposed systems.
#[test]
fn gradients_of_histories_are_the_same() {
    for (name, own) in [("hats", "block"), ("dual", "slab")] {
        let block = MortarBlock::of(name, 4, own == "slab").unwrap();
        let traces = block.multipliers(name).unwrap();
        let mut history = block.history(&traces);
        let m = history.start();
        let serial = history.gradient(&m).unwrap();
        assert!(serial.gradient[0].abs() > 1e-4, "{:?}", serial.gradient);
        for processes in [1, 2, 3] {
            let told = told(processes, &[name, own, "gradient"]);
            let found = read(&told);
            let apart = [
                difference(&found["value"], &[serial.value]),
                difference(&found["gradient"], &serial.gradient),
            ];
            println!("{name} on {own}, {processes} processes: {apart:?}");
            assert!(apart.iter().all(|apart| *apart < SAME), "{name} on {own}, {processes}: {apart:?}");
        }
    }
}
