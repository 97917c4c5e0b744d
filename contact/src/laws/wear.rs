//! Wear of a body that slides on a flat obstacle, after Archard (1953), with friction by Nitsche's method, small strains.

use forms_fem::forms;

use crate::contact_law;

#[doc(inline)]
pub use self::wear::*;

/// Contact with friction as in [`frictional_nitsche`](super::frictional_nitsche) on a surface that has worn by the depth w, and
/// on an obstacle that has slid by S since the last step:
///
/// P_n = σ_n + γ (g + w − u_n),  P_t = σ_t − γ s_t,  s = u − u₀ − S,  w ← w + k_w \[P_n\]₋ |s_t| after the step.
///
/// The worn depth is a [`History`](forms_fem::prelude::History) at the points of Γ_C, held within a step: after it
/// `assembler.update_history(&model.worn_after(&u), &model.data.worn)` and `commit()`. This is Euler's explicit method in the
/// distance slid, of first order; under a given displacement it is stable while k_w |s_t| times the body's stiffness per
/// length is below one. The surface wears along n_y; its normal and its area stay those of the mesh.
#[forms]
pub mod wear {
    pub use super::super::frictional_nitsche::{
        Boundary, GammaC, GammaN, Omega, criterion, elasticity, stress, traction_product,
    };
    use super::super::frictional_nitsche::{law, loads};
    use crate::operators::friction::{augmented_traction, tangential};
    use crate::operators::obstacle::{current_gap, gamma};
    use crate::operators::signed_distance::nitsche_density;

    /// Data of the body, of friction and of wear.
    #[includes(crate::laws::frictional_nitsche::Data)]
    pub struct Data {
        /// k_w, worn depth per pressure and distance slid \[1/stress\]: Archard's coefficient over the hardness.
        #[doc(alias = "k_w")]
        pub wear_rate: Param,
        /// w, the worn depth \[length\].
        #[doc(alias = "w")]
        pub worn: History<Scalar>,
        /// S, the obstacle's displacement since the last step \[length\].
        #[doc(alias = "S")]
        #[default(0)]
        pub sliding: Given<Vector>,
    }

    fn slip(w: Vector) -> Vector {
        w - displacement_before - sliding
    }

    fn augmented(w: Vector) -> Vector {
        augmented_traction(stress(w) * n, current_gap(w) + worn, slip(w), gamma(), obstacle_normal)
    }

    /// T(u), the traction of the obstacle on the body.
    pub fn obstacle_traction(w: Vector) -> Vector {
        law(augmented(w))
    }

    /// \[P_n\]₋, the contact pressure.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(augmented(w), obstacle_normal))
    }

    /// |s_t|, the distance slid in the step.
    pub fn distance_slid(w: Vector) -> Scalar {
        norm(tangential(slip(w), obstacle_normal))
    }

    /// w + k_w \[P_n\]₋ |s_t|, the worn depth after the step.
    pub fn worn_after(w: Vector) -> Scalar {
        worn + wear_rate * contact_pressure(w) * distance_slid(w)
    }

    /// The direct problem of a step.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - loads(v)
            + integral(
                GammaC,
                nitsche_density(stress(u) * n, obstacle_traction(u), stress(v) * n, v, theta, gamma()),
            )
    }

    /// The adjoint of the discrete problem of one step, the worn depth held.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// ∫ w, the worn volume.
    pub fn worn_volume() -> Functional {
        integral(GammaC, worn)
    }
}

contact_law!(wear {
    direct: direct,
    region: gamma_c,
    criterion: criterion,
    adjoint: discrete_adjoint,
    theta: theta,
    threshold: traction_product(elasticity, gamma0),
    positive: mu,
    positive: gamma0,
    non_negative: slip_stress,
    non_negative: friction,
    non_negative: wear_rate,
    unit: obstacle_normal,
    coefficient: friction,
    line_search: OnResidual,
});
