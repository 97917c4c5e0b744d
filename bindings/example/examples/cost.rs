//! Seconds of a value with its gradient in Rust, for comparison with `tests/cost.py`.

use std::error::Error;
use std::time::Instant;

use beam_on_ground::level;
use forms_bindings::{Parameters, ProblemThread};
use forms_fem::inverse::DifferentiableMap;

/// Microseconds of a call: the minimum over 200 calls.
fn microseconds(mut call: impl FnMut()) -> f64 {
    let timed = (0..200).map(|_| {
        let begun = Instant::now();
        call();
        begun.elapsed().as_secs_f64()
    });
    1e6 * timed.fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut beam = level(&mut Parameters::default())?;
    let m = beam.start();
    let mut moved = m.clone();
    let solved = microseconds(|| {
        moved[1] += 1e-9;
        beam.vjp(&moved, &[1.0]).expect("it has been solved before");
    });
    let known = microseconds(|| {
        beam.vjp(&moved, &[1.0]).expect("it has been solved before");
    });
    let thread = ProblemThread::open(level, Parameters::default())?;
    thread.value_and_gradient(m.clone())?;
    let asked = microseconds(|| {
        thread.value_and_gradient(m.clone()).expect("it has been solved before");
    });
    println!(
        "value and gradient: {solved:.1} µs; of the last controls {known:.2} µs, through the thread {asked:.2} µs"
    );
    Ok(())
}
