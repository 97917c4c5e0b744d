//! Forms of nearly incompressible bodies: one energy, and ways to treat the change of volume.

use forms_fem::forms;

/// The nearly incompressible neo-Hookean material W = μ/2 (J^(−2/3) (tr C) − 3) + K/2 (J − 1)², J = det F; in two dimensions plane
/// strain, where tr C counts the stretch 1 out of the plane.
///
/// | unknowns | density | element |
/// | --- | --- | --- |
/// | u | [`energy_density`](fn@rubber::energy_density) | degree 2 or more, K/μ below 100 |
/// | u | [`averaged_density`](fn@rubber::averaged_density) | F-bar: quadrilaterals and hexahedra of degree 1 |
/// | u, p | [`averaged_mixed_density`](fn@rubber::averaged_mixed_density) | F-bar with one p per cell: the same solution in fewer steps |
/// | u, p | [`mixed_density`](fn@rubber::mixed_density) | MINI, P2/P1, Q2/P₋₁ |
/// | u, p, j | [`three_field_density`](fn@rubber::three_field_density) | Q2/P₋₁; with degree 0 the mean dilatation |
///
/// p is the mean of Cauchy's stress, negative where the body is pressed, and j is J − 1. Where p and j have the same discontinuous space, both
/// mixed forms have the same u and p.
#[forms]
pub mod rubber {
    use super::super::strains::{deformation_gradient, f_bar};

    /// The material.
    pub struct Data {
        /// μ, shear modulus \[stress\].
        #[doc(alias = "μ")]
        pub mu: Param,
        /// K, bulk modulus \[stress\].
        #[doc(alias = "K")]
        pub bulk_modulus: Param,
    }

    /// μ/2 (J^(−2/3) tr C − 3), the energy of the change of shape.
    #[doc(alias = "W_iso")]
    pub fn isochoric_density(F: Tensor) -> Scalar {
        mu / 2 * (pow(det(F), -2 / 3) * (inner(F, F) + 3 - D) - 3)
    }

    /// ∂W_iso/∂F = μ J^(−2/3) (F − tr C/3J cof F). It is written out, so that what is derived from it is smaller.
    #[doc(alias = "P_iso")]
    pub fn isochoric_piola(F: Tensor) -> Tensor {
        let J = det(F);
        mu * pow(J, -2 / 3) * (F - (inner(F, F) + 3 - D) / (3 * J) * cof(F))
    }

    /// K/2 j², the energy of the change of volume j = J − 1.
    #[doc(alias = "U")]
    pub fn volumetric_density(dilatation: Scalar) -> Scalar {
        bulk_modulus / 2 * sqr(dilatation)
    }

    /// W of a deformation gradient.
    #[doc(alias = "W")]
    pub fn density(F: Tensor) -> Scalar {
        isochoric_density(F) + volumetric_density(det(F) - 1)
    }

    /// P = ∂W/∂F.
    fn piola(F: Tensor) -> Tensor {
        isochoric_piola(F) + bulk_modulus * (det(F) - 1) * cof(F)
    }

    /// W of a displacement.
    pub fn energy_density(u: Vector) -> Scalar {
        density(deformation_gradient(u))
    }

    /// P = ∂W/∂F, the first Piola stress of a displacement.
    #[doc(alias = "P")]
    pub fn first_piola(u: Vector) -> Tensor {
        piola(deformation_gradient(u))
    }

    /// W_iso + p (J − 1) − p²/2K.
    pub fn mixed_density(u: Vector, p: Scalar) -> Scalar {
        let F = deformation_gradient(u);
        isochoric_density(F) + p * (det(F) - 1) - p * p / (2 * bulk_modulus)
    }

    /// W_iso + U(j) + p (J − 1 − j).
    pub fn three_field_density(u: Vector, p: Scalar, dilatation: Scalar) -> Scalar {
        let F = deformation_gradient(u);
        isochoric_density(F) + volumetric_density(dilatation) + p * (det(F) - 1 - dilatation)
    }

    /// P = ∂W_iso/∂F + p cof F, the first Piola stress of both mixed forms.
    #[doc(alias = "P")]
    pub fn mixed_piola(u: Vector, p: Scalar) -> Tensor {
        let F = deformation_gradient(u);
        isochoric_piola(F) + p * cof(F)
    }

    /// W(F̄) with `strains::f_bar`.
    pub fn averaged_density(u: Vector) -> Scalar {
        density(f_bar(u))
    }

    /// `averaged_density` with p for its pressure, W_iso(F̄) + p (det ⟨F⟩ − 1) − p²/2K. With one p in each cell the
    /// solution is that of F-bar in u, and Newton's method takes far fewer steps where K/μ is large.
    pub fn averaged_mixed_density(u: Vector, p: Scalar) -> Scalar {
        isochoric_density(f_bar(u)) + p * (det(mean(deformation_gradient(u))) - 1)
            - p * p / (2 * bulk_modulus)
    }

    /// ∂W_iso/∂F + p cof F at F̄.
    #[doc(alias = "P")]
    pub fn averaged_mixed_piola(u: Vector, p: Scalar) -> Tensor {
        let F = f_bar(u);
        isochoric_piola(F) + p * cof(F)
    }

    /// ∂W/∂F at F̄, the first Piola stress of F-bar.
    #[doc(alias = "P")]
    pub fn averaged_piola(u: Vector) -> Tensor {
        piola(f_bar(u))
    }
}
