//! Contact of bodies at large sliding and finite strains with Coulomb's law regularised by springs that remember.

use forms_fem::forms;

use crate::contact_law;
use crate::material_threshold::threshold_of_material;

#[doc(inline)]
pub use self::friction_with_memory::*;

/// ∫ P:∇v − Σ ½ ∫ T·⟦v⟧ dA = ℓ(v) with T = −\[P_n\]₋ n_x + Π_s(−ε F (e + F₀⁻¹ s_t)), P_n = σ_n + γ g: contact by Nitsche's method, θ = 0,
/// as in [`sliding_bodies`](super::sliding_bodies), and friction by tangential springs of stiffness ε per area, whose elastic slip e is
/// remembered from step to step (Simo and Laursen 1992). What sticks gives way by T_t/ε, however many steps there are: the error of the law is
/// of the order κ p/ε, and the force does not depend on the size of the steps. Springs that forget, as in
/// [`frictional_penalty`](super::frictional_penalty), lose their force as steps shrink.
///
/// e is a [`History`](forms_fem::prelude::History) at the own points of the pairs, made by [`Assembler::history_on_sliding_pairs`](forms_fem::prelude::Assembler::history_on_sliding_pairs). After each step
/// `assembler.update_sliding_history(&model.slip_after_step(&u), &model.data.elastic_slip, &touch, &u, WithoutPartner::Restart)` and
/// `commit()`: a point that loses its opposite point forgets its spring, as one that presses no more does.
/// [`friction_with_memory_adjoint`](mod@friction_with_memory_adjoint) differentiates whole load histories.
///
/// On [`penalty_with_memory`](mod@penalty_with_memory) the pressure is that of springs, too.
#[forms]
pub mod friction_with_memory {
    pub use super::super::two_bodies::{GammaN, Omega, Touch, criterion, loads};
    use crate::operators::elastic_slip::{slip_of, spring_traction};
    use crate::operators::friction::slip_limit;
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};
    use crate::operators::sliding::reference_slip;

    /// Data of bodies, friction and springs.
    #[includes(crate::laws::two_bodies::Data, crate::operators::elastic_slip::Data)]
    pub struct Data {}

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn contact_pressure(w: Vector) -> Scalar {
        neg_part(dot(this(first_piola(w) * n), toward) + this(gamma0) / this(h) * gap)
    }

    /// Π_s(−ε F (e + F₀⁻¹ s_t)), the traction of friction.
    pub fn friction_traction(w: Vector) -> Vector {
        let bound = slip_limit(contact_pressure(w));
        spring_traction(
            this(I + grad(w)),
            this(elastic_slip) + reference_slip(w),
            this(stick_stiffness),
            bound,
        )
    }

    /// T(u), the traction of the opposite body on this one, per reference area.
    pub fn opposite_traction(w: Vector) -> Vector {
        friction_traction(w) - contact_pressure(w) * toward
    }

    /// e(u), the elastic slip after the step: the history's next value.
    pub fn slip_after_step(w: Vector) -> Vector {
        slip_of(this(I + grad(w)), friction_traction(w), this(stick_stiffness))
    }

    /// The direct problem of a step.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(Touch(u), share * dot(opposite_traction(u), jump(v)))
    }

    /// The adjoint of the discrete problem of one step, its memory held.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// ∫ e·T over the surfaces of the pairs: bound to one surface, the force of the opposite body on its body along e.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(Touch(u), dot(opposite_traction(u), this(force_direction)))
    }
}

contact_law!(friction_with_memory {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    threshold_by: threshold,
    positive: mu,
    positive: gamma0,
    positive: share,
    positive: stick_stiffness,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});

threshold_of_material!(threshold, friction_with_memory, pairs: touch, lambda, traction: Normal);

/// Adjoint states of a row of steps with [`friction_with_memory`](mod@friction_with_memory), for J = Σ J(uⁿ). Each step n has data of its own: the
/// state before it, the elastic slip before it, and a weight ω. Backwards from the last step, whose ω is zero:
///
/// 1. pⁿ solves `adjoint` of step n plus `carried` of step n + 1, at homogeneous conditions;
/// 2. ω of step n − 1 is written with `weight_before` of step n at uⁿ and pⁿ, by
///    [`update_sliding_history`](forms_fem::prelude::Assembler::update_sliding_history) with `WithoutPartner::Restart`.
///
/// dJ/dκ is the sum of `by_friction` over the steps, dJ/dε that of `by_stiffness`. All of them are exact for what is assembled: the motion of
/// opposite points, gaps and normals is in them.
#[forms]
pub mod friction_with_memory_adjoint {
    pub use super::friction_with_memory::{GammaN, Omega, Touch, criterion};
    use super::friction_with_memory::{contact_pressure, direct, slip_after_step};
    use crate::operators::elastic_slip::{slip_of, spring_traction};
    use crate::operators::friction::slip_limit;
    use crate::operators::sliding::reference_slip;

    /// Data of a step, with the weight of what it leaves behind.
    #[includes(crate::laws::friction_with_memory::Data)]
    pub struct Data {
        /// ω, the derivative of J by the elastic slip after the step, per area, as far as later steps read it \[J/volume\].
        #[doc(alias = "ω")]
        pub slip_weight: History<Vector>,
    }

    /// ∫ ω·e(u), what a step leaves behind.
    fn left(w: Vector) -> Functional {
        integral(Touch(w), dot(this(slip_weight), slip_after_step(w)))
    }

    /// The equation of the adjoint state, without what the next step carries.
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(left(u), u, q) + derivative(criterion(u), u, q)
    }

    /// The derivative of the step by the displacement before it: a load of the adjoint state of the step before.
    pub fn carried(u: State<Vector>, p: State<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), displacement_before, q) + derivative(left(u), displacement_before, q)
    }

    /// ω of the step before.
    pub fn weight_before(u: Vector, p: Vector) -> Vector {
        let before = this(elastic_slip);
        let F = this(I + grad(u));
        let bound = slip_limit(contact_pressure(u));
        let T = spring_traction(F, before + reference_slip(u), this(stick_stiffness), bound);
        let after = slip_of(F, T, this(stick_stiffness));
        diff(dot(this(slip_weight), after) - share * dot(T, jump(p)), before)
    }

    /// The part of the step in dJ/dκ.
    pub fn by_friction(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), friction, 1) + derivative(left(u), friction, 1)
    }

    /// The part of the step in dJ/dε.
    pub fn by_stiffness(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), stick_stiffness, 1) + derivative(left(u), stick_stiffness, 1)
    }
}

/// The law of [`friction_with_memory`](mod@friction_with_memory) with the pressure \[γ g\]₋ of normal springs: no stress of the bodies enters. The bodies
/// overlap by p/γ.
#[forms]
pub mod penalty_with_memory {
    pub use super::super::two_bodies::{GammaN, Omega, Touch, criterion, loads};
    pub use super::friction_with_memory::Data;
    use crate::operators::elastic_slip::{slip_of, spring_traction};
    use crate::operators::friction::slip_limit;
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};
    use crate::operators::sliding::reference_slip;

    /// \[γ g\]₋, the contact pressure per reference area.
    pub fn contact_pressure() -> Scalar {
        neg_part(this(gamma0) / this(h) * gap)
    }

    /// Π_s(−ε F (e + F₀⁻¹ s_t)), the traction of friction.
    pub fn friction_traction(w: Vector) -> Vector {
        let bound = slip_limit(contact_pressure());
        spring_traction(
            this(I + grad(w)),
            this(elastic_slip) + reference_slip(w),
            this(stick_stiffness),
            bound,
        )
    }

    /// T(u), the traction of the opposite body on this one, per reference area.
    pub fn opposite_traction(w: Vector) -> Vector {
        friction_traction(w) - contact_pressure() * toward
    }

    /// e(u), the elastic slip after the step: the history's next value.
    pub fn slip_after_step(w: Vector) -> Vector {
        slip_of(this(I + grad(w)), friction_traction(w), this(stick_stiffness))
    }

    /// The direct problem of a step.
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(Touch(u), share * dot(opposite_traction(u), jump(v)))
    }

    /// The adjoint of the discrete problem of one step, its memory held.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// ∫ e·T over the surfaces of the pairs: bound to one surface, the force of the opposite body on its body along e.
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(Touch(u), dot(opposite_traction(u), this(force_direction)))
    }
}

contact_law!(penalty_with_memory {
    direct: direct,
    region: touch,
    criterion: criterion,
    adjoint: discrete_adjoint,
    positive: mu,
    positive: gamma0,
    positive: share,
    positive: stick_stiffness,
    non_negative: slip_stress,
    non_negative: friction,
    line_search: OnResidual,
});
