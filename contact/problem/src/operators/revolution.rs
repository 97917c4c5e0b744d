//! Forms of bodies of revolution in the (r, z) plane.

use forms_fem::forms;

/// Isotropic linear elasticity with axial symmetry: x = (r, z), no displacement around the axis. Integrals get the weight 2π r, so that forces and
/// energies are those of the whole body. The displacement along r is zero on the axis.
#[forms(dimension = 2)]
pub mod axial {
    pub use super::super::linear_elastic::Data;

    /// 2π r, the length of a point's circle.
    pub fn circumference() -> Scalar {
        6.283185307179586 * x[0]
    }

    /// w_r/r, the strain around the axis.
    #[doc(alias = "ε_θ")]
    pub fn hoop_strain(w: Vector) -> Scalar {
        w[0] / x[0]
    }

    /// The stress in the (r, z) plane, 2μ ε(w) + λ (div w + w_r/r) I.
    #[doc(alias = "σ")]
    pub fn meridian_stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * (div(w) + hoop_strain(w)) * I
    }

    /// The stress around the axis, 2μ w_r/r + λ (div w + w_r/r).
    #[doc(alias = "σ_θ")]
    pub fn hoop_stress(w: Vector) -> Scalar {
        2 * mu * hoop_strain(w) + lambda * (div(w) + hoop_strain(w))
    }

    /// 2π r (σ(u):ε(v) + σ_θ(u) v_r/r), whose integral over the plane is the work of the stresses in the body.
    pub fn internal_work(u: Vector, v: Vector) -> Scalar {
        circumference() * (inner(meridian_stress(u), eps(v)) + hoop_stress(u) * hoop_strain(v))
    }
}
