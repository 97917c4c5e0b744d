//! Closed forms of plane elasticity in the half-plane y > 0, by one holomorphic function Z of z = x + iy
//! (Westergaard's form with σ_xy = 0 on y = 0), with f = 0 and κ = 3 − 4ν:
//!
//! ```text
//! 2μ u_x = (κ−1)/2 Re Z̃ − y Im Z      σ_xx = Re Z − y Im Z′
//! 2μ u_y = (κ+1)/2 Im Z̃ − y Re Z      σ_yy = Re Z + y Im Z′
//! Z̃′ = Z                              σ_xy = −y Re Z′
//! ```
#![allow(dead_code, reason = "each test uses a part")]

use nalgebra::Complex;

/// An isotropic material in plane strain.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// λ \[stress\].
    pub lambda: f64,
    /// μ \[stress\].
    pub mu: f64,
}

impl Material {
    /// From Young's modulus \[stress\] and Poisson's ratio.
    pub fn new(young: f64, poisson: f64) -> Self {
        let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        Material { lambda, mu: young / (2.0 * (1.0 + poisson)) }
    }

    /// κ = 3 − 4ν = (λ + 3μ)/(λ + μ).
    pub fn kappa(self) -> f64 {
        (self.lambda + 3.0 * self.mu) / (self.lambda + self.mu)
    }
}

/// The function Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Potential {
    /// Z = i c √z: contact for x < 0 with σ_yy = −c √r, the gap (κ+1) c r^{3/2} / (6μ) for x > 0.
    SignoriniTransition(f64),
    /// Z = i c / √z: p_n = 0 for x < 0, σ_n = 0 for x > 0.
    AdjointTransition(f64),
    /// Z = 4z³ + 3z²: p_n = 0 on all of y = 0.
    Smooth,
}

/// A displacement (or adjoint state) with its gradient and stress.
#[derive(Clone, Copy, Debug)]
pub struct HalfPlaneField {
    /// The material.
    pub material: Material,
    /// Z.
    pub potential: Potential,
}

impl HalfPlaneField {
    /// (Z, Z′, Z̃) at a point.
    fn functions(&self, x: &[f64; 2]) -> [Complex<f64>; 3] {
        // −0 would turn the branch of the root.
        let z = Complex::new(x[0], x[1].max(0.0));
        let i = Complex::i();
        match self.potential {
            Potential::SignoriniTransition(c) => {
                let root = z.sqrt();
                [i * c * root, i * (0.5 * c) / root, i * (2.0 / 3.0 * c) * z * root]
            }
            Potential::AdjointTransition(c) => {
                let root = z.sqrt();
                [i * c / root, -i * (0.5 * c) / (z * root), i * (2.0 * c) * root]
            }
            Potential::Smooth => {
                let square = z * z;
                [4.0 * z * square + 3.0 * square, 12.0 * square + 6.0 * z, square * square + z * square]
            }
        }
    }

    /// u.
    pub fn displacement(&self, x: &[f64; 2]) -> [f64; 2] {
        let (kappa, twice_mu, y) = (self.material.kappa(), 2.0 * self.material.mu, x[1].max(0.0));
        let [value, _, primitive] = self.functions(x);
        // y Z → 0 at the transition, where Z of the adjoint has a pole.
        let [real, imaginary] = if y == 0.0 { [0.0; 2] } else { [y * value.re, y * value.im] };
        [
            (0.5 * (kappa - 1.0) * primitive.re - imaginary) / twice_mu,
            (0.5 * (kappa + 1.0) * primitive.im - real) / twice_mu,
        ]
    }

    /// ∇u, component × direction.
    pub fn gradient(&self, x: &[f64; 2]) -> [[f64; 2]; 2] {
        let (kappa, twice_mu, y) = (self.material.kappa(), 2.0 * self.material.mu, x[1]);
        let [value, slope, _] = self.functions(x);
        [
            [
                (0.5 * (kappa - 1.0) * value.re - y * slope.im) / twice_mu,
                (-0.5 * (kappa + 1.0) * value.im - y * slope.re) / twice_mu,
            ],
            [
                (0.5 * (kappa + 1.0) * value.im - y * slope.re) / twice_mu,
                (0.5 * (kappa - 1.0) * value.re + y * slope.im) / twice_mu,
            ],
        ]
    }

    /// σ.
    pub fn stress(&self, x: &[f64; 2]) -> [[f64; 2]; 2] {
        let [value, slope, _] = self.functions(x);
        let y = x[1];
        let shear = -y * slope.re;
        [[value.re - y * slope.im, shear], [shear, value.re + y * slope.im]]
    }

    /// σ n on a vertical side, n = (sign x, 0).
    pub fn side_traction(&self, x: &[f64; 2]) -> [f64; 2] {
        let stress = self.stress(x);
        [stress[0][0] * x[0].signum(), stress[1][0] * x[0].signum()]
    }
}
