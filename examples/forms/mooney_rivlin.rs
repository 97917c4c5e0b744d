//! Finite strain with two invariants, stated by its energy.

use forms_fem::prelude::*;

/// A compressible Mooney-Rivlin solid; in two dimensions in plane strain.
#[forms]
pub mod solid {
    /// The three moduli \[stress\].
    pub struct Data {
        /// c₁, of the first invariant.
        pub c1: Param,
        /// c₂, of the second.
        pub c2: Param,
        /// κ, of the change of volume.
        pub kappa: Param,
    }

    /// Ω, undeformed.
    #[cells]
    pub struct Omega;

    /// c₁ (J^(−2/3) I₁ − 3) + c₂ (J^(−4/3) I₂ − 3) + κ/2 (J − 1)². What lies across the plane is not stretched.
    fn density(F: Tensor) -> Scalar {
        let across = 3 - D;
        let C = transpose(F) * F;
        let J = det(F);
        let I1 = tr(C) + across;
        let I2 = (pow(I1, 2) - inner(C, C) - across) / 2;
        c1 * (pow(J, -2 / 3) * I1 - 3) + c2 * (pow(J, -4 / 3) * I2 - 3) + kappa / 2 * pow(J - 1, 2)
    }

    /// ∫ ψ(I + ∇u).
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, density(I + grad(u)))
    }

    /// The first Piola-Kirchhoff stress, ∂ψ/∂F.
    pub fn stress(u: State<Vector>) -> Tensor {
        let F = I + grad(u);
        diff(density(F), F)
    }
}
