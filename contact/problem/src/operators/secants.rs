//! Stresses of a material between the two ends of a step, whose work over the step is what the material's energy gains.

use forms_fem::forms;

/// The plane neo-Hookean material between the displacements at the two ends of a step: P* with P*:(F₁ − F₀) = W(F₁) − W(F₀), a discrete
/// gradient (Gonzalez 2000, Exact energy and momentum conserving algorithms for general models in nonlinear elasticity, Comput.
/// Methods Appl. Mech. Eng. 190) in closed form. In the plane det F is quadratic, so that J₁ − J₀ = cof F_m:(F₁ − F₀) with the mean F_m
/// of the ends, and with the quotient f* of differences of f(J) = −μ ln J + λ/2 (ln J)² it is P* = μ F_m + f* cof F_m. P* F_mᵀ is
/// symmetric, so that angular momentum stays, too.
#[forms(dimension = 2)]
pub mod neo_hookean_secant {
    pub use super::super::linear_elastic::Data;
    use super::super::strains::deformation_gradient;

    /// (ln b − ln a)/(b − a), by the series of artanh where a and b are near each other.
    fn mean_inverse(a: Scalar, b: Scalar) -> Scalar {
        let y = (b - a) / (a + b);
        let s = sqr(y);
        let series = 1 + s * (1 / 3 + s * (1 / 5 + s * (1 / 7 + s * (1 / 9 + s * (1 / 11 + s / 13)))));
        if s < 0.01 { 2 * series / (a + b) } else { (ln(b) - ln(a)) / (b - a) }
    }

    /// cof A, which is linear in the plane.
    fn cofactor(A: Tensor) -> Tensor {
        tr(A) * I - transpose(A)
    }

    fn mean_gradient(before: Vector, after: Vector) -> Tensor {
        (deformation_gradient(before) + deformation_gradient(after)) / 2
    }

    /// P*, the stress of the step.
    pub fn mean_stress(before: Vector, after: Vector) -> Tensor {
        let F = mean_gradient(before, after);
        let a = det(deformation_gradient(before));
        let b = det(deformation_gradient(after));
        mu * F + mean_inverse(a, b) * (lambda / 2 * (ln(a) + ln(b)) - mu) * cofactor(F)
    }

    /// S with S(F₁ − F₀) = P(F₁) − P(F₀), linear in the gradient H: the quotient of differences of P.
    pub fn stress_secant(before: Vector, after: Vector, H: Tensor) -> Tensor {
        let cofactor_of_mean = cofactor(mean_gradient(before, after));
        let a = det(deformation_gradient(before));
        let b = det(deformation_gradient(after));
        // P = μ F + f'(J) cof F with f' = (λ ln J − μ)/J.
        let of_a = lambda * ln(a) - mu;
        let of_b = lambda * ln(b) - mu;
        let slope = lambda * mean_inverse(a, b) * (1 / a + 1 / b) / 2 - (of_a + of_b) / (2 * a * b);
        mu * H
            + (of_a / a + of_b / b) / 2 * cofactor(H)
            + slope * inner(cofactor_of_mean, H) * cofactor_of_mean
    }
}
