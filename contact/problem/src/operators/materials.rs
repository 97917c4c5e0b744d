//! Forms of materials: measures of strain, stresses and energies.

use forms_fem::forms;

/// Measures of strain.
#[forms]
pub mod strains {
    /// ε(w) = (∇w + ∇wᵀ)/2.
    #[doc(alias = "ε")]
    pub fn strain(w: Vector) -> Tensor {
        eps(w)
    }

    /// F = I + ∇u.
    #[doc(alias = "F")]
    pub fn deformation_gradient(u: Vector) -> Tensor {
        I + grad(u)
    }

    /// C = FᵀF.
    #[doc(alias = "C")]
    pub fn right_cauchy_green(u: Vector) -> Tensor {
        let F = deformation_gradient(u);
        transpose(F) * F
    }

    /// E = (C − I)/2.
    #[doc(alias = "E")]
    pub fn green_lagrange(u: Vector) -> Tensor {
        (right_cauchy_green(u) - I) / 2
    }

    /// F̄ = (det ⟨F⟩ / det F)^(1/D) F: F with the change of volume of its mean over the cell (F-bar). Nearly incompressible
    /// quadrilaterals and hexahedra of degree 1 do not lock with it; on simplices of degree 1 it is F. In place of F in an
    /// energy density, `density(f_bar(u))`, or in a stress.
    #[doc(alias = "F̄")]
    pub fn f_bar(u: Vector) -> Tensor {
        let F = deformation_gradient(u);
        pow(det(mean(F)) / det(F), 1 / D) * F
    }

    /// ε̄ = ε + (⟨div w⟩ − div w)/D I, which has the cell's mean in place of div w (B-bar): [`f_bar()`] at small strains.
    #[doc(alias = "ε̄")]
    pub fn strain_bar(w: Vector) -> Tensor {
        eps(w) + (mean(div(w)) - div(w)) / D * I
    }
}

/// Isotropic linear elasticity; in two dimensions plane strain.
#[forms]
pub mod linear_elastic {
    /// Lamé's parameters.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ, shear modulus \[stress\].
        pub mu: Param,
    }

    /// σ(w) = 2μ ε(w) + λ tr ε(w) I.
    #[doc(alias = "σ")]
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }

    /// ½ σ(w):ε(w), per volume.
    pub fn energy_density(w: Vector) -> Scalar {
        inner(stress(w), eps(w)) / 2
    }

    /// Von Mises stress in plane strain (2D, with σ_zz = λ tr ε) or in 3D: √(3/2 s:s).
    #[doc(alias = "σ_vM")]
    pub fn von_mises(w: Vector) -> Scalar {
        let out_of_plane = if D < 3 { lambda * tr(eps(w)) } else { 0 };
        let mean = (tr(stress(w)) + out_of_plane) / 3;
        let in_plane = stress(w) - mean * I;
        let rest = if D < 3 { pow(out_of_plane - mean, 2) } else { 0 };
        sqrt(1.5 * (inner(in_plane, in_plane) + rest))
    }
}

/// The St Venant–Kirchhoff material: linear between the Green–Lagrange strain and the second Piola stress. For large
/// rotations and small strains; it softens without bound in compression.
#[forms]
pub mod st_venant_kirchhoff {
    pub use super::linear_elastic::Data;
    use super::strains::{deformation_gradient, green_lagrange};

    /// W = μ E:E + λ/2 (tr E)², per reference volume.
    pub fn energy_density(u: Vector) -> Scalar {
        let E = green_lagrange(u);
        mu * inner(E, E) + lambda / 2 * pow(tr(E), 2)
    }

    /// S = 2μ E + λ tr E I, the second Piola stress.
    #[doc(alias = "S")]
    pub fn second_piola(u: Vector) -> Tensor {
        let E = green_lagrange(u);
        2 * mu * E + lambda * tr(E) * I
    }

    /// P = F S, the first Piola stress.
    #[doc(alias = "P")]
    pub fn first_piola(u: Vector) -> Tensor {
        deformation_gradient(u) * second_piola(u)
    }
}

/// The compressible neo-Hookean material with W = μ/2 (tr C − D − 2 ln J) + λ/2 (ln J)²; in two dimensions plane strain.
#[forms]
pub mod neo_hookean {
    pub use super::linear_elastic::Data;
    use super::strains::deformation_gradient;

    /// W of a deformation gradient: that of a displacement, or [`f_bar`](fn@super::strains::f_bar). P is `diff(density(F), F)`.
    #[doc(alias = "W")]
    pub fn density(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * pow(ln(J), 2)
    }

    /// W, per reference volume.
    pub fn energy_density(u: Vector) -> Scalar {
        density(deformation_gradient(u))
    }

    /// P = ∂W/∂F, the first Piola stress.
    #[doc(alias = "P")]
    pub fn first_piola(u: Vector) -> Tensor {
        let F = deformation_gradient(u);
        diff(density(F), F)
    }

    /// σ = P Fᵀ / J, Cauchy's stress.
    #[doc(alias = "σ")]
    pub fn cauchy_stress(u: Vector) -> Tensor {
        let F = deformation_gradient(u);
        first_piola(u) * transpose(F) / det(F)
    }
}
