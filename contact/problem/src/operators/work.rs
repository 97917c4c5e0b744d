//! Forms of loads and criteria that are linear in the displacement.

use forms_fem::forms;

/// The dead load of a body.
#[forms]
pub mod body_load {
    /// No load acts unless it is given.
    pub struct Data {
        /// f, force per volume.
        #[doc(alias = "f")]
        #[default(0)]
        pub body_force: Given<Vector>,
    }
}

/// Dead loads of a body and its boundary.
#[forms]
pub mod loads {
    /// No load acts unless it is given.
    #[includes(super::body_load::Data)]
    pub struct Data {
        /// g_N, force per area on Γ_N.
        #[doc(alias = "g_N")]
        #[default(0)]
        pub traction: Given<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;

    /// ℓ(v), the work of the loads.
    #[doc(alias = "ℓ")]
    pub fn loads(v: Test<Vector>) -> Form {
        integral(Omega, dot(body_force, v)) + integral(GammaN, dot(traction, v))
    }
}

/// A criterion that is linear in the displacement.
#[forms]
pub mod linear_criterion {
    /// The weight of the displacement, zero unless it is given.
    pub struct Data {
        /// F, the weight of the displacement in the criterion: ∫ F·u.
        #[doc(alias = "F")]
        #[default(0)]
        pub criterion_force: Given<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;

    /// J = ∫ F·u.
    #[doc(alias = "J")]
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, dot(criterion_force, u))
    }
}

/// Forces of contact along a direction.
#[forms]
pub mod resultant {
    /// The direction.
    pub struct Data {
        /// e, unit vector along which the forces of contact and friction are measured.
        #[doc(alias = "e")]
        #[default(0)]
        pub force_direction: Given<Vector>,
    }
}
