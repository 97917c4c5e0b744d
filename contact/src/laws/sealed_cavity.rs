//! A nearly incompressible body with a closed cavity whose volume is given, pressed by a round rigid tool, by Nitsche's method: finite strains,
//! no friction, an energy.

use forms_fem::forms;

use crate::parameter_ranges;

#[doc(inline)]
pub use self::sealed_cavity::*;

/// The stationary point of ∫ W(u,p) − c (V(u) − s V₀) − ℓ(u) + ∫ (\[P_n\]₋² − σ_n²)/2γ: the pressure c of what fills the cavity is one unknown of the whole
/// body, on `Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[])`, and its equation is V = s V₀. The body is that of
/// [`rubber`](fn@crate::operators::rubber::mixed_density), on an element that is stable for incompressible bodies; the tool is a disk or a ball
/// ([`signed_distance`](crate::operators::signed_distance)). γ₀ has the scale of μ ([`usual_gamma0`](super::mixed_nitsche::usual_gamma0)).
///
/// The tangent is symmetric. [`pressure_adjoint`](fn@pressure_adjoint) is the adjoint state of the pressure c.
#[forms]
pub mod sealed_cavity {
    use crate::operators::cavity::{enclosed, enclosed_at_rest};
    pub use crate::operators::loads::loads;
    use crate::operators::rubber::{mixed_density, mixed_piola};
    use crate::operators::signed_distance::{ball_distance, nitsche_energy};

    /// Data of the body, the filling and the tool.
    #[includes(
        crate::operators::rubber::Data,
        crate::operators::penalty::Data,
        crate::operators::loads::Data
    )]
    pub struct Data {
        /// s, the cavity's volume over that of the undeformed one.
        #[doc(alias = "s")]
        pub volume_ratio: Param,
        /// The tool's centre \[length\].
        pub centre: Param<Vector>,
        /// The tool's radius \[length\].
        pub radius: Param,
        /// e, unit vector along which the tool's force is measured.
        #[default(0)]
        pub direction: Param<Vector>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// Γ_N, the loaded boundary.
    #[facets]
    pub struct GammaN;
    /// Γ_C, the potential contact boundary.
    #[facets]
    pub struct GammaC;
    /// The cavity's wall.
    #[facets]
    pub struct Wall;

    fn distance(y: Vector) -> Scalar {
        ball_distance(y, centre, radius)
    }

    fn outward(y: Vector) -> Vector {
        normalize(y - centre)
    }

    /// \[P_n\]₋, the pressure of the tool per reference area.
    pub fn contact_pressure(u: Vector, p: Scalar) -> Scalar {
        neg_part(gamma0 / h * distance(x + u) - dot(mixed_piola(u, p) * n, outward(x + u)))
    }

    fn potential(u: Vector, p: Scalar, filling: Scalar) -> Energy {
        let own = mixed_piola(u, p) * n;
        integral(Omega, mixed_density(u, p) - dot(body_force, u))
            - integral(GammaN, dot(traction, u))
            - integral(Wall, filling * (enclosed(u) - volume_ratio * enclosed_at_rest()))
            + integral(GammaC, nitsche_energy(own, distance(x + u), outward(x + u), gamma0 / h))
    }

    /// The direct problem with u, p and the pressure of the filling.
    pub fn energy(u: Unknown<Vector>, p: Unknown<Scalar>, filling: Unknown<Scalar>) -> Energy {
        potential(u, p, filling)
    }

    /// The derivative of the energy as the tool moves along e: the force of the tool on the body along e.
    pub fn tool_force(u: State<Vector>, p: State<Scalar>, filling: State<Scalar>) -> Functional {
        derivative(potential(u, p, filling), centre, direction)
    }

    /// V, the volume that the wall encloses.
    pub fn volume(u: State<Vector>) -> Functional {
        integral(Wall, enclosed(u))
    }

    /// V₀, the undeformed volume.
    pub fn volume_at_rest() -> Functional {
        integral(Wall, enclosed_at_rest())
    }

    /// The first variation of the energy.
    fn variation(u: Vector, p: Scalar, filling: Scalar, v: Vector, q: Scalar, d: Scalar) -> Form {
        derivative(potential(u, p, filling), u, v)
            + derivative(potential(u, p, filling), p, q)
            + derivative(potential(u, p, filling), filling, d)
    }

    /// c V₀, whose adjoint state `pressure_adjoint` is.
    pub fn scaled_pressure(filling: State<Scalar>) -> Functional {
        integral(Wall, filling * enclosed_at_rest())
    }

    /// The adjoint (z, s, t) of `scaled_pressure`.
    pub fn pressure_adjoint(
        u: State<Vector>,
        p: State<Scalar>,
        filling: State<Scalar>,
        z: Unknown<Vector>,
        s: Unknown<Scalar>,
        t: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        d: Test<Scalar>,
    ) -> Form {
        let R = variation(u, p, filling, z, s, t);
        derivative(R, u, v)
            + derivative(R, p, q)
            + derivative(R, filling, d)
            + integral(Wall, d * enclosed_at_rest())
    }

    /// The derivative of `scaled_pressure` by s, with its adjoint state.
    pub fn by_volume_ratio(
        u: State<Vector>,
        p: State<Scalar>,
        filling: State<Scalar>,
        z: State<Vector>,
        s: State<Scalar>,
        t: State<Scalar>,
    ) -> Functional {
        derivative(variation(u, p, filling, z, s, t), volume_ratio, 1)
    }

    /// The derivative of `scaled_pressure` by the tool's radius, with its adjoint state.
    pub fn by_radius(
        u: State<Vector>,
        p: State<Scalar>,
        filling: State<Scalar>,
        z: State<Vector>,
        s: State<Scalar>,
        t: State<Scalar>,
    ) -> Functional {
        derivative(variation(u, p, filling, z, s, t), radius, 1)
    }
}

parameter_ranges!(sealed_cavity {
    positive: mu,
    positive: bulk_modulus,
    positive: gamma0,
    positive: volume_ratio,
    positive: radius,
});
