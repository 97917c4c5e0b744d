//! Displacements of half-spaces under a force near the origin: after Flamant in the plane, after Boussinesq and Cerruti in space.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::hertz::{POISSON, YOUNG};

/// G \[MPa\].
pub const SHEAR_MODULUS: f64 = YOUNG / (2.0 * (1.0 + POISSON));

/// A traction over a strip |x| < a of the boundary of the half-plane y > 0, as seen from afar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    /// Its resultant \[force per length\].
    pub force: f64,
    /// Four times its second moment over its resultant: a² where the traction is p0 √(1 − x²/a²) \[length²\].
    pub spread: f64,
}

impl Strip {
    /// Re and Im of i·f and of i·f′ with f = ln z − iπ/2 − a²/8z², the first terms of the traction's potential.
    fn potential(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        // −0 lies on the wrong side of the cut.
        let (r, angle) = (x.hypot(y), (y + 0.0).atan2(x));
        let spread = self.spread / (r * r);
        let real = r.ln() - spread * (2.0 * angle).cos() / 8.0;
        let imaginary = angle - FRAC_PI_2 + spread * (2.0 * angle).sin() / 8.0;
        let slope_real = (angle.cos() + spread * (3.0 * angle).cos() / 4.0) / r;
        let slope_imaginary = -(angle.sin() + spread * (3.0 * angle).sin() / 4.0) / r;
        let scale = self.force / PI;
        // The potential is −(P/π) i f.
        [[scale * imaginary, -scale * real], [scale * slope_imaginary, -scale * slope_real]]
    }

    /// Displacement where the traction is normal and pushes into the half-plane, y > 0.
    pub fn pushed(&self, at: [f64; 2]) -> [f64; 2] {
        let [potential, slope] = self.potential(at);
        let y = at[1];
        [
            ((1.0 - 2.0 * POISSON) * potential[0] - y * slope[1]) / (2.0 * SHEAR_MODULUS),
            (2.0 * (1.0 - POISSON) * potential[1] - y * slope[0]) / (2.0 * SHEAR_MODULUS),
        ]
    }

    /// Displacement where the traction is tangential, along x.
    pub fn dragged(&self, at: [f64; 2]) -> [f64; 2] {
        let [potential, slope] = self.potential(at);
        let y = at[1];
        [
            (2.0 * (1.0 - POISSON) * potential[1] + y * slope[0]) / (2.0 * SHEAR_MODULUS),
            (-(1.0 - 2.0 * POISSON) * potential[0] - y * slope[1]) / (2.0 * SHEAR_MODULUS),
        ]
    }
}

/// Displacement of the boundary of the half-plane in the middle of p0 √(1 − x²/a²), along that traction.
pub(super) fn in_the_middle(force: f64, reach: f64) -> f64 {
    (1.0 - POISSON) / SHEAR_MODULUS * force / PI * ((2.0 / reach).ln() + 0.5)
}

/// Displacement \[length\] of the half-space z > 0 under a force at the origin along z (Boussinesq), at a point with z ≥ 0 that is not the origin.
pub fn pushed(force: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let r = (x * x + y * y + z * z).sqrt();
    let scale = force / (4.0 * PI * SHEAR_MODULUS);
    let aside = z / r.powi(3) - (1.0 - 2.0 * POISSON) / (r * (r + z));
    [x * aside, y * aside, z * z / r.powi(3) + 2.0 * (1.0 - POISSON) / r].map(|u| scale * u)
}

/// Displacement \[length\] of the half-space z > 0 under a force at the origin along x (Cerruti; Johnson 1985, equation 3.75), at a point with z ≥ 0
/// that is not the origin.
pub fn dragged(force: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let r = (x * x + y * y + z * z).sqrt();
    let scale = force / (4.0 * PI * SHEAR_MODULUS);
    let (less, below) = (1.0 - 2.0 * POISSON, r + z);
    let aside = x / r.powi(3) - less * x / (r * below * below);
    [
        scale * (1.0 / r + less / below + x * aside),
        scale * y * aside,
        scale * (x * z / r.powi(3) + less * x / (r * below)),
    ]
}
