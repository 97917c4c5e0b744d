//! Signs of a tangent's eigenvalues: what tells stable from unstable, and bifurcations from regular points.

use crate::linear_algebra::Sign;

/// Knowledge of the signs of a tangent's eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inertia {
    /// The number of negative eigenvalues of a symmetric tangent. Zero for a stable equilibrium; under multipliers their number is added.
    NegativeEigenvalues(usize),
    /// The sign of the determinant of an unsymmetric tangent, as with friction. Two eigenvalues that change their sign together
    /// are not seen.
    Determinant(Sign),
    /// The tangent is singular up to rounding.
    Singular,
}

impl Inertia {
    /// The determinant's sign, 1 or −1; none where the tangent is singular.
    pub fn determinant_sign(self) -> Option<f64> {
        match self {
            Inertia::NegativeEigenvalues(count) => Some(if count % 2 == 0 { 1.0 } else { -1.0 }),
            Inertia::Determinant(Sign::Positive) => Some(1.0),
            Inertia::Determinant(Sign::Negative) => Some(-1.0),
            Inertia::Singular => None,
        }
    }

    /// Eigenvalues whose sign differs from that of another tangent; of determinants zero or one.
    pub(super) fn changes(self, other: Inertia) -> usize {
        match (self, other) {
            (Inertia::NegativeEigenvalues(count), Inertia::NegativeEigenvalues(other)) => {
                count.abs_diff(other)
            }
            _ => usize::from(self.determinant_sign() != other.determinant_sign()),
        }
    }
}
