//! Products with the Jacobian compared with central differences, and with one another.

use beam_on_ground::{deflection, level};
use forms_bindings::Parameters;
use forms_fem::inverse::DifferentiableMap;

const STEP: f64 = 3e-5;

/// A ground and a direction in which no point changes its state within the step.
fn ground(start: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let m = start.iter().enumerate().map(|(k, m)| m * (1.0 + 0.3 * (1.3 * k as f64).sin())).collect();
    (m, (0..start.len()).map(|k| (0.7 * k as f64 + 0.2).cos() * start[k]).collect())
}

fn check(map: &mut impl DifferentiableMap, accuracy: f64) {
    let (m, direction) = ground(&map.start());
    let moved = |step: f64| m.iter().zip(&direction).map(|(m, along)| m + step * along).collect::<Vec<_>>();
    let (above, below) = (map.value(&moved(STEP)).unwrap(), map.value(&moved(-STEP)).unwrap());
    let differences: Vec<f64> =
        above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * STEP)).collect();
    let along = map.jvp(&m, &direction).unwrap();
    let size = differences.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    assert!(size > 0.0);
    for (along, difference) in along.iter().zip(&differences) {
        let error = (along - difference).abs() / size;
        println!("{along:.12e} and {difference:.12e} by differences: {error:.1e}");
        assert!(error < accuracy);
    }
    // wᵀ (F′ δ) = (F′ᵀ w)ᵀ δ.
    let w: Vec<f64> = (0..along.len()).map(|k| 1.0 + (k as f64).sin()).collect();
    let product = map.vjp(&m, &w).unwrap();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (one, other) = (dot(&w, &along), dot(&product, &direction));
    assert!((one - other).abs() < 1e-12 * size * w.len() as f64, "{one} is not {other}");
}

#[test]
fn the_gradient_of_the_criterion() {
    check(&mut level(&mut Parameters::default()).unwrap(), 1e-8);
}

#[test]
fn the_jacobian_of_the_readings() {
    check(&mut deflection(&mut Parameters::default()).unwrap(), 1e-8);
}
