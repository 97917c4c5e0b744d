//! Wear of a body that slides far along another one, by Archard's law (1953), at points that slide, finite strains.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::sliding_wear::*;

/// The law of [`sliding_bodies`](super::sliding_bodies) with own surfaces that have worn by the depth w:
///
/// P_n = σ_n + γ (g + w),  w ← w + k_w p |s_t| after the step, with the pressure p = \[P_n\]₋ dA/da per deformed area and the slip s_t of the
/// step.
///
/// The worn depth is a [`History`](forms_fem::prelude::History) at the own points of the pairs, made by [`Assembler::history_on_sliding_pairs`](forms_fem::prelude::Assembler::history_on_sliding_pairs) and held within a step:
/// Euler's explicit method in the distance slid. After the step
/// `assembler.update_sliding_history(&model.worn_after(&u), &model.data.worn, &touch, &u, WithoutPartner::Keep)` and `commit()`: what has no
/// opposite point stays as it is worn. The surface of the body that wears is the own one: `Pairing::onto(wearing, other)` with `share: 1.0`.
/// The normal of the worn surface is that of the mesh, and w is measured along it.
#[forms]
pub mod sliding_wear {
    pub use super::super::two_bodies::{GammaN, Omega, Touch, criterion, loads, slip_limit};
    use crate::operators::friction::{contact_traction, deformed_normal, tangential};
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};
    use crate::operators::sliding::{augmented, slip};

    /// Data of the bodies, of friction and of wear.
    #[includes(crate::laws::two_bodies::Data)]
    pub struct Data {
        /// k_w, worn depth per pressure and distance slid \[1/stress\]: Archard's coefficient over the hardness.
        #[doc(alias = "k_w")]
        pub wear_rate: Param,
        /// w, the worn depth \[length\].
        #[doc(alias = "w")]
        pub worn: History<Scalar>,
    }

    /// P, with the gap of the worn surface.
    fn augmented_worn(w: Vector) -> Vector {
        augmented(first_piola(w) * n, w) + this(gamma0) / this(h) * this(worn) * toward
    }

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(augmented_worn(w), toward))
    }

    /// T(u), the traction of the opposite body on this one, per reference area.
    pub fn opposite_traction(w: Vector) -> Vector {
        contact_traction(augmented_worn(w), slip_limit(contact_pressure(w)), toward)
    }

    /// da/dA, the deformed area per reference area.
    fn stretched_area(w: Vector) -> Scalar {
        norm(cof(I + grad(w)) * n)
    }

    /// |s_t|, the distance slid in the step.
    pub fn distance_slid(w: Vector) -> Scalar {
        norm(tangential(slip(w), this(deformed_normal(displacement_before))))
    }

    /// w + k_w p |s_t|, the worn depth after the step.
    pub fn worn_after(w: Vector) -> Scalar {
        this(worn) + wear_rate * contact_pressure(w) / this(stretched_area(w)) * distance_slid(w)
    }

    /// The direct problem of a step.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(Touch(u), share * dot(opposite_traction(u), jump(v)))
    }

    /// The adjoint of the discrete problem of one step, the worn depth held.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// The surface that wears, for its volume.
    #[facets]
    pub struct Worn;

    /// ∫ w da, the volume that is worn off, also where nothing touches any more.
    pub fn worn_volume(u: State<Vector>) -> Functional {
        integral(Worn, worn * stretched_area(u))
    }

    /// ∫ e·T over the surfaces of the pairs: bound to one surface, the force of the opposite body on its body along e.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(Touch(u), dot(opposite_traction(u), this(force_direction)))
    }
}

contact_law!(sliding_wear {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: gamma0,
    positive: share,
    non_negative: slip_stress,
    non_negative: friction,
    non_negative: wear_rate,
    line_search: OnResidual,
});

threshold_of_material!(threshold, sliding_wear, pairs: touch, lambda);
