//! Boussinesq's and Cerruti's displacements: the tractions on a half sphere balance the force, the boundary carries none.

use std::f64::consts::PI;

use forms_contact::half_spaces::far_field::{SHEAR_MODULUS, dragged, pushed};
use forms_contact::hertz::POISSON;

/// The stress of a displacement at a point, by differences of fourth order.
fn stress(displacement: impl Fn([f64; 3]) -> [f64; 3], at: [f64; 3]) -> [[f64; 3]; 3] {
    let step = 1e-3;
    let moved = |axis: usize, by: f64| {
        let mut x = at;
        x[axis] += by * step;
        displacement(x)
    };
    let slope = |i: usize, j: usize| {
        let difference = |by: f64| moved(j, by)[i] - moved(j, -by)[i];
        (8.0 * difference(1.0) - difference(2.0)) / (12.0 * step)
    };
    let lambda = 2.0 * SHEAR_MODULUS * POISSON / (1.0 - 2.0 * POISSON);
    let trace: f64 = (0..3).map(|k| slope(k, k)).sum();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let spread = if i == j { lambda * trace } else { 0.0 };
            spread + SHEAR_MODULUS * (slope(i, j) + slope(j, i))
        })
    })
}

/// The tractions on a half sphere around the origin have the force as their resultant, and the boundary carries none.
fn carries(displacement: impl Fn([f64; 3]) -> [f64; 3] + Copy, force: [f64; 3]) {
    let (rings, parts) = (40, 60);
    let mut sum = [0.0; 3];
    for ring in 0..rings {
        // The middle of a ring of equal height: all patches have one area.
        let z = (f64::from(ring) + 0.5) / f64::from(rings);
        let radius = (1.0 - z * z).sqrt();
        for part in 0..parts {
            let angle = 2.0 * PI * (f64::from(part) + 0.5) / f64::from(parts);
            let normal = [radius * angle.cos(), radius * angle.sin(), z];
            let sigma = stress(displacement, normal);
            let area = 2.0 * PI / f64::from(rings * parts);
            for i in 0..3 {
                sum[i] += area * (0..3).map(|j| sigma[i][j] * normal[j]).sum::<f64>();
            }
        }
    }
    for (found, force) in sum.iter().zip(force) {
        // What is outside pulls back; the sum over rings is of second order.
        assert!((found + force).abs() < 2e-3, "{sum:?} is not {force}");
    }
    let sigma = stress(displacement, [0.6, 0.7, 0.0]);
    assert!(sigma.iter().all(|row| row[2].abs() < 1e-8), "{sigma:?}");
}

#[test]
fn forces_on_a_half_space_in_space() {
    carries(|x| pushed(1.0, x), [0.0, 0.0, 1.0]);
    carries(|x| dragged(1.0, x), [1.0, 0.0, 0.0]);
}
