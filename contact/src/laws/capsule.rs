//! Friction with a round rigid obstacle that moves and turns, by Nitsche's method with θ = 0, for a neo-Hookean body at finite strain.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::capsule::*;

/// Signed distance \[length\] of a point, positive outside, to a capsule around the origin: all points within `radius` of the
/// segment from −`half_length` to `half_length` along the first axis. It is a disk or a ball where the segment is a point, in
/// the plane a punch with rounded edges otherwise, in space a cylinder with round ends.
pub fn capsule_distance<R: Real, const D: usize>(y: [R; D], half_length: R, radius: R) -> R {
    let beyond = if y[0] > half_length {
        y[0] - half_length
    } else if y[0] < R::from(0.0) - half_length {
        y[0] + half_length
    } else {
        R::from(0.0)
    };
    let square = y.iter().skip(1).fold(beyond * beyond, |sum, y| sum + *y * *y);
    square.sqrt() - radius
}

/// Contact with the obstacle y = c + Q ŷ, ŷ in a capsule: g = φ(Qᵀ(x + u − c)), n_y = −∇g, exactly, by dual numbers. The slip
/// is that against the obstacle's own points, which have moved from (c₀, Q₀) since the last step:
/// (x + u − c) − Q Q₀ᵀ (x + u₀ − c₀). Tractions are forces per reference area.
///
/// For an obstacle of another shape copy this module with another function φ: it needs |∇φ| = 1 for g to be a distance.
#[forms]
pub mod capsule {
    use super::super::moving_obstacle::{in_own_axes, slip};
    use crate::operators::friction::{augmented_traction, contact_traction, slip_limit};
    pub use crate::operators::linear_criterion::criterion;
    pub use crate::operators::neo_hookean::first_piola;

    extern "Rust" {
        fn capsule_distance(y: Vector, half_length: Scalar, radius: Scalar) -> Scalar;
    }

    /// Data of the body, the method, the obstacle's motion and its shape.
    #[includes(crate::laws::moving_obstacle::Data)]
    pub struct Data {
        /// Half the length of the capsule's segment \[length\].
        #[default(0)]
        pub half_length: Param,
        /// Its radius \[length\].
        pub radius: Param,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;

    /// φ at a point of space.
    fn distance(y: Vector) -> Scalar {
        capsule_distance(in_own_axes(y), half_length, radius)
    }

    /// ∇φ there.
    fn outward(y: Vector) -> Vector {
        diff(distance(y), y)
    }

    /// g = φ(x + u), the present gap.
    pub fn current_gap(w: Vector) -> Scalar {
        distance(x + w)
    }

    /// n_y = −∇φ(x + u), the unit normal into the obstacle.
    pub fn obstacle_normal(w: Vector) -> Vector {
        -outward(x + w)
    }

    /// T(u), the traction of the obstacle on the body, per reference area.
    pub fn obstacle_traction(w: Vector) -> Vector {
        let P =
            augmented_traction(first_piola(w) * n, current_gap(w), slip(w), gamma0 / h, obstacle_normal(w));
        let pressure = neg_part(dot(P, obstacle_normal(w)));
        contact_traction(P, slip_limit(pressure), obstacle_normal(w))
    }

    /// The direct problem: ∫ P(u):∇v − ∫ T(u)·v.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v))) - integral(GammaC, dot(obstacle_traction(u), v))
    }

    /// The adjoint of the discrete problem.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// dJ/dκ = ∂R/∂κ (u; p), with p of `discrete_adjoint`.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1)
    }
}

contact_law!(capsule {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: gamma0,
    positive: radius,
    non_negative: slip_stress,
    non_negative: friction,
    non_negative: half_length,
    rotation: rotation,
    rotation: rotation_before,
    coefficient: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold, capsule, facets: gamma_c, lambda);
