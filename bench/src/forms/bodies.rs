//! Two linear elastic bodies that slide on each other, as `peers/bodies_getfem.py` states them.

use forms_fem::forms;

/// Nitsche's method with θ = 0 on rays along the deformed normals (Poulios and Renard 2015), integrated over one surface:
/// −∫ T·(v(X) − v(Y)) dA with T = −\[P_n\]₋ n + Π(P_t), P = σ(u)n augmented by γ g and −γ (u(X) − u(Y)).
#[forms]
pub mod sliding {
    use forms_contact::operators::friction::{augmented_traction, contact_traction};
    use forms_contact::operators::linear_elastic::stress;

    /// One number γ and no γ₀/h: GetFEM's form has it too.
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub gamma: Param,
        pub kappa: Param,
    }
    /// Both bodies.
    #[cells]
    pub struct Omega;
    /// The surface that is integrated over, onto the other one.
    #[pairs]
    pub struct Touch;

    fn augmented(u: Vector) -> Vector {
        augmented_traction(this(stress(u) * n), gap, jump(u), gamma, toward)
    }
    fn with_friction(u: Vector) -> Vector {
        let P = augmented(u);
        contact_traction(P, kappa * neg_part(dot(P, toward)), toward)
    }
    fn without_friction(u: Vector) -> Vector {
        -neg_part(dot(this(stress(u) * n), toward) + gamma * gap) * toward
    }

    /// The contact term with Coulomb's friction.
    pub fn friction(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        -integral(Touch(u), dot(with_friction(u), jump(v)))
    }
    /// The contact term without friction.
    pub fn frictionless(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        -integral(Touch(u), dot(without_friction(u), jump(v)))
    }
    /// Balance of both bodies with friction.
    pub fn balance_with_friction(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Touch(u), dot(with_friction(u), jump(v)))
    }
    /// Balance of both bodies without friction.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Touch(u), dot(without_friction(u), jump(v)))
    }
}
