//! A membrane, free or above an obstacle: the problems, their adjoints and their estimators as forms.

use forms_fem::prelude::*;

/// −Δu = f.
#[forms]
pub mod poisson {
    /// The load.
    pub struct Data {
        /// f.
        pub source: Given<Scalar>,
    }
    /// Ω.
    #[cells]
    pub struct Omega;

    /// ∫∇u·∇v − f v.
    pub fn direct(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v)
    }

    /// J = ∫u.
    pub fn goal(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }

    /// The adjoint state of J.
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(direct(u, p), u, q) + derivative(goal(u), u, q)
    }

    /// R(u; q z).
    pub fn localised(u: State<Scalar>, z: State<Scalar>, q: Test<Scalar>) -> Form {
        direct(u, q * z)
    }
}

/// Scalar Signorini: −Δu = 0; u ≥ 0, ∂u/∂n ≥ 0 and u ∂u/∂n = 0 on the obstacle, by Nitsche's method; ∂u/∂n given on the rest.
#[forms]
pub mod signorini {
    /// The method, what acts, and the zone of contact where it is known.
    pub struct Data {
        /// θ: −1 skew-symmetric, 0 incomplete, 1 symmetric variant.
        pub theta: Param,
        /// γ₀; γ = γ₀/h.
        pub gamma0: Param,
        /// A field whose normal component is the flux through the loaded boundary.
        pub flux: Given<Vector>,
        /// 1 in the zone of contact and 0 outside; only the adjoint (22) reads it.
        pub contact: Given<Scalar>,
    }
    /// Ω.
    #[cells]
    pub struct Omega;
    /// The facets between cells.
    #[interior_facets]
    pub struct Interior;
    /// The boundary with a given flux.
    #[facets]
    pub struct Loaded;
    /// The boundary above the obstacle.
    #[facets]
    pub struct Obstacle;

    fn gamma() -> Scalar {
        gamma0 / h
    }
    fn slope(w: Scalar) -> Scalar {
        dot(grad(w), n)
    }
    /// The obstacle's reaction [∂u/∂n − γu]₊.
    fn reaction(w: Scalar) -> Scalar {
        pos_part(slope(w) - gamma() * w)
    }
    /// The value of the reaction in (22).
    fn linear_reaction(w: Scalar) -> Scalar {
        contact * (slope(w) - gamma() * w)
    }

    /// ∫∇w·∇v − ∫flux·n v − ∫(θ/γ) ∂w/∂n ∂v/∂n + ∫(r/γ)(θ ∂v/∂n − γv), with r the reaction.
    fn balance(w: Scalar, v: Scalar, r: Scalar) -> Form {
        integral(Omega, dot(grad(w), grad(v)))
            - integral(Loaded, dot(flux, n) * v)
            - integral(Obstacle, theta / gamma() * slope(w) * slope(v))
            + integral(Obstacle, r / gamma() * (theta * slope(v) - gamma() * v))
    }
    pub fn direct(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        balance(u, v, reaction(u))
    }
    /// The adjoint (22) of a criterion that is zero inside, with exact contact.
    pub fn consistent_adjoint(p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        balance(p, q, linear_reaction(p))
    }

    /// The adjoint (21) of the same criterion and zone: the transposed of `direct`'s tangent, which is consistent for θ = 1 only.
    pub fn discrete_adjoint(p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(p), grad(q)))
            - integral(Loaded, dot(flux, n) * q)
            - integral(Obstacle, theta / gamma() * slope(p) * slope(q))
            + integral(Obstacle, linear_reaction(q) / gamma() * (theta * slope(p) - gamma() * p))
    }
    /// ‖∇w − flux‖² on each cell: the true error, where the flux is that of the exact solution's gradient.
    pub fn true_error(w: State<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(w) - flux, grad(w) - flux) * q)
    }

    /// η_T² = h²‖Δw‖² + h‖½⟦∂w/∂n⟧‖² + h‖∂w/∂n − flux·n‖² + h‖∂w/∂n − r‖².
    fn squared(w: Scalar, q: Scalar, r: Scalar) -> Form {
        integral(Omega, sqr(h) * sqr(tr(hess(w))) * q)
            + integral(Interior, avg(h) * sqr(dot(jump(grad(w)), n)) / 2 * avg(q))
            + integral(Loaded, h * sqr(slope(w) - dot(flux, n)) * q)
            + integral(Obstacle, h * sqr(slope(w) - r) * q)
    }
    pub fn residual(u: State<Scalar>, q: Test<Scalar>) -> Form {
        squared(u, q, reaction(u))
    }
    pub fn adjoint_residual(p: State<Scalar>, q: Test<Scalar>) -> Form {
        squared(p, q, linear_reaction(p))
    }

    /// J = ∫u.
    pub fn goal(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }
    /// The adjoint (21) of J.
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(direct(u, p), u, q) + derivative(goal(u), u, q)
    }
    /// R(u; q z).
    pub fn localised(u: State<Scalar>, z: State<Scalar>, q: Test<Scalar>) -> Form {
        direct(u, q * z)
    }
}
